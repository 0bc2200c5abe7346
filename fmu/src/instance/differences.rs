//! Derivatives of inputs that drivers follow, where the importer gives none: backward differences of the values at its communication points.

use serde::{Deserialize, Serialize};

use super::Instance;
use crate::model::Model;

/// Values remembered of an input, before the present one.
const EARLIER: usize = 3;

/// What is known of an input that a driver follows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Followed {
    /// Time and value at the last communication points, the latest first.
    earlier: [[f64; 2]; EARLIER],
    known: u8,
    /// The value last set.
    value: f64,
    /// Has it changed since the start?
    changed: bool,
    /// Does the importer give its derivatives?
    given: bool,
}

impl Followed {
    fn new(start: f64) -> Self {
        Self { earlier: [[0.0; 2]; EARLIER], known: 0, value: start, changed: false, given: false }
    }

    /// Those of a model, at the start.
    pub(super) fn all(model: &Model) -> Vec<Self> {
        model.followed().iter().map(|&input| Self::new(model.program().inputs[input].start)).collect()
    }

    /// Could an instance have written it?
    pub(super) fn is_sound(&self) -> bool {
        let points = self.earlier.get(..usize::from(self.known));
        let ordered = |points: &[[f64; 2]]| points.windows(2).all(|pair| pair[0][0] > pair[1][0]);
        self.value.is_finite()
            && self.earlier.iter().flatten().all(|number| number.is_finite())
            && points.is_some_and(ordered)
    }

    /// The points before a time.
    fn before(&self, time: f64) -> &[[f64; 2]] {
        let points = self.earlier.get(..usize::from(self.known)).unwrap_or_default();
        let now = points.iter().take_while(|point| point[0] >= time).count();
        &points[now..]
    }

    /// Value, rate and acceleration: the parabola through the last three values. An input that rests in two of the last three intervals, or of which fewer are
    /// known, is taken as a step: of those nobody knows whether they begin a motion or jump.
    fn polynomial(&self, time: f64) -> [f64; 3] {
        let (earlier, now) = (self.before(time), [time, self.value]);
        let step = [self.value, 0.0, 0.0];
        let [first, second, ..] = earlier else { return step };
        let points = std::iter::once(&now).chain(earlier);
        let rests = points.zip(earlier).filter(|(after, before)| after[1] == before[1]).count();
        if rests + 1 >= earlier.len() {
            return step;
        }
        let slope = |after: &[f64; 2], before: &[f64; 2]| (after[1] - before[1]) / (after[0] - before[0]);
        let (last, one_before) = (slope(&now, first), slope(first, second));
        let bend = (last - one_before) / (time - second[0]);
        let polynomial = [self.value, last + bend * (time - first[0]), 2.0 * bend];
        if polynomial.iter().all(|number| number.is_finite()) { polynomial } else { step }
    }

    /// Remembers the value at a communication point.
    fn remember(&mut self, time: f64) {
        if self.before(time).len() == usize::from(self.known) {
            self.earlier.rotate_right(1);
            self.known = (self.known + 1).min(EARLIER as u8);
        }
        self.earlier[0] = [time, self.value];
    }

    /// Is it a step to another value, after a while in which it was followed?
    fn jumps(&self, time: f64) -> bool {
        let before = self.before(time);
        before.len() == EARLIER && before[0][1] != self.value && self.polynomial(time)[1..] == [0.0, 0.0]
    }
}

impl Instance {
    /// Its place among the inputs that drivers follow.
    fn followed(&self, input: usize) -> Option<usize> {
        self.model.followed().binary_search(&input).ok()
    }

    /// An input of which a driver needs derivatives that the importer does not give: it has the value that is set, and the derivatives that follow from the values
    /// before. False if it is none.
    pub(super) fn set_differenced(&mut self, input: usize, value: f64) -> bool {
        let Some(place) = self.followed(input).filter(|&place| !self.now.followed[place].given) else { return false };
        let (time, running) = (self.time(), self.is_running());
        let followed = &mut self.now.followed[place];
        followed.changed |= running && value != followed.value;
        followed.value = value;
        let polynomial = followed.polynomial(time);
        self.set_polynomial(input, polynomial);
        true
    }

