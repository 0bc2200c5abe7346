//! Peak values and crossing times, and their sensitivities.
//!
//! Of a peak Y = y(t*) it is dY/dp = y_p(t*) and dt*/dp = -y'_p / y''; of a time with y(t) = c it is dt/dp = -y_p / y'. Values and derivatives around it are
//! interpolated by a polynomial through Chebyshev's points, whose last coefficients say whether it is exact.

use std::f64::consts::PI;

use thiserror::Error;

use super::super::report::Features;
use super::super::{AnalysisFailure, SetError, Study, StudyError};
use super::corner::Switched;
use super::{Along, At, Varying};

/// Points of the polynomial, less one.
const DEGREE: usize = 14;
/// Its last coefficients may be this share of the largest derivative over the whole motion.
const EXACT: f64 = 1e-8;
/// How often the interval is made shorter, and to which share.
pub(super) const ROUNDS: usize = 8;
pub(super) const SHORTER: f64 = 0.2;
/// Peaks that are lower by more than this share of the extent are not the highest; so many are looked at.
const LOWER: f64 = 1e-2;
const MOST: usize = 12;
/// Peaks are equally high within this share of the extent.
pub(super) const EQUAL: f64 = 1e-8;
/// An output is constant if its extent is below this share of its size.
const CONSTANT: f64 = 1e-7;
/// Derivatives are the same within this share.
const SAME: f64 = 1e-5;
/// A value is touched, not crossed, if its rate over the interval is below this share of the extent.
const TOUCHED: f64 = 1e-9;
/// The motion is looked at in so many intervals of time, at least.
const INTERVALS: usize = 1000;
/// Places that are looked at for the highest value of a polynomial.
const PLACES: usize = 64;

/// What happens in a motion, and how that changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// The output, and its unit.
    pub output: (String, String),
    pub kind: FeatureKind,
    /// When \[s\].
    pub time: f64,
    /// The value then, SI.
    pub value: f64,
    /// How both change; or why they have no derivatives.
    pub changes: Result<FeatureDerivatives, NotDifferentiable>,
}

/// Why what happens has no derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NotDifferentiable {
    /// The output does not change.
    #[error("it is constant")]
    Constant,
    /// Another extreme has the same value.
    #[error("it has the same value at {time:?} s but another derivative")]
    EquallyHigh {
        /// When \[s\].
        time: f64,
    },
    /// A level is reached, but not crossed.
    #[error("it is touched without being crossed")]
    Touched,
    /// A corner of the course.
    #[error("it has a corner: derivatives differ on both sides")]
    Corner,
}

/// Derivatives of a value and of the time at which it is reached, one for each parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureDerivatives {
    /// Of the value.
    pub value: Vec<f64>,
    /// Of the time; zero at the ends of the run.
    pub time: Vec<f64>,
}

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeatureKind {
    Largest,
    Smallest,
    Crossing,
}

/// An interval in which something happens.
#[derive(Clone, Debug)]
pub(super) struct FeatureSearch {
    pub output: usize,
    pub kind: FeatureKind,
    /// The value that is crossed.
    pub level: f64,
    pub interval: [f64; 2],
}

