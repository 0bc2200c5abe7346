//! Newton's iterations for the stages of an implicit step with a Jacobian of its own at each of them.
//!
//! Stiff springs that turn within a step make one Jacobian for all stages a poor one: it takes many iterations, or shorter steps. With X and Y the stages of q
//! and v less the start, and B the inverse of the method's matrix over the step, they are where B X = v + Y and B Y = a(q + X, v + Y). A change by
//! dX and dY is then to make up for r = v + Y - B X and s = a - B Y: dY = B dX - r leaves (B^2 - a_v B - a_q) dX = s + (B - a_v) r for
//! the three stages together.

use super::turn;
use crate::linalg::dense::Lu;
use crate::linalg::lane::{Lane, ZERO, add, minus, multiply, splat, subtract};

/// Storage for few coordinates.
#[derive(Clone, Debug)]
pub(crate) struct EachStage {
    n: usize,
    /// Derivatives of the accelerations by q, then by v, row by row, at the stages side by side.
    jacobians: Vec<Lane>,
    matrix: Lu,
    right: Vec<f64>,
    /// r
    residuals: Vec<Lane>,
    /// The inverse of the method's matrix over the step, by columns.
    inverse: [Lane; 3],
}

impl EachStage {
    /// Storage for n coordinates.
    pub fn new(n: usize) -> Self {
        let jacobians = vec![ZERO; 2 * n * n];
        Self {
            n,
            jacobians,
            matrix: Lu::new(3 * n),
            right: vec![0.0; 3 * n],
            residuals: vec![ZERO; n],
            inverse: [ZERO; 3],
        }
    }

    /// Derivatives of the accelerations by q, then by v, row by row, at the stages side by side.
    pub fn jacobians(&mut self) -> &mut [Lane] {
        &mut self.jacobians
    }

    /// Factors the matrix for a step, with the inverse of the method's matrix and its square, by columns; false if it is singular.
    pub fn factor(&mut self, h: f64, inverse: &[Lane; 3], square: &[Lane; 3]) -> bool {
        let n = self.n;
        self.inverse = inverse.map(|column| column.map(|entry| entry / h));
        let square = square.map(|column| column.map(|entry| entry / (h * h)));
        let (by_q, by_v) = self.jacobians.split_at(n * n);
        let matrix = self.matrix.matrix();
        for (place, (by_q, by_v)) in by_q.iter().zip(by_v).enumerate() {
            let (a, b) = (place / n, place % n);
            for (j, (column, square)) in self.inverse.iter().zip(&square).enumerate() {
                let damped = multiply(*by_v, *column);
                for i in 0..3 {
                    let mut entry = -damped[i];
                    if a == b {
                        entry += square[i];
                    }
                    if i == j {
                        entry -= by_q[i];
                    }
                    matrix[(3 * a + i) * 3 * n + 3 * b + j] = entry;
                }
            }
        }
        self.matrix.factor(0.0).is_ok()
    }

    /// One iteration: moves the stages, at which the derivatives are the slopes, and returns by how much, in units of the tolerances.
    pub fn iterate(&mut self, slopes: &[Lane], stages: &mut [Lane], tolerances: &[f64]) -> f64 {
        let Self { n, jacobians, matrix, right, residuals, inverse } = self;
        let (x, y) = stages.split_at_mut(*n);
        let (rates, accelerations) = slopes.split_at(*n);
        for ((residual, rate), x) in residuals.iter_mut().zip(rates).zip(&*x) {
            *residual = subtract(*rate, turn(inverse, *x));
        }
        let rows = jacobians[*n * *n..].chunks_exact(*n).zip(accelerations).zip(&*y).zip(&*residuals);
        for ((((by_v, acceleration), y), residual), place) in rows.zip(right.chunks_exact_mut(3)) {
            let undamped = add(subtract(*acceleration, turn(inverse, *y)), turn(inverse, *residual));
            let sum = by_v.iter().zip(&*residuals).fold(undamped, |sum, (by_v, residual)| minus(sum, *by_v, *residual));
            place.copy_from_slice(&sum[..3]);
        }
        matrix.solve(right);
        let (by_x, by_y) = tolerances.split_at(*n);
        let mut squares = ZERO;
        let mut count = |change: Lane, tolerance: f64| {
            let part = multiply(change, splat(1.0 / tolerance));
            squares = add(squares, multiply(part, part));
        };
        for (a, change) in right.chunks_exact(3).enumerate() {
            let dx = [change[0], change[1], change[2], change[2]];
            let dy = subtract(turn(inverse, dx), residuals[a]);
            (x[a], y[a]) = (add(x[a], dx), add(y[a], dy));
            count(dx, by_x[a]);
            count(dy, by_y[a]);
        }
        ((squares[0] + squares[1] + squares[2]) / (6 * *n).max(1) as f64).sqrt()
    }
}
