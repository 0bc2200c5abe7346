//! Do branches cross in a pose in which loop equations depend on each other?
//!
//! That is geometry, and no matter of how well the motion is known. A combination of the loop equations vanishes there to first order. Where the other equations
//! hold, what is left of it is a saddle, d + x H x / 2, and branches are where it vanishes: they cross in the saddle if the defect d is zero, and turn off before it, at
//! a distance of about the root of d, if it is not. A motion that is known to a tolerance comes by somewhere near, where what is left may have any value. So
//! Newton's method goes to the saddle first; time is one of its unknowns, for drivers have a part in where it is.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};

use crate::constraints::poses::{Loops, scaled};
use crate::linalg::lane::{Lane, WIDTH, ZERO, multiply, splat};
use crate::linalg::least_squares::Equations;
use crate::linalg::sparse::{Factors, SparseRow, columns, independent_rows, product_with_transposed};
use crate::machine::Machine;
use crate::math;
use crate::model::{Model, State};

/// At the pose less than this share of a loop equation is new if it depends on the others. A pose that is known to 1e-3 is off by the root of that in what is
/// new: the larger shares are for those.
const NEW: [f64; 3] = [0.02, 0.1, 0.3];
/// At most so many steps of Newton's method lead to the saddle.
const CORRECTIONS: usize = 8;
/// It is as good as reached where a step is this small, in units of the scales: what is left there follows from the first and second derivatives but for the cube of
/// the step.
const NEAR: f64 = 1e-5;
/// A step longer than this leads elsewhere.
const FAR: f64 = 0.3;
/// For derivatives by time [s].
const DIFFERENCE: f64 = 1e-5;
/// Directions in which the saddle bends by less than this share of the most do not matter for where it is.
const FLAT: f64 = 1e-4;
/// A loop equation with a smaller share in a combination does not bend its saddle: what is left is wrong by half of this times the square of a step of [`NEAR`].
const SMALLEST: f64 = 1e-6;

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
    pub fn of(rows: &[SparseRow]) -> Option<Self> {
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
    fn with(independent: Vec<usize>, rows: &[SparseRow]) -> Option<Self> {
        let own: Vec<SparseRow> = independent.iter().map(|&row| rows[row].clone()).collect();
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
    pub fn defect(&self, model: &Model, imposed: &[usize], state: &State) -> f64 {
        let mut study = Study::new(model, imposed);
        let Some(mut here) = study.at(&self.independent, state) else { return 0.0 };
        let defects = (0..self.combinations.len()).map(|place| study.defect(&mut here, place).abs());
        defects.fold(0.0, math::maximum)
    }

    /// What the independent equations leave of a change of one coordinate.
    fn along_the_loops(&self, rows: &[SparseRow], column: usize) -> SparseRow {
        let opened: Vec<f64> = rows.iter().map(|row| row.get(&column).copied().unwrap_or_default()).collect();
        let mut left = self.shortest(rows, &opened);
        left.values_mut().for_each(|part| *part = -*part);
        *left.entry(column).or_default() += 1.0;
        left
    }

    /// The shortest change of the coordinates that the independent rows turn into these values.
    fn shortest(&self, rows: &[SparseRow], values: &[f64]) -> SparseRow {
        let mut weights: Vec<f64> = self.independent.iter().map(|&row| values[row]).collect();
        self.factors.solve(&mut weights);
        let mut change = SparseRow::new();
        for (&row, weight) in self.independent.iter().zip(weights) {
            rows[row].iter().for_each(|(&column, entry)| *change.entry(column).or_default() += weight * entry);
        }
        change
    }
}

/// A pose: the loop equations that count there in units of the scales, and what follows from their rows. The column after those of the coordinates is that of time.
struct Pose {
    state: State,
    rows: Vec<SparseRow>,
    open: Vec<f64>,
    found: Dependences,
    /// The shortest change that closes the independent equations.
    closing: SparseRow,
    /// What the independent equations leave of changes of single coordinates, as far as that has been asked for.
    free: BTreeMap<usize, SparseRow>,
    /// How the Jacobian changes with four coordinates, by the number of the four, as far as that has been asked for.
    changes: BTreeMap<usize, Vec<Change>>,
}

impl Pose {
    /// What the independent equations leave of a change of a coordinate.
    fn free(&mut self, column: usize) -> &SparseRow {
        let Self { rows, found, free, .. } = self;
        free.entry(column).or_insert_with(|| found.along_the_loops(rows, column))
    }

    /// What is left of a combination.
    fn value(&self, place: usize) -> f64 {
        self.found.combinations[place].iter().zip(&self.open).map(|(share, open)| share * open).sum()
    }
}

/// A step of Newton's method to a saddle.
struct NewtonStep {
    /// By columns.
    way: Vec<f64>,
    /// Its largest part among those that bend the saddle.
    length: f64,
    /// What is left of the combination in the saddle, up to second order: with the multipliers of the pose it is stationary there (Nocedal and Wright, Numerical
    /// Optimization, 2006, 18.1).
    left: f64,
}

/// How an entry of a loop equation's row changes along four directions: row and column, in units of the scales.
pub(super) type Change = (usize, usize, Lane);

/// Second derivatives of the loop equations, exact, along directions.
pub(super) struct Changes<'a> {
    model: &'a Model,
    /// The loop equations whose rows are asked for.
    imposed: Vec<usize>,
    machine: Machine,
    tangents: Vec<Lane>,
}