impl Study {
    /// The largest and the smallest value of each output, and the times at which outputs cross given values \[SI\]; with their derivatives. The motion is looked at
    /// at these times \[s\], ascending, and between them, in 1000 intervals or more: what happens and is gone again within one of them is not seen.
    ///
    /// There are no derivatives at a corner of the output itself, of two different peaks that are equally high, where a value is touched without being crossed, and of what is constant.
    ///
    /// # Errors
    /// Those of [`Study::sensitivities`].
    pub fn features(&mut self, to: &[String], times: &[f64], levels: &[(String, f64)]) -> Result<Features, StudyError> {
        let name = self.name().to_owned();
        let times = &closer(times);
        self.varying(to, |varying| {
            let start: Vec<f64> = varying.parameters().iter().map(|parameter| parameter.start).collect();
            let Along { rows, switched, .. } = varying.along(&start, times, None, u64::MAX)?;
            varying.check_values(times, &rows)?;
            let course = SeenMotion { varying, start, times, rows, switched };
            let outputs: Vec<(String, String)> =
                varying.outputs().map(|(name, unit)| (name.to_owned(), unit.si.clone())).collect();
            let mut features = Vec::new();
            for output in 0..outputs.len() {
                for kind in [FeatureKind::Largest, FeatureKind::Smallest] {
                    features.push(course.extreme(output, kind, &outputs[output])?);
                }
            }
            for (name, level) in levels {
                let output = outputs.iter().position(|(candidate, _)| candidate == name);
                let known = || AnalysisFailure::Unknown(vec![SetError(format!("`{name}` is not an output"))]);
                features.extend(course.crossings(output.ok_or_else(known)?, *level, &outputs)?);
            }
            let parameters = varying
                .parameters()
                .iter()
                .map(|parameter| (parameter.name.clone(), parameter.unit.si.clone()))
                .collect();
            Ok(Features { name, parameters, features })
        })
    }
}

/// These times and others between them.
fn closer(times: &[f64]) -> Vec<f64> {
    let parts = INTERVALS.div_ceil(times.len().saturating_sub(1).max(1));
    let between = |pair: &[f64]| {
        let [low, high] = [pair[0], pair[1]];
        (0..parts).map(move |part| low + (high - low) * part as f64 / parts as f64)
    };
    let mut all: Vec<f64> = times.windows(2).flat_map(between).collect();
    all.extend(times.last());
    all.dedup();
    all
}

/// A motion that has been looked at.
pub(super) struct SeenMotion<'a, 'f> {
    varying: &'a Varying<'f>,
    start: Vec<f64>,
    times: &'a [f64],
    rows: Vec<At>,
    /// Laws that have switched.
    pub switched: Vec<Switched>,
}

impl SeenMotion<'_, '_> {
    fn value(&self, row: usize, output: usize) -> f64 {
        self.rows[row].0[output]
    }

    /// Largest less smallest value.
    pub(super) fn extent(&self, output: usize) -> f64 {
        let values = || (0..self.rows.len()).map(|row| self.value(row, output));
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    }

    /// The largest derivative with respect to each parameter.
    fn sizes(&self, output: usize) -> Vec<f64> {
        let size = |parameter: usize| self.rows.iter().map(|row| row.1[(output, parameter)].abs()).fold(0.0, f64::max);
        (0..self.start.len()).map(size).collect()
    }

    fn extreme(&self, output: usize, kind: FeatureKind, named: &(String, String)) -> Result<Feature, AnalysisFailure> {
        let sign = if kind == FeatureKind::Smallest { -1.0 } else { 1.0 };
        let extent = self.extent(output);
        let first = self.value(0, output);
        if extent <= CONSTANT * first.abs() {
            let changes = Err(NotDifferentiable::Constant);
            return Ok(Feature { output: named.clone(), kind, time: self.begin(), value: first, changes });
        }
        let mut found = Vec::new();
        for interval in self.peaks(output, sign) {
            found.push(self.refined(&FeatureSearch { output, kind, level: 0.0, interval }, named)?);
        }
        let highest =
            |best: Feature, other: Feature| if sign * (other.value - best.value) > 0.0 { other } else { best };
        let nothing = || AnalysisFailure::NoDerivative { time: self.begin(), what: "there is no motion".into() };
        let best = found.iter().cloned().reduce(highest).ok_or_else(nothing)?;
        // Of peaks that are the same the first counts.
        let mut equals: Vec<&Feature> =
            found.iter().filter(|candidate| sign * (best.value - candidate.value) <= EQUAL * extent).collect();
        equals.sort_by(|a, b| a.time.total_cmp(&b.time));
        let Some((&first, others)) = equals.split_first() else { return Ok(best) };
        let Some(other) = others.iter().find(|candidate| differs(first, candidate, &self.sizes(output))) else {
            return Ok(first.clone());
        };
        Ok(Feature { changes: Err(NotDifferentiable::EquallyHigh { time: other.time }), ..first.clone() })
    }

