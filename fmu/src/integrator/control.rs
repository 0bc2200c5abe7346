//! Lengths of steps, for every method.

use crate::failure::Failure;
use crate::model::Model;

/// A step that would end at most this much further ends at the limit.
pub(crate) const STRETCH: f64 = 1.01;
/// Longest step, for motions that nothing else limits \[s\].
pub(crate) const LONGEST: f64 = 1e4;
/// Shortest step, in units of the spacing of floating-point times.
const SHORTEST: f64 = 16.0;
/// Times nearer to zero than this are spaced as if they were there \[s\].
const EARLY: f64 = 1e-6;

/// The shortest step at a time.
pub(crate) fn shortest(time: f64) -> f64 {
    SHORTEST * f64::EPSILON * time.abs().max(EARLY)
}

/// A proposed step within its limits; one that is no number is as long as they permit.
pub(crate) fn within(proposed: f64, shortest: f64, max_step: f64) -> f64 {
    proposed.min(LONGEST).min(max_step).max(shortest)
}

/// How far steps may go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Horizon {
    /// The communication point that is wanted.
    pub target: f64,
    /// Nothing is evaluated after this time.
    pub limit: f64,
}

/// What came of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    /// The run has come further, or sees the place where it is differently now.
    Stepped,
    /// None is taken: another method is to take it.
    Declined,
}

/// No step is short enough; names the coordinate that accelerates most, judging by the derivative where the step begins.
pub(crate) fn underflow(model: &Model, time: f64, derivative: &[f64], cause: Option<Failure>) -> Failure {
    let n = model.coordinates();
    let coordinates = &model.program().coordinates;
    let speed = |index: usize| {
        let size = derivative[n + index].abs() / coordinates[index].scale;
        if size.is_finite() { size } else { f64::INFINITY }
    };
    let fastest = (0..n).max_by(|&a, &b| speed(a).total_cmp(&speed(b)));
    let coordinate = fastest.map_or_else(|| model.program().name.clone(), |index| coordinates[index].name.clone());
    Failure::StepUnderflow { time, coordinate, cause: cause.map(Box::new) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_proposal_becomes_a_finite_step() {
        let least = shortest(0.0);
        for proposed in [0.0, 1e-300, 1.0, f64::INFINITY, f64::NAN] {
            let step = within(proposed, least, f64::INFINITY);
            assert!((least..=LONGEST).contains(&step), "{proposed} becomes {step}");
        }
        assert_eq!(within(1.0, least, 0.5), 0.5);
        assert!(shortest(1e9) > f64::EPSILON * 1e9);
    }
}
