//! What is known of a run between communication points: signals, the last step, singular poses.

use serde::{Deserialize, Serialize};

use super::last_step::LastStep;
use super::passage::Passage;
use super::poses::SingularPoses;
use super::signals::Signals;
use crate::math::maximum;
use crate::model::{Model, State, motion};

/// Nothing is evaluated so near to a singular pose, in units of a usual step.
const ZONE: f64 = 0.2;

/// Together with the [`State`] and what the methods remember it determines the rest of the run bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    pub(crate) signals: Signals,
    pub(crate) last: LastStep,
    pub(crate) singular: SingularPoses,
}

impl Run {
    /// The beginning of a run, with room for so long a dense output of a step.
    pub fn new(model: &Model, state: &State, room: usize) -> Self {
        Self {
            signals: Signals::new(state),
            last: LastStep::new(model, state, room),
            singular: SingularPoses::new(model),
        }
    }

    /// Begins anew at a state.
    pub fn start(&mut self, model: &Model, state: &State) {
        self.restart(model, state);
        (self.last.start_time, self.last.natural) = (state.time(), 0.0);
        self.singular.start();
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
        self.signals.origin.copy_from(state);
        self.shift_poses(state.time());
        self.last.end_at(model, state);
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

    /// Does the next step pass a singular pose if it ends at this time, as far as is known?
    pub(crate) fn passes(&self, end: f64) -> bool {
        self.singular.ahead > 0.0 && self.last.end_time + self.singular.ahead < end
    }

    /// The largest rate at the end of the last step, in scales of its coordinate \[1/s\].
    pub(crate) fn speed(&self, model: &Model) -> f64 {
        let coordinates = &model.program().coordinates;
        let rates = coordinates.iter().zip(&self.last.end[coordinates.len()..]).take(model.mechanical());
        rates.fold(0.0, |largest, (coordinate, rate)| maximum(largest, rate.abs() / coordinate.scale))
    }

    /// Is the curve followed by short steps, and how long may the next one be?
    pub(crate) fn following(&self) -> Option<f64> {
        self.singular.follow.filter(|follow| self.last.end_time < follow.until).map(|follow| follow.most)
    }

    /// When the singular pose is in whose zone the last step ends; its end if there is none.
    pub(crate) fn pose_here(&self) -> f64 {
        self.singular.pose.filter(|_| self.in_zone(self.last.end_time)).unwrap_or(self.last.end_time)
    }

    /// Is this time so close to a singular pose that nothing may be evaluated?
    pub(crate) fn in_zone(&self, time: f64) -> bool {
        self.in_zone_of(time, self.last.natural)
    }

    /// The same for steps that are usually so long.
    pub(crate) fn in_zone_of(&self, time: f64, usual: f64) -> bool {
        self.singular.pose.is_some_and(|pose| (pose - time).abs() < ZONE * usual)
    }

    /// The next step begins at this time, earlier or later than the last one ended.
    pub(crate) fn shift_poses(&mut self, now: f64) {
        if self.singular.ahead > 0.0 {
            self.singular.ahead = f64::max(self.singular.ahead + self.last.end_time - now, 0.0);
        }
        // In the zone of a pose the next step passes it again.
        if !self.in_zone(now) {
            self.singular.passages.retain(|passage| passage.time <= now);
        }
    }

    /// Copies another run of the same model without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.signals.copy_from(&other.signals);
        self.last.copy_from(&other.last);
        self.singular.copy_from(&other.singular);
    }

    /// Is this a run of that model, with nothing in it that a run would not write?
    pub fn belongs_to(&self, model: &Model, room: usize) -> bool {
        self.signals.belongs_to(model) && self.last.belongs_to(model, room) && self.singular.belongs_to(model)
    }
}
