//! Singular poses: where a mechanism could leave its branch, and steps that cannot.
//!
//! In a singular pose (all bars of a loop in line, say) the rows of the Jacobian depend on each other and two branches of the motion cross. The motion itself
//! is analytic in time and goes straight on; but what is computed close to the pose knows the branch only up to rounding errors divided by
//! the distance. So nothing may be evaluated there: no step ends near a singular pose, and the polynomial of the step before
//! carries the motion across.
//!
//! The distance comes for nothing with the inverse of \[M J^T; J 0\]: the diagonal of its lower right block is that of
//! (J M^-1 J^T)^-1, and r_k = 1 / sqrt of its entry k is how far row k of J is from the rows that it may come to depend on. It passes zero like a straight
//! line in time.

use std::fmt;

use nalgebra::DMatrix;

use super::poses::{jacobian, sparse_jacobian};
use super::sparse::Row;
use super::spectrum::{ends, ends_of_many};
use crate::math;
use crate::model::{Model, State};

/// A step may bring a row this much closer to the others.
const NEAREST: f64 = 0.25;
/// A row that comes closer by this factor in one step may be on its way to a singular pose.
const FALLS: f64 = 1.05;
/// A pose further ahead than so many steps is of no concern yet.
const HORIZON: f64 = 12.0;
/// A row that comes closer by this factor in one step is about to arrive.
const SOON: f64 = 0.8;
/// A row that was coming closer and ends a step with more than this share of its distance has turned round, or has passed a singular pose.
const TURNED: f64 = 0.8;
/// Shares of a usual step: the distance from which a step passes the pose best, how long it must be in units of that distance.
const TAKE_OFF: f64 = 0.77;
const LANDING: f64 = 1.28;
/// Shares of a usual step: the largest distance from which a step passes the pose.
const PASSES: f64 = 0.85;
/// A joint or a loop equation takes part in a dependence with at least this share of the largest one.
const SHARE: f64 = 0.1;
/// With more loop equations than this the weakest combination is found by iteration.
const MANY: usize = 100;
/// A start is in the zone of a singular pose if a step along it brings a row so many times further from the others.
const ESCAPE: f64 = 20.0;

/// How close the loop equations are to depending on each other, at the front and at the end of a step: 1 / r_k^2.
#[derive(Clone, Debug)]
pub struct Guard {
    pub front: Vec<f64>,
    pub next: Vec<f64>,
}

/// What a step does about a singular pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Plan {
    /// There is none near enough.
    Free,
    /// At most this long.
    Approach(f64),
    /// At least this long: it passes the pose.
    Pass(f64),
}

/// The plan for a pose so far ahead, if steps are usually so long.
pub fn plan(ahead: f64, usual: f64) -> Plan {
    if ahead <= PASSES * usual {
        Plan::Pass(LANDING * ahead)
    } else if ahead <= (1.0 + TAKE_OFF) * usual {
        Plan::Approach(ahead - TAKE_OFF * usual)
    } else {
        Plan::Free
    }
}

impl Guard {
    /// For so many joints.
    pub fn new(joints: usize) -> Self {
        Self { front: vec![0.0; joints], next: vec![0.0; joints] }
    }

    /// The end of the step has become the front.
    pub fn roll(&mut self) {
        self.front.copy_from_slice(&self.next);
    }

    /// Is the end of the step in the zone of a singular pose, as seen from its start?
    pub fn ends_near(&self) -> bool {
        let growth = 1.0 / (NEAREST * NEAREST);
        self.front.iter().zip(&self.next).any(|(front, next)| *next > growth * front && *front > 0.0)
    }

    /// Was the start of the step in the zone of a singular pose, as seen from its end?
    pub fn began_near(&self) -> bool {
        self.front.iter().zip(&self.next).any(|(front, next)| *front > ESCAPE * ESCAPE * next && *next > 0.0)
    }

    /// The smallest r_k at the end of the step, as a share of that at its start.
    pub fn share(&self) -> f64 {
        let squares =
            self.front.iter().zip(&self.next).filter(|(front, _)| **front > 0.0).map(|(front, next)| front / next);
        squares.fold(f64::INFINITY, f64::min).sqrt()
    }

    /// Joints that are about as close as the closest one, measured by what they were at the front.
    pub fn closest(&self) -> impl Iterator<Item = usize> {
        let growth = |joint: usize| if self.front[joint] > 0.0 { self.next[joint] / self.front[joint] } else { 0.0 };
        let largest = (0..self.front.len()).map(growth).fold(0.0, f64::max);
        (0..self.front.len()).filter(move |&joint| growth(joint) >= SHARE * largest)
    }

