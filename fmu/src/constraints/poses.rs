//! Loop equations as matrices, and random poses that fulfil them: for the exporter, which studies a mechanism before its kernels exist.

use nalgebra::{DMatrix, DVector};

use super::initial::FULFILLED;
use crate::linalg::least_squares::{Entry, Equations, project};
use crate::linalg::sparse::Row;
use crate::machine::Machine;
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
pub(crate) fn sparse_jacobian(model: &Model, state: &State) -> Vec<Row> {
    let mut machine = Machine::new(model);
    let x: Vec<f64> = state
        .positions()
        .iter()
        .zip(&model.program().coordinates)
        .map(|(q, coordinate)| q / coordinate.scale)
        .collect();
    let mut entries = Vec::new();
    Loops { model, machine: &mut machine, state: &mut state.clone() }.jacobian(&x, &mut entries);
    let mut rows = vec![Row::new(); model.program().constraints.len()];
    entries.into_iter().for_each(|(row, column, value)| *rows[row].entry(column).or_default() += value);
    rows
}

/// Those of the active loop equations.
pub(crate) fn active_rows(model: &Model, state: &State) -> Vec<Row> {
    let mut rows = sparse_jacobian(model, state);
    model.active().iter().map(|&row| std::mem::take(&mut rows[row])).collect()
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
    let scales = model.program().coordinates.iter().map(|coordinate| coordinate.scale);
    let mut x: Vec<f64> = state.positions().iter().zip(scales).map(|(q, scale)| q / scale).collect();
    for part in 1..=parts {
        model.advance_signals(state, state.time() + time * part as f64 / parts as f64, pose.registers_mut());
        x.iter_mut().zip(moves).for_each(|(x, way)| *x += way / parts as f64);
        let mut loops = Loops { model, machine: &mut *machine, state: &mut pose };
        let r = project(&mut loops, &mut x, longest);
        // Written so that NaN is no way back.
        if !r.iter().all(|r| r.abs() <= FULFILLED) {
            return None;
        }
        loops.load(&x);
    }
    Some(pose)
}

/// All loop equations, with q as the unknown.
struct Loops<'a> {
    model: &'a Model,
    machine: &'a mut Machine,
    state: &'a mut State,
}

impl Loops<'_> {
    fn load(&mut self, x: &[f64]) {
        let coordinates = &self.model.program().coordinates;
        for ((place, x), coordinate) in self.state.positions_mut().iter_mut().zip(x).zip(coordinates) {
            *place = x * coordinate.scale;
        }
        self.machine.load(self.model, self.state);
    }
}

impl Equations for Loops<'_> {
    fn residuals(&mut self, x: &[f64], r: &mut Vec<f64>) {
        self.load(x);
        let tape = &self.model.program().tapes.constraint;
        self.machine.run(tape);
        let scales = self.model.program().constraints.iter().map(|constraint| constraint.scale);
        r.clear();
        r.extend(tape.results(self.machine.registers()).zip(scales).map(|(phi, scale)| phi / scale));
    }

    fn jacobian(&mut self, x: &[f64], entries: &mut Vec<Entry>) {
        self.load(x);
        let program = self.model.program();
        let jacobian = &program.tapes.jacobian;
        self.machine.run(&jacobian.tape);
        entries.clear();
        for (&(row, column), value) in jacobian.entries.iter().zip(jacobian.tape.results(self.machine.registers())) {
            let (row, column) = (row as usize, column as usize);
            if let Some(coordinate) = program.coordinates.get(column) {
                entries.push((row, column, value * coordinate.scale / program.constraints[row].scale));
            }
        }
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014): random enough for disturbances, and the same everywhere.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Between -1 and 1.
    pub fn symmetric(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Between 0 and 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }
}