impl<'a> Changes<'a> {
    pub fn new(model: &'a Model, imposed: Vec<usize>) -> Self {
        let tangents = vec![ZERO; model.program().registers as usize];
        Self { model, imposed, machine: Machine::new(model), tangents }
    }

    /// Of the rows at a state along these changes of coordinates, in units of the scales.
    pub fn along(&mut self, state: &State, directions: impl Iterator<Item = (usize, Lane)>) -> Vec<Change> {
        let (model, program) = (self.model, self.model.program());
        let (jacobian, first) = (&program.tapes.jacobian, model.layout().positions());
        let scale = |column: usize| program.coordinates[column].scale;
        self.machine.load(model, state);
        self.tangents[first..][..model.coordinates()].fill(ZERO);
        directions.for_each(|(column, parts)| self.tangents[first + column] = multiply(splat(scale(column)), parts));
        self.machine.run_tangents(&jacobian.tape, &mut self.tangents);
        let entries = jacobian.entries.iter().zip(&jacobian.tape.results);
        let entries = entries.filter(|((_, column), _)| (*column as usize) < model.coordinates());
        let change = |(&(row, column), &result): (&(u32, u32), &u32)| {
            let (row, column) = (row as usize, column as usize);
            let factor = scale(column) / program.constraints[row].scale;
            let place = self.imposed.binary_search(&row).ok()?;
            Some((place, column, multiply(splat(factor), self.tangents[result as usize])))
        };
        entries.filter_map(change).filter(|(.., changes)| *changes != ZERO).collect()
    }
}

/// The storage for studying the poses of a model.
struct Study<'a> {
    model: &'a Model,
    /// The loop equations that count in the pose.
    imposed: &'a [usize],
    machine: Machine,
    changes: Changes<'a>,
}

impl<'a> Study<'a> {
    fn new(model: &'a Model, imposed: &'a [usize]) -> Self {
        Self { model, imposed, machine: Machine::new(model), changes: Changes::new(model, imposed.to_vec()) }
    }

    /// Evaluates a pose; none if its independent rows are not.
    fn at(&mut self, independent: &[usize], state: &State) -> Option<Pose> {
        let (model, mut state) = (self.model, state.clone());
        let x = scaled(model, &state);
        let mut loops = Loops { model, machine: &mut self.machine, state: &mut state, only: Some(self.imposed) };
        let (mut rows, mut open) = (loops.rows(&x), Vec::new());
        loops.residuals(&x, &mut open);
        for (row, [before, _, after]) in rows.iter_mut().zip(self.around(&state)).filter(|(_, [a, _, b])| a != b) {
            row.insert(model.coordinates(), (after - before) / (2.0 * DIFFERENCE));
        }
        let found = Dependences::with(independent.to_vec(), &rows)?;
        let mut closing = found.shortest(&rows, &open);
        closing.values_mut().for_each(|part| *part = -*part);
        Some(Pose { state, rows, open, found, closing, free: BTreeMap::new(), changes: BTreeMap::new() })
    }

