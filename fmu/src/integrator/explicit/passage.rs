//! Singular poses on the way of a step of DOP853.
//!
//! A step that passes one is as long as brings the pose into the widest gap between the nodes; its stages are put on the loops, because what they
//! would miss them by is divided by the distance; and what rounding errors add to its error along the direction in which the loops hold least does not
//! count.

use super::dop853::{interpolate, node};
use super::stages::{Stages, Watch};
use super::{Explicit, tolerate};
use crate::context::Context;
use crate::failure::Failure;
use crate::integrator::run::Run;
use crate::singular::closeness::{is_watched, share_at};
use crate::singular::dependence::{begins_near, is_singular, undecided};
use crate::singular::detect::{Course, leapt_over, locate, refine};
use crate::singular::leaving::{CORRECTIONS, Search, Verdict};

/// The gap between the nodes 1/3 and 3/5, in the middle of which the pose is best.
pub(crate) const COURSE: Course =
    Course { take_off: 0.45, passes: 0.4667, landing: 1.0 / 0.4667, nearer: 0.5, missed: 0.07 };
/// So many steps after a pose the stages are still put on the loops.
const BEHIND: f64 = 3.0;
/// So far beyond a step its ends still tell where a singular pose is, in units of the step.
const REACH: f64 = 2.2;
/// The loops are closed this well where a step out of a singular pose begins and ends.
const TIGHT: f64 = 1e-10;

impl Explicit {
    /// Is a singular pose so near to a step that its stages must be on the loops?
    pub(super) fn is_near(run: &Run, end: f64) -> bool {
        let h = (end - run.last.end_time).abs();
        run.singular.closing
            || run.singular.pose.is_some_and(|pose| pose > run.last.end_time - BEHIND * h && pose < end + h)
    }

    /// The error of the step just tried, without what the loops take off it.
    pub(super) fn flattened_error(&mut self, context: &mut Context, run: &Run, end: f64, h: f64) -> f64 {
        let Self { method, next, tolerances, .. } = self;
        let Context { model, machine, projection, .. } = context;
        let n = model.coordinates();
        machine.load_signals(model, &run.signals.origin, end);
        machine.load_positions(model, &next[..n]);
        method.filtered_error(h, tolerances, |error| {
            error.chunks_exact_mut(n).for_each(|part| projection.flatten(model, machine, part));
        })
    }

    /// Looks for singular poses in the step just tried and after it. Says how far after it there is one; none if the step must be taken
    /// again, because it has passed a pose that was not known, or elsewhere, or nowhere.
    pub(super) fn survey(&mut self, context: &mut Context, run: &mut Run, end: f64) -> Option<f64> {
        let h = end - run.last.end_time;
        let expected = if run.passes(end) {
            Some(run.singular.ahead)
        } else {
            self.watch.dip().map(node).or_else(|| self.watch.late_dip()).map(|share| share * h)
        };
        if let Some(guess) = expected {
            self.watch.reference.copy_from_slice(&self.watch.start);
            let found = locate(guess, |dt| self.share_at(context, run, h, dt));
            let found = found.filter(|ahead| (0.0..h).contains(ahead));
            let known = run.passes(end);
            if let Some(ahead) = found {
                let missed = !known || (ahead - run.singular.ahead).abs() > COURSE.missed * h;
                (run.singular.ahead, run.singular.pose) = (ahead, Some(run.last.end_time + ahead));
                if missed {
                    return None;
                }
            } else if known {
                // What was judged as a passage is none.
                (run.singular.ahead, run.singular.pose) = (0.0, None);
                return None;
            }
        }
        let guess = self.watch.arrival(h);
        if guess > REACH * h {
            return Some(0.0);
        }
        self.watch.reference.copy_from_slice(&self.watch.guard.next);
        let found = locate(guess, |dt| self.share_at(context, run, h, h + dt));
        Some(found.filter(|ahead| *ahead > 0.0).unwrap_or(0.0))
    }

