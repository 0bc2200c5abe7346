//! The way out of a singular pose: the state a step later from which the motion comes back to the pose with the rates there.

use crate::context::Context;
use crate::linalg::ROUNDING_OF_SUMS;
use crate::math;
use crate::model::Model;
use crate::motion::Run;

/// Lengths that are tried for the step, each half of the one before.
const LENGTHS: usize = 12;
/// The first one turns nothing by more than this [rad, or scales].
const TURN: f64 = 0.3;
/// Corrections of the state after the step.
pub(crate) const STATE_CORRECTIONS: usize = 40;
/// A correction that is not smaller than this share of the one before the last is the last one: large and small ones may alternate.
const SLOW: f64 = 0.7;
/// What may be left of a correction of positions and of rates, or a tenth of the tolerance.
const EXACT: [f64; 2] = [1e-10; 2];
/// The same where a run begins: the pose itself cannot be known better, since its loops close to second order.
const POSE: f64 = 1e-6;
/// The same of the rates, relative to the largest; and in tolerances, to which the rates of a step are right.
const RATE: f64 = 1e-4;
const LOOSE: f64 = 10.0;

/// What a correction shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Again,
    /// The motion comes back to the pose.
    Found,
    Failed,
}

/// The search for the state so long after the start of the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    /// Length of the step [s].
    pub h: f64,
    /// The largest rate where the step begins, in scales.
    speed: f64,
    /// What may be left of positions and of rates.
    within: [f64; 2],
    /// The sizes of the last two corrections.
    before: [f64; 2],
}

impl Search {
    /// Those to be tried where the step begins, one after the other.
    pub fn all(context: &Context, run: &Run) -> impl Iterator<Item = Self> + use<> {
        let speed = run.speed(context.model);
        let longest = TURN / speed;
        let usual = if run.last.natural > 0.0 { f64::min(run.last.natural, longest) } else { longest };
        let first = usual.min(context.settings.max_step);
        let tolerance = context.settings.tolerance;
        let lengths = std::iter::successors(Some(first), |h| Some(0.5 * h)).take(LENGTHS).filter(|h| h.is_finite());
        let exact = EXACT.map(|left| math::maximum(left, tolerance / LOOSE));
        let given = [POSE.max(tolerance), RATE.max(LOOSE * tolerance)];
        let search = move |within| lengths.clone().map(move |h| Self { h, speed, within, before: [f64::INFINITY; 2] });
        let begins = !run.in_zone(run.last.end_time);
        [Some(exact), begins.then_some(given)].into_iter().flatten().flat_map(search)
    }

    /// Corrects the state at the end of the step by what `reached`, the place that the motion comes back to from there, is away from the start of the step; `reached`
    /// becomes the new state.
    pub fn correct(&mut self, model: &Model, start: &[f64], state: &[f64], reached: &mut [f64]) -> Verdict {
        let (n, mut left) = (model.coordinates(), [0.0, 0.0]);
        for (index, coordinate) in model.program().coordinates.iter().enumerate() {
            // Integrals of states begin at zero with every series.
            let dq = if index < model.mechanical() { start[index] - reached[index] } else { 0.0 };
            let dv = start[n + index] - reached[n + index];
            left[0] = math::maximum(left[0], dq.abs() / coordinate.scale);
            left[1] = math::maximum(left[1], dv.abs() / (coordinate.scale * self.speed));
            reached[index] = state[index] + dq + self.h * dv;
            reached[n + index] = state[n + index] + dv;
        }
        let size = math::maximum(left[0], self.h * self.speed * left[1]);
        if !size.is_finite() {
            return Verdict::Failed;
        }
        if size > ROUNDING_OF_SUMS && size <= SLOW * self.before[0] {
            self.before = [self.before[1], size];
            return Verdict::Again;
        }
        let close = left.iter().zip(self.within).all(|(left, within)| *left <= within);
        if close { Verdict::Found } else { Verdict::Failed }
    }
}
