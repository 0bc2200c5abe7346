//! Integration of Eqs. (22): steps of DOP853, each projected onto the loop equations.
//!
//! Singular poses are not passed: a step in which a loop equation comes much closer to the others is taken again with half the length, and next to a pose none
//! is taken at all.

mod dop853;

use super::right_hand_side::RightHandSide;
use crate::context::{Context, Settings};
use crate::events::{Monitor, Objection, Span};
use crate::failure::Failure;
use crate::integrator::accelerations::finite;
use crate::integrator::control::{Attempt, Integrator, Trial, because, reach, rejected, shortest};
use crate::integrator::range::{Range, Ranged};
use crate::linalg::ROUNDING_OF_SUMS;
use crate::math;
use crate::model::Model;
use crate::motion::Run;
use dop853::{Dop853, interpolate, next_step, slope};

/// Share of the tolerance that one step may use: what the user sees is the sum of the errors of many steps.
const EXPLICIT_TOLERANCE: f64 = 0.01;
/// What the rates would change by in a step with the accelerations that its dense output lacks somewhere, in units of what one step may be wrong by:
/// more, and they are those of a law that no stage has seen.
const EXPLICIT_OVERLOOKED: f64 = 1e3;

/// Storage for dynamic motion.
#[derive(Clone, Debug)]
pub struct Explicit {
    method: Dop853,
    next: Vec<f64>,
    tolerances: Vec<f64>,
    /// Is the derivative where the step begins known?
    known: bool,
    /// How close loop equations come to the others.
    range: Range,
    monitor: Monitor,
}

impl Integrator for Explicit {
    fn begin(&mut self, context: &mut Context, run: &mut Run) -> Result<(), Failure> {
        let time = run.last.end_time;
        if !self.known {
            self.method.begin(&mut RightHandSide::new(context, &run.signals.origin), time, &run.last.end);
            self.known = true;
            self.range.begin(context.model, context.machine);
        }
        let n = context.model.coordinates();
        finite(context.model, time, &self.method.first()[n..]).map_err(|failure| because(context, run, failure))?;
        if run.last.natural == 0.0 {
            tolerate(context, [&run.last.end, &run.last.end], &mut self.tolerances);
            let mut f = RightHandSide::new(context, &run.signals.origin);
            run.last.natural = self.method.starting_step(&mut f, time, &run.last.end, &self.tolerances);
        }
        Ok(())
    }

    fn try_step(&mut self, context: &mut Context, run: &mut Run, attempt: &mut Attempt) -> Trial {
        let (end, h) = (attempt.end, attempt.end - run.last.end_time);
        let shorter = |error: f64| next_step(h, error, true).min(0.5 * h);
        let error = match self.solve(context, run, end) {
            Ok(error) => error,
            Err((error, cause)) => return rejected(context, shorter(error), cause),
        };
        if !self.range.is_steady() {
            return attempt.unsteady::<Self>(context, run);
        }
        let monitored = !self.monitor.is_empty() && h > 2.0 * shortest(end);
        if (attempt.passes_target() || monitored) && !self.interpolate(context, run, end) {
            return rejected(context, shorter(f64::NAN), None);
        }
        if monitored && let Some(objection) = self.objection(context, run, end) {
            return attempt.objected(context, run, objection);
        }
        let proposed = next_step(h, error, attempt.rejected);
        self.accept(context.model, run, end);
        attempt.accepted(context, run, proposed)
    }

    fn first(&self) -> &[f64] {
        self.method.first()
    }

    fn range(&self) -> &Range {
        &self.range
    }

    fn cross_jump(&mut self) {
        self.known = false;
    }

    fn yields(_: &Settings) -> bool {
        false
    }
}