    /// Has a step leapt over a pose that nothing had announced, and where branches do not meet? As with series: next to a small defect of lengths a row falls
    /// and rises within one step.
    pub(super) fn has_leapt(&mut self, context: &mut Context, run: &mut Run, end: f64) -> bool {
        let (h, share, known) = (end - run.last.end_time, self.watch.share(), run.singular.ahead);
        self.watch.reference.copy_from_slice(&self.watch.start);
        let tolerance = context.settings.tolerance;
        if let Some(ahead) = leapt_over(h, share, tolerance, |dt| self.share_at(context, run, h, dt)) {
            run.singular.ahead = ahead;
            let pose = refine(ahead, h, |dt| self.share_at(context, run, h, dt));
            self.share_at(context, run, h, pose);
            let time = run.last.end_time + pose;
            if run.finds_avoided(context.model, time, &self.watch.point) {
                return true;
            }
        }
        run.singular.ahead = known;
        false
    }

    /// The smallest distance from a singular pose along the polynomial through the ends of a step, as a share of the reference.
    fn share_at(&mut self, context: &mut Context, run: &Run, h: f64, dt: f64) -> f64 {
        let Self { method, next, watch, .. } = self;
        quintic([&run.last.end, method.first()], [next, method.last()], h, dt, &mut watch.point);
        share_at(context, &run.signals.origin, run.last.end_time + dt, &watch.point, &watch.reference)
    }

    /// Notes that the step of this length passes a singular pose; false if the branches do not meet there.
    pub(super) fn note_passage(&mut self, context: &mut Context, run: &mut Run, h: f64) -> bool {
        self.watch.reference.copy_from_slice(&self.watch.start);
        let ahead = refine(run.singular.ahead, h, |dt| {
            interpolate(&run.last.dense, dt / h, &mut self.watch.point);
            let Watch { point, reference, .. } = &self.watch;
            share_at(context, &run.signals.origin, run.last.end_time + dt, point, reference)
        });
        let time = run.last.end_time + ahead;
        interpolate(&run.last.dense, ahead / h, &mut self.watch.point);
        run.note_passage(context.model, time, &self.watch.point)
    }

    /// Leaves a singular pose in which a run begins. Says whether there was one.
    pub(super) fn leave_at_the_start(&mut self, context: &mut Context, run: &mut Run) -> Result<bool, Failure> {
        let looks = run.taylor.series.is_none() && is_watched(context.model);
        if !looks || !begins_near(context, run) {
            return Ok(false);
        }
        if self.leave(context, run) {
            return Ok(true);
        }
        // Too slow to be left, though not in the pose: it is followed like any other motion.
        if is_singular(context, run) { Err(undecided(context, run)) } else { Ok(false) }
    }

    /// Finds the state a step later from which the motion comes back to the start of the step.
    fn leave(&mut self, context: &mut Context, run: &mut Run) -> bool {
        let (time, pose) = (run.last.end_time, run.pose_here());
        for mut search in Search::all(context, run) {
            if self.shoot(context, run, &mut search, pose) {
                let theta = (pose - run.last.start_time) / (run.last.end_time - run.last.start_time);
                interpolate(&run.last.dense, theta, &mut self.watch.point);
                run.note_left(context.model, [time, pose], &self.watch.point);
                (run.singular.ahead, run.singular.pose) = (0.0, Some(pose));
                run.last.natural = run.last.natural.max(search.h);
                context.statistics.steps += 1;
                self.known = false;
                return true;
            }
        }
        false
    }

