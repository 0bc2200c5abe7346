//! Singular poses in the stages of a step of DOP853: where they are, what the stages do near them, and what they leave of its error.

use super::dop853::node;
use crate::constraints::projection::Projection;
use crate::context::Context;
use crate::failure::Failure;
use crate::integrator::right_hand_side::{Derivative, RightHandSide};
use crate::machine::Machine;
use crate::model::Model;
use crate::model::State;
use crate::singular::closeness::read;
use crate::singular::detect::Guard;

/// The loops are closed this well at least in stages near a singular pose.
const STAGE_TOLERANCE: f64 = 1e-5;
/// The stage before the end from which a row's way to the end is judged, and its node.
const LATE: usize = 10;
const LATE_NODE: f64 = node(LATE);
/// Stages at which rows are looked at: every gap between nodes has one of them at its side.
const LOOKS: [bool; LATE + 2] = [false, false, false, true, false, true, true, false, true, true, true, false];
/// A row whose 1 / r^2 has grown by this factor in between may have passed a singular pose.
const DIP: f64 = 10.0;

/// A row is judged by the way that it went up to the late stage if it would arrive within so many steps on it.
const BEYOND: f64 = 1.1;

/// A row whose 1 / r^2 is larger than its smallest by this factor is close to the others.
const CLOSE: f64 = 4.0;

/// It is about to depend on them, or has just done so, if that is within so many steps.
const HORIZON: f64 = 40.0;

/// What a step sees of the distance from singular poses.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    /// 1 / r^2 where the step begins.
    pub start: Vec<f64>,
    /// The same at whichever of the ends of the step distances are compared with.
    pub reference: Vec<f64>,
    /// The same at a late stage and at the end of the step.
    pub guard: Guard,
    /// At each stage, the largest growth of one since the start of the step; and of which row.
    growths: [(f64, usize); LATE + 2],
    /// The next stage.
    stage: usize,
    /// The state at a stage.
    pub point: Vec<f64>,
    /// What was against a stage.
    failure: Option<Failure>,
}

impl Watch {
    pub fn new(model: &Model) -> Self {
        let rows = model.program().tapes.closeness.len();
        Self {
            start: vec![0.0; rows],
            reference: vec![0.0; rows],
            guard: Guard::new(rows),
            growths: [(0.0, 0); LATE + 2],
            stage: 0,
            point: vec![0.0; 2 * model.coordinates()],
            failure: None,
        }
    }

    /// Before the stages of a step.
    pub fn begin_step(&mut self) {
        self.stage = 1;
        self.failure = None;
        self.growths.fill((0.0, 0));
    }

    /// The end of the step has become the start of the next one. Is a row so close to the others, and the step so long beside the way to where it would depend on them,
    /// that the stages of the next one must be on the loops?
    pub fn roll(&mut self, smallest: &mut [f64]) -> bool {
        let Self { start, guard, .. } = self;
        start.copy_from_slice(&guard.next);
        let mut close = false;
        for ((smallest, next), late) in smallest.iter_mut().zip(&guard.next).zip(&guard.start) {
            *smallest = f64::min(*smallest, *next);
            // r passes zero like a straight line: so it has changed by this share since the late stage.
            let change = ((late / next).sqrt() - 1.0).abs();
            close |= *next > CLOSE * *smallest && HORIZON * change > 1.0 - LATE_NODE;
        }
        close
    }

    /// The end of a step of length h that follows a curve has become the start of the next one. How long after it would a row depend on the others?
    pub fn follow(&mut self, h: f64) -> f64 {
        let arrival = self.whole().arrival(h);
        self.start.copy_from_slice(&self.guard.next);
        arrival
    }

    /// Does a row change so much in the step that it could have gone over to another branch?
    pub fn jumps(&mut self) -> bool {
        self.whole().jumps()
    }

    /// The smallest r at the end of the step, as a share of that at its start.
    pub fn share(&mut self) -> f64 {
        let Self { start, guard, .. } = self;
        std::mem::swap(start, &mut guard.start);
        let share = guard.share();
        std::mem::swap(start, &mut guard.start);
        share
    }

    /// Distances at both ends of the step.
    fn whole(&mut self) -> &Guard {
        self.guard.start.copy_from_slice(&self.start);
        &self.guard
    }

    /// How long after a step of length h a row would depend on the others, if it came closer as at the end of the step.
    pub fn arrival(&self, h: f64) -> f64 {
        self.guard.arrival((1.0 - LATE_NODE) * h)
    }

    pub fn take_failure(&mut self) -> Option<Failure> {
        self.failure.take()
    }

