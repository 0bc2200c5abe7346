//! The inverse where loop equations repeat others: with as many of them as are independent, chosen anew in every pose.
//!
//! Which choice of rows is independent changes with the pose: of a platform on parallel cranks no choice stays so for a whole turn. The pivots of the Schur
//! complement S = J M^-1 J^T, the largest first, say which rows are furthest from depending on those before them (Higham 2002, 10.3).

use super::Inverse;
use crate::linalg::SINGULAR;
use crate::linalg::dense::Lu;
use crate::linalg::lane::{WIDTH, ZERO};
use crate::math;

/// Which loop equations an inverse is made of.
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    /// How many masses come before the loop equations.
    masses: usize,
    /// Scales of the loop equations.
    scales: Vec<f64>,
    /// Equations that are in the present inverse, and loop equations that are not.
    taken: Vec<usize>,
    left_out: Vec<usize>,
    /// The sum of 1 / sigma^2 over the singular values of J in the metric of the masses and in units of the scales, but for those that are always zero.
    reciprocal_pivots: f64,
    /// I + W W^T, and columns of W C W^T, of the rows W that the others repeat.
    repeating: Lu,
    column: Vec<f64>,
}

impl Inverse {
    /// So many of the loop equations, which follow the `masses` first equations and have these scales, repeat others.
    pub fn with_repeating(mut self, repeating: usize, masses: usize, scales: &[f64]) -> Self {
        self.choice = Some(Box::new(Choice {
            masses,
            scales: scales.to_vec(),
            taken: Vec::with_capacity(self.places.len()),
            left_out: Vec::with_capacity(self.places.len()),
            reciprocal_pivots: 0.0,
            repeating: Lu::new(repeating),
            column: vec![0.0; repeating],
        }));
        self
    }

    /// Do loop equations repeat others?
    pub fn repeats(&self) -> bool {
        self.choice.is_some()
    }

    /// How close the loop equations are to depending on each other more than they always do, whichever of them are chosen: the sum of the inverse squares of
    /// their distances. None if none repeats others.
    pub fn reciprocal_pivots(&self) -> Option<f64> {
        self.choice.as_ref().map(|choice| choice.reciprocal_pivots)
    }

    /// Replaces the matrix by its inverse with as many of the loop equations as are independent; the others get rows and columns of zeros. False if there is no
    /// inverse.
    pub fn invert_independent(&mut self) -> bool {
        let Some(mut choice) = self.choice.take() else { return false };
        let regular = self.eliminate_independent(&mut choice);
        if regular {
            choice.reciprocal_pivots = choice.sum_of_inverse_squares(|row, column| self.entry(row, column));
            choice.left_out.iter().for_each(|&equation| self.clear_equation(equation));
        }
        self.choice = Some(choice);
        regular
    }

    fn eliminate_independent(&mut self, choice: &mut Choice) -> bool {
        self.bound(self.width);
        choice.taken.clear();
        choice.left_out.clear();
        choice.left_out.extend(choice.masses..self.places.len());
        for column in 0..choice.masses {
            // Written so that NaN is singular too.
            let regular = self.diagonal(column) > self.least[self.places[column]];
            if !regular {
                return false;
            }
            self.eliminate(column, self.width);
        }
        let mut first = 0.0;
        while choice.left_out.len() > choice.column.len() {
            let (place, square) = choice.furthest(|equation| self.diagonal(equation));
            first = math::maximum(first, square);
            let regular = square > SINGULAR * first;
            if !regular {
                return false;
            }
            let pivot = choice.left_out.swap_remove(place);
            choice.taken.push(pivot);
            self.eliminate(pivot, self.width);
        }
        true
    }

    fn clear_equation(&mut self, equation: usize) {
        let (place, width) = (self.places[equation], self.width);
        self.rows[place * width..][..width].fill(ZERO);
        self.rows.as_flattened_mut().chunks_exact_mut(width * WIDTH).for_each(|row| row[place] = 0.0);
    }
}

impl Choice {
    fn scale(&self, equation: usize) -> f64 {
        self.scales[equation - self.masses]
    }

    /// The place of the loop equation left out that is furthest from depending on those taken, and the square of how far.
    fn furthest(&self, diagonal: impl Fn(usize) -> f64) -> (usize, f64) {
        let square = |&equation: &usize| diagonal(equation).abs() / (self.scale(equation) * self.scale(equation));
        let larger =
            |furthest: (usize, f64), (place, square)| if square > furthest.1 { (place, square) } else { furthest };
        self.left_out.iter().map(square).enumerate().fold((0, 0.0), larger)
    }

