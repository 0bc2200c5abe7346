//! What is known of the singular poses that a run passes or comes to.

use serde::{Deserialize, Serialize};

use super::last_step::LONGEST_STEP;
use super::passage::Passage;
use super::trail::Trail;
use crate::math;
use crate::model::Model;

/// A step that follows a curve goes this share of the way to where branches would meet.
const SHARE_OF_WAY: f64 = 0.3;
/// A loop equation that is closer to the others by this factor than it has been may be about to depend on them.
const APPROACH: f64 = 100.0;

/// How the curve is followed where branches come close to each other but do not meet: by plain steps, so short that none can go over to the other branch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Follow {
    /// From here on as usual [s].
    pub until: f64,
    /// Longest next step [s].
    pub most: f64,
}

impl Follow {
    /// Where branches would meet at this time, which is so long after a step: the curve is followed for as long behind it.
    pub fn past(time: f64, ahead: f64) -> Self {
        Self { until: time + ahead, most: SHARE_OF_WAY * ahead }
    }
}

/// What a run remembers of singular poses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SingularPoses {
    /// How long after the last step a singular pose will come, as far as is known; 0 for none [s].
    pub ahead: f64,
    /// When the last singular pose was found, past or to come [s].
    pub pose: Option<f64>,
    /// The smallest 1 / r^2 of each loop equation so far, where r is how far it is from the others.
    pub smallest: Vec<f64>,
    /// Where branches come close to each other but do not meet.
    pub follow: Option<Follow>,
    /// The last states of short steps.
    pub trail: Trail,
    /// Singular poses that the last steps have passed, not yet reported.
    pub passages: Vec<Passage>,
}

impl SingularPoses {
    pub fn new(model: &Model) -> Self {
        Self {
            ahead: 0.0,
            pose: None,
            smallest: vec![f64::MAX; model.program().tapes.reciprocal_pivots.len()],
            follow: None,
            trail: Trail::new(model),
            passages: Vec::new(),
        }
    }

    /// Forgets everything.
    pub fn start(&mut self) {
        (self.ahead, self.pose, self.follow) = (0.0, None, None);
        self.smallest.fill(f64::MAX);
        self.trail.forget();
        self.passages.clear();
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
            follow.most = f64::min(SHARE_OF_WAY * arrival, LONGEST_STEP);
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
            close || *now > APPROACH * APPROACH * *smallest
        })
    }

    pub fn copy_from(&mut self, other: &Self) {
        (self.ahead, self.pose, self.follow) = (other.ahead, other.pose, other.follow);
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
            && self.trail.belongs_to(model)
            && self.passages.iter().all(|passage| passage.time.is_finite())
            && self.smallest.len() == model.program().tapes.reciprocal_pivots.len()
            && self.smallest.iter().all(|value| value.is_finite())
    }
}
