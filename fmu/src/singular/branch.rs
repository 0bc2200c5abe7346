//! Has the motion stayed on its branch where short steps pass a singular pose?
//!
//! Steps of natural length pass such a pose in one leap. Steps that stiffness keeps short come so close to it that rounding errors may decide where they
//! go on. In the pose the velocities v that continue a branch fulfil J v = 0 and, for the combination l of the loop equations that vanishes, l (J_q v) v = 0:
//! two straight lines, and l (J_q v) w = 0 too for v and w on the same one. So the rates a little before and a little after the pose tell the branches apart.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::passing::Passage;
use crate::constraints::poses::active_rows;
use crate::context::Context;
use crate::failure::Failure;
use crate::integrator::run::Run;
use crate::linalg::sparse::Row;
use crate::math;
use crate::model::{Model, State};
use crate::singular::detect::{dependent, weakest_combination};
use crate::singular::reciprocals::read;
use crate::singular::supervisor::Supervisor;

/// States that are looked at together.
const WINDOW: usize = 4;
/// They lie at least so far apart, in units of the scales.
const APART: f64 = 0.01;
/// The same while all loop equations are further than half as far from the others as they have been.
const FAR_APART: f64 = 0.1;
const FAR: f64 = 4.0;
/// Longer steps pass a pose in one leap.
const LEAP: f64 = 0.05;
/// A loop equation this much closer to the others than it has been, by 1 / r^2, may be about to depend on them.
const CLOSE: f64 = 50.0;
/// What l (J_q v) w may be of the product of its factors if v and w belong to the same branch.
const SAME: f64 = 0.01;
/// At a pose between them, loop equations are closer to depending on each other than this share of what they are at the outer states. Closeness in the
/// metric of the masses alone may change while they come no closer: very different masses do that.
const NEARER: f64 = 0.8;
/// Steps of Newton's method to the pose.
const CORRECTIONS: usize = 8;
/// It has found the pose where the last step was smaller, in units of the scales.
const FOUND: f64 = 1e-6;
/// Directions along which l J changes by less than this share of the most do not matter for where it vanishes.
const FLAT: f64 = 1e-4;
/// For derivatives along the rates, in units of the scales.
const DIFFERENCE: f64 = 1e-5;

/// The last states of short steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Trail {
    /// So many are known.
    count: usize,
    /// Does the first one lie a leap before the others? It tells how far from the pose the motion was, but not on which branch.
    leapt: bool,
    /// Time, q and v, the oldest first.
    states: Vec<f64>,
    /// 1 / r^2 of each loop equation there, where r is how far it is from the others.
    reciprocal_pivots: Vec<f64>,
    /// Time, q and v after the last step, if it is known.
    begun: bool,
    last: Vec<f64>,
    /// Poses before this time have been judged [s].
    judged: Option<f64>,
}

impl Trail {
    pub fn new(model: &Model) -> Self {
        let (rows, size) = sizes(model);
        Self {
            count: 0,
            leapt: false,
            states: vec![0.0; WINDOW * (1 + size)],
            reciprocal_pivots: vec![0.0; WINDOW * rows],
            begun: false,
            last: vec![0.0; 1 + size],
            judged: None,
        }
    }

    pub fn start(&mut self) {
        self.judged = None;
        self.forget();
    }

    /// Does it say nothing yet of a pose at a time?
    pub fn leaves_open(&self, pose: f64) -> bool {
        let first = usize::from(self.leapt);
        let known = self.count > first && self.state(first)[0] < pose;
        known && self.judged.is_none_or(|judged| judged < pose)
    }

    /// Poses before a time have been judged.
    pub fn judge(&mut self, time: f64) {
        self.judged = Some(time);
    }

    /// The next states lie elsewhere.
    pub fn forget(&mut self) {
        (self.count, self.leapt, self.begun) = (0, false, false);
    }

    /// The next states lie a leap after the last one.
    fn leap(&mut self) {
        (self.count, self.leapt) = (0, self.begun);
        if self.begun {
            self.push_last();
        }
    }

    pub fn copy_from(&mut self, other: &Self) {
        (self.count, self.leapt, self.begun, self.judged) = (other.count, other.leapt, other.begun, other.judged);
        self.states.clone_from(&other.states);
        self.reciprocal_pivots.clone_from(&other.reciprocal_pivots);
        self.last.clone_from(&other.last);
    }