    /// Does a row come so close that the loops must be closed tightly?
    pub fn arrives(&self) -> bool {
        self.share() < SOON
    }

    /// When a row that was coming closer may have passed a singular pose in a step of length h.
    pub fn turned(&self, h: f64) -> Option<f64> {
        let share = self.share();
        (share > TURNED).then_some(h / (1.0 + share))
    }

    /// How long after the step a row will depend on the others, if it comes closer at the same rate; 0 if none does soon.
    pub fn ahead(&self, h: f64) -> f64 {
        let share = self.share();
        let ahead = h * share / (1.0 - share);
        if share * FALLS < 1.0 && ahead < HORIZON * h { ahead } else { 0.0 }
    }
}

/// A singular pose that the motion has passed.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    /// When [s].
    pub time: f64,
    /// Joints and drivers whose loop equations depend on each other there.
    pub joints: Vec<String>,
}

impl fmt::Display for Passage {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let joints: Vec<String> = self.joints.iter().map(|name| format!("`{name}`")).collect();
        let (time, joints) = (self.time, joints.join(", "));
        write!(
            formatter,
            "t = {time:.6} s: singular pose, the loops at {joints} hold less there; passed on the same branch"
        )
    }
}

/// Joints and drivers whose loop equations depend on each other at a state, or do so most, and how far from it they are: 0 to 1.
pub fn dependent(model: &Model, state: &State) -> (f64, Vec<String>) {
    let program = model.program();
    if model.active().is_empty() {
        return (1.0, Vec::new());
    }
    let found = if model.active().len() > MANY {
        let mut rows = sparse_jacobian(model, state);
        let active: Vec<Row> = model.active().iter().map(|&row| std::mem::take(&mut rows[row])).collect();
        ends_of_many(&active).map(|found| named(model, found))
    } else {
        let mut matrix = jacobian(model, state).select_rows(model.active());
        for (mut row, &index) in matrix.row_iter_mut().zip(model.active()) {
            row /= program.constraints[index].scale;
        }
        weakest(model, &matrix)
    };
    let Some(weakest) = found else { return (1.0, Vec::new()) };
    ((weakest.least.max(0.0) / weakest.largest).sqrt(), weakest.joints)
}

/// The combination of active loop equations that holds least.
#[derive(Debug)]
pub(crate) struct Weakest {
    /// Smallest and largest eigenvalue of J J^T.
    pub least: f64,
    pub largest: f64,
    /// Joints and drivers that take part in the combination.
    pub joints: Vec<String>,
}

/// The same for the rows J of the active loop equations, in whatever units; none without equations.
pub(crate) fn weakest(model: &Model, rows: &DMatrix<f64>) -> Option<Weakest> {
    ends(rows).map(|found| named(model, found))
}

fn named(model: &Model, (least, largest, combination): (f64, f64, Vec<f64>)) -> Weakest {
    let share = SHARE * combination.iter().fold(0.0, |largest, part| math::maximum(largest, part.abs()));
    let taking_part = model.active().iter().zip(combination.iter()).filter(|(_, part)| part.abs() > share);
    let constraints = &model.program().constraints;
    let mut joints: Vec<String> = taking_part.map(|(&row, _)| constraints[row].owner.clone()).collect();
    joints.dedup();
    Weakest { least, largest, joints }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_comes_closer_evenly_arrives_when_predicted() {
        let mut guard = Guard::new(2);
        guard.front = vec![1.0, 4.0];
        guard.next = vec![1.0, 16.0];
        assert!((guard.ahead(0.3) - 0.3).abs() < 1e-12);
        assert!(!guard.ends_near() && !guard.began_near());
        guard.next = vec![1.0, 100.0];
        assert!(guard.ends_near() && guard.closest().eq([1]));
        (guard.front, guard.next) = (guard.next.clone(), vec![1.0, 0.2]);
        assert!(guard.began_near());
    }

    #[test]
    fn no_planned_step_ends_near_the_pose() {
        for usual in [1e-3, 1.0] {
            let mut ahead = 4.0 * usual;
            while ahead > 0.0 {
                let h = match plan(ahead, usual) {
                    Plan::Free => usual,
                    Plan::Approach(most) => most.min(usual),
                    Plan::Pass(least) => usual.max(least),
                };
                assert!((ahead - h).abs() > 0.2 * ahead, "{ahead} {h}");
                ahead -= h;
            }
        }
    }
}
