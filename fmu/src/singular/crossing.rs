//! Do branches cross in a pose in which loop equations depend on each other?
//!
//! That is geometry, and no matter of how well the motion is known. A combination of the loop equations vanishes there to first order. Where the other equations
//! hold, what is left of it is a saddle, d + x H x / 2, and branches are where it vanishes: they cross in the saddle if the defect d is zero, and turn off before it, at
//! a distance of about the root of d, if it is not. A motion that is known to a tolerance comes by somewhere near, where what is left may have any value. So
//! Newton's method goes to the saddle first; time is one of its unknowns, for drivers have a part in where it is.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};

use crate::constraints::poses::{active_rows, constraint};
use crate::linalg::sparse::{Factors, Row, columns, independent_rows, product_with_transposed};
use crate::math;
use crate::model::{Model, State};

/// At the pose less than this share of a loop equation is new if it depends on the others. A pose that is known to 1e-3 is off by the root of that in what is
/// new: the larger shares are for those.
const NEW: [f64; 3] = [0.02, 0.1, 0.3];
/// At most so many steps of Newton's method lead to the saddle.
const CORRECTIONS: usize = 8;
/// It is reached where a step is this small, in units of the scales: what is left changes with the square only.
const NEAR: f64 = 1e-7;
/// A step longer than this leads elsewhere.
const FAR: f64 = 0.3;
/// For derivatives, in units of the scales, and in time [s].
const DIFFERENCE: f64 = 1e-5;
/// Directions in which the saddle bends by less than this share of the most do not matter for where it is.
const FLAT: f64 = 1e-4;
/// A loop equation with a smaller share in a combination has none.
const SMALLEST: f64 = 1e-12;

/// Which rows of a matrix J depend on each other.
#[derive(Debug)]
pub(super) struct Dependences {
    /// Rows that do not depend on those before them, and the factors of J J^T with them alone.
    independent: Vec<usize>,
    factors: Factors,
    /// For each other row the combination of rows that vanishes; its largest share is 1.
    pub combinations: Vec<Vec<f64>>,
}

impl Dependences {
    /// None if rounding errors hide it.
    pub fn of(rows: &[Row]) -> Option<Self> {
        let mut independent = Vec::new();
        for new in NEW {
            (_, independent) = independent_rows(rows.to_vec(), new, new);
            if independent.len() < rows.len() {
                break;
            }
        }
        Self::with(independent, rows)
    }

    /// With these rows as the independent ones.
    fn with(independent: Vec<usize>, rows: &[Row]) -> Option<Self> {
        let own: Vec<Row> = independent.iter().map(|&row| rows[row].clone()).collect();
        let factors = Factors::new(product_with_transposed(&own))?;
        let others = (0..rows.len()).filter(|row| independent.binary_search(row).is_err());
        let columns = columns(&own);
        let combination = |other: usize| {
            let mut shares = vec![0.0; own.len()];
            for (column, entry) in &rows[other] {
                columns.get(column).into_iter().flatten().for_each(|&(row, own)| shares[row] += own * entry);
            }
            factors.solve(&mut shares);
            let mut combination = vec![0.0; rows.len()];
            independent.iter().zip(shares).for_each(|(&row, share)| combination[row] = -share);
            combination[other] = 1.0;
            let largest = combination.iter().fold(0.0, |largest: f64, share| largest.max(share.abs()));
            combination.iter().map(|share| share / largest).collect()
        };
        Some(Self { combinations: others.map(combination).collect(), independent, factors })
    }

    /// By how much branches miss each other near a state, relative to the scales of the loop equations.
    pub fn defect(&self, model: &Model, state: &State) -> f64 {
        let defects = (0..self.combinations.len()).map(|place| self.defect_of(model, state, place).abs());
        defects.fold(0.0, math::maximum)
    }

    /// What is left of one of the combinations in its saddle.
    fn defect_of(&self, model: &Model, state: &State, place: usize) -> f64 {
        let mut pose = state.clone();
        for _ in 0..CORRECTIONS {
            let Some(step) = self.to_the_saddle(model, &pose, place) else { break };
            let length = step.values().fold(0.0, |most, part| math::maximum(most, part.abs()));
            // Written so that NaN leads elsewhere too.
            let near = length <= FAR;
            if !near {
                break;
            }
            pose = moved(model, &pose, &step, 1.0);
            if length < NEAR {
                break;
            }
        }
        let (rows, open) = loops(model, &pose);
        let found = Self::with(self.independent.clone(), &rows);
        found.map_or(0.0, |found| found.combinations[place].iter().zip(open).map(|(share, open)| share * open).sum())
    }

