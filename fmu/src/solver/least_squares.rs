//! Nonlinear equations with fewest demands: any number of them, contradictory or not, in any number of unknowns, with the
//! smallest movement that serves.
//!
//! Gauss-Newton steps by the pseudo-inverse, damped (Levenberg-Marquardt) when they do not help. The Jacobian falls apart into
//! blocks without common unknowns, which are decomposed one by one: thousands of unknowns cost little when few of them depend on each other.

use nalgebra::{DMatrix, DVector, SVD};

/// Singular values below this share of the largest do not count.
const RANK: f64 = 1e-10;
/// Most steps.
const ITERATIONS: usize = 200;
/// Damping, relative to the largest singular value, tried in this order.
const DAMPING: [f64; 8] = [0.0, 1e-6, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0];
/// So many steps without progress end the search.
const PATIENCE: usize = 6;
/// A step is progress if it leaves less than this share of the sum of squares.
const PROGRESS: f64 = 0.99;

/// A nonzero of a sparse matrix: row, column, value.
pub(crate) type Entry = (usize, usize, f64);

/// r(x) = 0, with x and r scaled so that 1 is a natural size.
pub(crate) trait Equations {
    /// Writes r(x).
    fn residuals(&mut self, x: &[f64], r: &mut Vec<f64>);
    /// Writes the nonzeros of dr/dx.
    fn jacobian(&mut self, x: &[f64], entries: &mut Vec<Entry>);
}

/// Moves x to a least-squares solution nearby, in steps of at most `reach`; returns the residuals there.
pub(crate) fn solve(equations: &mut impl Equations, x: &mut Vec<f64>, reach: f64) -> Vec<f64> {
    let (mut r, mut trial_r, mut entries) = (Vec::new(), Vec::new(), Vec::new());
    equations.residuals(x, &mut r);
    let mut idle = 0;
    for _ in 0..ITERATIONS {
        let before = sum_of_squares(&r);
        if before == 0.0 || !before.is_finite() || idle == PATIENCE {
            break;
        }
        equations.jacobian(x, &mut entries);
        let blocks = decompose(r.len(), x.len(), &entries);
        let improved = DAMPING.iter().any(|&damping| {
            let trial: Vec<f64> = x
                .iter()
                .zip(step(&blocks, &r, x.len(), damping, reach))
                .map(|(x, d)| x - d)
                .collect();
            equations.residuals(&trial, &mut trial_r);
            let improves = sum_of_squares(&trial_r) < before;
            if improves {
                x.clone_from(&trial);
                std::mem::swap(&mut r, &mut trial_r);
            }
            improves
        });
        if !improved {
            break;
        }
        idle = if sum_of_squares(&r) < PROGRESS * before {
            0
        } else {
            idle + 1
        };
    }
    r
}

fn sum_of_squares(r: &[f64]) -> f64 {
    r.iter().map(|r| r * r).sum()
}

/// J^+ r over all blocks, no component longer than `reach`.
fn step(blocks: &[Block], r: &[f64], unknowns: usize, damping: f64, reach: f64) -> Vec<f64> {
    let largest = blocks
        .iter()
        .map(|block| block.values.max())
        .fold(0.0, f64::max);
    let mut step = vec![0.0; unknowns];
    for block in blocks {
        block.apply(r, damping * largest, RANK * largest, &mut step);
    }
    let longest = step
        .iter()
        .fold(0.0, |longest: f64, d| longest.max(d.abs()));
    if longest > reach {
        step.iter_mut().for_each(|d| *d *= reach / longest);
    }
    step
}

/// U S V^T of the rows and columns that depend on each other.
struct Block {
    rows: Vec<usize>,
    columns: Vec<usize>,
    u: DMatrix<f64>,
    values: DVector<f64>,
    v_transposed: DMatrix<f64>,
}

impl Block {
    fn apply(&self, r: &[f64], damping: f64, smallest: f64, step: &mut [f64]) {
        let right = DVector::from_iterator(self.rows.len(), self.rows.iter().map(|&row| r[row]));
        let mut components = self.u.tr_mul(&right);
        for (component, &value) in components.iter_mut().zip(self.values.iter()) {
            *component *= if value > smallest {
                value / (value * value + damping * damping)
            } else {
                0.0
            };
        }
        for (&column, value) in self
            .columns
            .iter()
            .zip(self.v_transposed.tr_mul(&components).iter())
        {
            step[column] = *value;
        }
    }

    /// None if the decomposition does not converge.
    fn new(rows: Vec<usize>, columns: Vec<usize>, matrix: DMatrix<f64>) -> Option<Self> {
        let norm = matrix.norm();
        if !(norm > 0.0 && norm.is_finite()) {
            return None;
        }
        let unit = DMatrix::from_element(1, 1, 1.0);
        let values = DVector::from_element(1, norm);
        if matrix.nrows() == 1 {
            return Some(Self {
                rows,
                columns,
                u: unit,
                values,
                v_transposed: matrix / norm,
            });
        }
        if matrix.ncols() == 1 {
            return Some(Self {
                rows,
                columns,
                u: matrix / norm,
                values,
                v_transposed: unit,
            });
        }
        let SVD {
            u,
            v_t,
            singular_values,
        } = SVD::try_new(matrix, true, true, f64::EPSILON, 10_000)?;
        Some(Self {
            rows,
            columns,
            u: u?,
            values: singular_values,
            v_transposed: v_t?,
        })
    }
}

