//! Phi_q of the active loop equations, factored: for driven mechanisms, where it is square.
//!
//! The equations come in blocks, each of which needs only what the blocks before it determine: Phi_q is block triangular. So positions,
//! rates and accelerations follow block after block, reactions from the last block to the first, each with a small dense factorisation.

use crate::failure::Failure;
use crate::linalg::dense::{Lu, Singular};
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
    /// The largest entry of each column, in units of the rows' scales; 1 at least.
    sizes: Vec<f64>,
}

impl Factors {
    fn new(block: &Block) -> Self {
        let [rows, columns] = [&block.rows, &block.columns].map(|list| list.iter().map(|&i| i as usize).collect());
        let size = block.rows.len();
        let zeros = vec![0.0; size];
        Self {
            rows,
            columns,
            lu: Lu::new(size),
            inner: Vec::new(),
            before: Vec::new(),
            right: zeros.clone(),
            sizes: zeros,
        }
    }
}

/// For each equation or coordinate its block and its place there.
fn places<'a>(count: usize, lists: impl Iterator<Item = &'a Vec<u32>>) -> Vec<Option<(usize, usize)>> {
    let mut places = vec![None; count];
    for (block, list) in lists.enumerate() {
        list.iter().enumerate().for_each(|(place, &index)| places[index as usize] = Some((block, place)));
    }
    places
}

impl Loops {
    pub fn new(model: &Model) -> Self {
        let program = model.program();
        let mut blocks: Vec<Factors> = program.blocks.iter().map(Factors::new).collect();
        let rows = places(program.constraints.len(), program.blocks.iter().map(|block| &block.rows));
        let columns = places(model.coordinates(), program.blocks.iter().map(|block| &block.columns));
        for (entry, &(row, column)) in program.tapes.jacobian.entries.iter().enumerate() {
            // Inactive equations and followers have no place.
            let (Some(Some((block, row))), Some(Some((other, place)))) =
                (rows.get(row as usize), columns.get(column as usize))
            else {
                continue;
            };
            let own = &mut blocks[*block];
            match block == other {
                true => own.inner.push((row * own.rows.len() + place, entry)),
                false => own.before.push((*row, column as usize, entry)),
            }
        }
        let values = vec![0.0; program.tapes.jacobian.entries.len()];
        Self { blocks, values, work: vec![0.0; model.coordinates()] }
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Number of equations, and of coordinates, of a block.
    pub fn size(&self, block: usize) -> usize {
        self.blocks[block].rows.len()
    }

    /// The coordinates of a block.
    pub fn columns(&self, block: usize) -> &[usize] {
        &self.blocks[block].columns
    }

    /// 1 / u_kk of the LU factors of a block.
    pub fn reciprocal_pivots(&self, block: usize) -> impl Iterator<Item = f64> {
        self.blocks[block].lu.diagonal()
    }

    /// Have rows of a block been exchanged an odd number of times?
    pub fn is_odd(&self, block: usize) -> bool {
        self.blocks[block].lu.is_odd()
    }

    /// Replaces b by J^-1 b, or by J^-T b, with the block J of Phi_q in such units that its columns have at most unit size.
    pub fn solve_scaled(&self, model: &Model, block: usize, b: &mut [f64], transposed: bool) {
        let Factors { rows, lu, sizes, .. } = &self.blocks[block];
        let by_rows = |b: &mut [f64]| {
            b.iter_mut().zip(rows).for_each(|(b, &row)| *b *= model.program().constraints[row].scale);
        };
        let by_columns = |b: &mut [f64]| b.iter_mut().zip(sizes).for_each(|(b, size)| *b *= size);
        match transposed {
            false => {
                by_rows(b);
                lu.solve(b);
                by_columns(b);
            }
            true => {
                by_columns(b);
                lu.solve_transposed(b);
                by_rows(b);
            }
        }
    }

    /// Evaluates and factors Phi_q at the registers. What is singular is named by its coordinate.
    pub fn factor(&mut self, model: &Model, machine: &mut Machine) -> Result<(), Singular> {
        machine.evaluate(&model.program().tapes.jacobian.tape, &mut self.values);
        let entries = self.blocks.iter().flat_map(|block| {
            block.inner.iter().map(|&(_, entry)| entry).chain(block.before.iter().map(|&(_, _, entry)| entry))
        });
        let largest = entries.fold(0.0, |largest: f64, entry| largest.max(self.values[entry].abs()));
        for Factors { lu, rows, columns, inner, sizes, .. } in &mut self.blocks {
            let (matrix, size) = (lu.matrix(), rows.len());
            // A column of small entries may be one that is about to vanish.
            sizes.fill(1.0);
            for &(place, entry) in inner.iter() {
                let value = self.values[entry];
                matrix[place] = value;
                let scale = model.program().constraints[rows[place / size]].scale;
                sizes[place % size] = f64::max(sizes[place % size], value.abs() / scale);
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

    /// Factors Phi_q, or names a coordinate that the drivers leave free.
    pub fn factor_regular(&mut self, model: &Model, machine: &mut Machine) -> Result<(), Failure> {
        self.factor(model, machine).map_err(|Singular(column)| Failure::Singular {
            time: machine.registers()[model.layout().time()],
            coordinate: model.program().coordinates[column].name.clone(),
        })
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
