//! Loop equations of a model at a state, as a vector and a matrix: what is shown of them, and what assemblies are compared by.

use cotree_fmu::machine::Machine;
use cotree_fmu::model::{Model, State};
use nalgebra::{DMatrix, DVector};

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
