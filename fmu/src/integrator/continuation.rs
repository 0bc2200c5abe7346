//! What a run remembers between communication points.

use serde::{Deserialize, Serialize};

use super::explicit::Explicit;
use super::implicit::Memory;
use super::taylor::Taylor;
use crate::constraints::kinematic::Track;
use crate::events::switch::Choices;
use crate::integrator::control::LONGEST;
use crate::integrator::stiffness::Choice;
use crate::model::{Model, State, motion};
use crate::singular::branch::Trail;
use crate::singular::passing::Passage;

/// Nothing is evaluated so near to a singular pose, in units of a usual step.
pub(crate) const ZONE: f64 = 0.2;

/// A step that follows a curve goes this share of the way to where branches would meet.
const SHARE: f64 = 0.3;
/// The curve is followed for so many times its distance from there.
const AFTER: f64 = 1.0;

/// How the curve is followed where branches come close to each other but do not meet: by plain steps, so short that none can go over to the other branch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Follow {
    /// From here on as usual [s].
    pub until: f64,
    /// Longest next step [s].
    pub most: f64,
}

/// Together with the [`State`] it determines the rest of the run bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Continuation {
    /// The last state at which parameters, inputs or their derivatives changed; signals continue from here.
    pub(crate) origin: State,
    /// The state before the first change at this communication point.
    pub(crate) before: State,
    /// End of the last step.
    pub(crate) front_time: f64,
    /// (q, v) at the end of the last step.
    pub(crate) front: Vec<f64>,
    /// Start of the last step.
    pub(crate) dense_from: f64,
    /// Dense output of the last step, if that went beyond a communication point.
    pub(crate) dense: Vec<f64>,
    /// Order of the polynomial that the dense output is; 0 for that of the explicit method.
    pub(crate) order: u32,
    /// Pieces of laws that the next step begins in, where the front is at the end of a piece.
    pub(crate) choices: Choices,
    /// Did the last step begin the series at the front, and with the loops closed tightly? None if there is no series yet.
    pub(crate) series: Option<bool>,
    /// Natural length of the next step; 0 if it is not known.
    pub(crate) step: f64,
    /// How long after the front a singular pose will come, as far as is known; 0 for none [s].
    pub(crate) ahead: f64,
    /// When the last singular pose was found, past or to come [s].
    pub(crate) pose: Option<f64>,
    /// The smallest 1 / r^2 of each loop equation so far, where r is how far it is from the others.
    pub(crate) smallest: Vec<f64>,
    /// Do loop equations come so close to the others that the stages of a step must be on the loops?
    pub(crate) closing: bool,
    /// Where branches come close to each other but do not meet.
    pub(crate) follow: Option<Follow>,
    /// The last states of short steps.
    pub(crate) trail: Trail,
    /// Singular poses that the last steps have passed, not yet told.
    pub(crate) passages: Vec<Passage>,
    /// What the implicit method knows from the steps before.
    pub(crate) implicit: Memory,
    /// Which engine is in charge, if that may change.
    pub(crate) choice: Choice,
    /// Has anything changed at this communication point?
    pub(crate) changed: bool,
    /// Had anything changed at the last one?
    pub(crate) changed_before: bool,
}

impl Continuation {
    /// The beginning of a run.
    pub fn new(model: &Model, state: &State) -> Self {
        Self {
            origin: state.clone(),
            before: state.clone(),
            front_time: state.time(),
            front: state.registers()[motion(model.layout())].to_vec(),
            dense_from: state.time(),
            dense: vec![0.0; dense_length(model)],
            order: 0,
            choices: Choices::default(),
            series: None,
            step: 0.0,
            ahead: 0.0,
            pose: None,
            smallest: vec![f64::MAX; model.program().tapes.closeness.len()],
            closing: false,
            follow: None,
            trail: Trail::new(model),
            passages: Vec::new(),
            implicit: Memory::new(model),
            choice: Choice::new(),
            changed: false,
            changed_before: false,
        }
    }