    /// Tries to find the state so long after the start of the step, by steps back from it that have the pose in their gap. The step that leads there is then the
    /// last one.
    fn shoot(&mut self, context: &mut Context, run: &mut Run, search: &mut Search, pose: f64) -> bool {
        let (n, h) = (context.model.coordinates(), search.h);
        let end = run.last.end_time + h;
        let back = (end - pose) * COURSE.landing;
        let mut state = run.last.end.clone();
        (0..n).for_each(|index| state[index] += h * state[n + index]);
        let mut reached = state.clone();
        for _ in 0..CORRECTIONS {
            if !self.stretch(context, run, end, -back, &mut state) {
                return false;
            }
            interpolate(&run.last.dense, h / back, &mut reached);
            match search.correct(context.model, &run.last.end, &state, &mut reached) {
                Verdict::Again => std::mem::swap(&mut state, &mut reached),
                Verdict::Failed => return false,
                Verdict::Found => return self.accept_departure(context, run, end, back),
            }
        }
        false
    }

    /// Takes the step that leads to the state found, from where the last step back has ended.
    fn accept_departure(&mut self, context: &mut Context, run: &mut Run, end: f64, h: f64) -> bool {
        let mut state = self.next.clone();
        let there = self.stretch(context, run, end - h, h, &mut state);
        tolerate(context, [&state, &self.next], &mut self.tolerances);
        let straight = self.method.error(h, &self.tolerances);
        if !there || straight.min(self.flattened_error(context, run, end, h)) > 1.0 {
            return false;
        }
        run.last.start_time = end - h;
        // The steps back know only the laws that hold at its end.
        if !self.monitor.is_empty() && self.objection(context, run, [run.last.end_time, end]).is_some() {
            return false;
        }
        run.last.end_time = end;
        run.last.end.copy_from_slice(&self.next);
        true
    }

    /// A step from a state, which is put on the loops first, with its stages on the loops. Its end and dense output are at hand then.
    fn stretch(&mut self, context: &mut Context, run: &mut Run, from: f64, h: f64, state: &mut [f64]) -> bool {
        if !close(context, run, from, state) {
            return false;
        }
        let Self { method, next, watch, .. } = self;
        watch.begin_step();
        let mut f = Stages::new(context, &run.signals.origin, watch, true);
        method.begin(&mut f, from, state);
        method.attempt(&mut f, from, state, h, next);
        if watch.take_failure().is_some() || !close(context, run, from + h, next) {
            return false;
        }
        let mut f = Stages::new(context, &run.signals.origin, watch, true);
        method.finish(&mut f, from + h, next);
        method.dense(&mut f, from, state, h, next, &mut run.last.dense);
        watch.take_failure().is_none() && run.last.dense.iter().chain(&*next).all(|value| value.is_finite())
    }
}

/// Puts a state on the loops, tightly. Says whether that was possible.
fn close(context: &mut Context, run: &Run, time: f64, state: &mut [f64]) -> bool {
    let Context { model, machine, projection, settings, .. } = context;
    let (q, v) = state.split_at_mut(model.coordinates());
    let tolerance = settings.tolerance.min(TIGHT);
    machine.load_signals(model, &run.signals.origin, time);
    projection.positions(model, machine, q, tolerance, f64::INFINITY).is_ok()
        && projection.rates(model, machine, v, tolerance).is_ok()
}

/// (q, v) along the polynomial of degree 5 through two states with their derivatives, h apart, so long after the first one.
fn quintic([y, f]: [&[f64]; 2], [end, slope]: [&[f64]; 2], h: f64, dt: f64, point: &mut [f64]) {
    let (n, x) = (y.len() / 2, dt / h);
    for i in 0..n {
        let (v, a) = (h * y[n + i], 0.5 * h * h * f[n + i]);
        // What is left of position, rate and half the acceleration at the end.
        let p = end[i] - y[i] - v - a;
        let r = h * end[n + i] - v - 2.0 * a;
        let s = 0.5 * h * h * slope[n + i] - a;
        let (c3, c4, c5) = (10.0 * p - 4.0 * r + s, -15.0 * p + 7.0 * r - 2.0 * s, 6.0 * p - 3.0 * r + s);
        point[i] = y[i] + x * (v + x * (a + x * (c3 + x * (c4 + x * c5))));
        point[n + i] = (v + x * (2.0 * a + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / h;
    }
}
