//! The least value of a strictly convex quadratic function under linear inequalities: the dual method of active sets of Goldfarb and Idnani (*Math. Program.* 27, 1983).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A row is violated by more than this share of the size of its terms.
const VIOLATED: f64 = 1e-13;
/// A row that adds less than this share of its own length to those that are active depends on them.
const DEPENDENT: f64 = 1e-13;
/// Rows come and go no more often than this, for each row and each unknown.
const ROUNDS: usize = 20;

/// `slope . x <= bound`
#[derive(Clone, Debug)]
pub struct Inequality {
    pub slope: DVector<f64>,
    pub bound: f64,
}

/// Where the function is least, and the multiplier of each row, none below zero.
#[derive(Clone, Debug)]
pub struct Least {
    pub x: DVector<f64>,
    pub multipliers: Vec<f64>,
}

/// The least of `x.H x / 2 + g.x` under all rows; none if the rows contradict each other, or H is not positive.
pub fn least(hessian: &DMatrix<f64>, gradient: &DVector<f64>, rows: &[Inequality]) -> Option<Least> {
    let factor = Cholesky::new(hessian.clone())?;
    let mut search = Dual { factor, rows, x: DVector::zeros(0), active: Vec::new(), multipliers: Vec::new() };
    search.x = -search.factor.solve(gradient);
    for _ in 0..ROUNDS * (rows.len() + gradient.len()) {
        let Some(worst) = search.worst() else { return Some(search.found(hessian, gradient)) };
        search.add(worst)?;
    }
    None
}

struct Dual<'r> {
    factor: Cholesky<f64, Dyn>,
    rows: &'r [Inequality],
    x: DVector<f64>,
    active: Vec<usize>,
    multipliers: Vec<f64>,
}

