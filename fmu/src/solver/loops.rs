//! Phi_q of the active loop equations, factored: for driven mechanisms, where it is square.

use super::Failure;
use super::dense::{Lu, Singular};
use crate::machine::Machine;
use crate::model::Model;

/// LU factors of Phi_q with preallocated storage.
#[derive(Clone, Debug)]
pub(crate) struct Loops {
    lu: Lu,
    /// Place of each constraint among the active ones.
    place: Vec<Option<usize>>,
    right: Vec<f64>,
}

impl Loops {
    pub fn new(model: &Model) -> Self {
        let mut place = vec![None; model.program().constraints.len()];
        for (index, &row) in model.active().iter().enumerate() {
            place[row] = Some(index);
        }
        let size = model.active().len();
        Self { lu: Lu::new(size), place, right: vec![0.0; size] }
    }

    /// Evaluates and factors Phi_q at the registers.
    pub fn factor(&mut self, model: &Model, machine: &mut Machine) -> Result<(), Singular> {
        let jacobian = &model.program().tapes.jacobian;
        machine.run(&jacobian.tape);
        let n = model.coordinates();
        let matrix = self.lu.matrix();
        for (&(row, column), value) in jacobian.entries.iter().zip(jacobian.tape.results(machine.registers())) {
            if let Some(row) = self.place[row as usize]
                && (column as usize) < n
            {
                matrix[row * n + column as usize] = value;
            }
        }
        self.lu.factor()
    }

    /// x of Phi_q x = b, with b given for all constraints.
    pub fn solve(&mut self, model: &Model, b: &[f64]) -> &[f64] {
        for (place, &row) in self.right.iter_mut().zip(model.active()) {
            *place = b[row];
        }
        self.lu.solve(&mut self.right);
        &self.right
    }

    /// Factors Phi_q, or names a coordinate that the drivers leave free.
    pub fn factor_regular(&mut self, model: &Model, machine: &mut Machine) -> Result<(), Failure> {
        self.factor(model, machine).map_err(|Singular(column)| Failure::Singular {
            time: machine.registers()[model.layout().time()],
            coordinate: model.program().coordinates[column].name.clone(),
        })
    }

    /// lambda of Phi_q^T lambda = b, zero for inactive constraints.
    pub fn reactions(&mut self, model: &Model, b: &[f64], reactions: &mut [f64]) {
        self.right.copy_from_slice(b);
        self.lu.solve_transposed(&mut self.right);
        reactions.fill(0.0);
        for (&value, &row) in self.right.iter().zip(model.active()) {
            reactions[row] = value;
        }
    }
}