    /// 1 / r^2 after an evaluation.
    fn note(&mut self, model: &Model, machine: &Machine) {
        let Self { start, guard, growths, stage, .. } = self;
        if *stage >= LOOKS.len() {
            return;
        }
        let rows = &model.program().tapes.closeness;
        if *stage == LATE {
            read(model, machine, &mut guard.start);
        }
        if !LOOKS[*stage] {
            *stage += 1;
            return;
        }
        let mut largest = (0.0, 0);
        for (row, (&register, start)) in rows.iter().zip(start.iter()).enumerate() {
            let growth = machine.registers()[register as usize].abs() / start;
            if growth > largest.0 {
                largest = (growth, row);
            }
        }
        growths[*stage] = largest;
        *stage += 1;
    }

    /// Where in the step, between the late stage and the end, a row may have depended on the others.
    pub fn late_dip(&self) -> Option<f64> {
        let Guard { start: late, next: end } = &self.guard;
        let rows = self.start.iter().zip(late).zip(end);
        let distances =
            |((start, late), end): ((&f64, &f64), &f64)| [start, late, end].map(|value| value.sqrt().recip());
        rows.map(distances).find_map(turned)
    }

    /// The stage at which a row was much closer to the others than at both ends of the step.
    pub fn dip(&self) -> Option<usize> {
        let stages = 1..LATE + 1;
        let deepest = stages.max_by(|&a, &b| self.growths[a].0.total_cmp(&self.growths[b].0))?;
        let (growth, row) = self.growths[deepest];
        let end = self.guard.next[row] / self.start[row];
        (growth > DIP && growth > DIP * end).then_some(deepest)
    }
}

/// The place in the last gap of a step at which a row may have depended on the others, with these distances at its start, at the late stage and at its end:
/// on the way that it went before, it would have arrived there.
fn turned([start, late, end]: [f64; 3]) -> Option<f64> {
    let arrival = LATE_NODE * start / (start - late);
    let place = LATE_NODE + (1.0 - LATE_NODE) * late / (late + end);
    (start > late && arrival < BEYOND).then_some(place)
}

/// (q, v)' at the stages of a step, on the loops if need be.
pub(super) struct Stages<'a> {
    motion: RightHandSide<'a>,
    projection: &'a mut Projection,
    watch: &'a mut Watch,
    /// How well the loops are closed first, if they are.
    tolerance: Option<f64>,
}

impl<'a> Stages<'a> {
    pub fn new(context: &'a mut Context<'_>, origin: &'a State, watch: &'a mut Watch, closed: bool) -> Self {
        let tolerance = closed.then_some(context.settings.tolerance.min(STAGE_TOLERANCE));
        let Context { model, machine, projection, statistics, .. } = context;
        Self { motion: RightHandSide { model, machine, statistics, origin }, projection, watch, tolerance }
    }

    fn close(&mut self, time: f64, y: &[f64], tolerance: f64) -> Result<(), Failure> {
        let RightHandSide { model, machine, origin, .. } = &mut self.motion;
        self.watch.point.copy_from_slice(y);
        let (q, v) = self.watch.point.split_at_mut(model.coordinates());
        machine.load_signals(model, origin, time);
        self.projection.positions(model, machine, q, tolerance, f64::INFINITY)?;
        self.projection.rates(model, machine, v, tolerance)
    }
}

impl Derivative for Stages<'_> {
    fn evaluate(&mut self, time: f64, y: &[f64], derivative: &mut [f64]) {
        match self.tolerance {
            _ if self.watch.failure.is_some() => return derivative.fill(f64::NAN),
            None => self.motion.evaluate(time, y, derivative),
            Some(tolerance) => {
                if let Err(failure) = self.close(time, y, tolerance) {
                    self.watch.failure = Some(failure);
                    return derivative.fill(f64::NAN);
                }
                self.motion.evaluate(time, &self.watch.point, derivative);
            }
        }
        self.watch.note(self.motion.model, self.motion.machine);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances that pass zero like a straight line at a place of the step.
    fn distances(zero: f64) -> [f64; 3] {
        [0.0, LATE_NODE, 1.0].map(|place: f64| (place - zero).abs())
    }

    #[test]
    fn a_pose_in_the_last_gap_of_a_step_is_seen() {
        for zero in [0.86, 0.9, 0.93, 0.98, 0.999] {
            assert!(turned(distances(zero)).is_some_and(|place| (place - zero).abs() < 1e-12), "{zero}");
        }
        // It is still to come, has passed long ago, or is not on the way.
        assert_eq!([1.2, 2.0, 0.4, -1.0].map(distances).map(turned), [None; 4]);
        assert_eq!(turned([1.0, 0.5, 0.6]), None);
    }
}
