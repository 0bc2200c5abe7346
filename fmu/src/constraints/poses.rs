//! Loop equations as matrices, and random poses that fulfil them: for the exporter, which studies a mechanism before its kernels exist.

use nalgebra::{DMatrix, DVector};

use super::initial::FULFILLED;
use crate::linalg::least_squares::{Entry, Equations, project};
use crate::linalg::sparse::SparseRow;
use crate::machine::Machine;
use crate::math::Random;
use crate::model::{Model, State};

/// {Phi} at a state.
pub fn constraint(model: &Model, state: &State) -> DVector<f64> {
    let mut machine = Machine::new(model);
    machine.load(model, state);
    let tape = &model.program().tapes.constraint;
    machine.run(tape);
    DVector::from_iterator(tape.results.len(), tape.results(machine.registers()))
}

/// Phi_q at a state, m x n.
pub fn jacobian(model: &Model, state: &State) -> DMatrix<f64> {
    let mut machine = Machine::new(model);
    machine.load(model, state);
    let jacobian = &model.program().tapes.jacobian;
    machine.run(&jacobian.tape);
    let mut matrix = DMatrix::zeros(model.program().constraints.len(), model.coordinates());
    for (&(row, column), value) in jacobian.entries.iter().zip(jacobian.tape.results(machine.registers())) {
        if (column as usize) < matrix.ncols() {
            matrix[(row as usize, column as usize)] = value;
        }
    }
    matrix
}

/// The rows of Phi_q at a state, in units of the scales.
pub(crate) fn sparse_jacobian(model: &Model, state: &State) -> Vec<SparseRow> {
    let mut machine = Machine::new(model);
    Loops { model, machine: &mut machine, state: &mut state.clone(), only: None }.rows(&scaled(model, state))
}

/// The coordinates of a state in units of their scales.
pub(crate) fn scaled(model: &Model, state: &State) -> Vec<f64> {
    let coordinates = state.positions().iter().zip(&model.program().coordinates);
    coordinates.map(|(q, coordinate)| q / coordinate.scale).collect()
}

/// Those of some loop equations.
pub(crate) fn rows_of(model: &Model, state: &State, imposed: &[usize]) -> Vec<SparseRow> {
    let mut rows = sparse_jacobian(model, state);
    imposed.iter().map(|&row| std::mem::take(&mut rows[row])).collect()
}

/// The active loop equations without those that are open in the mode of a state.
pub(crate) fn closed(model: &Model, state: &State) -> Vec<usize> {
    let masks = &model.program().instants.masks;
    let is_open = |row: usize| {
        let own = masks.iter().find(|(own, _)| *own as usize == row);
        own.is_some_and(|(_, parameter)| state.parameters()[*parameter as usize] == 0.0)
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

/// Consistent poses near a state, the state itself first: random moves in all coordinates (up to `reach` in units of
/// their scales) and in time (up to `reach` seconds), then back to the loops, in so many parts of the way. The same every time; moves from which there is
/// no way back are left out.
pub fn consistent_poses(model: &Model, state: &State, samples: usize, reach: f64, parts: usize) -> Vec<State> {
    let mut random = Random::new(2);
    let mut machine = Machine::new(model);
    let mut poses = vec![state.clone()];
    for _ in 0..samples {
        let time = reach * random.symmetric().abs();
        let moves: Vec<f64> = (0..model.coordinates()).map(|_| reach * random.symmetric()).collect();
        poses.extend(moved(model, &mut machine, state, (time, &moves), reach.min(0.5), parts));
    }
    poses
}

/// The pose after a move in so many parts, each followed by the way back to the loops; none if there is no way back.
fn moved(
    model: &Model,
    machine: &mut Machine,
    state: &State,
    (time, moves): (f64, &[f64]),
    longest: f64,
    parts: usize,
) -> Option<State> {
    let mut pose = state.clone();
    let mut x = scaled(model, state);
    for part in 1..=parts {
        model.advance_signals(state, state.time() + time * part as f64 / parts as f64, pose.registers_mut());
        x.iter_mut().zip(moves).for_each(|(x, way)| *x += way / parts as f64);
        let mut loops = Loops { model, machine: &mut *machine, state: &mut pose, only: None };
        let r = project(&mut loops, &mut x, longest);
        // Written so that NaN is no way back.
        if !r.iter().all(|r| r.abs() <= FULFILLED) {
            return None;
        }
        loops.load(&x);
    }
    Some(pose)
}

/// Loop equations with q as the unknown, all of them unless only some are named.
pub(crate) struct Loops<'a> {
    pub model: &'a Model,
    pub machine: &'a mut Machine,
    pub state: &'a mut State,
    pub only: Option<&'a [usize]>,
}

impl Loops<'_> {
    /// Writes the coordinates, in units of their scales, to the state and the registers.
    pub fn load(&mut self, x: &[f64]) {
        let coordinates = &self.model.program().coordinates;
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

impl Equations for Loops<'_> {
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
            if let (Some(place), Some(coordinate)) = (place, program.coordinates.get(column)) {
                entries.push((place, column, value * coordinate.scale / program.constraints[row].scale));
            }
        }
    }
}
