//! One number of a run: the largest value of a variable, its mean, when it is least.

use std::str::FromStr;

use crate::report::statistics::Accumulator;

/// What is made of a variable over time, and its word.
const KINDS: [(&str, Statistic); 10] = [
    ("max", Statistic::Max),
    ("min", Statistic::Min),
    ("peak", Statistic::Peak),
    ("range", Statistic::Range),
    ("mean", Statistic::Mean),
    ("rms", Statistic::RootMeanSquare),
    ("first", Statistic::First),
    ("last", Statistic::Last),
    ("when_max", Statistic::WhenMax),
    ("when_min", Statistic::WhenMin),
];

/// What a measure makes of the values of its variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// The largest.
    Max,
    /// The smallest.
    Min,
    /// The largest magnitude.
    Peak,
    /// The largest less the smallest.
    Range,
    /// The mean over time.
    Mean,
    /// The root of the mean square over time.
    RootMeanSquare,
    /// The first.
    First,
    /// The last.
    Last,
    /// When the largest is reached.
    WhenMax,
    /// When the smallest is reached.
    WhenMin,
}

/// A number of a run, written as `max(rod.angle)`. Extremes are those of the values at communication points; means are integrals over time
/// by the trapezoidal rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Measure {
    kind: Statistic,
    pub variable: String,
}

/// Why a text is no measure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct MeasureError(pub String);

fn words() -> String {
    KINDS.map(|(word, _)| word).join(", ")
}

impl FromStr for Measure {
    type Err = MeasureError;

    /// A variable alone stands for its last value.
    fn from_str(text: &str) -> Result<Self, MeasureError> {
        let text = text.trim();
        let Some((word, rest)) = text.split_once('(') else {
            return Ok(Measure::last(text));
        };
        let known = KINDS.iter().find(|(known, _)| *known == word.trim());
        let variable =
            rest.strip_suffix(')').map(str::trim).filter(|name| !name.is_empty() && !name.contains(['(', ')']));
        match (known, variable) {
            (Some(&(_, kind)), Some(variable)) => Ok(Measure { kind, variable: variable.to_owned() }),
            (None, Some(_)) => Err(MeasureError(format!("`{word}` is not one of {}", words(), word = word.trim()))),
            (_, None) => Err(MeasureError(format!("`{text}` is not a measure such as `max(variable)`"))),
        }
    }
}

impl std::fmt::Display for Measure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let word = KINDS.iter().find(|(_, kind)| *kind == self.kind).map_or("", |(word, _)| word);
        write!(f, "{word}({})", self.variable)
    }
}

impl Measure {
    /// What it makes of the variable.
    pub fn statistic(&self) -> Statistic {
        self.kind
    }

    /// Does it follow from the two ends of a run?
    pub fn is_of_ends(&self) -> bool {
        matches!(self.kind, Statistic::First | Statistic::Last)
    }

    /// The last value of a variable.
    pub fn last(variable: &str) -> Self {
        Measure { kind: Statistic::Last, variable: variable.to_owned() }
    }

    /// Its unit, given that of the variable.
    pub fn unit<'u>(&self, unit: &'u str) -> &'u str {
        if matches!(self.kind, Statistic::WhenMax | Statistic::WhenMin) { "s" } else { unit }
    }

    /// The number, once the run has ended.
    pub fn of(&self, seen: &Accumulator) -> f64 {
        match self.kind {
            Statistic::Max => seen.max.1,
            Statistic::Min => seen.min.1,
            Statistic::Peak => seen.max.1.abs().max(seen.min.1.abs()),
            Statistic::Range => seen.max.1 - seen.min.1,
            Statistic::Mean => seen.mean(),
            Statistic::RootMeanSquare => seen.rms(),
            Statistic::First => seen.first,
            Statistic::Last => seen.end,
            Statistic::WhenMax => seen.max.0,
            Statistic::WhenMin => seen.min.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(text: &str, points: &[(f64, f64)]) -> f64 {
        let mut seen = Accumulator::new(points[0].0, points[0].1);
        points[1..].iter().for_each(|&(time, value)| seen.add(time, value));
        text.parse::<Measure>().unwrap().of(&seen)
    }

    #[test]
    fn a_sine_has_its_known_measures() {
        let points: Vec<(f64, f64)> =
            (0..=100_000).map(|i| i as f64 * 1e-4).map(|t| (t, (0.2 * std::f64::consts::PI * t).sin())).collect();
        for (text, exact) in [
            ("max(x)", 1.0),
            ("min(x)", -1.0),
            ("range(x)", 2.0),
            ("mean(x)", 0.0),
            ("rms(x)", 0.5f64.sqrt()),
            ("when_max(x)", 2.5),
            ("when_min(x)", 7.5),
            ("peak(x)", 1.0),
            ("first(x)", 0.0),
            ("x", 0.0),
        ] {
            assert!((measured(text, &points) - exact).abs() < 1e-8, "{text}");
        }
        // One point has no duration.
        assert_eq!(["mean(x)", "rms(x)", "range(x)"].map(|text| measured(text, &[(1.0, -3.0)])), [-3.0, 3.0, 0.0]);
    }

    #[test]
    fn what_is_not_a_measure_is_refused() {
        let message = |text: &str| text.parse::<Measure>().unwrap_err().to_string();
        assert!(message("maximum(x)").contains("not one of max, min"), "{}", message("maximum(x)"));
        for text in ["max(x", "max()", "max(min(x))", "("] {
            assert!(text.parse::<Measure>().is_err(), "{text}");
        }
        assert_eq!(" max( rod.angle ) ".parse::<Measure>().unwrap().to_string(), "max(rod.angle)");
    }
}
