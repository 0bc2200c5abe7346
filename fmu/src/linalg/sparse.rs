//! Linear algebra of large matrices with few entries: cost follows the entries, not the square of the size.

use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A row of a matrix: column and value.
pub type SparseRow = BTreeMap<usize, f64>;

/// L D L^T of a symmetric, positive definite matrix, rows with the fewest neighbours first.
#[derive(Clone, Debug)]
pub struct Factors {
    steps: Vec<Pivot>,
}

/// One pivot, and the multipliers of the rows that were left.
#[derive(Clone, Debug)]
struct Pivot {
    index: usize,
    pivot: f64,
    below: Vec<(usize, f64)>,
}

impl Factors {
    /// Factorises; both triangles of the matrix are given. None if a pivot is not positive.
    pub fn new(mut rows: Vec<SparseRow>) -> Option<Self> {
        let mut left: BTreeSet<(usize, usize)> = rows.iter().enumerate().map(|(i, row)| (row.len(), i)).collect();
        let mut steps = Vec::with_capacity(rows.len());
        while let Some((_, index)) = left.pop_first() {
            let mut row = std::mem::take(&mut rows[index]);
            let pivot = row.remove(&index).unwrap_or_default();
            // Written so that NaN is no pivot either.
            let positive = pivot > 0.0 && pivot.is_finite();
            if !positive {
                return None;
            }
            let below: Vec<(usize, f64)> = row.iter().map(|(&other, entry)| (other, entry / pivot)).collect();
            for &(other, factor) in &below {
                left.remove(&(rows[other].len(), other));
                rows[other].remove(&index);
                for (&column, entry) in &row {
                    *rows[other].entry(column).or_default() -= factor * entry;
                }
                left.insert((rows[other].len(), other));
            }
            steps.push(Pivot { index, pivot, below });
        }
        Some(Self { steps })
    }

    /// Replaces the right-hand side by the solution.
    pub fn solve(&self, x: &mut [f64]) {
        for Pivot { index, below, .. } in &self.steps {
            let value = x[*index];
            below.iter().for_each(|&(row, factor)| x[row] -= factor * value);
        }
        for Pivot { index, pivot, below } in self.steps.iter().rev() {
            x[*index] = x[*index] / pivot - below.iter().map(|&(row, factor)| factor * x[row]).sum::<f64>();
        }
    }
}

/// The entries of each column: row and value.
pub(crate) fn columns(rows: &[SparseRow]) -> BTreeMap<usize, Vec<(usize, f64)>> {
    let mut columns: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
    for (index, row) in rows.iter().enumerate() {
        row.iter().for_each(|(&column, &value)| columns.entry(column).or_default().push((index, value)));
    }
    columns
}

/// J J^T of the rows of J.
pub fn product_with_transposed(rows: &[SparseRow]) -> Vec<SparseRow> {
    let mut product = vec![SparseRow::new(); rows.len()];
    for entries in columns(rows).values() {
        for &(row, a) in entries {
            entries.iter().for_each(|&(other, b)| *product[row].entry(other).or_default() += a * b);
        }
    }
    product
}

/// Which rows are independent of those before them: those of which a share of more than `new` is left when the rows before are taken out, by
/// Gauss elimination with the largest entry as the pivot. Also whether more than a share of `clear` was left of each.
pub fn independent_rows(rows: Vec<SparseRow>, new: f64, clear: f64) -> (bool, Vec<usize>) {
    let mut pivots: Vec<(usize, SparseRow)> = Vec::new();
    let mut place: HashMap<usize, usize> = HashMap::new();
    let mut independent = Vec::new();
    let mut is_clear = true;
    for (index, mut row) in rows.into_iter().enumerate() {
        // Rows are of natural size 1, so that a row of rounding errors is not a direction.
        let size = norm(&row).max(1.0);
        let mut due: BTreeSet<usize> = row.keys().filter_map(|column| place.get(column).copied()).collect();
        while let Some(earliest) = due.pop_first() {
            let (column, pivot) = &pivots[earliest];
            let Some(entry) = row.remove(column) else { continue };
            let factor = entry / pivot[column];
            for (&other, value) in pivot.iter().filter(|(other, _)| *other != column) {
                *row.entry(other).or_default() -= factor * value;
                due.extend(place.get(&other));
            }
        }
        let rest = norm(&row);
        if rest > new * size {
            is_clear &= rest > clear * size;
            let largest = row.iter().max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
            if let Some((&column, _)) = largest {
                place.insert(column, pivots.len());
                pivots.push((column, row));
                independent.push(index);
            }
        }
    }
    (is_clear, independent)
}

fn norm(row: &SparseRow) -> f64 {
    row.values().map(|value| value * value).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(dense: &[&[f64]]) -> Vec<SparseRow> {
        dense.iter().map(|row| row.iter().copied().enumerate().filter(|(_, value)| *value != 0.0).collect()).collect()
    }

    #[test]
    fn factors_solve_what_they_were_made_of() {
        let matrix: &[&[f64]] =
            &[&[4.0, 1.0, 0.0, 0.5], &[1.0, 3.0, 1.0, 0.0], &[0.0, 1.0, 2.0, 0.0], &[0.5, 0.0, 0.0, 1.0]];
        let solution = [1.0, -2.0, 3.0, 0.5];
        let mut x: Vec<f64> =
            matrix.iter().map(|row| row.iter().zip(solution).map(|(entry, x)| entry * x).sum()).collect();
        Factors::new(rows(matrix)).unwrap().solve(&mut x);
        x.iter().zip(solution).for_each(|(found, expected)| assert!((found - expected).abs() < 1e-14, "{x:?}"));
    }

    #[test]
    fn what_is_not_definite_has_no_factors() {
        assert!(Factors::new(rows(&[&[1.0, 1.0], &[1.0, 1.0]])).is_none());
        assert!(Factors::new(rows(&[&[f64::NAN]])).is_none());
    }

    #[test]
    fn a_tridiagonal_matrix_fills_nothing_in() {
        let size = 1000;
        let entry = |i: usize, j: usize| (j < size).then_some((j, if i == j { 2.5 } else { -1.0 }));
        let matrix = (0..size).map(|i| [i.wrapping_sub(1), i, i + 1].into_iter().filter_map(|j| entry(i, j)).collect());
        let factors = Factors::new(matrix.collect()).unwrap();
        assert_eq!(factors.steps.iter().map(|step| step.below.len()).sum::<usize>(), size - 1);
    }

    #[test]
    fn dependent_rows_are_found_whatever_lies_between() {
        let matrix = rows(&[&[1.0, 2.0, 0.0], &[0.0, 1.0, 1.0], &[1.0, 1.0, -1.0], &[0.0; 3], &[0.0, 0.0, 1e-6]]);
        assert_eq!(independent_rows(matrix.clone(), 1e-8, 1e-5), (false, vec![0, 1, 4]));
        assert_eq!(independent_rows(matrix, 1e-5, 1e-4), (true, vec![0, 1]));
    }
}
