//! Measures of a motion as sums of largest pieces: `max(y)` is the largest of its values, each of which is smooth where the largest of them is not. Of the values those count that
//! are higher than their neighbours, with these neighbours, and what the polynomial through five of them has in between.

use cotree::run::Statistic;
use nalgebra::{DMatrix, DVector};

use super::goal::Goal;

/// The highest places that are evaluated, of each measure.
const MOST: usize = 12;
/// Values to each side of a highest one through which the polynomial is.
const BESIDE: usize = 2;
/// Golden sections, and how often an interval is cut: to rounding.
const GOLDEN: f64 = 0.618_033_988_749_895;
const CUTS: usize = 60;

/// Values along a motion, and how they change: a row for each value, a column for each quantity that is varied.
#[derive(Clone, Debug)]
pub struct SampledValues {
    pub times: Vec<f64>,
    pub values: DVector<f64>,
    pub slopes: DMatrix<f64>,
}

/// A value and how it changes.
#[derive(Clone, Debug)]
pub struct Linear {
    pub value: f64,
    pub slope: DVector<f64>,
}

/// A smooth function of the quantities.
#[derive(Clone, Debug)]
pub struct SmoothPiece {
    course: usize,
    form: PieceForm,
}

#[derive(Clone, Debug)]
enum PieceForm {
    /// A weighted sum of values.
    Sum(Vec<(usize, f64)>),
    /// A multiple of the root of the mean square.
    Effective(f64),
    /// A multiple of the highest value, of the lowest, or of the larger of their sizes, wherever it lies: its time does not change it, so that it is as smooth as the values while
    /// no other one is as high.
    Extreme { of: &'static [f64], weight: f64 },
}

/// The signs with which values are highest for the largest of them, the smallest, and the peak.
const LARGEST: &[f64] = &[1.0];
const SMALLEST: &[f64] = &[-1.0];
const PEAK: &[f64] = &[1.0, -1.0];

/// The largest of some pieces.
pub type Largest = Vec<SmoothPiece>;

impl SmoothPiece {
    fn at(course: usize, row: usize, weight: f64) -> SmoothPiece {
        SmoothPiece { course, form: PieceForm::Sum(vec![(row, weight)]) }
    }

    /// None where the course is no longer as long as it was.
    pub fn of(&self, courses: &[SampledValues]) -> Option<Linear> {
        let course = courses.get(self.course)?;
        match &self.form {
            PieceForm::Sum(parts) => course.sum(parts),
            PieceForm::Effective(weight) => Some(course.effective(*weight)),
            PieceForm::Extreme { of, weight } => {
                let highest = of.iter().map(|&sign| course.sum(&weighed(course.best(sign), sign)));
                let highest = highest
                    .reduce(|best, other| if other.as_ref()?.value > best.as_ref()?.value { other } else { best });
                let Linear { value, slope } = highest??;
                Some(Linear { value: weight * value, slope: *weight * slope })
            }
        }
    }
}

impl SampledValues {
    /// A weighed sum of values; none where there are no longer as many.
    fn sum(&self, parts: &[(usize, f64)]) -> Option<Linear> {
        let mut sum = Linear { value: 0.0, slope: DVector::zeros(self.slopes.ncols()) };
        for &(row, weight) in parts {
            sum.value += weight * self.values.get(row)?;
            sum.slope += weight * self.slopes.row(row).transpose();
        }
        Some(sum)
    }

    /// The root of the mean square, of values that are straight in between.
    fn effective(&self, weight: f64) -> Linear {
        let (mut square, mut half, mut length) = (0.0, DVector::zeros(self.slopes.ncols()), 0.0);
        for row in 1..self.times.len() {
            let step = self.times[row] - self.times[row - 1];
            let [before, after] = [self.values[row - 1], self.values[row]];
            length += step;
            square += step * (before * before + before * after + after * after) / 3.0;
            half += step / 6.0 * (2.0 * before + after) * self.slopes.row(row - 1).transpose();
            half += step / 6.0 * (before + 2.0 * after) * self.slopes.row(row).transpose();
        }
        if length == 0.0 {
            let first = self.values[0];
            return Linear {
                value: weight * first.abs(),
                slope: weight * first.signum() * self.slopes.row(0).transpose(),
            };
        }
        let value = (square / length).sqrt();
        // Where everything is zero nothing is smaller.
        let by = if value > 0.0 { 1.0 / (length * value) } else { 0.0 };
        Linear { value: weight * value, slope: weight * by * half }
    }

    /// The weights with which values add up to the mean.
    fn mean(&self, weight: f64) -> Vec<(usize, f64)> {
        let last = self.times.len() - 1;
        let length = self.times[last] - self.times[0];
        if length == 0.0 {
            return vec![(0, weight)];
        }
        let part = |row: usize| 0.5 * (self.times[(row + 1).min(last)] - self.times[row.saturating_sub(1)]) / length;
        (0..=last).map(|row| (row, weight * part(row))).collect()
    }