/// Splits a sparse matrix into blocks without common columns.
fn decompose(rows: usize, columns: usize, entries: &[Entry]) -> Vec<Block> {
    let mut sets = Sets::new(columns);
    let mut first = vec![None; rows];
    for &(row, column, value) in entries {
        if value != 0.0 {
            let with = *first[row].get_or_insert(column);
            sets.join(with, column);
        }
    }
    // Members of each set, in order, and the place of each column and row among them.
    let mut members: Vec<(Vec<usize>, Vec<usize>)> = vec![Default::default(); columns];
    let mut column_place = vec![0; columns];
    let mut row_place = vec![0; rows];
    for (column, place) in column_place.iter_mut().enumerate() {
        let set = &mut members[sets.root(column)].1;
        *place = set.len();
        set.push(column);
    }
    for (row, place) in row_place.iter_mut().enumerate() {
        if let Some(column) = first[row] {
            let set = &mut members[sets.root(column)].0;
            *place = set.len();
            set.push(row);
        }
    }
    let mut matrices: Vec<_> = members
        .iter()
        .map(|(rows, columns)| DMatrix::zeros(rows.len(), columns.len()))
        .collect();
    for &(row, column, value) in entries.iter().filter(|entry| entry.2 != 0.0) {
        matrices[sets.root(column)][(row_place[row], column_place[column])] += value;
    }
    let blocks = members
        .into_iter()
        .zip(matrices)
        .filter(|((rows, _), _)| !rows.is_empty());
    blocks
        .filter_map(|((rows, columns), matrix)| Block::new(rows, columns, matrix))
        .collect()
}

/// Disjoint sets of columns.
struct Sets(Vec<usize>);

impl Sets {
    fn new(size: usize) -> Self {
        Self((0..size).collect())
    }

    fn root(&mut self, mut element: usize) -> usize {
        while self.0[element] != element {
            self.0[element] = self.0[self.0[element]];
            element = self.0[element];
        }
        element
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A x = b with a given sparse matrix.
    struct Linear {
        entries: Vec<Entry>,
        right: Vec<f64>,
    }

    impl Equations for Linear {
        fn residuals(&mut self, x: &[f64], r: &mut Vec<f64>) {
            *r = self.right.iter().map(|right| -right).collect();
            self.entries
                .iter()
                .for_each(|&(row, column, value)| r[row] += value * x[column]);
        }
        fn jacobian(&mut self, _: &[f64], entries: &mut Vec<Entry>) {
            entries.clone_from(&self.entries);
        }
    }

    fn solution(entries: &[Entry], right: &[f64], unknowns: usize) -> (Vec<f64>, f64) {
        let mut x = vec![0.0; unknowns];
        let mut linear = Linear {
            entries: entries.to_vec(),
            right: right.to_vec(),
        };
        let r = solve(&mut linear, &mut x, f64::INFINITY);
        (x, r.iter().fold(0.0, |worst: f64, r| worst.max(r.abs())))
    }

    fn near(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        found
            .iter()
            .zip(expected)
            .for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{found:?} for {expected:?}"));
    }

    #[test]
    fn takes_the_shortest_solution_and_leaves_the_rest_alone() {
        let (x, residual) = solution(&[(0, 1, 3.0), (0, 2, 4.0)], &[5.0], 4);
        near(&x, &[0.0, 0.6, 0.8, 0.0]);
        assert!(residual < 1e-14);
    }

    #[test]
    fn solves_blocks_redundancy_and_contradiction_alike() {
        let block = [
            (0, 0, 1.0),
            (0, 1, 1.0),
            (1, 0, 1.0),
            (1, 1, -1.0),
            (2, 0, 2.0),
            (2, 1, 2.0),
            (3, 3, 2.0),
        ];
        let (x, residual) = solution(&block, &[3.0, 1.0, 6.0, 8.0], 4);
        near(&x, &[2.0, 1.0, 0.0, 4.0]);
        assert!(residual < 1e-13);
        let (x, residual) = solution(&[(0, 0, 1.0), (1, 0, 1.0)], &[1.0, 2.0], 1);
        near(&x, &[1.5]);
        assert!((residual - 0.5).abs() < 1e-12);
    }

    #[test]
    fn thousands_of_unrelated_unknowns_are_no_trouble() {
        let size = 15_000;
        let entries: Vec<Entry> = (0..size).map(|i| (i, i, 2.0)).collect();
        let (x, residual) = solution(&entries, &vec![3.0; size], size);
        near(&x, &vec![1.5; size]);
        assert_eq!(residual, 0.0);
    }
}