    fn begin(&self) -> f64 {
        self.times.first().copied().unwrap_or(0.0)
    }

    /// Intervals around the highest values.
    fn peaks(&self, output: usize, sign: f64) -> Vec<[f64; 2]> {
        let (extent, last) = (self.extent(output), self.rows.len().saturating_sub(1));
        let at = |row: usize| sign * self.value(row, output);
        let neighbours = |row: usize| [row.saturating_sub(1), (row + 1).min(last)];
        let is_peak = |&row: &usize| neighbours(row).iter().all(|&other| at(other) <= at(row));
        let mut rows: Vec<usize> = (0..self.rows.len()).filter(is_peak).collect();
        // Between the points a peak is higher by no more than the fall to its neighbours.
        let height =
            |row: usize| at(row) + neighbours(row).iter().map(|&other| at(row) - at(other)).fold(0.0, f64::max);
        let best = rows.iter().map(|&row| at(row)).fold(f64::MIN, f64::max);
        rows.retain(|&row| height(row) >= best - EQUAL * extent || at(row) >= best - LOWER * extent);
        rows.sort_by(|&a, &b| at(b).total_cmp(&at(a)));
        rows.truncate(MOST);
        rows.iter().map(|&row| neighbours(row).map(|other| self.times[other])).collect()
    }

    fn crossings(
        &self,
        output: usize,
        level: f64,
        outputs: &[(String, String)],
    ) -> Result<Vec<Feature>, AnalysisFailure> {
        let above = |row: usize| self.value(row, output) > level;
        let rows = (1..self.rows.len()).filter(|&row| above(row - 1) != above(row));
        let search = |row: usize| {
            let interval = [self.times[row - 1], self.times[row]];
            self.refined(&FeatureSearch { output, kind: FeatureKind::Crossing, level, interval }, &outputs[output])
        };
        rows.map(search).collect()
    }

    /// Finds what happens in an interval: between the times at which laws switch, or at one of them.
    fn refined(&self, search: &FeatureSearch, named: &(String, String)) -> Result<Feature, AnalysisFailure> {
        let [low, high] = search.interval;
        let switched: Vec<&Switched> =
            self.switched.iter().filter(|switched| low < switched.times[0] && switched.times[1] < high).collect();
        if switched.is_empty() { self.smooth(search, named) } else { self.pieces(search, named, &switched) }
    }

