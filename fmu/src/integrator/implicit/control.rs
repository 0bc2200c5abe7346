//! How long steps are, and how exact.

use super::{Implicit, ImplicitMemory};
use crate::context::Context;
use crate::linalg::SPACINGS;
use crate::math;

/// The error estimate is of order 3, the step of order 5: so much of tolerance^(4/5) makes the error of the motion follow the tolerance.
const IMPLICIT_TOLERANCE: f64 = 0.03;
/// Safety factor of the step size.
pub(super) const IMPLICIT_SAFETY: f64 = 0.9;
/// Limits on the change of the step size.
pub(super) const SHRINK: f64 = 0.2;
const IMPLICIT_GROWTH: f64 = 8.0;
/// A step that would grow by less keeps its length, and its factors.
const KEEP: f64 = 1.2;
/// A contraction that a longer step must not come near: steps that Newton's iterations limit grow by no more than leads there.
const SLOWEST: f64 = 0.15;
/// Iterations for which the safety factor is meant.
const USUAL_ITERATIONS: f64 = 7.0;
/// Smallest error that counts.
const SMALLEST_ERROR: f64 = 1e-10;
/// Longest first step [s].
const LONGEST_START: f64 = 1.0;

impl Implicit {
    /// What the error estimate of one step may be.
    pub(super) fn share(&mut self, tolerance: f64) -> f64 {
        if self.share[0] != tolerance {
            self.share = [tolerance, share(tolerance)];
        }
        self.share[1]
    }

    /// A step in which a motion that changes as fast as this one, and no faster, is wrong by less than the tolerance.
    pub(super) fn first_step(&self, context: &Context, start: &[f64]) -> f64 {
        let n = start.len() / 2;
        let mut frequency = 1.0 / LONGEST_START;
        for (index, coordinate) in context.model.program().coordinates.iter().enumerate() {
            let acceleration = self.radau.first()[n + index].abs() / coordinate.scale;
            frequency = math::maximum(frequency, start[n + index].abs() / coordinate.scale);
            frequency = math::maximum(frequency, acceleration.sqrt());
        }
        fourth_root(share(context.settings.tolerance)) / frequency
    }

    /// What rounding makes of the stages, in units of the tolerances: rates are differences of positions over the step.
    pub(super) fn noise(&self, start: &[f64], h: f64) -> f64 {
        let n = start.len() / 2;
        let rates = start[..n].iter().zip(&self.tolerances[n..]);
        let largest = rates.fold(0.0, |largest: f64, (q, tolerance)| largest.max((1.0 + q.abs()) / tolerance));
        SPACINGS * largest / h
    }

    /// The natural length of the next step.
    pub(super) fn propose(
        &self,
        memory: &ImplicitMemory,
        h: f64,
        error: f64,
        [iterations, contraction]: [f64; 2],
        rejected: bool,
    ) -> f64 {
        let error = error.max(SMALLEST_ERROR);
        let safety =
            IMPLICIT_SAFETY * f64::min(1.0, (1.0 + 2.0 * USUAL_ITERATIONS) / (iterations + 2.0 * USUAL_ITERATIONS));
        let mut factor = safety / fourth_root(error);
        if memory.step > 0.0 {
            let predicted = IMPLICIT_SAFETY * (memory.step.recip() * h) * fourth_root(memory.error / (error * error));
            factor = factor.min(predicted);
        }
        let most = if rejected { 1.0 } else { (SLOWEST / contraction).sqrt().clamp(1.0, IMPLICIT_GROWTH) };
        let factor = factor.clamp(SHRINK, most);
        if (1.0..=KEEP).contains(&factor) { h } else { factor * h }
    }

    /// Absolute tolerances of q and v for one step. Rates count relative to themselves, but not below the least that do, or one scale a step if that is
    /// less.
    pub(super) fn tolerate(&mut self, context: &Context, start: &[f64], h: f64, share: f64) {
        let (n, least) = (context.model.coordinates(), math::minimum(context.settings.least_rate, h.recip()));
        for (index, coordinate) in context.model.program().coordinates.iter().enumerate() {
            self.tolerances[index] = share * coordinate.scale;
            self.tolerances[n + index] = share * (least * coordinate.scale).max(start[n + index].abs());
        }
    }
}

/// What the error estimate of one step may be.
fn share(tolerance: f64) -> f64 {
    IMPLICIT_TOLERANCE * libm::pow(tolerance, 0.8)
}

pub(super) fn fourth_root(value: f64) -> f64 {
    value.sqrt().sqrt()
}