    /// The loop equations a little before a time, at it, and a little after, the pose the same.
    fn around(&mut self, state: &State) -> Vec<[f64; 3]> {
        let model = self.model;
        let mut values = vec![[0.0; 3]; self.imposed.len()];
        let (x, mut open) = (scaled(model, state), Vec::new());
        for (place, shift) in [-DIFFERENCE, 0.0, DIFFERENCE].into_iter().enumerate() {
            let mut moved = moved(model, state, [(model.coordinates(), 1.0)], shift);
            Loops { model, machine: &mut self.machine, state: &mut moved, only: Some(self.imposed) }
                .residuals(&x, &mut open);
            values.iter_mut().zip(&open).for_each(|(values, open)| values[place] = *open);
        }
        values
    }

    /// What is left of one of the combinations in its saddle.
    fn defect(&mut self, here: &mut Pose, place: usize) -> f64 {
        let Some(mut step) = self.newton_step(here, place) else { return here.value(place) };
        let mut moved_on: Option<Pose> = None;
        for _ in 0..CORRECTIONS {
            let pose = moved_on.as_ref().unwrap_or(here);
            if step.length < NEAR {
                return step.left;
            }
            // Written so that NaN leads elsewhere too.
            let near = step.length <= FAR;
            if !near {
                return pose.value(place);
            }
            let next = moved(self.model, &pose.state, step.way.iter().copied().enumerate(), 1.0);
            let Some(mut next) = self.at(&here.found.independent, &next) else { return 0.0 };
            let Some(found) = self.newton_step(&mut next, place) else { return next.value(place) };
            step = found;
            moved_on = Some(next);
        }
        moved_on.as_ref().unwrap_or(here).value(place)
    }

    /// One step of Newton's method to where the independent equations hold and a combination does not change along them.
    fn newton_step(&mut self, pose: &mut Pose, place: usize) -> Option<NewtonStep> {
        let combination = pose.found.combinations[place].clone();
        let mut slope = vec![0.0; self.model.coordinates() + 1];
        for (row, share) in pose.rows.iter().zip(&combination).filter(|(_, share)| **share != 0.0) {
            row.iter().for_each(|(&column, entry)| slope[column] += share * entry);
        }
        let bending = pose.rows.iter().zip(&combination).filter(|(_, share)| share.abs() > SMALLEST);
        let columns: BTreeSet<usize> = bending.flat_map(|(row, _)| row.keys().copied()).collect();
        let columns: Vec<usize> = columns.into_iter().collect();
        let bend = self.bend(pose, &combination, &columns);
        if !bend.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        let on_columns =
            |row: &SparseRow| DVector::from_iterator(columns.len(), columns.iter().map(|column| entry(row, column)));
        columns.iter().for_each(|&column| _ = pose.free(column));
        let free: Vec<&SparseRow> = columns.iter().map(|column| &pose.free[column]).collect();
        let projected = DMatrix::from_columns(&free.iter().map(|row| on_columns(row)).collect::<Vec<_>>());
        let sloping = DVector::from_iterator(columns.len(), free.iter().map(|row| dot(row, &slope)));
        let sloping = sloping + &projected * (&bend * on_columns(&pose.closing));
        // A projection and second derivatives are symmetric.
        let eigen = (&projected * &bend * &projected).symmetric_eigen();
        let least = FLAT * eigen.eigenvalues.amax();
        let inverse = eigen.eigenvalues.map(|value| if value.abs() > least { 1.0 / value } else { 0.0 });
        let weights = &eigen.eigenvectors * eigen.eigenvectors.tr_mul(&sloping).component_mul(&inverse);
        let mut way = vec![0.0; slope.len()];
        pose.closing.iter().for_each(|(&column, part)| way[column] = *part);
        for (row, weight) in free.iter().zip(&weights) {
            row.iter().for_each(|(&column, part)| way[column] -= weight * part);
        }
        let bent = DVector::from_iterator(columns.len(), columns.iter().map(|&column| way[column]));
        let left = pose.value(place)
            + slope.iter().zip(&way).map(|(slope, part)| slope * part).sum::<f64>()
            + 0.5 * bent.dot(&(&bend * &bent));
        Some(NewtonStep { way, length: bent.amax(), left })
    }

