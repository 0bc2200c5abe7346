//! Values at equal steps of the input, with the extremes and zeros between them, by polynomials through eight neighbours. Next to jumps and kinks (cams, forces on one
//! stroke) these are neighbours of one side, as in essentially non-oscillatory interpolation (Harten, Engquist, Osher, Chakravarthy, *J. Comput. Phys.* 71, 1987).

use cotree::model::Quantity;

/// Position, rate and acceleration: how a joint moves.
pub type Derivatives = [Quantity; 3];
/// The variables of a joint that turns.
pub const ANGULAR: Derivatives = Quantity::TURN;
/// The variables of a joint that slides.
pub const SLIDING: Derivatives = Quantity::SLIDE;
/// How many neighbours an interpolation uses.
const NEIGHBOURS: usize = 8;
/// Where polynomials through different neighbours differ by more than this share of what the values there do, the values are not smooth.
const SMOOTH: f64 = 1e-3;
/// Values below this share of the largest are rounding errors of zero.
const ROUNDING: f64 = 1e-12;

/// Values of one quantity at equal steps.
#[derive(Clone, Debug)]
pub struct Samples {
    /// The place of the first value, and the step.
    grid: [f64; 2],
    values: Vec<f64>,
    /// Does it begin again after the last value?
    periodic: bool,
}

/// A value and where it is.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ValueAt {
    pub input: f64,
    pub value: f64,
}

impl Samples {
    pub fn new(grid: [f64; 2], values: Vec<f64>, periodic: bool) -> Samples {
        Samples { grid, values, periodic }
    }

    /// Does it begin again after the last value?
    pub fn is_periodic(&self) -> bool {
        self.periodic
    }

    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The input at a sample.
    pub fn input(&self, index: usize) -> f64 {
        self.grid[0] + self.grid[1] * index as f64
    }

    fn value(&self, index: isize) -> Option<f64> {
        let count = self.values.len() as isize;
        let index = if self.periodic { index.rem_euclid(count) } else { index };
        self.values.get(usize::try_from(index).ok()?).copied()
    }

    /// The value at a place in steps.
    fn at(&self, place: f64) -> f64 {
        let place = if self.periodic { place.rem_euclid(self.values.len() as f64) } else { place };
        let first = self.first(place);
        let [centred, smoothest] = [first, self.smoothest(place)].map(|first| self.polynomial(first, place));
        let values = || (first..first + NEIGHBOURS as isize).filter_map(|index| self.value(index));
        let [least, most] = [f64::min, f64::max].map(|of| values().reduce(of).unwrap_or(0.0));
        if (centred - smoothest).abs() > SMOOTH * (most - least) { smoothest } else { centred }
    }

    /// The first of those neighbours of a place whose divided differences are the smallest.
    fn smoothest(&self, place: f64) -> isize {
        let used = NEIGHBOURS.min(self.values.len());
        let mut first = place.floor() as isize;
        if !self.periodic {
            first = first.clamp(0, self.values.len() as isize - 2.min(used as isize));
        }
        for order in 2..used {
            let [left, right] = [first - 1, first].map(|first| self.difference(first, order));
            if left < right {
                first -= 1;
            }
        }
        first
    }

    /// The size of a difference of so many orders from a sample on; infinite where there are no values.
    fn difference(&self, first: isize, order: usize) -> f64 {
        let mut values = [f64::INFINITY; NEIGHBOURS];
        for (value, index) in values.iter_mut().zip(first..=first + order as isize) {
            let Some(sample) = self.value(index) else { return f64::INFINITY };
            *value = sample;
        }
        for last in (1..=order).rev() {
            (0..last).for_each(|index| values[index] = values[index + 1] - values[index]);
        }
        values[0].abs()
    }

    /// The first of the neighbours of a place.
    fn first(&self, place: f64) -> isize {
        let count = self.values.len();
        let used = NEIGHBOURS.min(count) as isize;
        let first = place.floor() as isize - used / 2 + 1;
        if self.periodic { first } else { first.clamp(0, count as isize - used) }
    }

    /// The polynomial through neighbours.
    fn polynomial(&self, first: isize, place: f64) -> f64 {
        let used = NEIGHBOURS.min(self.values.len());
        let mut points = [[0.0; 2]; NEIGHBOURS];
        for (point, index) in points[..used].iter_mut().zip(first..) {
            let Some(value) = self.value(index) else { return f64::NAN };
            *point = [index as f64, value];
        }
        lagrange(&points[..used], place)
    }

    /// The value at an input.
    pub fn at_input(&self, input: f64) -> f64 {
        self.at((input - self.grid[0]) / self.grid[1])
    }

    /// The pairs of neighbours, by the index of the first.
    fn pairs(&self) -> impl Iterator<Item = (usize, [f64; 2])> {
        let last = if self.periodic { self.values.len() } else { self.values.len().saturating_sub(1) };
        (0..last).filter_map(|index| Some((index, [self.value(index as isize)?, self.value(index as isize + 1)?])))
    }

