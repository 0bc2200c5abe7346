//! The last step: its ends, and the motion between them.

use serde::{Deserialize, Serialize};

use crate::model::{Model, State, motion};
use crate::program::arm_form::MAX_ORDER;

/// Longest step, for motions that nothing else limits \[s\].
pub(crate) const LONGEST_STEP: f64 = 1e4;

/// The last step of a run, by whichever method; the next one begins at its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct LastStep {
    pub start_time: f64,
    pub end_time: f64,
    /// (q, v) at the end.
    pub end: Vec<f64>,
    /// Dense output, if the step went beyond a communication point.
    pub dense: Vec<f64>,
    /// Order of the Taylor polynomial that the dense output is; 0 for that of another method.
    pub order: u32,
    /// Natural length of the next step; 0 if it is not known.
    pub natural: f64,
    /// Has a law no value at its end? Communication points in it are looked at one by one.
    pub undefined: bool,
}

impl LastStep {
    /// Of length zero, at a state, with room for so long a dense output.
    pub fn new(model: &Model, state: &State, room: usize) -> Self {
        Self {
            start_time: state.time(),
            end_time: state.time(),
            end: state.registers()[motion(model.layout())].to_vec(),
            dense: vec![0.0; room],
            order: 0,
            natural: 0.0,
            undefined: false,
        }
    }

    /// The next step begins at this state.
    pub fn end_at(&mut self, model: &Model, state: &State) {
        (self.end_time, self.undefined) = (state.time(), false);
        self.end.copy_from_slice(&state.registers()[motion(model.layout())]);
    }

    /// Is the motion at a time known from a Taylor polynomial?
    pub fn covers(&self, time: f64) -> bool {
        self.order > 0 && !self.undefined && self.start_time < time && time < self.end_time
    }

    pub fn copy_from(&mut self, other: &Self) {
        (self.start_time, self.end_time) = (other.start_time, other.end_time);
        self.end.clone_from(&other.end);
        self.dense.clone_from(&other.dense);
        (self.order, self.natural, self.undefined) = (other.order, other.natural, other.undefined);
    }

    /// Could a run of that model have written it?
    pub fn belongs_to(&self, model: &Model, room: usize) -> bool {
        self.end.len() == 2 * model.coordinates()
            && self.dense.len() == room
            && self.order as usize <= MAX_ORDER
            && self.end.iter().chain(&self.dense).all(|value| value.is_finite())
            && [self.start_time, self.end_time, self.natural].into_iter().all(f64::is_finite)
            && self.natural >= 0.0
    }
}