    /// The same where no law switches; where the polynomial is not exact the interval becomes shorter.
    pub(super) fn smooth(&self, search: &FeatureSearch, named: &(String, String)) -> Result<Feature, AnalysisFailure> {
        let FeatureSearch { output, kind, level, interval } = search.clone();
        let [begin, end] = [self.times.first(), self.times.last()].map(|time| time.copied().unwrap_or(0.0));
        let mut interval = interval;
        let feature = |time, value, changes| Feature { output: named.clone(), kind, time, value, changes };
        let (mut near, mut seen) = (interval[0], f64::NAN);
        for _ in 0..ROUNDS {
            let [low, high] = interval;
            if high <= low {
                break;
            }
            let (values, derivatives) = self.polynomials(output, interval)?;
            let place = match kind {
                FeatureKind::Crossing => values.crossing(level),
                FeatureKind::Largest => values.highest(1.0),
                FeatureKind::Smallest => values.highest(-1.0),
            };
            let time = low + 0.5 * (place + 1.0) * (high - low);
            (near, seen) = (time, values.at(place));
            if !self.are_exact(output, &values, &derivatives) {
                let half = 0.5 * SHORTER * (high - low);
                interval = [(time - half).max(low), (time + half).min(high)];
                continue;
            }
            // The interval ends before the peak does: there is something that no polynomial follows.
            if (place >= 1.0 && high < search.interval[1]) || (place <= -1.0 && low > search.interval[0]) {
                break;
            }
            let per_second = 2.0 / (high - low);
            let values_by: Vec<f64> = derivatives.iter().map(|derivative| derivative.at(place)).collect();
            let slope = values.slope();
            let is_end = kind != FeatureKind::Crossing && (time <= begin || time >= end);
            let times_by = match kind {
                _ if is_end => vec![0.0; values_by.len()],
                FeatureKind::Crossing if slope.at(place).abs() <= TOUCHED * self.extent(output) => {
                    return Ok(feature(time, level, Err(NotDifferentiable::Touched)));
                }
                FeatureKind::Crossing => values_by.iter().map(|by| -by / (slope.at(place) * per_second)).collect(),
                _ => {
                    let bend = slope.slope().at(place) * per_second;
                    derivatives.iter().map(|derivative| -derivative.slope().at(place) / bend).collect()
                }
            };
            let (value, values_by) = match kind {
                FeatureKind::Crossing => (level, vec![0.0; values_by.len()]),
                _ => (values.at(place), values_by),
            };
            return Ok(feature(time, value, Ok(FeatureDerivatives { value: values_by, time: times_by })));
        }
        Ok(feature(near, seen, Err(NotDifferentiable::Corner)))
    }

    /// The values at both ends of an interval.
    pub(super) fn ends(&self, search: &FeatureSearch) -> Result<[f64; 2], AnalysisFailure> {
        let rows = self.varying.at(&self.start, &search.interval)?;
        let value = |row: Option<&At>| row.map_or(f64::NAN, |row| row.0[search.output]);
        Ok([value(rows.first()), value(rows.last())])
    }

    /// Does the motion begin or end then?
    pub(super) fn is_end(&self, time: f64) -> bool {
        self.times.first() == Some(&time) || self.times.last() == Some(&time)
    }

    /// Do the last coefficients say that an output and its derivatives are these polynomials?
    pub(super) fn are_exact(&self, output: usize, values: &Polynomial, derivatives: &[Polynomial]) -> bool {
        let sizes = [self.extent(output)].into_iter().chain(self.sizes(output));
        [values].into_iter().chain(derivatives).zip(sizes).all(|(series, size)| series.tail() <= EXACT * size)
    }

    /// An output and its derivatives over an interval.
    pub(super) fn polynomials(
        &self,
        output: usize,
        [low, high]: [f64; 2],
    ) -> Result<(Polynomial, Vec<Polynomial>), AnalysisFailure> {
        let place = |index: usize| -(PI * index as f64 / DEGREE as f64).cos();
        let mut times: Vec<f64> = (0..=DEGREE).map(|index| low + 0.5 * (place(index) + 1.0) * (high - low)).collect();
        (times[0], times[DEGREE]) = (low, high);
        let rows = self.varying.at(&self.start, &times)?;
        let of = |pick: &dyn Fn(&At) -> f64| Polynomial::through(&rows.iter().map(pick).collect::<Vec<f64>>());
        let derivatives = (0..self.start.len()).map(|parameter| of(&|row| row.1[(output, parameter)])).collect();
        Ok((of(&|row| row.0[output]), derivatives))
    }
}

/// Do two peaks change differently? Derivatives are as large as these.
fn differs(one: &Feature, other: &Feature, sizes: &[f64]) -> bool {
    let (Ok(one), Ok(other)) = (&one.changes, &other.changes) else { return true };
    let pairs = one.value.iter().zip(&other.value).zip(sizes);
    pairs.into_iter().any(|((one, other), size)| (one - other).abs() > SAME * size)
}