    pub fn belongs_to(&self, model: &Model) -> bool {
        let Self { count, leapt, states, reciprocal_pivots, begun: _, last, judged } = self;
        let expected = Self::new(model);
        let pairs = [(states, expected.states), (reciprocal_pivots, expected.reciprocal_pivots), (last, expected.last)];
        (usize::from(*leapt)..=WINDOW).contains(count)
            && judged.is_none_or(f64::is_finite)
            && pairs
                .iter()
                .all(|(all, expected)| all.len() == expected.len() && all.iter().all(|value| value.is_finite()))
    }

    /// May the next state decide whether the motion has left its branch?
    pub fn decides(&self) -> bool {
        self.count + 1 >= WINDOW
    }

    fn state(&self, place: usize) -> &[f64] {
        let size = self.states.len() / WINDOW;
        &self.states[place * size..][..size]
    }

    fn rows(&self, place: usize) -> &[f64] {
        let size = self.reciprocal_pivots.len() / WINDOW;
        &self.reciprocal_pivots[place * size..][..size]
    }

    /// How far the next state lies from the last one at least, with these smallest 1 / r^2 so far.
    fn apart(&self, smallest: &[f64]) -> f64 {
        let rows = self.rows(self.count - 1).iter().zip(smallest);
        let far = rows.into_iter().all(|(row, smallest)| *row < FAR * smallest);
        if far && self.count == WINDOW { FAR_APART } else { APART }
    }

    /// Adds the last state.
    fn push_last(&mut self) {
        let (size, rows) = (self.last.len(), self.reciprocal_pivots.len() / WINDOW);
        if self.count == WINDOW {
            self.states.copy_within(size.., 0);
            self.reciprocal_pivots.copy_within(rows.., 0);
            (self.count, self.leapt) = (self.count - 1, false);
        }
        self.states[self.count * size..][..size].copy_from_slice(&self.last);
        self.reciprocal_pivots[self.count * rows..][..rows].fill(0.0);
        self.count += 1;
    }

    /// Which of the inner states is closest to a pose that lies between the outer ones, if there may be one, with these smallest 1 / r^2 so far. A pose that was leapt
    /// over lies before all but the first.
    fn closest(&self, smallest: &[f64], pose: Option<f64>) -> Option<usize> {
        let leapt_over = |place: usize| self.leapt && place == 1 && pose.is_none_or(|pose| pose < self.state(1)[0]);
        let [first, second, third, last] = [0, 1, 2, 3].map(|place| self.rows(place));
        let near = |row: usize, place: f64| place > CLOSE * smallest[row] && place > first[row] && place > last[row];
        let inner = (0..smallest.len()).filter(|&row| near(row, math::maximum(second[row], third[row])));
        inner.map(|row| if second[row] > third[row] { 1 } else { 2 }).find(|&place| !leapt_over(place))
    }
}

/// Loop equations that may come to depend on each other, and numbers in (q, v) if there are any.
pub(super) fn sizes(model: &Model) -> (usize, usize) {
    let rows = model.program().tapes.reciprocal_pivots.len();
    (rows, if rows > 0 { 2 * model.coordinates() } else { 0 })
}

/// How far a state is from the start of the step, in units of the scales.
pub(crate) fn progress(model: &Model, from: &[f64], to: &[f64]) -> f64 {
    let coordinates = model.program().coordinates.iter().zip(from.iter().zip(to));
    coordinates.fold(0.0, |most, (coordinate, (from, to))| math::maximum(most, (to - from).abs() / coordinate.scale))
}

