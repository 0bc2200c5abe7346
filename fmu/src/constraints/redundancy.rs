//! Which loop equations repeat others in every pose.

use nalgebra::DMatrix;

use super::poses::{consistent_poses, jacobian, sparse_jacobian};
use crate::linalg::sparse;
use crate::model::{Model, State};

/// A row counts as dependent when less than this share of it is new.
const NEW: f64 = 1e-8;
/// Where more than this share of each independent row is new, the pose is regular. Elsewhere, near a singular pose, rounding errors of the pose make
/// dependent rows look independent: loops that are closed to 1e-9 leave a flat pose open by the square root of that, 3e-5.
const CLEAR: f64 = 1e-4;
/// With more rows, entries are looked at instead of matrices.
const DENSE: usize = 200;
/// How far the poses are apart, in units of the scales.
const REACH: f64 = 0.3;
/// Parts of the way to them where the motion is followed: none is so long that it ends on another branch.
const PARTS: usize = 12;

/// Rank of Phi_q over many poses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Redundancy {
    /// The largest rank found.
    pub rank: usize,
    /// Rows that are independent of the rows before them, in a pose of that rank. The others are redundant.
    pub independent: Vec<usize>,
}

/// Examines the loop equations at a consistent state and at random consistent poses near it. Of rows that depend on each other the
/// first ones are kept.
pub fn redundancy(model: &Model, state: &State, samples: usize) -> Redundancy {
    let at = |parts: usize| -> Vec<(bool, Vec<usize>)> {
        let poses = consistent_poses(model, state, samples, REACH, parts);
        poses.iter().map(|pose| examine(model, pose)).collect()
    };
    let mut found = at(1);
    if found.iter().any(|other| *other != found[0]) {
        // One of them may be an assembly that the motion does not come to: of a platform on parallel cranks, say, one that cannot move at all.
        found = at(PARTS);
    }
    let better = |best: (bool, Vec<usize>), other: (bool, Vec<usize>)| {
        if (other.0, other.1.len()) > (best.0, best.1.len()) { other } else { best }
    };
    let independent = found.into_iter().fold((false, Vec::new()), better).1;
    Redundancy { rank: independent.len(), independent }
}

/// Is the choice clear at a pose, and which rows are independent there?
fn examine(model: &Model, pose: &State) -> (bool, Vec<usize>) {
    let program = model.program();
    if program.constraints.len() > DENSE {
        return sparse::independent_rows(sparse_jacobian(model, pose), NEW, CLEAR);
    }
    let mut matrix = jacobian(model, pose);
    for (mut row, constraint) in matrix.row_iter_mut().zip(&program.constraints) {
        row /= constraint.scale;
    }
    for (mut column, coordinate) in matrix.column_iter_mut().zip(&program.coordinates) {
        column *= coordinate.scale;
    }
    independent_rows(&matrix)
}

/// Gram-Schmidt with reorthogonalisation, row by row. Is the choice clear, and which rows are independent?
fn independent_rows(matrix: &DMatrix<f64>) -> (bool, Vec<usize>) {
    let mut basis: Vec<nalgebra::RowDVector<f64>> = Vec::new();
    let mut independent = Vec::new();
    let mut clear = true;
    for (index, row) in matrix.row_iter().enumerate() {
        let size = row.norm();
        let mut rest = row.into_owned();
        for _ in 0..2 {
            for direction in &basis {
                rest -= direction * direction.dot(&rest);
            }
        }
        // Rows are of natural size 1, so that a row of rounding errors is not a direction.
        if rest.norm() > NEW * size.max(1.0) {
            clear &= rest.norm() > CLEAR * size.max(1.0);
            rest /= rest.norm();
            basis.push(rest);
            independent.push(index);
        }
    }
    (clear, independent)
}