    /// Where it changes its sign, by halving between samples, and where it begins and ends to be zero.
    pub fn zeros(&self) -> Vec<f64> {
        let least = ROUNDING * self.values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let rounded = |value: f64| if value.abs() <= least { 0.0 } else { value };
        let mut zeros = Vec::new();
        for (index, pair) in self.pairs() {
            let [a, b] = pair.map(rounded);
            if a == 0.0 {
                // Of a dwell only its ends.
                let before = self.value(index as isize - 1).map(rounded);
                if b != 0.0 || before != Some(0.0) {
                    zeros.push(self.input(index));
                }
            } else if a * b < 0.0 {
                let (mut low, mut high) = (index as f64, index as f64 + 1.0);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if self.at(middle) * a > 0.0 { low = middle } else { high = middle }
                }
                zeros.push(self.grid[0] + self.grid[1] * 0.5 * (low + high));
            }
        }
        zeros
    }

    /// The largest value; between samples too.
    pub fn max(&self) -> ValueAt {
        self.extreme(1.0)
    }

    /// The smallest value; between samples too.
    pub fn min(&self) -> ValueAt {
        self.extreme(-1.0)
    }

    fn extreme(&self, sign: f64) -> ValueAt {
        let best = (0..self.values.len()).max_by(|&a, &b| (sign * self.values[a]).total_cmp(&(sign * self.values[b])));
        let best = best.unwrap_or(0) as f64;
        let last = self.values.len().saturating_sub(1) as f64;
        let (mut low, mut high) = (best - 1.0, best + 1.0);
        if !self.periodic {
            (low, high) = (low.max(0.0), high.min(last));
        }
        // Golden section; near the top rounding hides what is higher.
        const GOLDEN: f64 = 0.618_033_988_749_895;
        for _ in 0..60 {
            let (a, b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
            if sign * self.at(a) > sign * self.at(b) { high = b } else { low = a }
        }
        let middle = 0.5 * (low + high);
        let at_sample = sign * self.values.get(best as usize).copied().unwrap_or(f64::NAN);
        let place = if sign * self.at(middle) >= at_sample { middle } else { best };
        ValueAt { input: self.grid[0] + self.grid[1] * place, value: self.at(place) }
    }

    /// The mean over the input; of a stroke by trapezoids.
    pub fn mean(&self) -> f64 {
        let count = self.values.len() as f64;
        let sum: f64 = self.values.iter().sum();
        if self.periodic {
            return sum / count;
        }
        let ends = 0.5 * (self.values.first().unwrap_or(&0.0) + self.values.last().unwrap_or(&0.0));
        (sum - ends) / (count - 1.0)
    }

    /// The integral over the input, in the order of the samples.
    pub fn work(&self) -> f64 {
        self.mean() * self.span().copysign(self.grid[1])
    }

    /// The root of the mean square.
    pub fn rms(&self) -> f64 {
        self.map(|value| value * value).mean().sqrt()
    }

    /// Other values at the same places.
    pub fn made_of(&self, values: Vec<f64>) -> Samples {
        Samples { values, ..self.clone() }
    }

    /// Made of two, sample by sample.
    pub fn with(&self, other: &Samples, of: impl Fn(f64, f64) -> f64) -> Samples {
        let values = self.values.iter().zip(&other.values).map(|(&a, &b)| of(a, b)).collect();
        Samples { values, ..self.clone() }
    }

    /// How far the input goes.
    pub fn span(&self) -> f64 {
        let steps = if self.periodic { self.values.len() } else { self.values.len().saturating_sub(1) };
        (self.grid[1] * steps as f64).abs()
    }

    /// The runs of samples that are wanted; of a turn, with such that are not, they may go on beyond its end.
    pub fn pieces(&self, wanted: &[bool]) -> Vec<Samples> {
        let count = self.values.len();
        let first = if self.periodic { wanted.iter().position(|wanted| !wanted).unwrap_or(0) } else { 0 };
        let mut pieces: Vec<Samples> = Vec::new();
        let mut goes_on = false;
        for index in first..first + count {
            let is_wanted = wanted[index % count];
            if is_wanted && !goes_on {
                pieces.push(Samples { grid: [self.input(index), self.grid[1]], values: Vec::new(), periodic: false });
            }
            if let Some(piece) = pieces.last_mut().filter(|_| is_wanted) {
                piece.values.push(self.values[index % count]);
            }
            goes_on = is_wanted;
        }
        pieces
    }

    pub fn plus(&self, other: &Samples) -> Samples {
        self.with(other, |a, b| a + b)
    }

    pub fn minus(&self, other: &Samples) -> Samples {
        self.with(other, |a, b| a - b)
    }

    /// An angle without the jumps of whole turns; no longer periodic if it turns on and on.
    pub fn unwound(&self) -> Samples {
        use std::f64::consts::TAU;
        let mut turns = 0.0;
        let mut values: Vec<f64> = Vec::with_capacity(self.values.len() + 1);
        for &value in self.values.iter().chain(self.values.first().filter(|_| self.periodic)) {
            if let Some(last) = values.last() {
                turns = ((last - value) / TAU).round() * TAU;
            }
            values.push(value + turns);
        }
        let returns = self.periodic && turns == 0.0;
        if returns {
            values.pop();
        }
        Samples { values, periodic: returns, ..self.clone() }
    }

    /// The derivative by the input, from the polynomial through the neighbours.
    pub fn slope(&self) -> Samples {
        let count = self.values.len();
        let reach = 1e-3;
        let slope = |index: usize| {
            let place = (index as f64).clamp(reach, (count as f64 - 1.0 - reach).max(reach));
            let place = if self.periodic { index as f64 } else { place };
            (self.around(place, reach) - self.around(place, -reach)) / (2.0 * reach * self.grid[1])
        };
        Samples { values: (0..count).map(slope).collect(), ..self.clone() }
    }

    /// The value beside a place, by the polynomial of that place.
    fn around(&self, place: f64, offset: f64) -> f64 {
        self.polynomial(self.first(place), place + offset)
    }

    pub fn map(&self, of: impl Fn(f64) -> f64) -> Samples {
        Samples { values: self.values.iter().map(|&value| of(value)).collect(), ..self.clone() }
    }

    /// The integral from the first sample on, without the mean: that of a Fourier series is that of its terms, so each interval is
    /// integrated by the polynomial through its neighbours (Gauss's three points).
    pub fn fluctuation(&self) -> Samples {
        let mean = self.mean();
        let root = 0.6f64.sqrt();
        let mut sum = 0.0;
        let mut values = Vec::with_capacity(self.values.len());
        for index in 0..self.values.len() {
            values.push(sum);
            let middle = index as f64 + 0.5;
            let at = |offset: f64| self.at(middle + 0.5 * offset) - mean;
            if self.periodic || index + 1 < self.values.len() {
                sum += self.grid[1] * (5.0 * at(-root) + 8.0 * at(0.0) + 5.0 * at(root)) / 18.0;
            }
        }
        Samples { values, ..self.clone() }
    }
}

