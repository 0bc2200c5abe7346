//! Small dense linear equations without allocation.

/// The smallest pivot that counts, relative to the largest entry.
const SINGULAR: f64 = 1e-13;

/// LU factors of a square matrix, with partial pivoting. Storage is reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lu {
    size: usize,
    /// Row by row; L below the diagonal, U on and above it.
    factors: Vec<f64>,
    pivots: Vec<usize>,
}

/// The matrix has no inverse: this column depends on the columns before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Singular(pub usize);

impl Lu {
    pub fn new(size: usize) -> Self {
        Self { size, factors: vec![0.0; size * size], pivots: vec![0; size] }
    }

    /// The matrix to be factored, zeroed, row by row.
    pub fn matrix(&mut self) -> &mut [f64] {
        self.factors.fill(0.0);
        &mut self.factors
    }

    /// Replaces the matrix by its factors. `largest` is the size of what the matrix is a part of: a pivot that is nothing beside it counts as
    /// zero.
    pub fn factor(&mut self, largest: f64) -> Result<(), Singular> {
        let n = self.size;
        for column in 0..n {
            let size = |row: &usize| self.factors[row * n + column].abs();
            let pivot = (column..n).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(column);
            // Written so that NaN is singular too.
            let regular = size(&pivot) > SINGULAR * largest;
            if !regular {
                return Err(Singular(column));
            }
            self.pivots[column] = pivot;
            self.swap_rows(column, pivot);
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
            let factor = row[column] / pivot[column];
            row[column] = factor;
            for (entry, above) in row[column + 1..].iter_mut().zip(&pivot[column + 1..]) {
                *entry -= factor * above;
            }
        }
    }

    /// Replaces b by the solution of A x = b.
    pub fn solve(&self, b: &mut [f64]) {
        let n = self.size;
        for row in 0..n {
            b.swap(row, self.pivots[row]);
        }
        for row in 0..n {
            b[row] -= dot(&self.factors[row * n..][..row], b);
        }
        for row in (0..n).rev() {
            let known = dot(&self.factors[row * n..][row + 1..n], &b[row + 1..]);
            b[row] = (b[row] - known) / self.factors[row * n + row];
        }
    }

    /// Replaces b by the solution of A^T x = b.
    pub fn solve_transposed(&self, b: &mut [f64]) {
        let n = self.size;
        for row in 0..n {
            b[row] /= self.factors[row * n + row];
            for column in row + 1..n {
                b[column] -= self.factors[row * n + column] * b[row];
            }
        }
        for row in (0..n).rev() {
            for column in 0..row {
                b[column] -= self.factors[row * n + column] * b[row];
            }
        }
        for row in (0..n).rev() {
            b.swap(row, self.pivots[row]);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MATRIX: [f64; 9] = [0.0, 2.0, -1.0, 3.0, 1.0, 4.0, 6.0, -5.0, 2.0];
    const X: [f64; 3] = [1.0, -2.0, 3.0];

    #[test]
    fn solves_with_the_matrix_and_its_transpose() {
        let mut lu = Lu::new(3);
        lu.matrix().copy_from_slice(&MATRIX);
        lu.factor(6.0).expect("regular");
        let mut b: [f64; 3] =
            std::array::from_fn(|row| (0..3).map(|column| MATRIX[3 * row + column] * X[column]).sum());
        lu.solve(&mut b);
        let mut c: [f64; 3] = std::array::from_fn(|column| (0..3).map(|row| MATRIX[3 * row + column] * X[row]).sum());
        lu.solve_transposed(&mut c);
        for ((b, c), x) in b.iter().zip(c).zip(X) {
            assert!((b - x).abs() < 1e-14 && (c - x).abs() < 1e-14);
        }
    }

    #[test]
    fn says_that_a_matrix_is_singular() {
        let mut lu = Lu::new(2);
        lu.matrix().copy_from_slice(&[1.0, 2.0, 2.0, 4.0]);
        assert_eq!(lu.factor(4.0), Err(Singular(1)));
        lu.matrix().copy_from_slice(&[1.0, f64::NAN, 2.0, 4.0]);
        assert!(lu.factor(4.0).is_err());
    }
}
