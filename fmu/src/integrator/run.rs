//! What a run remembers between communication points, each part with its owner.

use serde::{Deserialize, Serialize};

use super::implicit;
use super::last_step::LastStep;
use super::signals::Signals;
use super::stiffness::Choice;
use super::taylor;
use crate::model::{Model, State, motion};
use crate::singular::passing::Passage;
use crate::singular::supervisor::Supervisor;

/// Together with the [`State`] it determines the rest of the run bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    pub(crate) signals: Signals,
    pub(crate) last: LastStep,
    pub(crate) singular: Supervisor,
    pub(crate) taylor: taylor::Memory,
    pub(crate) radau: implicit::Memory,
    pub(crate) stiffness: Choice,
}

impl Run {
    /// The beginning of a run.
    pub fn new(model: &Model, state: &State) -> Self {
        Self {
            signals: Signals::new(state),
            last: LastStep::new(model, state),
            singular: Supervisor::new(model),
            taylor: taylor::Memory::default(),
            radau: implicit::Memory::new(model),
            stiffness: Choice::new(),
        }
    }

    /// Begins anew at a state.
    pub fn start(&mut self, model: &Model, state: &State) {
        self.restart(model, state);
        (self.last.start_time, self.last.natural) = (state.time(), 0.0);
        self.singular.start();
        self.stiffness = Choice::new();
        (self.signals.changed, self.signals.changed_before) = (false, false);
    }

    /// Has no step been taken yet?
    pub(crate) fn is_first(&self) -> bool {
        self.last.natural == 0.0 && self.last.start_time == self.last.end_time
    }

    /// Has no step been taken yet, and is the start a singular pose?
    pub(crate) fn begins_at_pose(&self) -> bool {
        self.is_first() && self.singular.pose == Some(self.last.end_time)
    }

    /// Forgets the step that went beyond a state; the run goes on from that state.
    pub(crate) fn restart(&mut self, model: &Model, state: &State) {
        self.taylor = taylor::Memory::default();
        self.signals.origin.copy_from(state);
        self.shift_poses(state.time());
        self.last.end_at(model, state);
        self.singular.restart();
        self.radau.forget();
    }

    /// To be called before an input or parameter of the state changes.
    pub fn change(&mut self, state: &State) {
        self.signals.change(state);
    }

    /// Has anything changed since the last communication point?
    pub fn is_changed(&self) -> bool {
        self.signals.changed
    }

    /// Will the next step end at its communication point, because changes come at every one?
    pub(crate) fn ends_at_communication_points(&self) -> bool {
        self.signals.changed && self.signals.changed_before
    }

    /// End of the last step of the integrator.
    pub(crate) fn step_end(&self) -> f64 {
        self.last.end_time
    }

    /// Does a law change over to another piece at the end of the last step?
    pub(crate) fn switches(&self) -> bool {
        self.taylor.branches.known != 0
    }

    /// Does the last step end so soon after a singular pose that nobody knows yet whether the motion has left its branch there?
    pub(crate) fn is_undecided(&self) -> bool {
        let passed = self.singular.pose.filter(|pose| *pose <= self.last.end_time);
        passed.is_some_and(|pose| self.singular.trail.leaves_open(pose))
    }

    /// All that was done since a communication point was one step, before which something had changed or not.
    pub(crate) fn join(&mut self, changed: bool) {
        self.signals.changed_before = changed;
    }

    /// The state before the first change.
    pub fn before(&self) -> &State {
        &self.signals.before
    }

    /// Goes on from a state that somebody else has moved.
    pub fn keep(&mut self, state: &State) {
        self.signals.before.copy_from(state);
        self.signals.changed = false;
    }

    /// Is the state at a later time known from the last step's polynomial? That communication point is then passed.
    pub(crate) fn interpolates(&mut self, time: f64) -> bool {
        let known = !self.signals.changed && self.last.covers(time);
        if known {
            self.signals.changed_before = false;
        }
        known
    }

    /// The state at a time with this motion (q, v).
    pub(crate) fn state_at(&self, model: &Model, time: f64, place: &[f64]) -> State {
        let mut state = self.signals.origin.clone();
        model.advance_signals(&self.signals.origin, time, state.registers_mut());
        state.registers_mut()[motion(model.layout())].copy_from_slice(place);
        state
    }

    /// Is there no passage to be reported?
    pub(crate) fn has_no_report(&self) -> bool {
        self.singular.passages.is_empty()
    }

    /// Takes those up to a time out that were passed as if branches met.
    pub fn take_inexact_passages(&mut self, time: f64) -> Vec<Passage> {
        self.singular.take_inexact_passages(time)
    }

    /// Takes the passages up to a time out.
    pub fn take_passages(&mut self, time: f64) -> Vec<Passage> {
        self.singular.take_passages(time)
    }

    /// Copies another run of the same model without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.signals.copy_from(&other.signals);
        self.last.copy_from(&other.last);
        self.singular.copy_from(&other.singular);
        self.taylor = other.taylor;
        self.radau.copy_from(&other.radau);
        self.stiffness = other.stiffness;
    }

    /// Is this a run of that model, with nothing in it that a run would not write?
    pub fn belongs_to(&self, model: &Model) -> bool {
        self.signals.belongs_to(model)
            && self.last.belongs_to(model)
            && self.singular.belongs_to(model)
            && self.radau.belongs_to(model)
            && self.stiffness.is_sound()
    }
}
