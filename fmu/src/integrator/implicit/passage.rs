//! Singular poses on the way of an implicit step.
//!
//! Between the nodes (4 - sqrt 6)/10 and (4 + sqrt 6)/10 there is room for one: a step is as long as brings the pose into the middle, so that every stage
//! is far from it, whatever the stiffness.

use super::Implicit;
use super::radau::{NODES, evaluate};
use crate::context::Context;
use crate::integrator::run::Run;
use crate::singular::closeness::share_at;
use crate::singular::detect::{Course, locate, refine};

/// The middle of the gap.
const MIDDLE: f64 = 0.4;
pub(super) const COURSE: Course =
    Course { take_off: 0.45, passes: MIDDLE, landing: 1.0 / MIDDLE, nearer: 0.5, missed: 0.08 };
/// So far beyond a step its polynomial tells where a singular pose is, in units of the step.
const REACH: f64 = 3.0;
/// So many steps after a pose rows go away from the others.
const BEHIND: f64 = 3.0;
/// A step that passes a pose may be wrong by so much more than others: there are few of them, and closer to the pose it would be no better.
const PASSING: f64 = 10.0;
/// A pose within so many steps is near.
const NEAR: f64 = 6.0;

/// What a step has to do with singular poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Survey {
    /// The next one is so far after the end of the step; 0 for none.
    Clear(f64),
    /// There is one in the step, so long after its start, that is not known or elsewhere.
    Elsewhere(f64),
    /// The step jumps, but there is no pose where it could be.
    Unsteady,
}

impl Implicit {
    /// Does a time between the last steps lie so close to a pose that nothing may be evaluated there?
    pub(crate) fn is_at_pose(run: &Run, time: f64) -> bool {
        run.in_zone_of(time, run.last.end_time - run.last.start_time)
    }

    /// Is there a singular pose near a step?
    pub(super) fn is_near(run: &Run, end: f64) -> bool {
        run.singular.pose.is_some_and(|pose| (pose - run.last.end_time).abs() < NEAR * (end - run.last.end_time))
    }

    /// What the error of a step near a pose is without what the loops take off it.
    pub(super) fn judge(&mut self, context: &mut Context, run: &Run, end: f64, error: f64) -> f64 {
        if !Self::is_near(run, end) {
            return error;
        }
        let Self { radau, next, tolerances, .. } = self;
        let Context { model, machine, projection, .. } = context;
        let n = model.coordinates();
        radau.end(&run.last.end, next);
        machine.load_signals(model, &run.signals.origin, end);
        machine.load_positions(model, &next[..n]);
        let flat = radau.filtered_error(tolerances, |error| {
            error.chunks_exact_mut(n).for_each(|part| projection.flatten(model, machine, part));
        });
        let left = error.min(flat);
        if run.passes(end) { left / PASSING } else { left }
    }

    /// Looks for singular poses in the step just solved and after it.
    pub(super) fn survey(&mut self, context: &mut Context, run: &Run, end: f64) -> Survey {
        let model = context.model;
        let closeness = &model.program().tapes.closeness;
        if closeness.is_empty() {
            return Survey::Clear(0.0);
        }
        let h = end - run.last.end_time;
        let Self { radau, batched, first, late, ends, polynomial, .. } = self;
        for (row, &register) in closeness.iter().enumerate() {
            let stages = batched.registers()[register as usize].map(f64::abs);
            (first[row], late[row], ends[row]) = (stages[0], stages[1], stages[2]);
        }
        radau.dense(&run.last.end, h, polynomial);
        self.reference.copy_from_slice(&self.start);
        let passes = run.passes(end);
        let steady = passes || self.is_steady(model);
        if passes || !steady {
            let guess = if passes { run.singular.ahead } else { self.nearest(context, run, h) };
            let found = locate(guess, |dt| self.share_at(context, run, dt)).filter(|ahead| (0.0..h).contains(ahead));
            match found {
                Some(ahead) if !passes || (ahead / h - MIDDLE).abs() > COURSE.missed => {
                    return Survey::Elsewhere(ahead);
                }
                None if passes => return Survey::Elsewhere(0.0),
                _ => {}
            }
        }
        let guess = arrival(&self.late, &self.ends) * (1.0 - NODES[1]) * h;
        self.reference.copy_from_slice(&self.ends);
        let found = if guess < REACH * h { locate(guess, |dt| self.share_at(context, run, h + dt)) } else { None };
        match found.filter(|ahead| *ahead > 0.0) {
            Some(ahead) => Survey::Clear(ahead),
            None if steady || is_behind(run, h) => Survey::Clear(0.0),
            None => Survey::Unsteady,
        }
    }

    /// Where in the step just solved a row is closest to the others, if it is between the nodes that it passes zero.
    fn nearest(&mut self, context: &mut Context, run: &Run, h: f64) -> f64 {
        let mut best = (f64::INFINITY, 0.0);
        let [c1, c2, _] = NODES;
        for row in 0..self.start.len() {
            let [start, first, late, end] =
                [self.start[row], self.first[row], self.late[row], self.ends[row]].map(|value| value.sqrt().recip());
            for (from, to, r, next) in [(0.0, c1, start, first), (c1, c2, first, late), (c2, 1.0, late, end)] {
                let place = h * (from + (to - from) * r / (r + next));
                let share = self.share_at(context, run, place);
                if share < best.0 {
                    best = (share, place);
                }
            }
        }
        best.1
    }

    /// The smallest distance from a singular pose along the polynomial of the step just solved, as a share of the reference.
    fn share_at(&mut self, context: &mut Context, run: &Run, dt: f64) -> f64 {
        let Self { polynomial, point, reference, .. } = self;
        evaluate(polynomial, dt, point);
        share_at(context, &run.signals.origin, run.last.end_time + dt, point, reference)
    }

    /// Notes that the step just solved passes a singular pose; false if the branches do not meet there.
    pub(super) fn note_passage(&mut self, context: &mut Context, run: &mut Run, end: f64) -> bool {
        let h = end - run.last.end_time;
        self.reference.copy_from_slice(&self.start);
        let ahead = refine(run.singular.ahead, h, |dt| self.share_at(context, run, dt));
        evaluate(&self.polynomial, ahead, &mut self.point);
        run.note_passage(context.model, run.last.end_time + ahead, &self.point)
    }
}

/// Is the pose that the last steps have passed so little behind the start of the step that rows go away from the others in a step of this length?
fn is_behind(run: &Run, h: f64) -> bool {
    run.singular.pose.is_some_and(|pose| pose < run.last.end_time && pose > run.last.end_time - BEHIND * h)
}

/// When a row would depend on the others if it came closer as between the last stages, in units of their distance.
fn arrival(late: &[f64], ends: &[f64]) -> f64 {
    let squares = late.iter().zip(ends).map(|(late, end)| late / end);
    let share = squares.fold(f64::INFINITY, f64::min).sqrt();
    if share < 1.0 { share / (1.0 - share) } else { f64::INFINITY }
}
