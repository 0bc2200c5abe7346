//! How close the loop equations come to depending on each other: 1 / r^2 of each, where r is how far its row is from the others, as the kernel of the
//! accelerations leaves it in the registers.

use crate::machine::Machine;
use crate::model::Model;

/// A row that comes closer or goes away by no more than this factor in one step stays on its branch.
pub(crate) const SAME_BRANCH: f64 = 2.0;

/// 1 / r^2 where the accelerations have just been evaluated.
pub(crate) fn read(model: &Model, machine: &Machine, values: &mut [f64]) {
    let rows = model.program().tapes.reciprocal_pivots.iter();
    values.iter_mut().zip(rows).for_each(|(value, &register)| *value = machine.registers()[register as usize].abs());
}

/// Is a loop equation with this 1 / r^2 so close to the others? Both in one unit, or r as a share of what it was before elimination.
pub(crate) fn is_within(reciprocal: f64, distance: f64) -> bool {
    reciprocal.abs() > 1.0 / (distance * distance)
}

/// Has a row with these two values of 1 / r^2 come so much closer to the others, or gone so much further from them, that it could have gone over to another
/// branch? Not a number is a jump too.
pub(crate) fn is_jump(one: f64, other: f64) -> bool {
    !(1.0 / (SAME_BRANCH * SAME_BRANCH)..SAME_BRANCH * SAME_BRANCH).contains(&(other / one))
}