    /// Second derivatives of a combination of the loop equations, its shares fixed, by some columns: those by the coordinates are exact.
    fn bend(&mut self, pose: &mut Pose, combination: &[f64], columns: &[usize]) -> DMatrix<f64> {
        let n = self.model.coordinates();
        let mut bend = DMatrix::zeros(columns.len(), columns.len());
        let Pose { state, changes, .. } = pose;
        for (place, &column) in columns.iter().enumerate().filter(|(_, column)| **column < n) {
            let (four, lane) = (column / WIDTH, column % WIDTH);
            let changes = changes.entry(four).or_insert_with(|| self.changes.along(state, unit_directions(four, n)));
            for &(row, other, change) in changes.iter().filter(|(row, ..)| combination[*row].abs() > SMALLEST) {
                if let Ok(other) = columns.binary_search(&other) {
                    bend[(other, place)] += combination[row] * change[lane];
                }
            }
        }
        if columns.last() == Some(&n) {
            self.bend_in_time(state, combination, columns, &mut bend);
        }
        bend
    }

    /// The last row and column of the second derivatives.
    fn bend_in_time(&mut self, state: &State, combination: &[f64], columns: &[usize], bend: &mut DMatrix<f64>) {
        let (model, last) = (self.model, columns.len() - 1);
        let [before, after] = [-DIFFERENCE, DIFFERENCE].map(|shift| {
            let mut moved = moved(model, state, [(model.coordinates(), 1.0)], shift);
            let x = scaled(model, &moved);
            Loops { model, machine: &mut self.machine, state: &mut moved, only: Some(self.imposed) }.rows(&x)
        });
        for (place, column) in columns[..last].iter().enumerate() {
            let changes = after.iter().zip(&before).map(|(after, before)| entry(after, column) - entry(before, column));
            let mixed: f64 = changes.zip(combination).map(|(change, share)| share * change).sum();
            let mixed = mixed / (2.0 * DIFFERENCE);
            (bend[(place, last)], bend[(last, place)]) = (mixed, mixed);
        }
        let second = |[before, now, after]: [f64; 3]| (before - 2.0 * now + after) / (DIFFERENCE * DIFFERENCE);
        let values = self.around(state).into_iter().map(second);
        bend[(last, last)] = values.zip(combination).map(|(value, share)| share * value).sum();
    }
}

/// Each of four of so many coordinates by itself.
fn unit_directions(four: usize, coordinates: usize) -> impl Iterator<Item = (usize, Lane)> {
    let columns = four * WIDTH..coordinates.min((four + 1) * WIDTH);
    columns.map(|column| (column, std::array::from_fn(|lane| if lane == column % WIDTH { 1.0 } else { 0.0 })))
}

fn entry(row: &SparseRow, column: &usize) -> f64 {
    row.get(column).copied().unwrap_or_default()
}

fn dot(row: &SparseRow, columns: &[f64]) -> f64 {
    row.iter().map(|(&column, value)| value * columns[column]).sum()
}

/// A pose so many times a way further, in units of the scales and in time.
fn moved(model: &Model, pose: &State, way: impl IntoIterator<Item = (usize, f64)>, times: f64) -> State {
    let mut moved = pose.clone();
    for (column, part) in way.into_iter().filter(|(_, part)| *part != 0.0) {
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
            |entries: &[&[(usize, f64)]]| entries.iter().map(|row| SparseRow::from_iter(row.iter().copied())).collect();
        let matrix: Vec<SparseRow> = rows(&[&[(0, 1.0)], &[(1, 2.0)], &[(2, 1.0)], &[(1, 1.0), (2, -1.0)]]);
        let found = Dependences::of(&matrix).unwrap();
        let [shares] = &found.combinations[..] else { panic!("{found:?}") };
        let expected = [0.0, -0.5, 1.0, 1.0];
        assert!(shares.iter().zip(expected).all(|(share, expected)| (share - expected).abs() < 1e-12), "{found:?}");
        let change = found.shortest(&matrix, &[3.0, 4.0, 0.0, 9.0]);
        assert!((change[&0] - 3.0).abs() < 1e-12 && (change[&1] - 2.0).abs() < 1e-12, "{change:?}");
        assert!(Dependences::of(&matrix[..3]).unwrap().combinations.is_empty());
    }
}
