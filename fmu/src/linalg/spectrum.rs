//! The ends of the spectrum of J J^T.

use nalgebra::DMatrix;

use super::ROUNDING_OF_SUMS;
use super::sparse::{Factors, SparseRow, product_with_transposed};
use crate::math::Random;

/// Iterations towards one end; each shrinks what lies apart by the ratio of the eigenvalues.
const POWER_ITERATIONS: usize = 30;

/// The smallest and the largest eigenvalue of J J^T, and the unit vector of the smallest; none without rows.
pub(crate) fn ends(rows: &DMatrix<f64>) -> Option<(f64, f64, Vec<f64>)> {
    if rows.is_empty() {
        return None;
    }
    let eigen = (rows * rows.transpose()).symmetric_eigen();
    let (index, least) = eigen.eigenvalues.iter().enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b))?;
    Some((*least, eigen.eigenvalues.max(), eigen.eigenvectors.column(index).iter().copied().collect()))
}

/// The same for many rows with few entries: by iteration of J J^T for the largest one, of its inverse for the smallest.
pub(crate) fn ends_of_many(rows: &[SparseRow]) -> Option<(f64, f64, Vec<f64>)> {
    let product = product_with_transposed(rows);
    let times = |x: &[f64]| -> Vec<f64> {
        product.iter().map(|row| row.iter().map(|(&column, value)| value * x[column]).sum()).collect()
    };
    let mut random = Random::new(1);
    let mut x: Vec<f64> = (0..rows.len()).map(|_| random.symmetric()).collect();
    let mut largest = 0.0;
    for _ in 0..POWER_ITERATIONS {
        largest = normalise(&mut x);
        x = times(&x);
    }
    let mut shifted = product.clone();
    for (index, row) in shifted.iter_mut().enumerate() {
        // So that a singular matrix has factors.
        *row.entry(index).or_default() += ROUNDING_OF_SUMS * largest;
    }
    let factors = Factors::new(shifted)?;
    let mut x: Vec<f64> = (0..rows.len()).map(|_| random.symmetric()).collect();
    for _ in 0..POWER_ITERATIONS {
        factors.solve(&mut x);
        normalise(&mut x);
    }
    let least = times(&x).iter().zip(&x).map(|(a, b)| a * b).sum();
    Some((least, largest, x))
}

/// Makes the length 1 and returns what it was.
fn normalise(x: &mut [f64]) -> f64 {
    let length = x.iter().map(|value| value * value).sum::<f64>().sqrt();
    x.iter_mut().for_each(|value| *value /= length);
    length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iterations_agree_with_all_eigenvalues() {
        // Neighbours pull at each other; the last row is almost the sum of two others.
        let (size, columns) = (60, 70);
        let mut rows = DMatrix::from_fn(size, columns, |row, column| match column.abs_diff(row) {
            0 => 2.0 + (row as f64).sin(),
            1 => -1.0,
            _ => 0.0,
        });
        let sum = rows.row(3) + rows.row(20);
        rows.row_mut(size - 1).copy_from(&sum);
        rows[(size - 1, columns - 1)] += 1e-4;
        let sparse: Vec<SparseRow> = rows.row_iter().map(|row| row.iter().copied().enumerate().collect()).collect();
        let (least, largest, vector) = ends(&rows).unwrap();
        let (found, most, direction) = ends_of_many(&sparse).unwrap();
        assert!(
            (found - least).abs() < 1e-12 && (most / largest - 1.0).abs() < 0.05,
            "{found} {least} {most} {largest}"
        );
        let along: f64 = vector.iter().zip(&direction).map(|(a, b)| a * b).sum();
        assert!(along.abs() > 1.0 - 1e-9, "{along}");
    }
}
