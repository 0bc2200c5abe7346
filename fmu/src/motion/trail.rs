//! The last states of short steps, and how close loop equations were to depending on each other there.

use serde::{Deserialize, Serialize};

use crate::math;
use crate::model::Model;

/// States that are looked at together.
pub(crate) const WINDOW: usize = 4;
/// They lie at least so far apart, in units of the scales.
const STATES_APART: f64 = 0.01;
/// The same while all loop equations are further than half as far from the others as they have been.
const STATES_FAR_APART: f64 = 0.1;
const FAR_FROM_POSE: f64 = 4.0;
/// Longer steps pass a pose in one leap.
const LEAP: f64 = 0.05;
/// A loop equation this much closer to the others than it has been, by 1 / r^2, may be about to depend on them.
const CLOSE_TO_POSE: f64 = 50.0;

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
        }
    }

    /// The next states lie elsewhere.
    pub fn forget(&mut self) {
        (self.count, self.leapt, self.begun) = (0, false, false);
    }

    /// The next states lie a leap after the last one.
    fn leap(&mut self) {
        (self.count, self.leapt) = (0, self.begun);
        if self.begun {
            self.push();
        }
    }

    pub fn copy_from(&mut self, other: &Self) {
        (self.count, self.leapt, self.begun) = (other.count, other.leapt, other.begun);
        self.states.clone_from(&other.states);
        self.reciprocal_pivots.clone_from(&other.reciprocal_pivots);
        self.last.clone_from(&other.last);
    }

    pub fn belongs_to(&self, model: &Model) -> bool {
        let Self { count, leapt, states, reciprocal_pivots, begun: _, last } = self;
        let expected = Self::new(model);
        let pairs = [(states, expected.states), (reciprocal_pivots, expected.reciprocal_pivots), (last, expected.last)];
        (usize::from(*leapt)..=WINDOW).contains(count)
            && pairs
                .iter()
                .all(|(all, expected)| all.len() == expected.len() && all.iter().all(|value| value.is_finite()))
    }

    /// The first state that tells on which branch the motion was.
    pub fn first(&self) -> usize {
        usize::from(self.leapt)
    }

    /// Adds the end of a step (time; q and v), if the step was a short one and its end lies far enough from the states here; says whether it did. `measure` yields 1 / r^2
    /// of each loop equation at a state (time, q, v), whose smallest values so far are given.
    pub fn extend(
        &mut self,
        model: &Model,
        (time, end): (f64, &[f64]),
        smallest: &mut [f64],
        mut measure: impl FnMut(&[f64], &mut [f64]),
    ) -> bool {
        let leap = !self.begun || progress(model, &self.last[1..], end) > LEAP;
        if leap {
            self.leap();
        } else if self.leapt && self.count == 1 || self.count == 0 {
            self.push_last(smallest, &mut measure);
        }
        self.begun = true;
        self.last[0] = time;
        self.last[1..].copy_from_slice(end);
        if leap || progress(model, &self.state(self.count - 1)[1..], end) < self.apart(smallest) {
            return false;
        }
        self.push_last(smallest, &mut measure);
        true
    }

    pub fn state(&self, place: usize) -> &[f64] {
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
        let far = rows.into_iter().all(|(row, smallest)| *row < FAR_FROM_POSE * smallest);
        if far && self.count == WINDOW { STATES_FAR_APART } else { STATES_APART }
    }

    /// Adds the last state, measured.
    fn push_last(&mut self, smallest: &mut [f64], measure: &mut impl FnMut(&[f64], &mut [f64])) {
        self.push();
        let rows = &mut self.reciprocal_pivots[(self.count - 1) * smallest.len()..][..smallest.len()];
        measure(&self.last, rows);
        for (row, smallest) in rows.iter_mut().zip(smallest) {
            *row = row.min(f64::MAX);
            *smallest = math::minimum(*smallest, *row);
        }
    }

    fn push(&mut self) {
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
    pub fn closest(&self, smallest: &[f64], pose: Option<f64>) -> Option<usize> {
        if self.count < WINDOW {
            return None;
        }
        let leapt_over = |place: usize| self.leapt && place == 1 && pose.is_none_or(|pose| pose < self.state(1)[0]);
        let [first, second, third, last] = [0, 1, 2, 3].map(|place| self.rows(place));
        let near =
            |row: usize, place: f64| place > CLOSE_TO_POSE * smallest[row] && place > first[row] && place > last[row];
        let inner = (0..smallest.len()).filter(|&row| near(row, math::maximum(second[row], third[row])));
        inner.map(|row| if second[row] > third[row] { 1 } else { 2 }).find(|&place| !leapt_over(place))
    }
}

/// How far a state is from the start of the step, in units of the scales.
fn progress(model: &Model, from: &[f64], to: &[f64]) -> f64 {
    let coordinates = model.program().coordinates.iter().zip(from.iter().zip(to));
    coordinates.fold(0.0, |most, (coordinate, (from, to))| math::maximum(most, (to - from).abs() / coordinate.scale))
}

/// Loop equations that may come to depend on each other, and numbers in (q, v) if there are any.
fn sizes(model: &Model) -> (usize, usize) {
    let rows = model.program().tapes.reciprocal_pivots.len();
    (rows, if rows > 0 { 2 * model.coordinates() } else { 0 })
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
}
