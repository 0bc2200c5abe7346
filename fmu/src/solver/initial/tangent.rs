//! How the first consistent state changes with parameters, inputs and initial values.

use nalgebra::{DMatrix, DVector};

use super::column_scale;
use crate::machine::Machine;
use crate::model::Model;
use crate::program::{Condition, FollowerOrder, SparseTape};
use crate::tape::Tape;

/// Singular values below this share of the largest do not count.
const RANK: f64 = 1e-10;

/// Equations of one level: those of the loops and the known conditions.
struct Level<'a> {
    loops: &'a Tape,
    conditions: &'a [Condition],
    condition: &'a Tape,
    condition_jacobian: &'a SparseTape,
    /// Registers of the unknowns: those of the coordinates, then those of the followers.
    unknowns: Vec<Option<usize>>,
}

/// Completes a direction of parameters and inputs by that of the assembled state: the linearised equations, with the smallest movement
/// where they leave a choice.
pub(crate) fn assemble(model: &Model, machine: &mut Machine, tangents: &mut [f64]) {
    let (program, layout) = (model.program(), model.layout());
    let (tapes, initial) = (&program.tapes, &program.initial);
    let (n, f) = (model.coordinates(), program.followers.len());
    let registers = |first: usize, count: usize| (first..first + count).map(Some);
    let rates = program.followers.iter().enumerate().map(|(index, follower)| {
        (follower.order == FollowerOrder::Acceleration).then_some(layout.follower_rates() + index)
    });
    let positions = Level {
        loops: &tapes.constraint,
        conditions: &initial.positions,
        condition: &initial.position,
        condition_jacobian: &initial.position_jacobian,
        unknowns: registers(layout.positions(), n).chain(registers(layout.followers(), f)).collect(),
    };
    let velocities = Level {
        loops: &tapes.constraint_rate,
        conditions: &initial.velocities,
        condition: &initial.velocity,
        condition_jacobian: &initial.velocity_jacobian,
        unknowns: registers(layout.rates(), n).chain(rates).collect(),
    };
    positions.solve(model, machine, tangents);
    velocities.solve(model, machine, tangents);
}

impl Level<'_> {
    fn solve(&self, model: &Model, machine: &mut Machine, tangents: &mut [f64]) {
        let known: Vec<usize> = (0..self.conditions.len()).filter(|&row| self.conditions[row].known).collect();
        let loops = model.program().constraints.len();
        let mut right = DVector::zeros(loops + known.len());
        let mut matrix = DMatrix::zeros(right.len(), self.unknowns.len());
        if matrix.is_empty() {
            return;
        }
        machine.differentiate(self.loops, tangents, &mut right.as_mut_slice()[..loops]);
        let mut conditions = vec![0.0; 2 * self.conditions.len()];
        machine.differentiate(self.condition, tangents, &mut conditions);
        for (row, &index) in known.iter().enumerate() {
            right[loops + row] = conditions[index] - conditions[self.conditions.len() + index];
        }
        self.fill(model, machine, &model.program().tapes.jacobian, Some, &mut matrix);
        let place = |row: usize| known.iter().position(|&index| index == row).map(|row| loops + row);
        self.fill(model, machine, self.condition_jacobian, place, &mut matrix);
        let svd = matrix.svd(true, true);
        let limit = RANK * svd.singular_values.max();
        // Both factors were asked for, so there is a solution.
        let Ok(step) = svd.solve(&right, limit) else { return };
        for (column, register) in self.unknowns.iter().enumerate() {
            if let Some(register) = *register {
                tangents[register] = -step[column] * column_scale(model, column);
            }
        }
    }

    /// Entries of a sparse matrix, with unknowns in units of their scales.
    fn fill(
        &self,
        model: &Model,
        machine: &mut Machine,
        sparse: &SparseTape,
        place: impl Fn(usize) -> Option<usize>,
        matrix: &mut DMatrix<f64>,
    ) {
        machine.run(&sparse.tape);
        for (&(row, column), value) in sparse.entries.iter().zip(sparse.tape.results(machine.registers())) {
            let column = column as usize;
            if let Some(row) = place(row as usize)
                && self.unknowns[column].is_some()
            {
                matrix[(row, column)] = value * column_scale(model, column);
            }
        }
    }
}