    /// One step of Newton's method to where the independent equations hold and a combination does not change along them.
    fn to_the_saddle(&self, model: &Model, pose: &State, place: usize) -> Option<Row> {
        let (rows, open) = loops(model, pose);
        let found = Self::with(self.independent.clone(), &rows)?;
        let combination = &found.combinations[place];
        let taking_part = rows.iter().zip(combination).filter(|(_, share)| share.abs() > SMALLEST);
        let columns: Vec<usize> =
            taking_part.flat_map(|(row, _)| row.keys().copied()).collect::<BTreeSet<_>>().into_iter().collect();
        let size = columns.len();
        let slope_at = |rows: &[Row]| {
            let entries = |&column: &usize| {
                rows.iter()
                    .zip(combination)
                    .map(move |(row, share)| share * row.get(&column).copied().unwrap_or_default())
                    .sum()
            };
            DVector::from_iterator(size, columns.iter().map(entries))
        };
        let bends: Vec<DVector<f64>> = columns
            .iter()
            .map(|&column| {
                let [after, before] = [DIFFERENCE, -DIFFERENCE]
                    .map(|shift| slope_at(&loops(model, &moved(model, pose, &Row::from([(column, 1.0)]), shift)).0));
                (after - before) / (2.0 * DIFFERENCE)
            })
            .collect();
        let bend = DMatrix::from_columns(&bends);
        let free: Vec<Row> = columns.iter().map(|&column| found.along_the_loops(&rows, column)).collect();
        let projected =
            DMatrix::from_fn(size, size, |row, column| free[column].get(&columns[row]).copied().unwrap_or_default());
        let mut step = found.shortest(&rows, &open);
        step.values_mut().for_each(|part| *part = -*part);
        let closing =
            DVector::from_iterator(size, columns.iter().map(|column| step.get(column).copied().unwrap_or_default()));
        let slope = &projected * (slope_at(&rows) + &bend * closing);
        let svd = (&projected * bend * &projected).svd(true, true);
        let weights = svd.solve(&slope, FLAT * svd.singular_values.max()).ok()?;
        for (direction, weight) in free.iter().zip(&weights) {
            direction.iter().for_each(|(&column, part)| *step.entry(column).or_default() -= weight * part);
        }
        Some(step)
    }

    /// What the independent equations leave of a change of one coordinate.
    fn along_the_loops(&self, rows: &[Row], column: usize) -> Row {
        let opened: Vec<f64> = rows.iter().map(|row| row.get(&column).copied().unwrap_or_default()).collect();
        let mut left = self.shortest(rows, &opened);
        left.values_mut().for_each(|part| *part = -*part);
        *left.entry(column).or_default() += 1.0;
        left
    }

    /// The shortest change of the coordinates that the independent rows turn into these values.
    fn shortest(&self, rows: &[Row], values: &[f64]) -> Row {
        let mut weights: Vec<f64> = self.independent.iter().map(|&row| values[row]).collect();
        self.factors.solve(&mut weights);
        let mut change = Row::new();
        for (&row, weight) in self.independent.iter().zip(weights) {
            rows[row].iter().for_each(|(&column, entry)| *change.entry(column).or_default() += weight * entry);
        }
        change
    }
}

/// The active loop equations at a pose, and their rows, in units of the scales; the column after those of the coordinates is that of time.
fn loops(model: &Model, pose: &State) -> (Vec<Row>, Vec<f64>) {
    let program = model.program();
    let open = |pose: &State| -> Vec<f64> {
        let values = constraint(model, pose);
        model.active().iter().map(|&row| values[row] / program.constraints[row].scale).collect()
    };
    let mut rows = active_rows(model, pose);
    let time = Row::from([(model.coordinates(), 1.0)]);
    let [after, before] = [DIFFERENCE, -DIFFERENCE].map(|shift| open(&moved(model, pose, &time, shift)));
    for (row, (after, before)) in
        rows.iter_mut().zip(after.iter().zip(before)).filter(|(_, (after, before))| **after != *before)
    {
        row.insert(model.coordinates(), (after - before) / (2.0 * DIFFERENCE));
    }
    (rows, open(pose))
}

/// A pose so many times a way further, in units of the scales and in time.
fn moved(model: &Model, pose: &State, way: &Row, times: f64) -> State {
    let mut moved = pose.clone();
    for (&column, part) in way {
        match model.program().coordinates.get(column) {
            Some(coordinate) => moved.positions_mut()[column] += times * part * coordinate.scale,
            None => model.advance_signals(pose, pose.time() + times * part, moved.registers_mut()),
        }
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_depend_on_each_other_are_found_with_their_shares() {
        let rows =
            |entries: &[&[(usize, f64)]]| entries.iter().map(|row| Row::from_iter(row.iter().copied())).collect();
        let matrix: Vec<Row> = rows(&[&[(0, 1.0)], &[(1, 2.0)], &[(2, 1.0)], &[(1, 1.0), (2, -1.0)]]);
        let found = Dependences::of(&matrix).unwrap();
        let [shares] = &found.combinations[..] else { panic!("{found:?}") };
        let expected = [0.0, -0.5, 1.0, 1.0];
        assert!(shares.iter().zip(expected).all(|(share, expected)| (share - expected).abs() < 1e-12), "{found:?}");
        let change = found.shortest(&matrix, &[3.0, 4.0, 0.0, 9.0]);
        assert!((change[&0] - 3.0).abs() < 1e-12 && (change[&1] - 2.0).abs() < 1e-12, "{change:?}");
        assert!(Dependences::of(&matrix[..3]).unwrap().combinations.is_empty());
    }
}