    /// The trace of the pseudoinverse of S = T S_c T^T with T = (I; W): of C (I + W^T W)^-1 with C = S_c^-1, which is that of
    /// C - (I + W W^T)^-1 W C W^T. Elimination has left -W in the rows left out and -C in those taken.
    fn sum_of_inverse_squares(&mut self, entry: impl Fn(usize, usize) -> f64) -> f64 {
        let Self { masses, scales, taken, left_out, repeating, column, .. } = self;
        let scale = |equation: usize| scales[equation - *masses];
        let w = |row: usize, k: usize| entry(row, k) * scale(k) / scale(row);
        let c = |j: usize, k: usize| -entry(j, k) * scale(j) * scale(k);
        let product = |one: usize, other: usize| taken.iter().map(|&k| w(one, k) * w(other, k)).sum::<f64>();
        let products = left_out.iter().flat_map(|&one| left_out.iter().map(move |&other| (one, other)));
        for (place, (one, other)) in repeating.matrix().iter_mut().zip(products) {
            *place = product(one, other);
        }
        repeating.add_to_diagonal(1.0);
        let sum: f64 = taken.iter().map(|&k| c(k, k)).sum();
        if repeating.factor(0.0).is_err() {
            return f64::NAN;
        }
        let mut repeated = 0.0;
        for (i, &one) in left_out.iter().enumerate() {
            for (place, &other) in column.iter_mut().zip(&*left_out) {
                let along = |j: usize| taken.iter().map(|&k| c(j, k) * w(one, k)).sum::<f64>();
                *place = taken.iter().map(|&j| w(other, j) * along(j)).sum();
            }
            repeating.solve(column);
            repeated += column[i];
        }
        sum - repeated
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, SymmetricEigen};

    use super::*;
    use crate::linalg::matrix::Entries;

    const MASSES: [f64; 3] = [2.0, 4.0, 0.5];

    /// Of rows of which so many repeat others.
    fn inverse(rows: &[[f64; 3]], repeating: usize, scales: &[f64]) -> Option<Inverse> {
        let places = (0..3).chain(4..4 + rows.len()).collect();
        let mut matrix = Inverse::new(places, 4 + rows.len(), false).with_repeating(repeating, 3, scales);
        matrix.clear();
        MASSES.iter().enumerate().for_each(|(index, mass)| matrix.add(matrix.places(index, index), *mass));
        for (row, entries) in rows.iter().enumerate() {
            entries.iter().enumerate().for_each(|(column, entry)| matrix.add(matrix.places(column, 3 + row), *entry));
        }
        matrix.invert_independent().then_some(matrix)
    }

    #[test]
    fn the_rows_that_are_furthest_from_each_other_are_taken() {
        let [c, s] = [0.6, 0.8];
        let found = inverse(&[[1e-9, 0.0, 0.0], [c, s, 0.0], [2.0 * c, 2.0 * s, 0.0]], 2, &[1.0; 3]).unwrap();
        assert_eq!(found.choice.as_ref().unwrap().taken, [5]);
        // -1 / (J M^-1 J^T)
        let expected = -1.0 / (4.0 * (c * c / 2.0 + s * s / 4.0));
        assert!((found.diagonal(5) - expected).abs() < 1e-15 && found.diagonal(3) == 0.0 && found.diagonal(4) == 0.0);
        // The masses that are left move across the row only: M^-1 - M^-1 J^T (J M^-1 J^T)^-1 J M^-1.
        assert!((found.diagonal(0) - (0.5 + expected * c * c)).abs() < 1e-15);
    }

    #[test]
    fn reciprocal_pivots_are_those_of_all_rows() {
        let first = [[0.6, 0.8, -0.3], [0.1, -0.7, 0.4]];
        let mix = |a: f64, b: f64| [0, 1, 2].map(|k| a * first[0][k] + b * first[1][k]);
        let rows = [mix(0.3, 2.0), first[0], mix(1.0, -0.2), first[1]];
        let scales = [2.0, 0.5, 1.0, 3.0];
        let found = inverse(&rows, 2, &scales).unwrap();
        let scaled = |i: usize, k: usize| rows[i][k] / scales[i];
        let product =
            DMatrix::from_fn(4, 4, |i, j| (0..3).map(|k| scaled(i, k) * scaled(j, k) / MASSES[k]).sum::<f64>());
        let mut values: Vec<f64> = SymmetricEigen::new(product).eigenvalues.iter().copied().collect();
        values.sort_by(f64::total_cmp);
        let expected = 1.0 / values[3] + 1.0 / values[2];
        let reciprocal_pivots = found.reciprocal_pivots().unwrap();
        assert!((reciprocal_pivots / expected - 1.0).abs() < 1e-12, "{reciprocal_pivots} {expected}");
    }

    #[test]
    fn fewer_independent_rows_than_there_should_be_are_singular() {
        let one = [0.6, 0.8, 0.0];
        assert!(inverse(&[one, one, [1.2, 1.6, 0.0]], 1, &[1.0; 3]).is_none());
        assert!(inverse(&[one, one, [1.2, -1.6, 0.0]], 1, &[1.0; 3]).is_some());
        assert!(inverse(&[[f64::NAN, 0.8, 0.0], one, [1.2, -1.6, 0.0]], 1, &[1.0; 3]).is_none());
    }
}
