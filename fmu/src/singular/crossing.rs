//! Do branches cross in a pose in which loop equations depend on each other?
//!
//! That is geometry, and no matter of how well the motion is known. A combination of the loop equations vanishes there to first order. Where the other equations
//! hold, what is left of it is a saddle, d + x H x / 2, and branches are where it vanishes: they cross in the saddle if the defect d is zero, and turn off before it, at
//! a distance of about the root of d, if it is not. A motion that is known to a tolerance comes by somewhere near, where what is left may have any value. So
//! Newton's method goes to the saddle first; time is one of its unknowns, for drivers have a part in where it is.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, DVectorViewMut};

use crate::constraints::poses::{Loops, scaled};
use crate::linalg::lane::{Lane, WIDTH, ZERO};
use crate::linalg::least_squares::Equations;
use crate::linalg::sparse::{Factors, Row, columns, independent_rows, product_with_transposed};
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
        let mut study = Study::new(model);
        let Some(mut here) = study.at(&self.independent, state) else { return 0.0 };
        let defects = (0..self.combinations.len()).map(|place| study.defect(&mut here, place).abs());
        defects.fold(0.0, math::maximum)
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

/// A pose: its active loop equations in units of the scales, and what follows from their rows. The column after those of the coordinates is that of time.
struct Pose {
    state: State,
    rows: Vec<Row>,
    open: Vec<f64>,
    found: Dependences,
    /// What the independent equations leave of changes of single coordinates, as far as that has been asked for.
    free: BTreeMap<usize, Row>,
}

impl Pose {
    /// What the independent equations leave of a change of a coordinate.
    fn free(&mut self, column: usize) -> &Row {
        let Self { rows, found, free, .. } = self;
        free.entry(column).or_insert_with(|| found.along_the_loops(rows, column))
    }

    /// What is left of a combination.
    fn value(&self, place: usize) -> f64 {
        self.found.combinations[place].iter().zip(&self.open).map(|(share, open)| share * open).sum()
    }
}

/// A step of Newton's method to a saddle.
struct Step {
    /// The columns of the equations that take part.
    columns: Vec<usize>,
    /// What closes the independent equations, and weights of changes along them.
    closing: Row,
    weights: DVector<f64>,
    /// The step in these columns.
    way: DVector<f64>,
    /// What is left of the combination in the saddle, up to second order: with the multipliers of the pose it is stationary there (Nocedal and Wright, Numerical
    /// Optimization, 2006, 18.1).
    left: f64,
}

impl Step {
    /// The step in all columns.
    fn whole(&self, pose: &mut Pose) -> Row {
        let mut step = self.closing.clone();
        for (&column, weight) in self.columns.iter().zip(&self.weights) {
            pose.free(column).iter().for_each(|(&column, part)| *step.entry(column).or_default() -= weight * part);
        }
        step
    }
}

/// The storage for studying the poses of a model.
struct Study<'a> {
    model: &'a Model,
    machine: Machine,
    tangents: Vec<Lane>,
}

impl<'a> Study<'a> {
    fn new(model: &'a Model) -> Self {
        Self { model, machine: Machine::new(model), tangents: vec![ZERO; model.program().registers as usize] }
    }

    /// Evaluates a pose; none if its independent rows are not.
    fn at(&mut self, independent: &[usize], state: &State) -> Option<Pose> {
        let (model, mut state) = (self.model, state.clone());
        let x = scaled(model, &state);
        let mut loops = Loops { model, machine: &mut self.machine, state: &mut state, only: Some(model.active()) };
        let (mut rows, mut open) = (loops.rows(&x), Vec::new());
        loops.residuals(&x, &mut open);
        for (row, [before, _, after]) in rows.iter_mut().zip(self.around(&state)).filter(|(_, [a, _, b])| a != b) {
            row.insert(model.coordinates(), (after - before) / (2.0 * DIFFERENCE));
        }
        let found = Dependences::with(independent.to_vec(), &rows)?;
        Some(Pose { state, rows, open, found, free: BTreeMap::new() })
    }

    /// The loop equations a little before a time, at it, and a little after, the pose the same.
    fn around(&mut self, state: &State) -> Vec<[f64; 3]> {
        let model = self.model;
        let mut values = vec![[0.0; 3]; model.active().len()];
        let (x, mut open) = (scaled(model, state), Vec::new());
        for (place, shift) in [-DIFFERENCE, 0.0, DIFFERENCE].into_iter().enumerate() {
            let mut moved = moved(model, state, &Row::from([(model.coordinates(), 1.0)]), shift);
            Loops { model, machine: &mut self.machine, state: &mut moved, only: Some(model.active()) }
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
            let pose = moved_on.as_mut().unwrap_or(here);
            let length = step.way.amax();
            if length < NEAR {
                return step.left;
            }
            // Written so that NaN leads elsewhere too.
            let near = length <= FAR;
            if !near {
                return pose.value(place);
            }
            let way = step.whole(pose);
            let next = moved(self.model, &pose.state, &way, 1.0);
            let Some(mut next) = self.at(&here.found.independent, &next) else { return 0.0 };
            let Some(found) = self.newton_step(&mut next, place) else { return next.value(place) };
            step = found;
            moved_on = Some(next);
        }
        moved_on.as_ref().unwrap_or(here).value(place)
    }