impl Dual<'_> {
    /// With the active rows known, once more at one go: on the way x may have been so large that rounding errors of then are no small ones now.
    fn found(self, hessian: &DMatrix<f64>, gradient: &DVector<f64>) -> Least {
        let (size, count) = (gradient.len(), self.active.len());
        let mut system = DMatrix::zeros(size + count, size + count);
        let mut right = DVector::zeros(size + count);
        system.view_mut((0, 0), (size, size)).copy_from(hessian);
        right.rows_mut(0, size).copy_from(&-gradient);
        for (place, &row) in self.active.iter().enumerate() {
            let Inequality { slope, bound } = &self.rows[row];
            system.view_mut((0, size + place), (size, 1)).copy_from(slope);
            system.view_mut((size + place, 0), (1, size)).copy_from(&slope.transpose());
            right[size + place] = *bound;
        }
        let mut multipliers = vec![0.0; self.rows.len()];
        let solved = system.lu().solve(&right).filter(|solved| solved.iter().all(|solved| solved.is_finite()));
        let (x, found) = match &solved {
            Some(solved) => (solved.rows(0, size).into_owned(), solved.rows(size, count).iter().copied().collect()),
            None => (self.x, self.multipliers),
        };
        self.active.iter().zip(found).for_each(|(&row, value)| multipliers[row] = f64::max(value, 0.0));
        Least { x, multipliers }
    }

    /// How far beyond its bound a row is.
    fn excess(&self, row: usize) -> f64 {
        self.rows[row].slope.dot(&self.x) - self.rows[row].bound
    }

    /// The row that is violated most, by the size of its terms.
    fn worst(&self) -> Option<usize> {
        let share = |row: usize| {
            let Inequality { slope, bound } = &self.rows[row];
            let size = bound.abs() + slope.iter().zip(self.x.iter()).map(|(a, x)| (a * x).abs()).sum::<f64>();
            let excess = self.excess(row);
            (excess > VIOLATED * size).then(|| excess / slope.norm().max(f64::MIN_POSITIVE))
        };
        let inactive = (0..self.rows.len()).filter(|row| !self.active.contains(row));
        let violated = inactive.filter_map(|row| Some((row, share(row)?)));
        violated.reduce(|best, other| if other.1 > best.1 { other } else { best }).map(|(row, _)| row)
    }

    /// Makes a violated row active, and others inactive that would push.
    fn add(&mut self, row: usize) -> Option<()> {
        let normal = -&self.rows[row].slope;
        let mut multiplier_of_row = 0.0;
        loop {
            let (along, by) = self.direction(&normal)?;
            let pushed = (0..by.len()).filter(|&place| by[place] > 0.0);
            let ratios = pushed.map(|place| (place, self.multipliers[place] / by[place]));
            let first = ratios.reduce(|best, other| if other.1 < best.1 { other } else { best });
            let gain = along.dot(&normal);
            let whole = normal.dot(&self.factor.solve(&normal));
            let full = if gain > DEPENDENT * whole { self.excess(row) / gain } else { f64::INFINITY };
            let length = first.map_or(full, |(_, ratio)| ratio.min(full));
            if !length.is_finite() {
                return None;
            }
            if full.is_finite() {
                self.x.axpy(length, &along, 1.0);
            }
            self.multipliers.iter_mut().zip(by.iter()).for_each(|(multiplier, by)| *multiplier -= length * by);
            multiplier_of_row += length;
            match first {
                Some((place, ratio)) if ratio < full => {
                    self.active.remove(place);
                    self.multipliers.remove(place);
                }
                _ => {
                    self.active.push(row);
                    self.multipliers.push(multiplier_of_row);
                    return Some(());
                }
            }
        }
    }

    /// The step in which the active rows stay as they are, and what it takes from their multipliers.
    fn direction(&self, normal: &DVector<f64>) -> Option<(DVector<f64>, DVector<f64>)> {
        let free = self.factor.solve(normal);
        let count = self.active.len();
        if count == 0 {
            return Some((free, DVector::zeros(0)));
        }
        let normals = DMatrix::from_fn(normal.len(), count, |index, place| -self.rows[self.active[place]].slope[index]);
        let through = self.factor.solve(&normals);
        let by = normals.tr_mul(&through).lu().solve(&normals.tr_mul(&free))?;
        Some((free - through * &by, by))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(slope: &[f64], bound: f64) -> Inequality {
        Inequality { slope: DVector::from_column_slice(slope), bound }
    }

    #[test]
    fn the_nearest_point_of_a_polygon_is_found_with_its_multipliers() {
        // Nearest to (3, 2) within x <= 1, y <= 1: the corner, whose sides push with 2 and 1.
        let (hessian, gradient) = (DMatrix::identity(2, 2), DVector::from_vec(vec![-3.0, -2.0]));
        let rows = [row(&[1.0, 0.0], 1.0), row(&[0.0, 1.0], 1.0), row(&[1.0, 1.0], 5.0)];
        let found = least(&hessian, &gradient, &rows).unwrap();
        assert!((found.x - DVector::from_vec(vec![1.0, 1.0])).norm() < 1e-14);
        assert_eq!(found.multipliers.iter().map(|multiplier| multiplier.round()).collect::<Vec<_>>(), [2.0, 1.0, 0.0]);
        // Within x + y <= 1 the foot of the perpendicular.
        let found = least(&hessian, &gradient, &[row(&[1.0, 1.0], 1.0)]).unwrap();
        assert!(
            (found.x - DVector::from_vec(vec![1.0, 0.0])).norm() < 1e-14 && (found.multipliers[0] - 2.0).abs() < 1e-14
        );
    }

    #[test]
    fn rows_that_contradict_each_other_have_no_least() {
        let rows = [row(&[1.0], -1.0), row(&[-1.0], -1.0)];
        assert!(least(&DMatrix::identity(1, 1), &DVector::zeros(1), &rows).is_none());
        assert!(least(&-DMatrix::<f64>::identity(1, 1), &DVector::zeros(1), &[]).is_none());
    }

    /// At the least value of random problems the gradient is what the rows push, rows that push are met, and no other is violated.
    #[test]
    fn the_conditions_of_kuhn_and_tucker_hold() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for _ in 0..200 {
            let (n, m) = (5, 12);
            let root = DMatrix::from_fn(n, n, |_, _| random());
            let hessian = root.tr_mul(&root) + 1e-3 * DMatrix::<f64>::identity(n, n);
            let gradient = DVector::from_fn(n, |_, _| random());
            // All rows hold at the origin.
            let rows: Vec<Inequality> = (0..m)
                .map(|_| Inequality { slope: DVector::from_fn(n, |_, _| random()), bound: random().abs() })
                .collect();
            let found = least(&hessian, &gradient, &rows).unwrap();
            let push =
                rows.iter().zip(&found.multipliers).fold(DVector::zeros(n), |sum, (row, by)| sum + *by * &row.slope);
            assert!((&hessian * &found.x + &gradient + push).norm() < 1e-9);
            for (row, &multiplier) in rows.iter().zip(&found.multipliers) {
                let excess = row.slope.dot(&found.x) - row.bound;
                assert!(
                    multiplier >= 0.0 && excess < 1e-10 && (multiplier * excess).abs() < 1e-9,
                    "{multiplier} {excess}"
                );
            }
        }
    }
}