/// Looks at the end of the last step.
///
/// # Errors
/// The motion has left its branch.
pub(crate) fn watch(context: &mut Context, run: &mut Run) -> Result<(), Failure> {
    let model = context.model;
    if model.program().tapes.reciprocal_pivots.is_empty() {
        return Ok(());
    }
    if !extend(context, run) {
        return Ok(());
    }
    let Supervisor { trail, smallest, pose, .. } = &run.singular;
    let Some(closest) = (if trail.count == WINDOW { trail.closest(smallest, *pose) } else { None }) else {
        return Ok(());
    };
    let followed = run.singular.follow.is_some_and(|follow| follow.until >= trail.state(0)[0]);
    let at = |place: usize| {
        let state = trail.state(place);
        run.state_at(model, state[0], &state[1..])
    };
    if followed {
        return Ok(());
    }
    let distances = [0, closest, WINDOW - 1].map(|place| dependent(model, &at(place)).0);
    if distances[1] > NEARER * math::minimum(distances[0], distances[2]) {
        return Ok(());
    }
    let before = usize::from(trail.leapt);
    let (angle, joints) = turn(model, [&at(before), &at(closest), &at(WINDOW - 1)]);
    // Written so that no number is another branch too.
    let same = angle < SAME;
    if same {
        return Ok(());
    }
    let time = trail.state(closest)[0];
    Err(Failure::BranchLost { time, joints, named: context.settings.is_named() })
}

/// Adds the end of the last step to the trail, if it was a short one and lies far enough from the states there. Says whether it did.
fn extend(context: &mut Context, run: &mut Run) -> bool {
    let model = context.model;
    let trail = &mut run.singular.trail;
    let leap = !trail.begun || progress(model, &trail.last[1..], &run.last.end) > LEAP;
    if leap {
        trail.leap();
    } else if trail.leapt && trail.count == 1 || trail.count == 0 {
        trail.push_last();
        note_reciprocals(context, run);
    }
    let trail = &mut run.singular.trail;
    trail.begun = true;
    trail.last[0] = run.last.end_time;
    trail.last[1..].copy_from_slice(&run.last.end);
    let known = trail.count;
    if leap || progress(model, &trail.state(known - 1)[1..], &run.last.end) < trail.apart(&run.singular.smallest) {
        return false;
    }
    trail.push_last();
    note_reciprocals(context, run);
    true
}

/// 1 / r^2 at the last state of the trail.
fn note_reciprocals(context: &mut Context, run: &mut Run) {
    let Context { model, machine, statistics, .. } = context;
    let Supervisor { trail, smallest, .. } = &mut run.singular;
    machine.load_signals(model, &run.signals.origin, trail.last[0]);
    machine.load_motion(model, &trail.last[1..]);
    machine.run(&model.program().tapes.acceleration);
    statistics.evaluations += 1;
    let rows = &mut trail.reciprocal_pivots[(trail.count - 1) * smallest.len()..][..smallest.len()];
    read(model, machine, rows);
    for (row, smallest) in rows.iter_mut().zip(smallest) {
        *row = row.min(f64::MAX);
        *smallest = math::minimum(*smallest, *row);
    }
}

/// l (J_q v) w at a pose for the rates before and after it, of the product of its factors; and the joints that take part in l. Zero where branches
/// only come close to each other: there the motion turns from the one to the other.
fn turn(model: &Model, [before, pose, after]: [&State; 3]) -> (f64, Vec<String>) {
    let rows = active_rows(model, pose);
    let Some((combination, joints)) = weakest_combination(model, &rows) else { return (0.0, Vec::new()) };
    let bend = change_along(model, pose, &combination, &scaled(model, before.rates()));
    let (mut product, mut bends, mut rates) = (0.0, 0.0, 0.0);
    for (bend, rate) in bend.iter().zip(scaled(model, after.rates())) {
        product += bend * rate;
        bends += bend * bend;
        rates += if *bend == 0.0 { 0.0 } else { rate * rate };
    }
    let factors = (bends * rates).sqrt();
    let angle = if factors > 0.0 { product.abs() / factors } else { 0.0 };
    let turned = angle >= SAME && cross(model, pose);
    (if turned { angle } else { 0.0 }, joints)
}

/// In units of the scales.
fn scaled(model: &Model, rates: &[f64]) -> Vec<f64> {
    rates.iter().zip(&model.program().coordinates).map(|(rate, coordinate)| rate / coordinate.scale).collect()
}