/// Coefficients of Chebyshev's polynomials on -1..1.
#[derive(Clone, Debug)]
pub(super) struct Polynomial(Vec<f64>);

impl Polynomial {
    /// Through values at the extremes of the last one, ascending.
    fn through(values: &[f64]) -> Self {
        let last = values.len() - 1;
        let coefficient = |degree: usize| {
            let term = |index: usize| {
                let weight = if index == 0 || index == last { 0.5 } else { 1.0 };
                weight * values[last - index] * (PI * (degree * index) as f64 / last as f64).cos()
            };
            let weight = if degree == 0 || degree == last { 1.0 } else { 2.0 };
            weight / last as f64 * (0..=last).map(term).sum::<f64>()
        };
        Polynomial((0..=last).map(coefficient).collect())
    }

    /// Clenshaw's sum.
    pub fn at(&self, x: f64) -> f64 {
        let (mut last, mut before) = (0.0, 0.0);
        for coefficient in self.0.iter().skip(1).rev() {
            (last, before) = (2.0 * x * last - before + coefficient, last);
        }
        x * last - before + self.0.first().copied().unwrap_or(0.0)
    }

    pub fn slope(&self) -> Self {
        let count = self.0.len();
        let mut slope = vec![0.0; count + 1];
        for degree in (1..count).rev() {
            slope[degree - 1] = slope[degree + 1] + 2.0 * degree as f64 * self.0[degree];
        }
        slope[0] *= 0.5;
        slope.truncate(count.saturating_sub(1).max(1));
        Polynomial(slope)
    }

    /// The last coefficients.
    fn tail(&self) -> f64 {
        self.0.iter().rev().take(2).fold(0.0, |most: f64, coefficient| most.max(coefficient.abs()))
    }

    /// Where it is highest, or lowest.
    fn highest(&self, sign: f64) -> f64 {
        let places = (0..=PLACES).map(|index| 2.0 * index as f64 / PLACES as f64 - 1.0);
        let best =
            places.fold(-1.0, |best, place| if sign * self.at(place) > sign * self.at(best) { place } else { best });
        let near = 2.0 / PLACES as f64;
        self.slope().root([(best - near).max(-1.0), (best + near).min(1.0)]).unwrap_or(best)
    }

    /// Where it has a value.
    fn crossing(&self, level: f64) -> f64 {
        let mut shifted = self.clone();
        shifted.0[0] -= level;
        shifted.root([-1.0, 1.0]).unwrap_or(1.0)
    }

    /// Where it is zero, if it has different signs at the ends.
    fn root(&self, [mut low, mut high]: [f64; 2]) -> Option<f64> {
        let begin = self.at(low);
        if begin == 0.0 {
            return Some(low);
        }
        if (begin > 0.0) == (self.at(high) > 0.0) {
            return None;
        }
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if (self.at(middle) > 0.0) == (begin > 0.0) { low = middle } else { high = middle }
        }
        Some(0.5 * (low + high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_have_values_slopes_and_peaks() {
        let place = |index: usize| -(PI * index as f64 / DEGREE as f64).cos();
        let values: Vec<f64> = (0..=DEGREE).map(|index| (1.3 * place(index) - 0.4).cos()).collect();
        let polynomial = Polynomial::through(&values);
        for x in [-1.0, -0.37, 0.5, 1.0] {
            assert!((polynomial.at(x) - (1.3 * x - 0.4f64).cos()).abs() < 1e-12);
            assert!((polynomial.slope().at(x) + 1.3 * (1.3 * x - 0.4f64).sin()).abs() < 1e-10);
        }
        assert!((polynomial.highest(1.0) - 0.4 / 1.3).abs() < 1e-8 && polynomial.highest(-1.0) == -1.0);
        assert!((polynomial.crossing(0.3) - (0.4 - 0.3f64.acos()) / 1.3).abs() < 1e-9 && polynomial.tail() < 1e-11);
    }
}