impl Explicit {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let size = 2 * model.coordinates();
        Self {
            method: Dop853::new(size),
            next: vec![0.0; size],
            tolerances: vec![0.0; size],
            known: false,
            range: Range::new(model),
            monitor: Monitor::new(model),
        }
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
        true
    }

    /// The stages, the error and the end of a step, on the loops; returns the error in units of the tolerance, or why the step is not accepted.
    fn solve(&mut self, context: &mut Context, run: &Run, end: f64) -> Result<f64, (f64, Option<Failure>)> {
        let (time, h) = (run.last.end_time, end - run.last.end_time);
        let Self { method, range, next, .. } = self;
        range.restart();
        let mut f = Ranged::new(RightHandSide::new(context, &run.signals.origin), range);
        method.attempt(&mut f, time, &run.last.end, h, next);
        tolerate(context, [&run.last.end, &self.next], &mut self.tolerances);
        let error = self.method.error(h, &self.tolerances);
        // Written so that NaN is rejected too.
        let small = error <= 1.0;
        if !small {
            return Err((error, None));
        }
        self.close(context, run, end).map_err(|failure| (error, Some(failure)))?;
        let Self { method, range, next, .. } = self;
        method.finish(&mut Ranged::new(RightHandSide::new(context, &run.signals.origin), range), end, next);
        let finite = self.method.last().iter().all(|value| value.is_finite());
        if finite { Ok(error) } else { Err((f64::NAN, None)) }
    }

    /// The dense output of the step just tried; false if it is not finite.
    fn interpolate(&mut self, context: &mut Context, run: &mut Run, end: f64) -> bool {
        let (time, h) = (run.last.end_time, end - run.last.end_time);
        let mut f = RightHandSide::new(context, &run.signals.origin);
        self.method.dense(&mut f, time, &run.last.end, h, &self.next, &mut run.last.dense);
        run.last.start_time = time;
        run.last.dense.iter().all(|value| value.is_finite())
    }

    /// What the laws have against the step just tried: they are steep where the dense output does not accelerate as the equations demand, or push to and fro.
    fn objection(&mut self, context: &mut Context, run: &Run, end: f64) -> Option<Objection> {
        let (time, h) = (run.last.end_time, end - run.last.end_time);
        let Context { model, machine, statistics, settings, .. } = context;
        let motion = |place: f64, motion: &mut [f64]| interpolate(&run.last.dense, place, motion);
        let mut span = Span {
            model,
            machine,
            origin: &run.signals.origin,
            time,
            h,
            shortest: shortest(end),
            tolerance: settings.tolerance,
            motion,
            places: 0,
        };
        let (n, tolerances) = (model.coordinates(), &self.tolerances);
        let excess = |_: bool, place: f64, accelerations: &[f64]| {
            statistics.evaluations += 1;
            accelerations.iter().enumerate().fold(0.0, |worst, (index, acceleration)| {
                let residual = h * acceleration - slope(&run.last.dense, place, 2 * n, n + index);
                math::maximum(worst, residual.abs() / (EXPLICIT_OVERLOOKED * tolerances[n + index]))
            })
        };
        let objection = self.monitor.objection(&mut span, EXPLICIT_TOLERANCE * settings.tolerance, false, excess);
        statistics.work += span.work();
        objection
    }

    /// Projects the end of the step onto the loop equations.
    fn close(&mut self, context: &mut Context, run: &Run, end: f64) -> Result<(), Failure> {
        if context.model.active().is_empty() {
            return Ok(());
        }
        let Context { model, machine, projection, settings, .. } = context;
        let (q, v) = self.next.split_at_mut(model.coordinates());
        machine.load_signals(model, &run.signals.origin, end);
        projection.positions(model, machine, q, settings.tolerance, reach(settings))?;
        projection.rates(model, machine, v, settings.tolerance)
    }

    fn accept(&mut self, model: &Model, run: &mut Run, end: f64) {
        self.method.roll();
        self.range.roll();
        run.singular.step_without_poses(run.last.end_time);
        run.last.end_time = end;
        model.forget_integrals(&mut self.next);
        run.last.end.copy_from_slice(&self.next);
    }
}

/// Absolute tolerances of q and v, by both ends of a step. Rates count relative to themselves, but not below the least that do.
fn tolerate(context: &Context, [start, next]: [&[f64]; 2], tolerances: &mut [f64]) {
    let n = context.model.coordinates();
    let tolerance = (EXPLICIT_TOLERANCE * context.settings.tolerance).max(ROUNDING_OF_SUMS);
    let least = context.settings.least_rate;
    for (index, coordinate) in context.model.program().coordinates.iter().enumerate() {
        let rate = start[n + index].abs().max(next[n + index].abs());
        tolerances[index] = tolerance * coordinate.scale;
        tolerances[n + index] = tolerance * (least * coordinate.scale).max(rate);
    }
}