/// How l J, the combination of the loop equations' rows, changes along a direction in units of the scales.
fn change_along(model: &Model, pose: &State, combination: &[f64], direction: &[f64]) -> Vec<f64> {
    let longest = direction.iter().fold(0.0, |most, part| math::maximum(most, part.abs()));
    let at = |shift: f64| {
        let mut aside = pose.clone();
        let coordinates = direction.iter().zip(&model.program().coordinates);
        let places = aside.positions_mut().iter_mut().zip(coordinates);
        places.for_each(|(place, (part, coordinate))| *place += shift * part * coordinate.scale);
        combined(&active_rows(model, &aside), combination, direction.len())
    };
    let shift = DIFFERENCE / longest;
    at(shift).iter().zip(at(-shift)).map(|(one, other)| (one - other) / (2.0 * shift)).collect()
}

/// l J
fn combined(rows: &[Row], combination: &[f64], columns: usize) -> Vec<f64> {
    let mut sum = vec![0.0; columns];
    for (row, share) in rows.iter().zip(combination) {
        row.iter().for_each(|(&column, entry)| sum[column] += share * entry);
    }
    sum
}

/// Do branches cross near a state on one of them, or do they only come close to each other? Newton's method finds the pose where l J vanishes along the
/// directions in which the other loop equations do not open.
fn cross(model: &Model, near: &State) -> bool {
    let (mut pose, mut last) = (near.clone(), f64::INFINITY);
    for _ in 0..CORRECTIONS {
        let Some(shift) = to_the_pose(model, &pose) else { return true };
        last = shift.iter().fold(0.0, |most, shift| math::maximum(most, shift.abs()));
        let coordinates = shift.iter().zip(&model.program().coordinates);
        let places = pose.positions_mut().iter_mut().zip(coordinates);
        places.for_each(|(place, (shift, coordinate))| *place -= shift * coordinate.scale);
    }
    let found = last < FOUND;
    !found || !Passage::at(model, &pose).is_avoided()
}

/// One step of it, in units of the scales.
fn to_the_pose(model: &Model, pose: &State) -> Option<Vec<f64>> {
    let (n, rows) = (model.coordinates(), active_rows(model, pose));
    let (combination, _) = weakest_combination(model, &rows)?;
    let matrix = DMatrix::from_fn(rows.len(), n, |row, column| rows[row].get(&column).copied().unwrap_or_default());
    let eigen = (matrix.transpose() * &matrix).symmetric_eigen();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    order.truncate(n + 1 - rows.len().min(n));
    let free = eigen.eigenvectors.select_columns(&order);
    let slope = free.transpose() * DVector::from_vec(combined(&rows, &combination, n));
    let bends: Vec<f64> = free
        .column_iter()
        .flat_map(|direction| {
            let direction: Vec<f64> = direction.iter().copied().collect();
            change_along(model, pose, &combination, &direction)
        })
        .collect();
    let bend = free.transpose() * DMatrix::from_vec(n, free.ncols(), bends);
    let svd = bend.svd(true, true);
    let least = FLAT * svd.singular_values.max();
    let shift = svd.solve(&slope, least).ok()?;
    Some((free * shift).iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_closest_to_a_pose_lies_between_others() {
        let trail = |reciprocal_pivots: [f64; 4]| Trail {
            count: WINDOW,
            leapt: false,
            states: vec![0.0, 1.0, 2.0, 3.0],
            reciprocal_pivots: reciprocal_pivots.to_vec(),
            judged: None,
            begun: true,
            last: Vec::new(),
        };
        let closest = |reciprocal_pivots| trail(reciprocal_pivots).closest(&[1.0], None);
        assert_eq!(closest([60.0, 900.0, 200.0, 40.0]), Some(1));
        assert_eq!(closest([60.0, 200.0, 900.0, 40.0]), Some(2));
        // It is still to come, or nothing is close.
        assert_eq!(closest([60.0, 200.0, 900.0, 1000.0]), None);
        assert_eq!(closest([1.0, 3.0, 2.0, 1.0]), None);
        let after_a_leap = Trail { leapt: true, ..trail([0.0, 900.0, 200.0, 40.0]) };
        let closest = |pose| after_a_leap.closest(&[1.0], pose);
        assert_eq!([None, Some(0.5), Some(1.1)].map(closest), [None, None, Some(1)]);
    }

    #[test]
    fn rows_are_combined_by_their_shares() {
        let rows = [Row::from([(0, 1.0), (2, 3.0)]), Row::from([(2, -1.0)])];
        assert_eq!(combined(&rows, &[0.5, 2.0], 3), [0.5, 0.0, -0.5]);
    }
}
