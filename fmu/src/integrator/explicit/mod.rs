//! Integration of Eqs. (22): steps of DOP853, each projected onto the loop equations.

pub(super) mod dop853;
mod passage;
mod stages;

use super::right_hand_side::RightHandSide;
use super::run::Run;
use crate::constraints::accelerations::finite;
use crate::context::Context;
use crate::events::{Monitor, Objection, Span};
use crate::failure::Failure;
use crate::integrator::control::{Attempt, Integrator, Progress, Trial, because, reach, shortest};
use crate::math;
use crate::model::Model;
use crate::singular::closeness::{is_watched, read};
use crate::singular::detect::Course;
use dop853::{Dop853, interpolate, next_step, slope};
pub(crate) use passage::COURSE;
use stages::{Stages, Watch};

/// Share of the tolerance that one step may use: what the user sees is the sum of the errors of many steps.
const SHARE_OF_TOLERANCE: f64 = 0.01;
/// Rounding is larger than an error below this.
const FINEST: f64 = 1e-14;
/// Near a singular pose the loops are closed this well.
const TIGHT: f64 = 1e-10;
/// The error of a step near a singular pose, but not across it, is rounding only if it is less than this.
const ROUGH: f64 = 1e6;
/// Across a singular pose only rounding errors are left if an error, in units of what one step may be wrong by, is less than this, and this share of what it
/// is together with the part that the loops take off.
const NOISE: f64 = 1e3;
const NOISE_SHARE: f64 = 1e-4;
/// What the rates would change by in a step with the accelerations that its dense output lacks somewhere, in units of what one step may be wrong by:
/// more, and they are those of a law that no stage has seen.
const OVERLOOKED: f64 = 1e3;

/// Storage for dynamic motion.
#[derive(Clone, Debug)]
pub struct Explicit {
    method: Dop853,
    next: Vec<f64>,
    tolerances: Vec<f64>,
    /// Is the derivative where the step begins known?
    known: bool,
    watch: Watch,
    monitor: Monitor,
}

impl Integrator for Explicit {
    const COURSE: Course = COURSE;

    fn begin(&mut self, context: &mut Context, run: &mut Run) -> Result<Option<Progress>, Failure> {
        if self.leave_at_the_start(context, run)? {
            return Ok(Some(Progress::Stepped));
        }
        let time = run.last.end_time;
        if !self.known {
            self.method.begin(&mut RightHandSide::new(context, &run.signals.origin), time, &run.last.end);
            self.known = true;
            read(context.model, context.machine, &mut self.watch.start);
        }
        let n = context.model.coordinates();
        finite(context.model, time, &self.method.first()[n..]).map_err(|failure| because(context, run, failure))?;
        if run.last.natural == 0.0 {
            tolerate(context, [&run.last.end, &run.last.end], &mut self.tolerances);
            let mut f = RightHandSide::new(context, &run.signals.origin);
            run.last.natural = self.method.starting_step(&mut f, time, &run.last.end, &self.tolerances);
        }
        Ok(None)
    }

    fn attempt(&mut self, context: &mut Context, run: &mut Run, attempt: &Attempt) -> Trial {
        let (end, h) = (attempt.end, attempt.end - run.last.end_time);
        let near = Self::is_near(run, end);
        let (error, ahead) = match self.solve(context, run, end, near).and_then(|error| {
            let ahead = self.supervise(context, run, attempt, near)?;
            Ok((error, ahead))
        }) {
            Ok(judged) => judged,
            Err(Unfit::Error(error, cause)) => {
                return Trial::Rejected { shorter: next_step(h, error, true).min(0.5 * h), cause };
            }
            Err(Unfit::Objection(objection)) => return Trial::objected(context.model, run.last.end_time, objection),
            Err(Unfit::Pose) => return Trial::Replanned,
        };
        let proposed = next_step(h, error, attempt.rejected);
        self.accept(run, end, ahead);
        Trial::Accepted {
            next: if attempt.is_cut() && !attempt.rejected { proposed.max(attempt.natural) } else { proposed },
        }
    }

    fn lose_pose(&mut self, _: &mut Context, run: &mut Run) -> Progress {
        (run.singular.ahead, run.singular.pose) = (0.0, None);
        Progress::Stepped
    }

    fn first(&self) -> &[f64] {
        self.method.first()
    }
}

