//! Loop equations as equations for the pose, and the rows of their Jacobian, in units of the scales.
//!
//! A pose is given by the branch coordinates alone. What the scene adds as states of its own is no part of it: neither loops nor what depends on them may read or move a state.

use crate::linalg::least_squares::{Entry, ResidualFunction};
use crate::linalg::sparse::SparseRow;
use crate::machine::Machine;
use crate::model::{Model, State};

/// The rows of Phi_q at a state, in units of the scales.
pub fn sparse_jacobian(model: &Model, state: &State) -> Vec<SparseRow> {
    let mut machine = Machine::new(model);
    Loops { model, machine: &mut machine, state: &mut state.clone(), only: None }.rows(&scaled(model, state))
}

/// The branch coordinates of a state in units of their scales.
pub fn scaled(model: &Model, state: &State) -> Vec<f64> {
    let coordinates = state.positions().iter().zip(model.program().branch_coordinates());
    coordinates.map(|(q, coordinate)| q / coordinate.scale).collect()
}

/// Their rates in units of the scales.
pub fn scaled_rates(model: &Model, state: &State) -> Vec<f64> {
    let coordinates = state.rates().iter().zip(model.program().branch_coordinates());
    coordinates.map(|(rate, coordinate)| rate / coordinate.scale).collect()
}

/// Those of some loop equations.
pub fn rows_of(model: &Model, state: &State, imposed: &[usize]) -> Vec<SparseRow> {
    let mut rows = sparse_jacobian(model, state);
    imposed.iter().map(|&row| std::mem::take(&mut rows[row])).collect()
}

/// The active loop equations without those that are open in the mode of a state.
pub(crate) fn closed(model: &Model, state: &State) -> Vec<usize> {
    let masks = &model.program().instants.masks;
    let is_open = |row: usize| {
        let mask = masks.iter().find(|(masked, _)| *masked as usize == row);
        mask.is_some_and(|(_, closed)| state.discrete()[*closed as usize] == 0.0)
    };
    model.active().iter().copied().filter(|&row| !is_open(row)).collect()
}

/// The loop equations that count in a pose: the active ones or, where others repeat them, as many of all as are furthest from depending on each other there.
pub(crate) fn imposed(model: &Model, state: &State) -> Vec<usize> {
    let eligible = model.eligible();
    if eligible.is_empty() {
        return closed(model, state);
    }
    let mut left: Vec<(usize, SparseRow)> = eligible.iter().copied().zip(rows_of(model, state, eligible)).collect();
    let square = |row: &SparseRow| row.values().map(|entry| entry * entry).sum::<f64>();
    let mut chosen = Vec::with_capacity(model.active().len());
    while chosen.len() < model.active().len() {
        let furthest = (0..left.len()).max_by(|&a, &b| square(&left[a].1).total_cmp(&square(&left[b].1)));
        let Some(furthest) = furthest else { break };
        let (row, direction) = left.swap_remove(furthest);
        chosen.push(row);
        let size = square(&direction);
        if size > 0.0 {
            left.iter_mut().for_each(|(_, other)| take_off(other, &direction, size));
        }
    }
    chosen.sort_unstable();
    chosen
}

/// Takes the part along a direction with this square out of a row.
fn take_off(row: &mut SparseRow, direction: &SparseRow, square: f64) {
    let product: f64 = direction.iter().filter_map(|(column, part)| Some(row.get(column)? * part)).sum();
    if product != 0.0 {
        direction.iter().for_each(|(&column, part)| *row.entry(column).or_default() -= product / square * part);
    }
}

/// Loop equations with the branch coordinates as the unknowns, all of them unless only some are named.
pub struct Loops<'a> {
    /// Whose equations they are.
    pub model: &'a Model,
    /// On which their tapes run.
    pub machine: &'a mut Machine,
    /// Where time and what drives stand; its coordinates are those that were loaded last.
    pub state: &'a mut State,
    /// In ascending order.
    pub only: Option<&'a [usize]>,
}

impl Loops<'_> {
    /// Writes the branch coordinates, in units of their scales, to the state and the registers.
    pub fn load(&mut self, x: &[f64]) {
        let coordinates = self.model.program().branch_coordinates();
        for ((place, x), coordinate) in self.state.positions_mut().iter_mut().zip(x).zip(coordinates) {
            *place = x * coordinate.scale;
        }
        self.machine.load(self.model, self.state);
    }

    /// The rows of the Jacobian, in units of the scales.
    pub fn rows(&mut self, x: &[f64]) -> Vec<SparseRow> {
        let mut entries = Vec::new();
        self.jacobian(x, &mut entries);
        let mut rows = vec![SparseRow::new(); self.only.map_or(self.model.program().constraints.len(), <[usize]>::len)];
        entries.into_iter().for_each(|(row, column, value)| *rows[row].entry(column).or_default() += value);
        rows
    }
}

impl ResidualFunction for Loops<'_> {
    fn residuals(&mut self, x: &[f64], r: &mut Vec<f64>) {
        self.load(x);
        let tape = &self.model.program().tapes.constraint;
        self.machine.run(tape);
        let constraints = &self.model.program().constraints;
        let residual = |row: usize| self.machine.result(tape, row) / constraints[row].scale;
        r.clear();
        match self.only {
            Some(only) => r.extend(only.iter().map(|&row| residual(row))),
            None => r.extend((0..constraints.len()).map(residual)),
        }
    }

    fn jacobian(&mut self, x: &[f64], entries: &mut Vec<Entry>) {
        self.load(x);
        let program = self.model.program();
        let jacobian = &program.tapes.jacobian;
        self.machine.run(&jacobian.tape);
        entries.clear();
        for (&(row, column), value) in jacobian.entries.iter().zip(jacobian.tape.results(self.machine.registers())) {
            let (row, column) = (row as usize, column as usize);
            let place = self.only.map_or(Some(row), |only| only.binary_search(&row).ok());
            if let (Some(place), Some(coordinate)) = (place, program.branch_coordinates().get(column)) {
                entries.push((place, column, value * coordinate.scale / program.constraints[row].scale));
            }
        }
    }
}