    /// One step of Newton's method to where the independent equations hold and a combination does not change along them.
    fn newton_step(&mut self, pose: &mut Pose, place: usize) -> Option<Step> {
        let combination = pose.found.combinations[place].clone();
        let mut slopes = Row::new();
        for (row, share) in pose.rows.iter().zip(&combination).filter(|(_, share)| share.abs() > SMALLEST) {
            row.iter().for_each(|(&column, entry)| *slopes.entry(column).or_default() += share * entry);
        }
        let columns: Vec<usize> = slopes.keys().copied().collect();
        let (size, slope) = (columns.len(), DVector::from_iterator(columns.len(), slopes.into_values()));
        let bend = self.bend(pose, &combination, &columns);
        if !bend.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        let mut places = vec![None; self.model.coordinates() + 1];
        columns.iter().enumerate().for_each(|(place, &column)| places[column] = Some(place));
        let on_columns = |row: &Row, mut into: DVectorViewMut<f64>| {
            row.iter().for_each(|(&column, value)| {
                if let Some(place) = places[column] {
                    into[place] = *value
                }
            });
        };
        let mut projected = DMatrix::zeros(size, size);
        for (place, &column) in columns.iter().enumerate() {
            on_columns(pose.free(column), projected.column_mut(place));
        }
        let mut closing = pose.found.shortest(&pose.rows, &pose.open);
        closing.values_mut().for_each(|part| *part = -*part);
        let mut way = DVector::zeros(size);
        on_columns(&closing, way.as_view_mut());
        let sloping = &projected * (&slope + &bend * &way);
        // A projection and second derivatives are symmetric.
        let eigen = (&projected * &bend * &projected).symmetric_eigen();
        let least = FLAT * eigen.eigenvalues.amax();
        let inverse = eigen.eigenvalues.map(|value| if value.abs() > least { 1.0 / value } else { 0.0 });
        let weights = &eigen.eigenvectors * eigen.eigenvectors.tr_mul(&sloping).component_mul(&inverse);
        way -= &projected * &weights;
        let left = pose.value(place) + slope.dot(&way) + 0.5 * way.dot(&(&bend * &way));
        Some(Step { columns, closing, weights, way, left })
    }

    /// Second derivatives of a combination of the loop equations, its shares fixed, by some columns: those by the coordinates are exact.
    fn bend(&mut self, pose: &Pose, combination: &[f64], columns: &[usize]) -> DMatrix<f64> {
        let (model, n) = (self.model, self.model.coordinates());
        let mut bend = DMatrix::zeros(columns.len(), columns.len());
        let slopes =
            self.slopes_along(&pose.state, combination, &columns[..columns.partition_point(|column| *column < n)]);
        for (place, slope) in slopes.iter().enumerate() {
            columns
                .iter()
                .enumerate()
                .for_each(|(row, column)| bend[(row, place)] = slope.get(column).copied().unwrap_or_default());
        }
        if columns.last() == Some(&n) {
            let last = columns.len() - 1;
            let time = Row::from([(n, 1.0)]);
            let [before, after] = [-DIFFERENCE, DIFFERENCE].map(|shift| {
                let mut moved = moved(model, &pose.state, &time, shift);
                let x = scaled(model, &moved);
                let rows =
                    Loops { model, machine: &mut self.machine, state: &mut moved, only: Some(model.active()) }.rows(&x);
                move |column: &usize| -> f64 {
                    rows.iter()
                        .zip(combination)
                        .map(|(row, share)| share * row.get(column).copied().unwrap_or_default())
                        .sum()
                }
            });
            for (row, column) in columns[..last].iter().enumerate() {
                let mixed = (after(column) - before(column)) / (2.0 * DIFFERENCE);
                (bend[(row, last)], bend[(last, row)]) = (mixed, mixed);
            }
            let second = |[before, now, after]: [f64; 3]| (before - 2.0 * now + after) / (DIFFERENCE * DIFFERENCE);
            bend[(last, last)] = self
                .around(&pose.state)
                .into_iter()
                .zip(combination)
                .map(|(values, share)| share * second(values))
                .sum();
        }
        bend
    }

    /// How the row of a combination changes along some coordinates, four at a time.
    fn slopes_along(&mut self, state: &State, combination: &[f64], columns: &[usize]) -> Vec<Row> {
        let (model, program) = (self.model, self.model.program());
        let (jacobian, first) = (&program.tapes.jacobian, model.layout().positions());
        let mut slopes = vec![Row::new(); columns.len()];
        let scale = |column: usize| program.coordinates[column].scale;
        for (four, slopes) in columns.chunks(WIDTH).zip(slopes.chunks_mut(WIDTH)) {
            self.machine.load(model, state);
            self.tangents.fill(ZERO);
            for (lane, &column) in four.iter().enumerate() {
                self.tangents[first + column][lane] = scale(column);
            }
            self.machine.run_tangents(&jacobian.tape, &mut self.tangents);
            for (&(row, column), &result) in jacobian.entries.iter().zip(&jacobian.tape.results) {
                let (row, column) = (row as usize, column as usize);
                let Ok(place) = model.active().binary_search(&row) else { continue };
                if column >= program.coordinates.len() || combination[place].abs() <= SMALLEST {
                    continue;
                }
                let factor = combination[place] * scale(column) / program.constraints[row].scale;
                for (slope, change) in slopes.iter_mut().zip(self.tangents[result as usize]) {
                    *slope.entry(column).or_default() += factor * change;
                }
            }
        }
        slopes
    }
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
