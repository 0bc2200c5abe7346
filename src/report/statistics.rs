//! What a run amounts to: the extremes of each variable and when they are, its mean and its effective value.

use serde::Serialize;

use super::data::{Report, Table, named, number};
use crate::row;

/// A run in figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunStatistics {
    /// The unit of the times.
    pub time_unit: String,
    /// First and last time.
    pub span: [f64; 2],
    /// A line for each variable.
    pub variables: Vec<VariableFigures>,
}

/// A variable in figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VariableFigures {
    pub name: String,
    /// Its unit; empty if it has none.
    pub unit: String,
    /// The smallest value and when it is first reached.
    pub min: [f64; 2],
    /// The largest value and when it is first reached.
    pub max: [f64; 2],
    /// The mean over time.
    pub mean: f64,
    /// The root of the mean square over time.
    pub rms: f64,
    pub end: f64,
}

impl VariableFigures {
    /// The figures of a variable; none of nothing. Between its values it is taken as straight.
    pub fn of(name: &str, unit: &str, times: &[f64], values: &[f64]) -> Option<VariableFigures> {
        let mut points = times.iter().zip(values);
        let (&time, &value) = points.next()?;
        let mut seen = Accumulator::new(time, value);
        points.for_each(|(&time, &value)| seen.add(time, value));
        let Accumulator { min, max, end, .. } = seen;
        let [min, max] = [min, max].map(|(time, value)| [value, time]);
        Some(VariableFigures {
            name: name.into(),
            unit: unit.into(),
            min,
            max,
            mean: seen.mean(),
            rms: seen.rms(),
            end,
        })
    }
}

/// What is kept of a variable while it runs: a few numbers, however long the run. Extremes are those of the values that were added;
/// integrals take it as straight in between. Where it has no value (NaN) nothing is added, but to its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accumulator {
    /// The first value; NaN if it has none there.
    pub first: f64,
    /// The same of the end.
    pub end: f64,
    /// Time and value of the last one that it has, as of the extremes.
    pub last: (f64, f64),
    /// The largest value, where it is first reached.
    pub max: (f64, f64),
    /// The smallest value, where it is first reached.
    pub min: (f64, f64),
    duration: f64,
    integral: f64,
    square: f64,
}

impl Accumulator {
    /// Begins with the first value.
    pub fn new(time: f64, value: f64) -> Self {
        let here = (time, value);
        Accumulator {
            first: value,
            end: value,
            last: here,
            max: here,
            min: here,
            duration: 0.0,
            integral: 0.0,
            square: 0.0,
        }
    }

    pub fn add(&mut self, time: f64, value: f64) {
        self.end = value;
        if value.is_nan() {
            return;
        }
        if self.last.1.is_nan() {
            *self = Accumulator { first: self.first, ..Accumulator::new(time, value) };
            return;
        }
        let (before, old) = self.last;
        let step = time - before;
        self.duration += step;
        self.integral += 0.5 * step * (old + value);
        self.square += step * (old * old + old * value + value * value) / 3.0;
        self.last = (time, value);
        if value > self.max.1 {
            self.max = self.last;
        }
        if value < self.min.1 {
            self.min = self.last;
        }
    }

    /// Adds the next values of several variables, and begins with the first ones.
    pub fn add_all(all: &mut Vec<Accumulator>, time: f64, values: &[f64]) {
        if all.is_empty() {
            all.extend(values.iter().map(|&value| Accumulator::new(time, value)));
        } else {
            all.iter_mut().zip(values).for_each(|(statistic, &value)| statistic.add(time, value));
        }
    }

    /// The mean over time; of a single point its value.
    pub fn mean(&self) -> f64 {
        if self.duration > 0.0 { self.integral / self.duration } else { self.last.1 }
    }

    pub fn rms(&self) -> f64 {
        if self.duration > 0.0 { (self.square / self.duration).max(0.0).sqrt() } else { self.last.1.abs() }
    }
}

impl RunStatistics {
    pub fn report(&self) -> Report {
        let row = |VariableFigures { name, unit, min, max, mean, rms, end }: &VariableFigures| {
            let value = |value: f64| number(value, unit);
            let [[min, first], [max, then]] =
                [min, max].map(|[extreme, at]| [value(*extreme), number(*at, &self.time_unit)]);
            row![name, unit, min, first, max, then, value(*mean), value(*rms), value(*end)]
        };
        let at = named("at", &self.time_unit);
        let columns = row!["variable", "unit", "min", at, "max", at, "mean", "RMS", "end"];
        let table = Table { left: 2, ..Table::new(columns, self.variables.iter().map(row)) };
        Report { tables: vec![table], ..Report::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, SQRT_2};

    #[test]
    fn a_sine_has_its_known_figures() {
        let times: Vec<f64> = (0..=4000).map(|index| f64::from(index) * 2.0 * PI / 4000.0).collect();
        let values: Vec<f64> = times.iter().map(|time| 1.0 + 2.0 * time.sin()).collect();
        let figures = VariableFigures::of("x", "m", &times, &values).unwrap();
        assert!((figures.max[0] - 3.0).abs() < 1e-12 && (figures.max[1] - 0.5 * PI).abs() < 1e-12, "{figures:?}");
        assert!((figures.min[0] + 1.0).abs() < 1e-12 && (figures.min[1] - 1.5 * PI).abs() < 1e-12, "{figures:?}");
        assert!((figures.mean - 1.0).abs() < 1e-12);
        assert!((figures.rms - (1.0f64 + 4.0 / (SQRT_2 * SQRT_2)).sqrt()).abs() < 1e-5, "{}", figures.rms);
    }

    #[test]
    fn steps_of_any_length_count_by_their_length() {
        let figures = VariableFigures::of("x", "", &[0.0, 1.0, 4.0], &[0.0, 2.0, 2.0]).unwrap();
        assert_eq!((figures.mean, figures.rms, figures.end), (7.0 / 4.0, ((4.0 / 3.0 + 12.0) / 4.0f64).sqrt(), 2.0));
        let one = VariableFigures::of("x", "", &[3.0], &[-2.0]).unwrap();
        assert_eq!((one.mean, one.rms, one.min), (-2.0, 2.0, [-2.0, 3.0]));
        assert_eq!(VariableFigures::of("x", "", &[], &[]), None);
    }
}