    /// Begins anew at a state.
    pub fn start(&mut self, model: &Model, state: &State) {
        self.restart(model, state);
        self.dense_from = state.time();
        (self.step, self.ahead, self.pose) = (0.0, 0.0, None);
        self.smallest.fill(f64::MAX);
        self.closing = false;
        self.passages.clear();
        self.follow = None;
        self.trail.start();
        self.choice = Choice::new();
        (self.changed, self.changed_before) = (false, false);
    }

    /// To be called before an input or parameter of the state changes.
    pub fn change(&mut self, state: &State) {
        if !self.changed {
            self.changed = true;
            self.before.copy_from(state);
        }
    }

    /// Has anything changed since the last communication point?
    pub fn is_changed(&self) -> bool {
        self.changed
    }

    /// The state before the first change.
    pub fn before(&self) -> &State {
        &self.before
    }

    /// Goes on from a state that somebody else has moved.
    pub fn keep(&mut self, state: &State) {
        self.before.copy_from(state);
        self.changed = false;
    }

    /// Is the state at a later time known from the last step's polynomial? That communication point is then passed.
    pub(crate) fn glide(&mut self, time: f64) -> bool {
        let known = !self.changed && self.order > 0 && self.dense_from < time && time < self.front_time;
        if known {
            self.changed_before = false;
        }
        known
    }

