//! What is known of the singular poses that a run passes or comes to.

use serde::{Deserialize, Serialize};

use super::branch::Trail;
use super::passing::Passage;
use crate::integrator::control::LONGEST;
use crate::integrator::run::Run;
use crate::math;
use crate::model::Model;

/// Series that begin anew next to a pose, converge no further than this share of the way to it, and less and less far, do not pass it: after so many steps they do
/// not go on until rounding errors choose the branch.
const CREEPING: f64 = 0.25;
const SHRINKING: f64 = 0.95;
const CREPT: u32 = 6;
/// Nothing is evaluated so near to a singular pose, in units of a usual step.
const ZONE: f64 = 0.2;
/// A step that follows a curve goes this share of the way to where branches would meet.
const SHARE: f64 = 0.3;
/// The curve is followed for so many times its distance from there.
const AFTER: f64 = 1.0;

/// A loop equation that is closer to the others by this factor than it has been may be about to depend on them.
const CLOSE: f64 = 100.0;

/// How the curve is followed where branches come close to each other but do not meet: by plain steps, so short that none can go over to the other branch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Follow {
    /// From here on as usual [s].
    pub until: f64,
    /// Longest next step [s].
    pub most: f64,
}

/// What a run remembers of singular poses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Supervisor {
    /// How long after the last step a singular pose will come, as far as is known; 0 for none [s].
    pub ahead: f64,
    /// When the last singular pose was found, past or to come [s].
    pub pose: Option<f64>,
    /// The smallest 1 / r^2 of each loop equation so far, where r is how far it is from the others.
    pub smallest: Vec<f64>,
    /// Where branches come close to each other but do not meet.
    pub follow: Option<Follow>,
    /// Since a change next to a pose so many steps, all that there were, were each shorter than the one before and a small part of the way to the pose, and the
    /// length of the last.
    pub creeping: Option<(u32, f64)>,
    /// The last states of short steps.
    pub trail: Trail,
    /// Singular poses that the last steps have passed, not yet reported.
    pub passages: Vec<Passage>,
}

impl Supervisor {
    pub fn new(model: &Model) -> Self {
        Self {
            ahead: 0.0,
            pose: None,
            smallest: vec![f64::MAX; model.program().tapes.reciprocal_pivots.len()],
            follow: None,
            creeping: None,
            trail: Trail::new(model),
            passages: Vec::new(),
        }
    }

    /// Forgets everything.
    pub fn start(&mut self) {
        (self.ahead, self.pose, self.follow) = (0.0, None, None);
        self.creeping = None;
        self.smallest.fill(f64::MAX);
        self.trail.start();
        self.passages.clear();
    }

    /// Something has changed.
    pub fn restart(&mut self) {
        self.creeping = Some((0, f64::MAX));
    }

    /// Takes those up to a time out that were passed as if branches met.
    pub fn take_inexact_passages(&mut self, time: f64) -> Vec<Passage> {
        self.take_passages_that(|passage| passage.is_inexact() && passage.time <= time)
    }

    /// Takes the passages up to a time out.
    pub fn take_passages(&mut self, time: f64) -> Vec<Passage> {
        self.take_passages_that(|passage| passage.time <= time)
    }

    fn take_passages_that(&mut self, are: impl FnMut(&Passage) -> bool) -> Vec<Passage> {
        let (reported, kept) = std::mem::take(&mut self.passages).into_iter().partition(are);
        self.passages = kept;
        reported
    }

    /// After a step that ends at a time, a pose so long after it is known; 0 for none.
    pub fn expect(&mut self, end: f64, ahead: f64) {
        self.ahead = ahead;
        if ahead > 0.0 {
            self.pose = Some(end + ahead);
        }
    }

    /// After a step, at whose end a row would arrive at the others so much later if it came closer at the same rate.
    pub fn follow_on(&mut self, arrival: f64) {
        if let Some(follow) = &mut self.follow {
            follow.most = f64::min(SHARE * arrival, LONGEST);
        }
    }

    /// After a step of a method that passes no poses, which began at a time: one that was expected after it may be that of a motion before something changed.
    pub fn step_without_poses(&mut self, start: f64) {
        self.ahead = 0.0;
        self.pose = self.pose.filter(|pose| *pose <= start);
    }

    /// Is a loop equation, with these 1 / r^2 now, much closer to the others than it has been?
    pub fn is_close(&mut self, reciprocal_pivots: &[f64]) -> bool {
        self.smallest.iter_mut().zip(reciprocal_pivots).fold(false, |close, (smallest, now)| {
            *smallest = math::minimum(*now, *smallest);
            close || *now > CLOSE * CLOSE * *smallest
        })
    }

