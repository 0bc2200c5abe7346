//! How the first consistent state changes with parameters, inputs and initial values: by the linearised equations where these determine it,
//! otherwise as the search for it does.

use nalgebra::{DMatrix, DVector};

use super::{column_scale, solve_initial};
use crate::failure::Failure;
use crate::linalg::RANK;
use crate::linalg::singular_values::svd;
use crate::machine::Machine;
use crate::model::Model;
use crate::program::{Condition, FollowerOrder, SparseTape};
use crate::tape::Tape;

/// Equations of one level: those of the loops and the known conditions.
struct Level<'a> {
    loops: &'a Tape,
    conditions: &'a [Condition],
    condition: &'a Tape,
    condition_jacobian: &'a SparseTape,
    /// Registers of the unknowns: those of the coordinates, then those of the followers.
    unknowns: Vec<Option<usize>>,
}

/// Completes a direction of parameters and inputs by that of the assembled state.
///
/// # Errors
/// The equations leave a choice, and nothing can be assembled nearby.
pub(crate) fn assemble(model: &Model, machine: &mut Machine, tangents: &mut [f64]) -> Result<(), Failure> {
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
    let rest = machine.registers()[layout.rates()..layout.accelerations()].iter().all(|rate| *rate == 0.0);
    // Rates that are zero for want of a reason change as little as they can.
    if positions.solve(model, machine, tangents) && (velocities.solve(model, machine, tangents) || rest) {
        return Ok(());
    }
    searched(model, machine.registers(), tangents)
}

impl Level<'_> {
    /// False if the equations leave a choice.
    fn solve(&self, model: &Model, machine: &mut Machine, tangents: &mut [f64]) -> bool {
        let known: Vec<usize> = (0..self.conditions.len()).filter(|&row| self.conditions[row].known).collect();
        let loops = model.program().constraints.len();
        let mut right = DVector::zeros(loops + known.len());
        let mut matrix = DMatrix::zeros(right.len(), self.unknowns.len());
        let unknowns = self.unknowns.iter().flatten().count();
        if matrix.is_empty() {
            return unknowns == 0;
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
        let svd = svd(matrix, true, true);
        let limit = RANK * svd.singular_values.max();
        // Both factors were asked for, so there is a solution.
        let Ok(step) = svd.solve(&right, limit) else { return false };
        for (column, register) in self.unknowns.iter().enumerate() {
            if let Some(register) = *register {
                tangents[register] = -step[column] * column_scale(model, column);
            }
        }
        svd.rank(limit) == unknowns
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

/// Derivatives of the assembled state by differences of what the search finds: to the fourth order, so that little more than rounding is lost.
fn searched(model: &Model, registers: &[f64], tangents: &mut [f64]) -> Result<(), Failure> {
    /// Relative to what changes: as far as the loops can follow.
    const STEPS: [f64; 3] = [1e-3, 1e-5, 1e-7];
    let layout = model.layout();
    let (given, found) = (layout.parameters()..layout.followers(), layout.followers()..layout.accelerations());
    let sizes = given.clone().filter(|&register| tangents[register] != 0.0).map(|register| {
        let value = registers[register].abs();
        let size = if value > 0.0 { value } else { 1.0 };
        size / tangents[register].abs()
    });
    let size = sizes.fold(f64::INFINITY, f64::min);
    if !size.is_finite() {
        tangents[found].fill(0.0);
        return Ok(());
    }
    let at = |by: f64| -> Result<Vec<f64>, Failure> {
        let mut state = model.default_state(registers[layout.time()]);
        let places = state.registers_mut()[given.clone()].iter_mut().zip(given.clone());
        places.for_each(|(place, register)| *place = registers[register] + by * tangents[register]);
        solve_initial(model, &mut state)?;
        Ok(state.registers()[found.clone()].to_vec())
    };
    let slopes = |step: f64| -> Result<Vec<f64>, Failure> {
        let [a, b, c, d] = [at(-step)?, at(-step / 2.0)?, at(step / 2.0)?, at(step)?];
        let slope = |index: usize| (8.0 * (c[index] - b[index]) - (d[index] - a[index])) / (6.0 * step);
        Ok((0..a.len()).map(slope).collect())
    };
    let [first, rest @ ..] = STEPS;
    let tried = rest.iter().fold(slopes(first * size), |found, step| found.or_else(|_| slopes(step * size)));
    tangents[found.clone()].copy_from_slice(&tried?);
    Ok(())
}
