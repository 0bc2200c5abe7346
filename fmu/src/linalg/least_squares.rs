//! Nonlinear equations with fewest demands: any number of them, contradictory or not, in any number of unknowns, with the
//! smallest movement that serves.
//!
//! Gauss-Newton steps by the pseudo-inverse, damped (Levenberg-Marquardt) when they do not help. The Jacobian falls apart into
//! blocks without common unknowns, which are decomposed one by one: thousands of unknowns cost little when few of them depend on each other.
//! Of blocks that are large themselves the normal equations are factorised, which have few entries; of smaller ones, too, and where that does not
//! lead to a solution the search begins again with the decomposition.

use nalgebra::{DMatrix, DVector, SVD};

use super::sparse::{Factors, SparseRow};
use super::{RANK, SPACINGS};

/// Most steps.
const LEAST_SQUARES_STEPS: usize = 200;
/// Blocks with more rows and more columns than this are sparse.
const DENSE: usize = 150;
/// The same for a first search: a decomposition of 48 rows takes a millisecond, the sixteenth part of which a run of such a mechanism takes for a second of motion.
const DENSE_FIRST: usize = 48;
/// A first search has led to a solution if no residual is larger than this.
const SOLVED: f64 = 1e-10;
/// What takes the place of [`RANK`] in normal equations, where singular values are squared; relative to the largest singular value.
const SMOOTHING: f64 = 1e-6;
/// Damping, relative to the largest singular value, tried in this order.
const DAMPING: [f64; 8] = [0.0, 1e-6, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0];
/// So many steps without progress end the search.
const PATIENCE: usize = 6;
/// A step is progress if it leaves less than this share of the sum of squares.
const PROGRESS: f64 = 0.99;

/// A nonzero of a sparse matrix: row, column, value.
pub type Entry = (usize, usize, f64);

/// r(x) = 0, with x and r scaled so that 1 is a natural size.
pub trait ResidualFunction {
    /// Writes r(x).
    fn residuals(&mut self, x: &[f64], r: &mut Vec<f64>);
    /// Writes the nonzeros of dr/dx.
    fn jacobian(&mut self, x: &[f64], entries: &mut Vec<Entry>);
}

/// Moves x to a least-squares solution nearby, in steps of at most `reach`; returns the residuals there.
pub(crate) fn solve(equations: &mut impl ResidualFunction, x: &mut Vec<f64>, reach: f64) -> Vec<f64> {
    search(equations, x, reach, |_| 0.0)
}

/// The same with steps that are damped by what is left of the residuals: x ends next to where it began even if the solutions there have a common singular
/// point, to which undamped steps lead. The order of convergence is the same, whatever the rank is (Yamashita and Fukushima, 2001, theorem 2.2).
pub fn project(equations: &mut impl ResidualFunction, x: &mut Vec<f64>, reach: f64) -> Vec<f64> {
    search(equations, x, reach, f64::sqrt)
}

/// `least`: the least damping, relative to the largest singular value, for the norm of the residuals.
fn search(equations: &mut impl ResidualFunction, x: &mut Vec<f64>, reach: f64, least: impl Fn(f64) -> f64) -> Vec<f64> {
    let start = x.clone();
    let (r, sparse) = search_with(equations, x, reach, &least, DENSE_FIRST);
    if !sparse || r.iter().all(|r| r.abs() <= SOLVED) {
        return r;
    }
    x.clone_from(&start);
    search_with(equations, x, reach, &least, DENSE).0
}