    /// From now on the importer gives the derivatives of an input. What was taken for them is forgotten.
    pub(super) fn give_derivatives(&mut self, input: usize) {
        if let Some(place) = self.followed(input)
            && !std::mem::replace(&mut self.now.followed[place].given, true)
        {
            let [value, ..] = self.now.state.input_polynomial(input);
            self.set_polynomial(input, [value, 0.0, 0.0]);
        }
    }

    /// Are there inputs of which an importer's communication points must be remembered?
    pub(crate) fn has_differences(&self) -> bool {
        self.now.followed.iter().any(|followed| !followed.given)
    }

    /// To be called where a communication step of an importer begins: what was not set has the value that was set before. Gives an input that jumps here.
    pub(crate) fn note_inputs(&mut self) -> Option<usize> {
        let (time, mut jumps) = (self.time(), None);
        for place in 0..self.now.followed.len() {
            let (followed, input) = (self.now.followed[place], self.model.followed()[place]);
            if !followed.given {
                self.catch_up();
                self.set_differenced(input, followed.value);
                jumps = jumps.or(followed.jumps(time).then_some(input));
                self.now.followed[place].remember(time);
            }
        }
        jumps
    }

    /// An input that a driver follows and that has changed since the start, though nobody has ever given its derivatives.
    pub(crate) fn without_derivatives(&self) -> Option<usize> {
        let place = self.now.followed.iter().position(|followed| followed.changed && !followed.given)?;
        self.model.followed().get(place).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is taken of an input at the last of these points.
    fn taken(points: &[[f64; 2]]) -> [f64; 3] {
        let mut followed = Followed::new(points[0][1]);
        let mut polynomial = [f64::NAN; 3];
        for &[time, value] in points {
            followed.value = value;
            polynomial = followed.polynomial(time);
            followed.remember(time);
        }
        assert!(followed.is_sound());
        polynomial
    }

    #[test]
    fn parabolas_are_exact_at_any_distances() {
        let points = [0.0, 0.1, 0.25, 0.3, 0.7].map(|time| [time, 1.0 + 2.0 * time - 3.0 * time * time]);
        for count in 3..=points.len() {
            let time = points[count - 1][0];
            let exact = [points[count - 1][1], 2.0 - 6.0 * time, -6.0];
            let found = taken(&points[..count]);
            found
                .iter()
                .zip(exact)
                .for_each(|(found, exact)| assert!((found - exact).abs() < 1e-12, "{found} {exact}"));
        }
    }

    #[test]
    fn jumps_and_rests_have_no_derivatives() {
        for values in [&[1.0][..], &[1.0, 2.0], &[1.0, 1.0, 1.0, 5.0], &[1.0, 1.0, 5.0, 5.0], &[1.0, 5.0, 5.0, 5.0]] {
            let points: Vec<[f64; 2]> = values.iter().enumerate().map(|(k, &value)| [0.1 * k as f64, value]).collect();
            assert_eq!(taken(&points)[1..], [0.0, 0.0], "{values:?}");
        }
        // Where a motion turns back two values may be the same.
        let turns = [[0.0, 0.0], [1.0, 3.0], [2.0, 4.0], [3.0, 4.0]];
        assert_eq!(taken(&turns), [4.0, -0.5, -1.0]);
    }

    #[test]
    fn a_step_that_is_repeated_remembers_its_beginning_once() {
        let mut followed = Followed::new(0.0);
        [(0.0, 0.0), (1.0, 7.0), (1.0, 1.0), (2.0, 4.0)].into_iter().for_each(|(time, value)| {
            followed.value = value;
            followed.remember(time);
        });
        followed.value = 9.0;
        assert_eq!((followed.known, followed.polynomial(3.0)), (3, [9.0, 6.0, 2.0]));
    }
}
