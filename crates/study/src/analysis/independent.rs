//! The independent coordinates of a configuration, and the dependent ones as functions of them.

use nalgebra::DMatrix;

use super::decompose::svd;

/// A direction counts as constrained when at least this share of it is independent of the others.
const NEW: f64 = 1e-9;
/// A choice that was good elsewhere is kept as long as its smallest pivot is not worse than this.
const POOR: f64 = 1e-2;

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Partition {
    pub independent: Vec<usize>,
    /// Determined by the loop equations; as many as there are equations.
    pub dependent: Vec<usize>,
}

/// A coordinate that the loops do not determine in a singular pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SingularCoordinate(pub usize);

impl Partition {
    /// The best choice for a Jacobian with rows and columns of natural size: QR factorisation with column pivoting; the pivots
    /// are the dependent coordinates.
    pub fn new(jacobian: &DMatrix<f64>) -> Result<Self, SingularCoordinate> {
        let mut rest = jacobian.clone();
        let mut left: Vec<usize> = (0..rest.ncols()).collect();
        let mut dependent = Vec::with_capacity(rest.nrows());
        for _ in 0..rest.nrows() {
            // Of equal columns the last is taken, so that the first coordinates tend to stay independent.
            let pivot = left.iter().copied().max_by(|&a, &b| rest.column(a).norm().total_cmp(&rest.column(b).norm()));
            let Some(pivot) = pivot else { return Err(SingularCoordinate(0)) };
            let norm = rest.column(pivot).norm();
            // Written so that NaN is singular too.
            let regular = norm > NEW;
            if !regular {
                return Err(SingularCoordinate(pivot));
            }
            let direction = rest.column(pivot) / norm;
            left.retain(|&column| column != pivot);
            for &column in &left {
                let share = direction.dot(&rest.column(column));
                rest.column_mut(column).axpy(-share, &direction, 1.0);
            }
            dependent.push(pivot);
        }
        dependent.sort_unstable();
        Ok(Partition { independent: left, dependent })
    }

    /// Is this choice still a good one in another pose?
    pub fn serves(&self, jacobian: &DMatrix<f64>) -> bool {
        self.dependent.len() == jacobian.nrows()
            && (jacobian.is_empty() || {
                let least = |matrix: DMatrix<f64>| svd(matrix, false, false).map(|svd| svd.singular_values.min());
                let (chosen, all) = (least(jacobian.select_columns(&self.dependent)), least(jacobian.clone()));
                chosen.is_ok_and(|chosen| all.is_ok_and(|all| chosen > POOR * all))
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_loops_determine_best_depends() {
        let jacobian = DMatrix::from_row_slice(2, 4, &[1.0, 0.1, 0.0, 3.0, 0.0, 2.0, 0.5, 0.0]);
        let partition = Partition::new(&jacobian).unwrap();
        assert_eq!(partition, Partition { independent: vec![0, 2], dependent: vec![1, 3] });
        assert!(partition.serves(&jacobian));
        let elsewhere = DMatrix::from_row_slice(2, 4, &[1.0, 0.1, 0.0, 1e-4, 0.0, 2.0, 0.5, 0.0]);
        assert!(!partition.serves(&elsewhere));
    }

    #[test]
    fn a_pose_with_more_freedom_is_singular() {
        let jacobian = DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 0.0, 2.0, 4.0, 0.0]);
        assert!(Partition::new(&jacobian).is_err());
    }
}
