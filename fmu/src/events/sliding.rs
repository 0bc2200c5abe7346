//! Switches to which both sides push the motion back.

use crate::machine::CANCELLED;
use crate::math;
use crate::model::Model;

/// Accelerations jump that differ by so many times as much as over the same way on one side.
pub(crate) const JUMPS: f64 = 10.0;

/// The coordinate whose acceleration differs most on the sides of a switch, if it jumps; `beyond` are accelerations as far behind the switch again. A law of what
/// joints hold switches by rounding errors, without a jump of accelerations.
pub(crate) fn pushed(
    model: &Model,
    tolerance: f64,
    rates: &[f64],
    [before, behind, beyond]: [&[f64]; 3],
) -> Option<usize> {
    let experiment = model.program().experiment;
    let scaled = |index: usize, value: f64| (value / model.program().coordinates[index].scale).abs();
    let largest = |of: &dyn Fn(usize) -> f64| (0..behind.len()).map(of).fold(0.0, math::maximum);
    let size = largest(&|index| math::maximum(scaled(index, behind[index]), scaled(index, rates[index]).powi(2)));
    let goes_on = largest(&|index| scaled(index, beyond[index] - behind[index]));
    let push = |index: usize| scaled(index, behind[index] - before[index]);
    // At rest all accelerations are rounding errors: what does not change rates by the tolerance in the whole experiment is no push.
    let felt = tolerance / (experiment.stop - experiment.start);
    // By 0 in place of rounding errors 4 of 225 runs with laws of a rate that loops hold at zero are refused.
    let least = math::maximum(JUMPS * goes_on, math::maximum(CANCELLED * size, felt));
    let most = (0..behind.len()).max_by(|&a, &b| push(a).total_cmp(&push(b)));
    most.filter(|&index| push(index) > least)
}
