//! Small dense linear equations without allocation.

use core::iter::Sum;
use core::ops::{AddAssign, Div, DivAssign, Mul, Sub, SubAssign};

use nalgebra::Complex;

use super::SINGULAR;

/// What a matrix may consist of.
pub(crate) trait Scalar:
    Copy + Default + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + AddAssign + SubAssign + DivAssign + Sum
{
    /// By which pivots are chosen.
    fn size(self) -> f64;
    /// 1 / self
    fn reciprocal(self) -> Self;
}

impl Scalar for f64 {
    fn size(self) -> f64 {
        self.abs()
    }

    fn reciprocal(self) -> Self {
        1.0 / self
    }
}

impl Scalar for Complex<f64> {
    fn size(self) -> f64 {
        self.re.abs() + self.im.abs()
    }

    fn reciprocal(self) -> Self {
        let square = self.re * self.re + self.im * self.im;
        Self::new(self.re / square, -self.im / square)
    }
}

/// LU factors of a square matrix, with partial pivoting. Storage is reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lu<T = f64> {
    size: usize,
    /// Row by row; L below the diagonal, U above it, and on it the reciprocals of U's.
    factors: Vec<T>,
    pivots: Vec<usize>,
}

/// The matrix has no inverse: this column depends on the columns before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Singular(pub usize);

impl<T: Scalar> Lu<T> {
    pub fn new(size: usize) -> Self {
        Self { size, factors: vec![T::default(); size * size], pivots: vec![0; size] }
    }

    /// The matrix to be factored, zeroed, row by row.
    pub fn matrix(&mut self) -> &mut [T] {
        self.factors.fill(T::default());
        &mut self.factors
    }

    /// Adds a number to each entry of the diagonal of the matrix.
    pub fn add_to_diagonal(&mut self, number: T) {
        self.factors.iter_mut().step_by(self.size + 1).for_each(|place| *place += number);
    }

    /// Replaces the matrix by its factors. `largest` is the size of what the matrix is a part of: a pivot that is nothing beside it counts as
    /// zero.
    pub fn factor(&mut self, largest: f64) -> Result<(), Singular> {
        let n = self.size;
        for column in 0..n {
            let size = |row: &usize| self.factors[row * n + column].size();
            let pivot = (column..n).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(column);
            // Written so that NaN is singular too.
            let regular = size(&pivot) > SINGULAR * largest;
            if !regular {
                return Err(Singular(column));
            }
            self.pivots[column] = pivot;
            self.swap_rows(column, pivot);
            let place = &mut self.factors[column * n + column];
            *place = place.reciprocal();
            self.eliminate(column);
        }
        Ok(())
    }

    fn swap_rows(&mut self, a: usize, b: usize) {
        if a != b {
            let n = self.size;
            let (upper, lower) = self.factors.split_at_mut(a.max(b) * n);
            upper[a.min(b) * n..][..n].swap_with_slice(&mut lower[..n]);
        }
    }

    fn eliminate(&mut self, column: usize) {
        let n = self.size;
        let (upper, lower) = self.factors.split_at_mut((column + 1) * n);
        let pivot = &upper[column * n..];
        for row in lower.chunks_exact_mut(n) {
            let factor = row[column] * pivot[column];
            row[column] = factor;
            for (entry, above) in row[column + 1..].iter_mut().zip(&pivot[column + 1..]) {
                *entry -= factor * *above;
            }
        }
    }

    /// Replaces b by the solution of A x = b.
    pub fn solve(&self, b: &mut [T]) {
        let n = self.size;
        for row in 0..n {
            b.swap(row, self.pivots[row]);
        }
        for row in 0..n {
            b[row] -= dot(&self.factors[row * n..][..row], b);
        }
        for row in (0..n).rev() {
            let known = dot(&self.factors[row * n..][row + 1..n], &b[row + 1..]);
            b[row] = (b[row] - known) * self.factors[row * n + row];
        }
    }
}

/// In four sums, so that not every addition waits for the one before.
fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    let (a, rest) = a.as_chunks::<4>();
    let (b, last) = b.split_at(4 * a.len());
    let mut sums = [T::default(); 4];
    for (a, b) in a.iter().zip(b.as_chunks::<4>().0) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += *a * *b);
    }
    sums.into_iter().chain(rest.iter().zip(last).map(|(a, b)| *a * *b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MATRIX: [f64; 9] = [0.0, 2.0, -1.0, 3.0, 1.0, 4.0, 6.0, -5.0, 2.0];
    const X: [f64; 3] = [1.0, -2.0, 3.0];

    #[test]
    fn solves_with_the_matrix() {
        let mut lu = Lu::new(3);
        lu.matrix().copy_from_slice(&MATRIX);
        lu.factor(6.0).expect("regular");
        let mut b: [f64; 3] =
            std::array::from_fn(|row| (0..3).map(|column| MATRIX[3 * row + column] * X[column]).sum());
        lu.solve(&mut b);
        for (b, x) in b.iter().zip(X) {
            assert!((b - x).abs() < 1e-14);
        }
    }

    #[test]
    fn solves_with_a_complex_matrix() {
        let mut lu = Lu::new(3);
        let entry = |index: usize| Complex::new(MATRIX[index], MATRIX[8 - index] - 0.5);
        lu.matrix().iter_mut().enumerate().for_each(|(index, place)| *place = entry(index));
        assert_eq!(lu.factor(6.0), Ok(()));
        let x = [Complex::new(1.0, 2.0), Complex::new(-2.0, 0.5), Complex::new(3.0, -1.0)];
        let mut b: [Complex<f64>; 3] =
            std::array::from_fn(|row| (0..3).map(|column| entry(3 * row + column) * x[column]).sum());
        lu.solve(&mut b);
        assert!(b.iter().zip(x).all(|(b, x)| (b - x).norm() < 1e-14), "{b:?}");
    }

    #[test]
    fn says_that_a_matrix_is_singular() {
        let mut lu = Lu::<f64>::new(2);
        lu.matrix().copy_from_slice(&[1.0, 2.0, 2.0, 4.0]);
        assert_eq!(lu.factor(4.0), Err(Singular(1)));
        lu.matrix().copy_from_slice(&[1.0, f64::NAN, 2.0, 4.0]);
        assert!(lu.factor(4.0).is_err());
    }
}
