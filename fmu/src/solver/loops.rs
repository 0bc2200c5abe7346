//! Phi_q of the active loop equations, factored: for driven mechanisms, where it is square.
//!
//! The equations come in blocks, each of which needs only what the blocks before it determine: Phi_q is block triangular. So positions,
//! rates and accelerations follow block after block, reactions from the last block to the first, each with a small dense factorisation.

use super::dense::{Lu, Singular};
use crate::machine::Machine;
use crate::model::Model;
use crate::program::Block;

/// LU factors of the diagonal blocks of Phi_q with preallocated storage.
#[derive(Clone, Debug)]
pub(crate) struct Loops {
    blocks: Vec<Factors>,
    /// The entries of Phi_q, in the order of its tape.
    values: Vec<f64>,
    /// By coordinates.
    work: Vec<f64>,
}

/// One block.
#[derive(Clone, Debug)]
struct Factors {
    rows: Vec<usize>,
    columns: Vec<usize>,
    lu: Lu,
    /// (place in the matrix of the block, entry of Phi_q)
    inner: Vec<(usize, usize)>,
    /// (row of the block, coordinate of an earlier block, entry of Phi_q)
    before: Vec<(usize, usize, usize)>,
    right: Vec<f64>,
}

impl Factors {
    fn new(model: &Model, block: &Block) -> Self {
        let [rows, columns] =
            [&block.rows, &block.columns].map(|list| list.iter().map(|&i| i as usize).collect::<Vec<_>>());
        let size = rows.len();
        let (mut inner, mut before) = (Vec::new(), Vec::new());
        for (entry, &(row, column)) in model.program().tapes.jacobian.entries.iter().enumerate() {
            let (row, column) = (row as usize, column as usize);
            let Some(row) = rows.iter().position(|&own| own == row) else { continue };
            match columns.iter().position(|&own| own == column) {
                Some(place) => inner.push((row * size + place, entry)),
                None if column < model.coordinates() => before.push((row, column, entry)),
                None => {} // a follower
            }
        }
        Self { lu: Lu::new(size), right: vec![0.0; size], rows, columns, inner, before }
    }
}

impl Loops {
    pub fn new(model: &Model) -> Self {
        let program = model.program();
        Self {
            blocks: program.blocks.iter().map(|block| Factors::new(model, block)).collect(),
            values: vec![0.0; program.tapes.jacobian.entries.len()],
            work: vec![0.0; model.coordinates()],
        }
    }

    /// Evaluates and factors Phi_q at the registers. What is singular is named by its coordinate.
    pub fn factor(&mut self, model: &Model, machine: &mut Machine) -> Result<(), Singular> {
        machine.evaluate(&model.program().tapes.jacobian.tape, &mut self.values);
        let entries = self.blocks.iter().flat_map(|block| {
            block.inner.iter().map(|&(_, entry)| entry).chain(block.before.iter().map(|&(_, _, entry)| entry))
        });
        let largest = entries.fold(0.0, |largest: f64, entry| largest.max(self.values[entry].abs()));
        for Factors { lu, columns, inner, .. } in &mut self.blocks {
            let matrix = lu.matrix();
            for &(place, entry) in inner.iter() {
                matrix[place] = self.values[entry];
            }
            lu.factor(largest).map_err(|Singular(column)| Singular(columns[column]))?;
        }
        Ok(())
    }

    /// x of Phi_q x = b, with b given for all constraints.
    pub fn solve(&mut self, b: &[f64]) -> &[f64] {
        for Factors { rows, columns, lu, before, right, .. } in &mut self.blocks {
            right.iter_mut().zip(rows.iter()).for_each(|(right, &row)| *right = b[row]);
            for &(row, column, entry) in before.iter() {
                right[row] -= self.values[entry] * self.work[column];
            }
            lu.solve(right);
            right.iter().zip(columns.iter()).for_each(|(&value, &column)| self.work[column] = value);
        }
        &self.work
    }

    /// lambda of Phi_q^T lambda = b, zero for inactive constraints.
    pub fn reactions(&mut self, b: &[f64], reactions: &mut [f64]) {
        reactions.fill(0.0);
        self.work.copy_from_slice(b);
        for Factors { rows, columns, lu, before, right, .. } in self.blocks.iter_mut().rev() {
            right.iter_mut().zip(columns.iter()).for_each(|(right, &column)| *right = self.work[column]);
            lu.solve_transposed(right);
            right.iter().zip(rows.iter()).for_each(|(&value, &row)| reactions[row] = value);
            for &(row, column, entry) in before.iter() {
                self.work[column] -= self.values[entry] * right[row];
            }
        }
    }
}
