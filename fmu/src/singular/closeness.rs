//! How close the loop equations come to depending on each other: 1 / r^2 of each, where r is how far its row is from the others, as the kernel of the
//! accelerations leaves it in the registers.

use crate::context::Context;
use crate::machine::Machine;
use crate::model::{Model, State};

/// Are there loop equations that may come to depend on each other?
pub(crate) fn is_watched(model: &Model) -> bool {
    !model.program().tapes.closeness.is_empty()
}

/// 1 / r^2 where the accelerations have just been evaluated.
pub(crate) fn read(model: &Model, machine: &Machine, values: &mut [f64]) {
    let rows = model.program().tapes.closeness.iter();
    values.iter_mut().zip(rows).for_each(|(value, &register)| *value = machine.registers()[register as usize].abs());
}

/// The smallest r at a time and (q, v), as a share of a reference given as 1 / r^2.
pub(crate) fn share_at(context: &mut Context, origin: &State, time: f64, motion: &[f64], reference: &[f64]) -> f64 {
    let Context { model, machine, statistics, .. } = context;
    machine.load_signals(model, origin, time);
    machine.load_motion(model, motion);
    machine.run(&model.program().tapes.acceleration);
    statistics.evaluations += 1;
    let rows = model.program().tapes.closeness.iter().zip(reference);
    let share = |(&register, reference): (&u32, &f64)| reference / machine.registers()[register as usize].abs();
    // Where a row depends on the others exactly, those after it are no numbers.
    rows.map(share).fold(f64::INFINITY, |least, share| if share < least { share } else { least }).sqrt()
}
