//! Dwells: the range of the input over which the output stays near an extreme position.

use std::f64::consts::TAU;

use serde::Serialize;

use super::samples::{Samples, ValueAt};

/// Limits of the same end of a stroke are equal but for this share of it.
const EQUAL: f64 = 1e-9;

/// The longest part of the turn or stroke in which the output stays within a tolerance of an end of its own stroke.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Dwell {
    pub tolerance: f64,
    pub position: f64,
    /// First and last input; the second may lie beyond a turn.
    pub from: f64,
    pub to: f64,
}

impl Dwell {
    /// Looks next to the two ends of the output's stroke, where it is at rest; none if it never is. From the first to the last of the ends of the input, which may go backwards.
    pub fn longest(
        output: &Samples,
        limits: &[ValueAt],
        tolerance: f64,
        ends: [f64; 2],
        periodic: bool,
    ) -> Option<Dwell> {
        let [first, last] = ends;
        let next_to = |limit: &ValueAt| {
            let [low, high] = around(output, limit, tolerance, [first.min(last), first.max(last)], periodic);
            let [from, to] = if first <= last { [low, high] } else { [high, low] };
            Dwell { tolerance, position: limit.value, from, to }
        };
        let of_values = |of: fn(f64, f64) -> f64| limits.iter().map(|limit| limit.value).reduce(of);
        let (low, high) = (of_values(f64::min)?, of_values(f64::max)?);
        let is_end = |value: f64| (value - low).min(high - value) <= EQUAL * (high - low);
        limits
            .iter()
            .filter(|limit| is_end(limit.value))
            .map(next_to)
            .max_by(|a, b| (a.to - a.from).abs().total_cmp(&(b.to - b.from).abs()))
    }
}

/// From where to where the output stays next to a limit.
fn around(output: &Samples, limit: &ValueAt, tolerance: f64, ends: [f64; 2], periodic: bool) -> [f64; 2] {
    let beyond = output.map(|value| (value - limit.value).powi(2) - tolerance * tolerance);
    let zeros = beyond.zeros();
    let turns: &[f64] = if periodic { &[-TAU, 0.0, TAU] } else { &[0.0] };
    let all = || zeros.iter().flat_map(|zero| turns.iter().map(move |turn| zero + turn));
    let before = all().filter(|&zero| zero <= limit.input).max_by(f64::total_cmp);
    let after = all().filter(|&zero| zero > limit.input).min_by(f64::total_cmp);
    [before.unwrap_or(ends[0]), after.unwrap_or(ends[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_dwells_where_it_turns() {
        let step = TAU / 720.0;
        let values = (0..720).map(|index| (step * f64::from(index)).cos()).collect();
        let wave = Samples::new([0.0, step], values, true);
        let limits = [ValueAt { input: 0.0, value: 1.0 }, ValueAt { input: TAU / 2.0, value: -1.0 }];
        let dwell = Dwell::longest(&wave, &limits, 0.1, [0.0, TAU], true).unwrap();
        assert!((dwell.to - dwell.from - 2.0 * 0.9f64.acos()).abs() < 1e-9, "{dwell:?}");
        assert_eq!(Dwell::longest(&wave, &[], 0.1, [0.0, TAU], true), None);
        let always = Dwell::longest(&wave, &limits, 3.0, [0.0, TAU], true).unwrap();
        assert_eq!([always.from, always.to], [0.0, TAU]);
    }
}