    /// The last step of a driven mechanism: where it began is its dense output.
    pub(super) fn track(&mut self) -> Track<'_> {
        let size = self.front.len();
        Track {
            origin: &self.origin,
            start_time: &mut self.dense_from,
            start: &mut self.dense[..size],
            end_time: &mut self.front_time,
            end: &mut self.front,
            step: &mut self.step,
        }
    }

    /// Forgets the step that went beyond a state; the run goes on from that state.
    pub(crate) fn restart(&mut self, model: &Model, state: &State) {
        self.choices = Choices::default();
        self.series = None;
        self.origin.copy_from(state);
        if self.ahead > 0.0 {
            self.ahead = f64::max(self.ahead + self.front_time - state.time(), 0.0);
        }
        // In the zone of a pose the next step passes it again.
        let now = state.time();
        if !self.in_zone(now) {
            self.passages.retain(|passage| passage.time <= now);
        }
        self.front_time = now;
        self.front.copy_from_slice(&state.registers()[motion(model.layout())]);
        self.implicit.forget();
    }

    /// Judges a singular pose that a step from the front passes, by the motion there, and notes it. False if the branches do not meet there: the step must
    /// be taken again, following the curve.
    pub(crate) fn note_passage(&mut self, model: &Model, tolerance: f64, time: f64, pose: &[f64]) -> bool {
        let passage = self.passage(model, time, pose);
        if passage.is_avoided(tolerance) {
            let ahead = time - self.front_time;
            self.follow = Some(Follow { until: time + AFTER * ahead, most: SHARE * ahead });
            (self.ahead, self.pose, self.closing) = (0.0, None, false);
            return false;
        }
        self.pose = Some(time);
        self.passages.push(passage);
        true
    }

    /// Notes a singular pose that is passed by leaving its zone, unless the step that first passed it has been noted.
    pub(crate) fn note_left(&mut self, model: &Model, tolerance: f64, [from, pose]: [f64; 2], there: &[f64]) {
        if pose > from && !self.passages.iter().any(|passage| passage.time > from) {
            let passage = self.passage(model, pose, there);
            if !passage.is_avoided(tolerance) {
                self.passages.push(passage);
            }
        }
    }

    fn passage(&self, model: &Model, time: f64, pose: &[f64]) -> Passage {
        Passage::at(model, &self.state_at(model, time, pose))
    }

    /// The state at a time with this motion (q, v).
    pub(crate) fn state_at(&self, model: &Model, time: f64, place: &[f64]) -> State {
        let mut state = self.origin.clone();
        model.advance_signals(&self.origin, time, state.registers_mut());
        state.registers_mut()[motion(model.layout())].copy_from_slice(place);
        state
    }

    /// Is the curve at the front followed by short steps, and how long may the next one be?
    pub(crate) fn following(&self) -> Option<f64> {
        self.follow.filter(|follow| self.front_time < follow.until).map(|follow| follow.most)
    }

    /// After a step, at whose end a row would arrive at the others so much later if it came closer at the same rate.
    pub(crate) fn follow_on(&mut self, arrival: f64) {
        if let Some(follow) = &mut self.follow {
            follow.most = f64::min(SHARE * arrival, LONGEST);
        }
    }

    /// Is there no passage to be told of?
    pub(crate) fn is_silent(&self) -> bool {
        self.passages.is_empty()
    }

    /// Takes the passages up to a time out.
    pub fn take_passages(&mut self, time: f64) -> Vec<Passage> {
        let (told, kept) = std::mem::take(&mut self.passages).into_iter().partition(|passage| passage.time <= time);
        self.passages = kept;
        told
    }

    /// When the singular pose is in whose zone the front lies; the front's own time if there is none.
    pub(crate) fn pose_here(&self) -> f64 {
        self.pose.filter(|_| self.in_zone(self.front_time)).unwrap_or(self.front_time)
    }

    /// Is this time so close to a singular pose that nothing may be evaluated?
    pub(crate) fn in_zone(&self, time: f64) -> bool {
        self.pose.is_some_and(|pose| (pose - time).abs() < ZONE * self.step)
    }

    /// Copies another continuation of the same model without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.origin.copy_from(&other.origin);
        self.before.copy_from(&other.before);
        self.front_time = other.front_time;
        self.front.clone_from(&other.front);
        self.dense_from = other.dense_from;
        self.dense.clone_from(&other.dense);
        self.order = other.order;
        self.choices = other.choices;
        self.series = other.series;
        self.step = other.step;
        self.ahead = other.ahead;
        self.pose = other.pose;
        self.smallest.clone_from(&other.smallest);
        self.closing = other.closing;
        self.follow = other.follow;
        self.trail.copy_from(&other.trail);
        self.passages.clone_from(&other.passages);
        self.implicit.copy_from(&other.implicit);
        self.choice = other.choice;
        self.changed = other.changed;
        self.changed_before = other.changed_before;
    }

    /// Is this a continuation of that model, with nothing in it that a run would not write?
    pub fn belongs_to(&self, model: &Model) -> bool {
        let size = 2 * model.coordinates();
        let states = [&self.origin, &self.before];
        states.into_iter().all(|state| state.belongs_to(model) && state.is_finite())
            && self.front.len() == size
            && self.dense.len() == dense_length(model)
            && self.order as usize <= crate::taylor::MAX_ORDER
            && self.front.iter().chain(&self.dense).all(|value| value.is_finite())
            && [self.front_time, self.dense_from, self.step, self.ahead].into_iter().all(f64::is_finite)
            && self.step >= 0.0
            && self.ahead >= 0.0
            && self.pose.is_none_or(f64::is_finite)
            && self.follow.is_none_or(|follow| follow.until.is_finite() && follow.most > 0.0 && follow.most.is_finite())
            && self.trail.belongs_to(model)
            && self.passages.iter().all(|passage| passage.time.is_finite())
            && self.smallest.len() == model.program().tapes.closeness.len()
            && self.smallest.iter().all(|value| value.is_finite())
            && self.implicit.belongs_to(model)
            && self.choice.is_sound()
    }
}

/// Room for the dense output of any engine.
fn dense_length(model: &Model) -> usize {
    let explicit = Explicit::dense_length(2 * model.coordinates());
    if model.program().arms.is_some() { explicit.max(Taylor::dense_length(model)) } else { explicit }
}