    pub fn copy_from(&mut self, other: &Self) {
        (self.ahead, self.pose, self.follow) = (other.ahead, other.pose, other.follow);
        self.creeping = other.creeping;
        self.smallest.clone_from(&other.smallest);
        self.trail.copy_from(&other.trail);
        self.passages.clone_from(&other.passages);
    }

    /// Could a run of that model have written it?
    pub fn belongs_to(&self, model: &Model) -> bool {
        self.ahead.is_finite()
            && self.ahead >= 0.0
            && self.pose.is_none_or(f64::is_finite)
            && self.follow.is_none_or(|follow| follow.until.is_finite() && follow.most > 0.0 && follow.most.is_finite())
            && self.creeping.is_none_or(|(_, length)| length >= 0.0)
            && self.trail.belongs_to(model)
            && self.passages.iter().all(|passage| passage.time.is_finite())
            && self.smallest.len() == model.program().tapes.reciprocal_pivots.len()
            && self.smallest.iter().all(|value| value.is_finite())
    }
}

/// Singular poses as seen from the end of the last step.
impl Run {
    /// Judges a singular pose that the next step passes, by the motion there, and notes it. False if the branches do not meet there: the step must
    /// be taken again, following the curve.
    pub(crate) fn note_passage(&mut self, model: &Model, time: f64, pose: &[f64]) -> bool {
        let passage = self.passage(model, time, pose);
        if self.avoids(&passage) {
            return false;
        }
        let known = &mut self.singular;
        known.pose = Some(time);
        known.passages.push(passage);
        true
    }

    /// Is this a pose where branches come close to each other but do not meet, seen from the motion there? The next steps then follow the curve. If they almost meet it
    /// is passed, and that is to be said.
    pub(crate) fn finds_avoided(&mut self, model: &Model, time: f64, pose: &[f64]) -> bool {
        let passage = self.passage(model, time, pose);
        let avoided = self.avoids(&passage);
        if !avoided && passage.is_inexact() {
            self.singular.passages.push(passage);
        }
        avoided
    }

    fn avoids(&mut self, passage: &Passage) -> bool {
        let avoided = passage.is_avoided();
        if avoided {
            let ahead = passage.time - self.last.end_time;
            let known = &mut self.singular;
            known.follow = Some(Follow { until: passage.time + AFTER * ahead, most: SHARE * ahead });
            (known.ahead, known.pose) = (0.0, None);
        }
        avoided
    }

    /// Notes a singular pose that is passed by leaving its zone, unless the step that first passed it has been noted.
    pub(crate) fn note_left(&mut self, model: &Model, [from, pose]: [f64; 2], there: &[f64]) {
        if pose > from && !self.singular.passages.iter().any(|passage| passage.time > from) {
            let passage = self.passage(model, pose, there);
            if !passage.is_avoided() {
                self.singular.passages.push(passage);
            }
        }
    }

    fn passage(&self, model: &Model, time: f64, pose: &[f64]) -> Passage {
        Passage::at(model, &self.state_at(model, time, pose))
    }

    /// Does the next step pass a singular pose if it ends at this time, as far as is known?
    pub(crate) fn passes(&self, end: f64) -> bool {
        self.singular.ahead > 0.0 && self.last.end_time + self.singular.ahead < end
    }

    /// Is the curve followed by short steps, and how long may the next one be?
    pub(crate) fn following(&self) -> Option<f64> {
        self.singular.follow.filter(|follow| self.last.end_time < follow.until).map(|follow| follow.most)
    }

    /// When the singular pose is in whose zone the last step ends; its end if there is none.
    pub(crate) fn pose_here(&self) -> f64 {
        self.singular.pose.filter(|_| self.in_zone(self.last.end_time)).unwrap_or(self.last.end_time)
    }

    /// Do all steps since the last change, of which one more has been taken, creep up to a pose that they do not pass?
    pub(crate) fn creeps(&mut self) -> bool {
        let (natural, ahead) = (self.last.natural, self.singular.ahead);
        let follows = self.following().is_some();
        let creeps = |before: f64| !follows && natural < CREEPING * ahead && natural < SHRINKING * before;
        let creeping = self.singular.creeping.filter(|(_, before)| creeps(*before));
        self.singular.creeping = creeping.map(|(count, _)| (count + 1, natural));
        creeping.is_some_and(|(count, _)| count + 1 >= CREPT)
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
}