/// Why a step is not accepted.
enum Unfit {
    /// Its error, in units of the tolerance, and what is behind it.
    Error(f64, Option<Failure>),
    /// A singular pose was not where it was expected.
    Pose,
    /// What its laws do.
    Objection(Objection),
}

impl Explicit {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let size = 2 * model.coordinates();
        let (method, watch, monitor) = (Dop853::new(size), Watch::new(model), Monitor::new(model));
        Self { method, next: vec![0.0; size], tolerances: vec![0.0; size], known: false, watch, monitor }
    }

    /// Numbers in the dense output of a step.
    pub fn dense_length(model: &Model) -> usize {
        Dop853::dense_length(2 * model.coordinates())
    }

    /// To be called when the next step does not begin where this method left the last one.
    pub fn forget(&mut self) {
        self.known = false;
    }

    /// (q, v) at the target, from the end of the last step or from the dense output; says whether it was interpolated.
    pub fn read(&self, run: &Run, target: f64, motion: &mut [f64]) -> bool {
        if run.last.end_time == target {
            motion.copy_from_slice(&run.last.end);
            return false;
        }
        let theta = (target - run.last.start_time) / (run.last.end_time - run.last.start_time);
        interpolate(&run.last.dense, theta, motion);
        // Where the loops hold less a projection would take the motion off its branch.
        !run.in_zone_of(target, run.last.end_time - run.last.start_time)
    }

    /// The stages, the error and the end of a step, on the loops; returns the error in units of the tolerance.
    fn solve(&mut self, context: &mut Context, run: &Run, end: f64, near: bool) -> Result<f64, Unfit> {
        self.try_stages(context, run, end, near).map_err(|failure| Unfit::Error(f64::NAN, Some(failure)))?;
        let error = self.judge(context, run, end, near);
        // Written so that NaN is rejected too.
        let small = error <= 1.0;
        if !small {
            return Err(Unfit::Error(error, None));
        }
        self.close(context, run, end, near).map_err(|failure| Unfit::Error(error, Some(failure)))?;
        self.method.finish(&mut RightHandSide::new(context, &run.signals.origin), end, &self.next);
        let finite = self.method.last().iter().all(|value| value.is_finite());
        if finite { Ok(error) } else { Err(Unfit::Error(f64::NAN, None)) }
    }

    /// Looks at a step that has been solved for singular poses and laws that it has not seen; returns how far after it the next pose is, 0 for none.
    fn supervise(&mut self, context: &mut Context, run: &mut Run, attempt: &Attempt, near: bool) -> Result<f64, Unfit> {
        let (end, unfit) = (attempt.end, Err(Unfit::Error(f64::NAN, None)));
        let mut ahead = 0.0;
        if is_watched(context.model) {
            read(context.model, context.machine, &mut self.watch.guard.next);
            if run.following().is_none() {
                ahead = self.survey(context, run, end).ok_or(Unfit::Pose)?;
                if !run.passes(end) && self.has_leapt(context, run, end) {
                    return Err(Unfit::Pose);
                }
            } else if self.watch.jumps() {
                return unfit;
            }
        }
        let passes = run.passes(end);
        let monitored = !self.monitor.is_empty() && end - run.last.end_time > 2.0 * shortest(end);
        if (end > attempt.target || passes || monitored) && !self.interpolate(context, run, end, near) {
            return unfit;
        }
        if monitored && let Some(objection) = self.objection(context, run, [run.last.end_time, end]) {
            return Err(Unfit::Objection(objection));
        }
        if passes && !self.note_passage(context, run, end - run.last.end_time) {
            return Err(Unfit::Pose);
        }
        Ok(ahead)
    }

    /// The stages of a step.
    fn try_stages(&mut self, context: &mut Context, run: &Run, end: f64, near: bool) -> Result<(), Failure> {
        let (time, h) = (run.last.end_time, end - run.last.end_time);
        let Self { method, watch, next, .. } = self;
        if is_watched(context.model) {
            watch.begin_step();
            method.attempt(&mut Stages::new(context, &run.signals.origin, watch, near), time, &run.last.end, h, next);
        } else {
            method.attempt(&mut RightHandSide::new(context, &run.signals.origin), time, &run.last.end, h, next);
        }
        watch.take_failure().map_or(Ok(()), Err)
    }

    /// The error of the step just tried, in units of the tolerance.
    fn judge(&mut self, context: &mut Context, run: &Run, end: f64, near: bool) -> f64 {
        let h = end - run.last.end_time;
        tolerate(context, [&run.last.end, &self.next], &mut self.tolerances);
        let error = self.method.error(h, &self.tolerances);
        let passes = run.passes(end);
        if near && error > 1.0 && (passes || error < ROUGH) {
            let flat = self.flattened_error(context, run, end, h);
            let noise = passes && flat <= NOISE && flat <= NOISE_SHARE * error;
            return if noise { flat.min(1.0) } else { error.min(flat) };
        }
        error
    }

    /// The dense output of the step just tried; false if it is not finite.
    fn interpolate(&mut self, context: &mut Context, run: &mut Run, end: f64, near: bool) -> bool {
        let (time, h) = (run.last.end_time, end - run.last.end_time);
        let Self { method, watch, next, .. } = self;
        if near {
            let mut f = Stages::new(context, &run.signals.origin, watch, true);
            method.dense(&mut f, time, &run.last.end, h, next, &mut run.last.dense);
        } else {
            method.dense(
                &mut RightHandSide::new(context, &run.signals.origin),
                time,
                &run.last.end,
                h,
                next,
                &mut run.last.dense,
            );
        }
        run.last.start_time = time;
        run.last.dense.iter().all(|value| value.is_finite())
    }

    /// What the laws have against the motion between these times, the last of which is the end of the step just tried: they are steep where the dense output does not
    /// accelerate as the equations demand, or push to and fro.
    fn objection(&mut self, context: &mut Context, run: &Run, [time, end]: [f64; 2]) -> Option<Objection> {
        let (step, h) = (end - run.last.start_time, end - time);
        let (first, part) = ((time - run.last.start_time) / step, h / step);
        let Context { model, machine, statistics, settings, .. } = context;
        let motion = |place: f64, motion: &mut [f64]| interpolate(&run.last.dense, first + part * place, motion);
        let mut span = Span {
            model,
            machine,
            origin: &run.signals.origin,
            time,
            h,
            shortest: shortest(end),
            tolerance: settings.tolerance,
            motion,
        };
        let (n, tolerances) = (model.coordinates(), &self.tolerances);
        let excess = |_: bool, place: f64, accelerations: &[f64]| {
            statistics.evaluations += 1;
            accelerations.iter().enumerate().fold(0.0, |worst, (index, acceleration)| {
                let lack = step * acceleration - slope(&run.last.dense, first + part * place, 2 * n, n + index);
                math::maximum(worst, lack.abs() / (OVERLOOKED * tolerances[n + index]))
            })
        };
        self.monitor.objection(&mut span, SHARE_OF_TOLERANCE * settings.tolerance, false, excess)
    }

    /// Projects the end of the step onto the loop equations.
    fn close(&mut self, context: &mut Context, run: &Run, end: f64, near: bool) -> Result<(), Failure> {
        if context.model.active().is_empty() {
            return Ok(());
        }
        let Context { model, machine, projection, settings, .. } = context;
        let (q, v) = self.next.split_at_mut(model.coordinates());
        machine.load_signals(model, &run.signals.origin, end);
        let [tolerance, reach] =
            if near { [settings.tolerance.min(TIGHT), f64::INFINITY] } else { [settings.tolerance, reach(settings)] };
        projection.positions(model, machine, q, tolerance, reach)?;
        projection.rates(model, machine, v, tolerance)
    }

    fn accept(&mut self, run: &mut Run, end: f64, ahead: f64) {
        self.method.roll();
        match run.following() {
            Some(_) => run.singular.follow_on(self.watch.follow(end - run.last.end_time)),
            None => run.singular.closing = self.watch.roll(&mut run.singular.smallest),
        }
        run.singular.expect(end, ahead);
        run.taylor.series = Some(false);
        run.last.end_time = end;
        run.last.end.copy_from_slice(&self.next);
    }
}

/// Absolute tolerances of q and v, by both ends of a step. Rates count relative to themselves, but not below the least that do.
pub(super) fn tolerate(context: &Context, [start, next]: [&[f64]; 2], tolerances: &mut [f64]) {
    let n = context.model.coordinates();
    let tolerance = (SHARE_OF_TOLERANCE * context.settings.tolerance).max(FINEST);
    let least = context.settings.least_rate;
    for (index, coordinate) in context.model.program().coordinates.iter().enumerate() {
        let rate = start[n + index].abs().max(next[n + index].abs());
        tolerances[index] = tolerance * coordinate.scale;
        tolerances[n + index] = tolerance * (least * coordinate.scale).max(rate);
    }
}