/// The value at a place of the polynomial through points (Lagrange).
pub(super) fn lagrange(points: &[[f64; 2]], place: f64) -> f64 {
    let mut sum = 0.0;
    for (i, [at, value]) in points.iter().enumerate() {
        let others = points.iter().enumerate().filter(|(j, _)| *j != i);
        sum += value * others.map(|(_, [other, _])| (place - other) / (at - other)).product::<f64>();
    }
    sum
}

/// A function over one turn.
#[cfg(test)]
pub(super) fn wave(of: impl Fn(f64) -> f64) -> Samples {
    let step = std::f64::consts::TAU / 720.0;
    Samples::new([0.0, step], (0..720).map(|index| of(step * f64::from(index))).collect(), true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn extremes_and_zeros_lie_between_samples() {
        let samples = wave(|x| (x - 0.1234).sin() + 0.3 * (2.0 * x).cos());
        let slope = |x: f64| (x - 0.1234).cos() - 0.6 * (2.0 * x).sin();
        for at in [samples.max(), samples.min()] {
            assert!(slope(at.input).abs() < 1e-7, "{at:?}");
            assert!((samples.at_input(at.input) - at.value).abs() < 1e-13);
        }
        let zeros = wave(|x| (x - 0.1234).sin()).zeros();
        assert!(zeros.iter().zip([0.1234, 0.1234 + PI]).all(|(a, b)| (a - b).abs() < 1e-12), "{zeros:?}");
    }

    #[test]
    fn any_input_has_a_value() {
        let wave = wave(f64::sin);
        assert!(wave.at_input(1e300).abs() <= 1.0 && wave.at_input(f64::NAN).is_nan());
        assert!((wave.at_input(-1.0) + 1f64.sin()).abs() < 1e-12);
    }

    #[test]
    fn a_jump_and_a_kink_do_not_oscillate() {
        let jump = wave(|x| if x < 1.0 { 1.0 + 0.1 * x } else { 0.1 * x.sin() });
        let (max, min) = (jump.max(), jump.min());
        assert!((max.value - 1.1).abs() < 1e-3 && (min.value + 0.1).abs() < 1e-9, "{max:?} {min:?}");
        let kink = wave(|x| 1.0 - (x - 1.0).abs());
        assert!((kink.max().value - 1.0).abs() < 5e-3 && kink.max().value <= 1.0);
        let dwell = wave(|x| if x < 2.0 { (1.0 - (x * PI).cos()) * 0.5 } else { 1e-17 }).zeros();
        assert_eq!(dwell.len(), 2, "{dwell:?}");
        assert!(dwell[0] == 0.0 && (dwell[1] - 2.0).abs() < TAU / 720.0);
    }

    #[test]
    fn means_and_integrals_are_those_of_the_function() {
        let samples = wave(|x| 2.0 + 3.0 * x.sin());
        assert!((samples.mean() - 2.0).abs() < 1e-12 && (samples.rms() - (4.0f64 + 4.5).sqrt()).abs() < 1e-12);
        let integral = samples.fluctuation();
        assert!((integral.max().value - integral.min().value - 6.0).abs() < 1e-10);
    }
}
