//! Round numbers along an axis.

use crate::alike::Alike;

/// Shortest axis relative to the largest value on it.
const FLATTEST: f64 = 2e-3;

/// An axis: its range, and the round numbers in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    pub range: [f64; 2],
    pub at: Vec<f64>,
    /// Decimal exponent of the distance between them.
    exponent: i32,
}

impl Ticks {
    /// An axis exactly over the finite ones among some values, with about `count` ticks.
    pub fn over(values: impl Iterator<Item = f64>, count: usize) -> Self {
        Self::between(range(values), count)
    }

    pub fn around(values: impl Iterator<Item = f64>, count: usize) -> Self {
        let [low, high] = range(values);
        let space = 0.05 * (high - low);
        Self::between([low - space, high + space], count)
    }

    /// The same middle with another length.
    pub fn widened(&self, length: f64, count: usize) -> Self {
        let middle = 0.5 * (self.range[0] + self.range[1]);
        Self::between([middle - 0.5 * length, middle + 0.5 * length], count)
    }

    fn between([low, high]: [f64; 2], count: usize) -> Self {
        let rough = (high - low) / count.max(1) as f64;
        let mut exponent = rough.decimal_logarithm().floor() as i32;
        let mantissa = rough / 10f64.powi(exponent);
        let mantissa = [1.0, 2.0, 5.0].into_iter().find(|&round| mantissa <= round * 1.0001).unwrap_or(10.0);
        let step = mantissa * 10f64.powi(exponent);
        if mantissa == 10.0 {
            exponent += 1;
        }
        let slack = 1e-9 * (high - low) / step;
        let (first, last) = ((low / step - slack).ceil(), (high / step + slack).floor());
        let steps = (last - first).clamp(0.0, 50.0) as usize;
        let at = (0..=steps).map(|index| (first + index as f64) * step).collect();
        Self { range: [low, high], at, exponent }
    }

    /// The same axis with whole numbers only.
    pub fn whole(mut self) -> Self {
        self.at.retain(|at| at.fract() == 0.0);
        self
    }

    /// Where a value is on the axis: 0 at its beginning, 1 at its end.
    pub fn part(&self, value: f64) -> f64 {
        (value - self.range[0]) / (self.range[1] - self.range[0])
    }

    /// A tick's text: all ticks of an axis with the same number of decimals, or as powers of ten.
    pub fn label(&self, value: f64) -> String {
        let largest = self.range[0].abs().max(self.range[1].abs());
        if largest >= 1e5 || self.exponent < -4 {
            let digits = (largest.decimal_logarithm().floor() as i32 - self.exponent).clamp(0, 12);
            let text = format!("{value:.*e}", digits as usize);
            return if value == 0.0 { "0".to_owned() } else { text };
        }
        let text = format!("{value:.*}", usize::try_from(-self.exponent).unwrap_or(0));
        if text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.')) { text.replace('-', "") } else { text }
    }
}

/// Smallest and largest finite value, made to differ.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    // Values near the end of the number range would make the axis infinitely long.
    let finite = values.filter(|value| value.abs() < 1e300);
    let bounds = finite.fold(None, |bounds: Option<[f64; 2]>, value| {
        let [low, high] = bounds.unwrap_or([value, value]);
        Some([low.min(value), high.max(value)])
    });
    let [low, high] = bounds.unwrap_or([0.0, 1.0]);
    // Nearly constant values are drawn as a level line: rounding errors are not magnified.
    let least = FLATTEST * low.abs().max(high.abs());
    if high - low > least {
        [low, high]
    } else if least > 0.0 {
        let middle = 0.5 * (low + high);
        [middle - 0.5 * least, middle + 0.5 * least]
    } else {
        [-1.0, 1.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        let ticks = Ticks::over([low, high].into_iter(), 5);
        ticks.at.iter().map(|&at| ticks.label(at)).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(0.0, 10.0), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(-0.031, 0.012), ["-0.03", "-0.02", "-0.01", "0.00", "0.01"]);
        assert_eq!(labels(0.0, 0.5), ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(labels(0.0, 3e7), ["0", "1e7", "2e7", "3e7"]);
        assert_eq!(labels(0.0, 9.9), ["0", "2", "4", "6", "8"]);
    }

    #[test]
    fn what_hardly_changes_has_short_labels() {
        let ticks = Ticks::around([10.619_632, 10.619_636].into_iter(), 5);
        let labels: Vec<_> = ticks.at.iter().map(|&at| ticks.label(at)).collect();
        assert_eq!(labels, ["10.610", "10.615", "10.620", "10.625", "10.630"]);
    }

    #[test]
    fn any_values_give_an_axis() {
        for values in [vec![], vec![0.0], vec![3.0, 3.0], vec![f64::NAN], vec![-1e308, 1e308], vec![1e-300, 2e-300]] {
            let ticks = Ticks::around(values.iter().copied(), 5);
            assert!(ticks.range[0] < ticks.range[1], "{values:?} {ticks:?}");
            assert!(ticks.at.iter().all(|&at| ticks.part(at).is_finite()), "{values:?} {ticks:?}");
        }
    }
}
