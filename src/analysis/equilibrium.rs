//! Static equilibrium: the pose, what holds it, and whether it is stable.

use cotree_fmu::model::Model;
use nalgebra::DMatrix;

use super::search::{scales, search};
use super::variation::{Column, Row, Variation};
use super::{Failure, Point};
use crate::formulate::Formulated;

/// Stiffness counts as none below this share of the largest.
const NEUTRAL: f64 = 1e-11;

/// A pose in which nothing accelerates, with the reactions that hold it.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// Rates and accelerations are zero.
    pub point: Point,
    /// What a small disturbance does.
    pub stability: Stability,
    /// Eigenvalues of the projected stiffness \[J\], for changes of 1 rad and of the mechanism's length, ascending.
    pub stiffness: Vec<f64>,
}

/// What happens after a small disturbance from rest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stability {
    /// Nothing can move: the joints and drivers hold everything.
    Held,
    /// Every motion that is left is pushed back.
    Stable,
    /// A motion that neither is pushed back nor goes on by itself, with the coordinate that moves most.
    Neutral(String),
    /// A motion goes on by itself, with the coordinate that moves most.
    Unstable(String),
}

impl Equilibrium {
    /// Searches from the scene's guess. `formulated` belongs to the mechanism [at rest](super::at_rest).
    ///
    /// # Errors
    /// There is no equilibrium, or none was found.
    pub fn find(formulated: &Formulated, variation: &Variation) -> Result<Self, Failure> {
        let model = Model::new(formulated.lowered.program.clone())?;
        let guess = Point::resting(&model, &formulated.state);
        let point = search(formulated, variation, guess)?;
        let (stiffness, softest) = stiffness(formulated, variation, &point)?;
        let name = |index: usize| formulated.equations.coordinates[index].name.position.clone();
        let hardest = stiffness.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let stability = match stiffness.first() {
            None => Stability::Held,
            Some(&least) if least < -NEUTRAL * hardest => Stability::Unstable(name(softest)),
            Some(&least) if least <= NEUTRAL * hardest => Stability::Neutral(name(softest)),
            Some(_) => Stability::Stable,
        };
        Ok(Equilibrium { point, stability, stiffness })
    }
}

/// Eigenvalues of the tangent stiffness on the motions that the loops permit, and the coordinate that moves most in the softest of them. Of
/// loads that have no potential the symmetric part counts.
fn stiffness(formulated: &Formulated, variation: &Variation, point: &Point) -> Result<(Vec<f64>, usize), Failure> {
    let numbers = variation.at(&formulated.equations, point)?;
    let scales = scales(formulated);
    let tangent = numbers.block(Row::Motion, Column::Positions);
    let loops = numbers.block(Row::Loops, Column::Positions);
    let tangent = DMatrix::from_fn(scales.len(), scales.len(), |i, j| tangent[(i, j)] * scales[i] * scales[j]);
    let loops = DMatrix::from_fn(loops.nrows(), scales.len(), |i, j| loops[(i, j)] * scales[j]);
    let free = null_space(&loops);
    if free.is_empty() {
        return Ok((Vec::new(), 0));
    }
    let projected = free.transpose() * tangent * &free;
    let eigen = (0.5 * (&projected + projected.transpose())).symmetric_eigen();
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let softest = (free * eigen.eigenvectors.column(order[0])).icamax();
    Ok((order.into_iter().map(|index| eigen.eigenvalues[index]).collect(), softest))
}

/// Orthonormal columns that the rows of a matrix do not see.
fn null_space(rows: &DMatrix<f64>) -> DMatrix<f64> {
    let n = rows.ncols();
    if rows.is_empty() {
        return DMatrix::identity(n, n);
    }
    // The decomposition gives as many directions as there are rows: empty rows make it give all.
    let square = rows.clone().resize_vertically(rows.nrows().max(n), 0.0);
    let svd = square.svd(false, true);
    let Some(v_t) = svd.v_t else { return DMatrix::zeros(n, 0) };
    let least = 1e-10 * svd.singular_values.max();
    let free: Vec<usize> = (0..n).filter(|&index| svd.singular_values[index] <= least).collect();
    v_t.select_rows(&free).transpose()
}