    /// The rows of the values that are the highest around, or lowest; the highest first.
    fn tops(&self, sign: f64) -> Vec<usize> {
        let last = self.values.len() - 1;
        let at = |row: usize| sign * self.values[row];
        let around = |row: usize| row.saturating_sub(1)..=(row + 1).min(last);
        let mut tops: Vec<usize> = (0..=last).filter(|&row| around(row).all(|other| at(other) <= at(row))).collect();
        tops.sort_by(|&a, &b| at(b).total_cmp(&at(a)));
        tops.truncate(MOST);
        tops
    }

    /// The highest place around a row, or the lowest, as a sum of values: where a polynomial through neighbours has it. Its time does not move the value, so that the weights stay.
    fn top(&self, row: usize, sign: f64) -> Vec<(usize, f64)> {
        let last = self.values.len() - 1;
        let first = row.saturating_sub(BESIDE).min(last.saturating_sub(2 * BESIDE));
        let rows: Vec<usize> = (first..=(first + 2 * BESIDE).min(last)).collect();
        let weights = |time: f64| -> Vec<f64> {
            let weight = |&row: &usize| {
                let others = rows.iter().filter(|&&other| other != row);
                others.map(|&other| (time - self.times[other]) / (self.times[row] - self.times[other])).product()
            };
            rows.iter().map(weight).collect()
        };
        let at = |time: f64| -> f64 {
            sign * rows.iter().zip(weights(time)).map(|(&row, weight)| weight * self.values[row]).sum::<f64>()
        };
        let [mut low, mut high] = [row.saturating_sub(1), (row + 1).min(last)].map(|row| self.times[row]);
        for _ in 0..CUTS {
            let (a, b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
            if at(a) > at(b) { high = b } else { low = a }
        }
        let (time, value) = (0.5 * (low + high), sign * self.values[row]);
        match at(time) > value && self.is_smooth(&rows) {
            true => rows.iter().copied().zip(weights(time)).collect(),
            false => vec![(row, 1.0)],
        }
    }

    /// Are third differences below second ones? At a corner or a jump they are as large or larger.
    fn is_smooth(&self, rows: &[usize]) -> bool {
        let mut differences: Vec<f64> = rows.iter().map(|&row| self.values[row]).collect();
        let mut sizes = [0.0; 3];
        for size in &mut sizes {
            differences = differences.windows(2).map(|pair| pair[1] - pair[0]).collect();
            *size = differences.iter().fold(0.0, |most: f64, difference| most.max(difference.abs()));
        }
        sizes[2] < sizes[1]
    }

    /// The highest place, or the lowest, as a sum of values.
    fn best(&self, sign: f64) -> Vec<(usize, f64)> {
        let value = |parts: &Vec<(usize, f64)>| {
            sign * parts.iter().map(|(row, weight)| weight * self.values[*row]).sum::<f64>()
        };
        let tops = self.tops(sign).into_iter().map(|row| self.top(row, sign));
        tops.reduce(|best, other| if value(&other) > value(&best) { other } else { best }).unwrap_or_default()
    }

    /// The highest places around, or the lowest, with a weight: what no polynomial between them is above.
    fn highest(&self, course: usize, sign: f64, weight: f64) -> Largest {
        let last = self.values.len() - 1;
        let of = |row: usize| {
            let top = SmoothPiece { course, form: PieceForm::Sum(weighed(self.top(row, sign), weight)) };
            let around = row.saturating_sub(1)..=(row + 1).min(last);
            around.map(move |row| SmoothPiece::at(course, row, weight)).chain([top])
        };
        self.tops(sign).into_iter().flat_map(of).collect()
    }

    /// A measure with a weight, as a sum of largest pieces. What cannot be one, and the sides of an equation, are the extremes themselves.
    fn parts(&self, course: usize, statistic: Statistic, weight: f64, is_equation: bool) -> Vec<Largest> {
        let tops = |sign: f64, weight: f64| self.highest(course, sign, weight);
        let one = |form: PieceForm| vec![SmoothPiece { course, form }];
        let extreme = |of: &'static [f64], weight: f64| one(PieceForm::Extreme { of, weight });
        let [is_high, is_low] = [!is_equation && weight > 0.0, !is_equation && weight < 0.0];
        match statistic {
            Statistic::Max if is_high => vec![tops(1.0, weight)],
            Statistic::Min if is_low => vec![tops(-1.0, weight)],
            Statistic::Peak if is_high => vec![[tops(1.0, weight), tops(-1.0, -weight)].concat()],
            Statistic::Range if is_high => vec![tops(1.0, weight), tops(-1.0, -weight)],
            Statistic::Max => vec![extreme(LARGEST, weight)],
            Statistic::Min => vec![extreme(SMALLEST, -weight)],
            Statistic::Peak => vec![extreme(PEAK, weight)],
            Statistic::Range => vec![extreme(LARGEST, weight), extreme(SMALLEST, weight)],
            Statistic::Mean => vec![one(PieceForm::Sum(self.mean(weight)))],
            Statistic::RootMeanSquare => vec![one(PieceForm::Effective(weight))],
            Statistic::First => vec![vec![SmoothPiece::at(course, 0, weight)]],
            Statistic::Last => vec![vec![SmoothPiece::at(course, self.values.len() - 1, weight)]],
            // Goals have none of them.
            Statistic::WhenMax | Statistic::WhenMin => Vec::new(),
        }
    }
}

fn weighed(parts: Vec<(usize, f64)>, weight: f64) -> Vec<(usize, f64)> {
    parts.into_iter().map(|(row, part)| (row, weight * part)).collect()
}

/// A goal whose measures are of these courses, with a sign, as a sum of largest pieces; of an equation each of them is one piece.
pub fn parts(goal: &Goal, places: &[usize], sign: f64, is_equation: bool, courses: &[SampledValues]) -> Vec<Largest> {
    let terms = goal.terms.iter().zip(places);
    let of = |((weight, measure), &place): (&(f64, cotree::run::Measure), &usize)| {
        courses[place].parts(place, measure.statistic(), sign * weight, is_equation)
    };
    terms.flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cotree::run::Measure;

    /// y = p sin(t) + q over a turn.
    fn wave(p: f64, q: f64) -> SampledValues {
        let times: Vec<f64> = (0..=400).map(|row| std::f64::consts::TAU * f64::from(row) / 400.0).collect();
        let values = DVector::from_iterator(times.len(), times.iter().map(|t| p * t.sin() + q));
        let slopes = DMatrix::from_fn(times.len(), 2, |row, column| if column == 0 { times[row].sin() } else { 1.0 });
        SampledValues { times, values, slopes }
    }

    fn value(text: &str, courses: &[SampledValues]) -> f64 {
        let goal: Goal = text.parse().unwrap();
        let places = vec![0; goal.terms.len()];
        let largest =
            |pieces: Largest| pieces.iter().map(|piece| piece.of(courses).unwrap().value).reduce(f64::max).unwrap();
        parts(&goal, &places, 1.0, false, courses).into_iter().map(largest).sum()
    }

    /// Between the values a smooth curve is as high as it is; a corner, and a jump, are no higher than their values.
    #[test]
    fn extremes_lie_between_the_values() {
        let course = |of: &dyn Fn(f64) -> f64| {
            let times: Vec<f64> = (0..=60).map(|row| 0.1 * f64::from(row)).collect();
            let values = DVector::from_iterator(times.len(), times.iter().map(|t| of(*t)));
            SampledValues { slopes: DMatrix::zeros(times.len(), 1), times, values }
        };
        for ahead in [0.0, 0.013, 0.05, 0.08] {
            let shifted = course(&|t| (t + ahead).sin());
            for (text, known) in
                [("max(y)", 1.0), ("min(y)", -1.0), ("range(y)", 2.0), ("-range(y)", -2.0), ("-peak(y)", -1.0)]
            {
                assert!((value(text, std::slice::from_ref(&shifted)) - known).abs() < 1e-7, "{text} {ahead}");
            }
        }
        let corner = course(&|t| -(t - 2.034_f64).abs());
        assert!(value("max(y)", std::slice::from_ref(&corner)).abs() < 0.035);
        let jump = course(&|t| if t < 2.03 { 1.0 } else { 0.0 });
        assert_eq!(value("max(y)", std::slice::from_ref(&jump)), 1.0);
        assert_eq!(value("min(y)", std::slice::from_ref(&jump)), 0.0);
    }

    /// Values are those of `sweep` where they are extremes, and slopes those of neighbouring values.
    #[test]
    fn pieces_are_the_measures_and_their_derivatives() {
        use cotree::report::statistics::Accumulator;
        let course = wave(1.3, -0.4);
        let mut seen = Accumulator::new(course.times[0], course.values[0]);
        (1..course.times.len()).for_each(|row| seen.add(course.times[row], course.values[row]));
        for text in ["max(y)", "min(y)", "peak(y)", "range(y)", "mean(y)", "rms(y)", "first(y)", "y"] {
            for (sign, written) in [(1.0, text.to_owned()), (-1.0, format!("-{text}"))] {
                let known = sign * text.parse::<Measure>().unwrap().of(&seen);
                assert!((value(&written, std::slice::from_ref(&course)) - known).abs() < 1e-12, "{written}");
                let goal: Goal = written.parse().unwrap();
                for largest in parts(&goal, &[0], 1.0, false, std::slice::from_ref(&course)) {
                    for piece in largest {
                        let slope = piece.of(std::slice::from_ref(&course)).unwrap().slope;
                        let step = 1e-5;
                        for (column, [dp, dq]) in [[step, 0.0], [0.0, step]].into_iter().enumerate() {
                            let [up, down] = [1.0, -1.0]
                                .map(|side| piece.of(&[wave(1.3 + side * dp, -0.4 + side * dq)]).unwrap().value);
                            assert!(((up - down) / (2.0 * step) - slope[column]).abs() < 1e-8, "{written}");
                        }
                    }
                }
            }
        }
        assert!((value("2*max(y) - min(y)", std::slice::from_ref(&course)) - (2.0 * 0.9 + 1.7)).abs() < 1e-12);
    }
}
