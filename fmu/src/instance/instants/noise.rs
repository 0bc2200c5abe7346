//! How well the sides of comparisons are known.
//!
//! What joints, stops or engaged joints hold is zero, or the value at which they took hold, but for rounding errors. These are errors of what is subtracted, which may be far larger than the
//! difference: so they are followed from the coordinates through the tape. An excess that is no further from zero may have either sign, and what varies by no more does not vary. In Model Exchange the coordinates have the importer's errors.

use super::super::Instance;
use super::Instants;
use super::importer::ERRORS_APART;
use crate::hybrid::contact::TOUCHING;
use crate::machine::{CANCELLED, ROUNDING};
use crate::math::maximum;

impl Instance {
    /// The error of the excess of each event of the scene where the sides were last evaluated: zero for contacts. Where a slope is infinite it is that of the sides alone.
    pub(super) fn find_noise(&mut self, instants: &mut Instants) {
        self.assume_errors(&mut instants.errors);
        let tape = &self.model.program().instants.sides;
        self.machine.bound_errors(tape, &mut instants.errors);
        for (noise, sides) in instants.noise.iter_mut().zip(tape.results.chunks_exact(2)) {
            let sum = |of: &[f64]| sides.iter().fold(0.0, |sum, &side| sum + of[side as usize].abs());
            let errors = sum(&instants.errors);
            *noise = if errors.is_finite() { errors } else { ROUNDING * sum(self.machine.registers()) };
        }
    }

    /// The errors of everything that the sides read.
    fn assume_errors(&self, errors: &mut [f64]) {
        let (layout, coordinates) = (self.model.layout(), &self.model.program().coordinates);
        let registers = self.machine.registers();
        for (error, value) in errors.iter_mut().zip(registers) {
            *error = ROUNDING * value.abs();
        }
        let accelerations = &registers[layout.accelerations()..layout.reactions()];
        let largest = accelerations
            .iter()
            .zip(coordinates)
            .fold(0.0, |largest, (value, coordinate)| maximum(largest, value.abs() / coordinate.scale));
        let share = if self.is_exchanged() { ERRORS_APART * self.importer_errors() } else { TOUCHING };
        // States are not held by anything.
        for (index, coordinate) in coordinates.iter().enumerate().take(self.model.mechanical()) {
            errors[layout.positions() + index] += share * coordinate.scale;
            let rate = layout.rates() + index;
            errors[rate] += share * maximum(coordinate.scale, registers[rate].abs());
            errors[layout.accelerations() + index] += CANCELLED * largest * coordinate.scale;
        }
        errors[layout.reactions()..layout.constants()].fill(CANCELLED * self.largest_reaction());
    }
}