/// With blocks of up to so many rows or columns decomposed. Says whether there was a larger one that would otherwise be.
fn search_with(
    equations: &mut impl ResidualFunction,
    x: &mut Vec<f64>,
    reach: f64,
    least: impl Fn(f64) -> f64,
    dense: usize,
) -> (Vec<f64>, bool) {
    let (mut r, mut trial_r, mut entries) = (Vec::new(), Vec::new(), Vec::new());
    equations.residuals(x, &mut r);
    let (mut idle, mut sparse) = (0, false);
    for _ in 0..LEAST_SQUARES_STEPS {
        let before = sum_of_squares(&r);
        if before == 0.0 || !before.is_finite() || idle == PATIENCE {
            break;
        }
        equations.jacobian(x, &mut entries);
        let blocks = decompose(r.len(), x.len(), &entries, dense);
        sparse |= blocks.iter().any(|block| matches!(block, Block::Sparse(block) if block.rank() <= DENSE));
        let noise = SPACINGS;
        if before <= r.len() as f64 * noise * noise && blocks.iter().any(|block| matches!(block, Block::Sparse(_))) {
            // What is left is rounding: a factorisation for each damping would show no more than that no step helps.
            break;
        }
        let least = least(before.sqrt());
        let larger = DAMPING.into_iter().filter(|damping| *damping > least);
        let improved = std::iter::once(least).chain(larger).any(|damping| {
            let trial: Vec<f64> =
                x.iter().zip(step(&blocks, &r, x.len(), damping, reach)).map(|(x, d)| x - d).collect();
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
        idle = if sum_of_squares(&r) < PROGRESS * before { 0 } else { idle + 1 };
    }
    (r, sparse)
}

fn sum_of_squares(r: &[f64]) -> f64 {
    r.iter().map(|r| r * r).sum()
}

/// J^+ r over all blocks, no component longer than `reach`.
fn step(blocks: &[Block], r: &[f64], unknowns: usize, damping: f64, reach: f64) -> Vec<f64> {
    let size = |block: &Block| match block {
        Block::Dense(block) => block.values.max(),
        Block::Sparse(block) => block.size,
    };
    let largest = blocks.iter().map(size).fold(0.0, f64::max);
    let mut step = vec![0.0; unknowns];
    for block in blocks {
        match block {
            Block::Dense(block) => block.apply(r, damping * largest, RANK * largest, &mut step),
            Block::Sparse(block) => block.apply(r, damping.max(SMOOTHING) * largest, &mut step),
        }
    }
    let longest = step.iter().fold(0.0, |longest: f64, d| longest.max(d.abs()));
    if longest > reach {
        step.iter_mut().for_each(|d| *d *= reach / longest);
    }
    step
}

/// The rows and columns that depend on each other.
enum Block {
    Dense(DenseBlock),
    Sparse(SparseBlock),
}

/// As U S V^T.
struct DenseBlock {
    rows: Vec<usize>,
    columns: Vec<usize>,
    u: DMatrix<f64>,
    values: DVector<f64>,
    v_transposed: DMatrix<f64>,
}

impl DenseBlock {
    fn apply(&self, r: &[f64], damping: f64, smallest: f64, step: &mut [f64]) {
        let right = DVector::from_iterator(self.rows.len(), self.rows.iter().map(|&row| r[row]));
        let mut components = self.u.tr_mul(&right);
        for (component, &value) in components.iter_mut().zip(self.values.iter()) {
            *component *= if value > smallest { value / (value * value + damping * damping) } else { 0.0 };
        }
        for (&column, value) in self.columns.iter().zip(self.v_transposed.tr_mul(&components).iter()) {
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
            return Some(Self { rows, columns, u: unit, values, v_transposed: matrix / norm });
        }
        if matrix.ncols() == 1 {
            return Some(Self { rows, columns, u: matrix / norm, values, v_transposed: unit });
        }
        let SVD { u, v_t, singular_values } = SVD::try_new(matrix, true, true, f64::EPSILON, 10_000)?;
        Some(Self { rows, columns, u: u?, values: singular_values, v_transposed: v_t? })
    }
}

/// As its entries.
struct SparseBlock {
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// Both by their places in the block.
    entries: Vec<Entry>,
    /// A bound of the largest singular value.
    size: f64,
    /// Has J J^T fewer entries than J^T J?
    by_rows: bool,
}

impl SparseBlock {
    fn new(rows: Vec<usize>, columns: Vec<usize>, entries: Vec<Entry>) -> Self {
        let (mut by_row, mut by_column) = (vec![0.0; rows.len()], vec![0.0; columns.len()]);
        for &(row, column, value) in &entries {
            by_row[row] += value.abs();
            by_column[column] += value.abs();
        }
        let largest = |sums: &[f64]| sums.iter().copied().fold(0.0, f64::max);
        let size = (largest(&by_row) * largest(&by_column)).sqrt();
        let crossings = |count: usize, line: fn(&Entry) -> usize| -> usize {
            let mut lines = vec![0_usize; count];
            entries.iter().for_each(|entry| lines[line(entry)] += 1);
            lines.into_iter().map(|length| length * length).sum()
        };
        let by_rows = crossings(columns.len(), |entry| entry.1) <= crossings(rows.len(), |entry| entry.0);
        Self { rows, columns, entries, size, by_rows }
    }

    /// At most.
    fn rank(&self) -> usize {
        self.rows.len().min(self.columns.len())
    }

    /// J^T (J J^T + damping^2)^-1 r = (J^T J + damping^2)^-1 J^T r, refined once.
    fn apply(&self, r: &[f64], damping: f64, step: &mut [f64]) {
        let Some(factors) = Factors::new(self.normal(damping)) else { return };
        let mut rest: Vec<f64> = self.rows.iter().map(|&row| r[row]).collect();
        let mut total = vec![0.0; self.columns.len()];
        for _ in 0..2 {
            let mut part = vec![0.0; self.columns.len()];
            if self.by_rows {
                let mut weights = rest.clone();
                factors.solve(&mut weights);
                self.entries.iter().for_each(|&(row, column, value)| part[column] += value * weights[row]);
            } else {
                self.entries.iter().for_each(|&(row, column, value)| part[column] += value * rest[row]);
                factors.solve(&mut part);
            }
            self.entries.iter().for_each(|&(row, column, value)| rest[row] -= value * part[column]);
            total.iter_mut().zip(part).for_each(|(total, part)| *total += part);
        }
        for (&column, value) in self.columns.iter().zip(total) {
            step[column] = value;
        }
    }

    /// J J^T + damping^2 or J^T J + damping^2.
    fn normal(&self, damping: f64) -> Vec<SparseRow> {
        let (size, others) =
            if self.by_rows { (self.rows.len(), self.columns.len()) } else { (self.columns.len(), self.rows.len()) };
        let mut crossing: Vec<Vec<(usize, f64)>> = vec![Vec::new(); others];
        for &(row, column, value) in &self.entries {
            let (to, other) = if self.by_rows { (row, column) } else { (column, row) };
            crossing[other].push((to, value));
        }
        let mut normal: Vec<SparseRow> = (0..size).map(|index| SparseRow::from([(index, damping * damping)])).collect();
        for line in crossing {
            for &(i, a) in &line {
                line.iter().for_each(|&(j, b)| *normal[i].entry(j).or_default() += a * b);
            }
        }
        normal
    }
}

/// Splits a sparse matrix into blocks without common columns.
fn decompose(rows: usize, columns: usize, entries: &[Entry], dense: usize) -> Vec<Block> {
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
    let mut blocks: Vec<Vec<Entry>> = vec![Vec::new(); columns];
    for &(row, column, value) in entries.iter().filter(|entry| entry.2 != 0.0) {
        blocks[sets.root(column)].push((row_place[row], column_place[column], value));
    }
    let blocks = members.into_iter().zip(blocks).filter(|((rows, _), _)| !rows.is_empty());
    blocks.filter_map(|((rows, columns), entries)| block(rows, columns, entries, dense)).collect()
}

/// None if the decomposition does not converge.
fn block(rows: Vec<usize>, columns: Vec<usize>, entries: Vec<Entry>, dense: usize) -> Option<Block> {
    if rows.len().min(columns.len()) > dense {
        return Some(Block::Sparse(SparseBlock::new(rows, columns, entries)));
    }
    let mut matrix = DMatrix::zeros(rows.len(), columns.len());
    entries.into_iter().for_each(|(row, column, value)| matrix[(row, column)] += value);
    DenseBlock::new(rows, columns, matrix).map(Block::Dense)
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
        /// How often the residuals were asked for.
        evaluations: usize,
    }

    impl ResidualFunction for Linear {
        fn residuals(&mut self, x: &[f64], r: &mut Vec<f64>) {
            self.evaluations += 1;
            *r = self.right.iter().map(|right| -right).collect();
            self.entries.iter().for_each(|&(row, column, value)| r[row] += value * x[column]);
        }
        fn jacobian(&mut self, _: &[f64], entries: &mut Vec<Entry>) {
            entries.clone_from(&self.entries);
        }
    }

    fn solution(entries: &[Entry], right: &[f64], unknowns: usize) -> (Vec<f64>, f64) {
        let mut x = vec![0.0; unknowns];
        let mut linear = Linear { entries: entries.to_vec(), right: right.to_vec(), evaluations: 0 };
        let r = solve(&mut linear, &mut x, f64::INFINITY);
        (x, r.iter().fold(0.0, |worst: f64, r| worst.max(r.abs())))
    }

    fn near(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        found.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{found:?} for {expected:?}"));
    }

    #[test]
    fn takes_the_shortest_solution_and_leaves_the_rest_alone() {
        let (x, residual) = solution(&[(0, 1, 3.0), (0, 2, 4.0)], &[5.0], 4);
        near(&x, &[0.0, 0.6, 0.8, 0.0]);
        assert!(residual < 1e-14);
    }

    #[test]
    fn solves_blocks_redundancy_and_contradiction_alike() {
        let block = [(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, -1.0), (2, 0, 2.0), (2, 1, 2.0), (3, 3, 2.0)];
        let (x, residual) = solution(&block, &[3.0, 1.0, 6.0, 8.0], 4);
        near(&x, &[2.0, 1.0, 0.0, 4.0]);
        assert!(residual < 1e-13);
        let (x, residual) = solution(&[(0, 0, 1.0), (1, 0, 1.0)], &[1.0, 2.0], 1);
        near(&x, &[1.5]);
        assert!((residual - 0.5).abs() < 1e-12);
    }

    /// Sums of neighbours.
    fn chain(count: usize) -> Vec<Entry> {
        (0..count).flat_map(|i| [(i, i, 1.0), (i, i + 1, 2.0 + (i as f64).sin())]).collect()
    }

    #[test]
    fn large_blocks_are_not_factorised_for_rounding_errors() {
        let size = 3 * DENSE;
        let right = (0..size).map(|i| (i as f64).cos()).collect();
        let mut linear = Linear { entries: chain(size), right, evaluations: 0 };
        solve(&mut linear, &mut vec![0.0; size + 1], f64::INFINITY);
        assert!(linear.evaluations <= 4, "{}", linear.evaluations);
    }

    /// Sums of neighbours, with and without a redundant and a contradictory row: the same whether dense or sparse.
    #[test]
    fn large_blocks_give_what_small_ones_give() {
        let size = 3 * DENSE;
        let right: Vec<f64> = (0..size).map(|i| (i as f64).cos()).collect();
        let wide = chain(size);
        let mut tall = chain(size - 1);
        tall.extend([(size - 1, 0, 1.0), (size, 3, 1.0), (size + 1, 3, 1.0)]);
        let more: Vec<f64> = right.iter().copied().chain([0.5, 0.3]).collect();
        for (entries, right, unknowns) in [(wide, right, size + 1), (tall, more, size)] {
            let mut matrix = DMatrix::zeros(right.len(), unknowns);
            entries.iter().for_each(|&(row, column, value)| matrix[(row, column)] += value);
            let expected = matrix.svd(true, true).solve(&DVector::from_column_slice(&right), 1e-12).unwrap();
            let (x, _) = solution(&entries, &right, unknowns);
            let worst = x.iter().zip(expected.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-8, "{worst}");
        }
    }

    /// Of blocks that are neither small nor large no decomposition is made, unless there is no solution.
    #[test]
    fn middle_blocks_are_factorised_where_that_solves_them() {
        let size = 2 * DENSE_FIRST;
        let right: Vec<f64> = (0..size).map(|i| (i as f64).cos()).collect();
        let searched = |entries: Vec<Entry>, right: Vec<f64>| {
            let (mut linear, mut x) = (Linear { entries, right, evaluations: 0 }, vec![0.0; size + 1]);
            search_with(&mut linear, &mut x, f64::INFINITY, |_| 0.0, DENSE_FIRST)
        };
        let (r, sparse) = searched(chain(size), right.clone());
        assert!(sparse && r.iter().all(|r| r.abs() <= SOLVED), "{r:?}");
        // Two contradict each other: what the decomposition leaves is the least.
        let contradicting: Vec<Entry> = chain(size).into_iter().chain([(size, 0, 1.0), (size + 1, 0, 1.0)]).collect();
        let more: Vec<f64> = right.into_iter().chain([0.5, 0.3]).collect();
        let (_, residual) = solution(&contradicting, &more, size + 1);
        assert!((residual - 0.1).abs() < 1e-9, "{residual}");
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
