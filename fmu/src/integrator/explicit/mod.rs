//! Integration of Eqs. (22): steps of DOP853, each projected onto the loop equations.

mod dop853;
mod passage;
mod stages;

use super::right_hand_side::RightHandSide;
use super::run::Run;
use crate::constraints::accelerations::finite;
use crate::context::Context;
use crate::events::{Monitor, Overlooked, Span};
use crate::failure::Failure;
use crate::integrator::control::{Horizon, LONGEST, STRETCH, shortest, underflow, within};
use crate::math;
use crate::model::Model;
use crate::singular::closeness::is_watched;
use crate::singular::dependence::end_of_reach;
use crate::singular::supervisor::ZONE;
use dop853::{Dop853, interpolate, next_step, slope};
pub(crate) use passage::COURSE;
use stages::{Stages, Watch};

/// Share of the tolerance that one step may use: what the user sees is the sum of the errors of many steps.
const SHARE_OF_TOLERANCE: f64 = 0.01;
/// Rounding is larger than an error below this.
const FINEST: f64 = 1e-14;
/// Near a singular pose the loops are closed this well.
const TIGHT: f64 = 1e-10;
/// So often a step is taken again because of a singular pose before it is made shorter.
const REPLANS: u32 = 4;
/// The error of a step near a singular pose, but not across it, is rounding only if it is less than this.
const ROUGH: f64 = 1e6;
/// Across a singular pose only rounding errors are left if an error, in units of what one step may be wrong by, is less than this, and this share of what it
/// is together with the part that the loops take off.
const NOISE: f64 = 1e3;
const NOISE_SHARE: f64 = 1e-4;
/// What the rates would change by in a step with the accelerations that its dense output lacks somewhere, in units of what one step may be wrong by:
/// more, and they are those of a law that no stage has seen.
const OVERLOOKED: f64 = 1e4;

/// Storage for dynamic motion.
#[derive(Clone, Debug)]
pub struct Explicit {
    method: Dop853,
    next: Vec<f64>,
    tolerances: Vec<f64>,
    /// Is the derivative at the front known?
    known: bool,
    watch: Watch,
    monitor: Monitor,
}

/// What came of a trial.
enum Trial {
    /// With that error, in units of the tolerance, and a singular pose so far after the end (0 for none).
    Accepted {
        error: f64,
        ahead: f64,
    },
    Rejected {
        error: f64,
        failure: Option<Failure>,
    },
    /// A singular pose was not where it was expected.
    Replanned,
    /// A law is steep somewhere within the step.
    Overlooked(Overlooked),
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

    /// To be called when the front is not the one that the last step left.
    pub fn forget(&mut self) {
        self.known = false;
    }

    /// Takes one step.
    pub fn advance(&mut self, context: &mut Context, run: &mut Run, horizon: Horizon) -> Result<(), Failure> {
        if self.leave_at_the_start(context, run)? {
            return Ok(());
        }
        self.begin(context, run)?;
        self.step(context, run, horizon)
    }

    /// (q, v) at the target, from the front or from the dense output; says whether it was interpolated.
    pub fn read(&self, run: &Run, target: f64, motion: &mut [f64]) -> bool {
        if run.last.end_time == target {
            motion.copy_from_slice(&run.last.end);
            return false;
        }
        let theta = (target - run.last.start_time) / (run.last.end_time - run.last.start_time);
        interpolate(&run.last.dense, theta, motion);
        // Where the loops hold less a projection would take the motion off its branch.
        let zone = ZONE * (run.last.end_time - run.last.start_time);
        run.singular.pose.is_none_or(|pose| (pose - target).abs() > zone)
    }

    /// The derivative at the front, and a first step size if there is none.
    fn begin(&mut self, context: &mut Context, run: &mut Run) -> Result<(), Failure> {
        let time = run.last.end_time;
        if !self.known {
            self.method.begin(&mut RightHandSide::new(context, &run.signals.origin), time, &run.last.end);
            self.known = true;
            self.look_around(context);
        }
        let n = context.model.coordinates();
        finite(context.model, time, &self.method.first()[n..])?;
        if run.last.natural == 0.0 {
            self.tolerate(context, &run.last.end, false);
            let mut f = RightHandSide::new(context, &run.signals.origin);
            run.last.natural = self.method.starting_step(&mut f, time, &run.last.end, &self.tolerances);
        }
        Ok(())
    }

    /// One accepted step from the front.
    fn step(&mut self, context: &mut Context, run: &mut Run, horizon: Horizon) -> Result<(), Failure> {
        let time = run.last.end_time;
        let shortest = shortest(time);
        // No step ends in the zone of a singular pose, whoever asks for it: the dense output serves what lies there.
        let limit = if run.in_zone(horizon.limit) { f64::INFINITY } else { horizon.limit };
        let (mut rejected, mut replans) = (false, 0);
        let mut following = f64::INFINITY;
        loop {
            let longest = run.following().unwrap_or(LONGEST).min(context.settings.max_step);
            let natural = within(run.last.natural, shortest, longest);
            let planned = COURSE.planned(run.singular.ahead, natural).max(shortest);
            // A step that ends before a law gets steep is not stretched into it.
            let stretch = if following.is_finite() { 1.0 } else { STRETCH };
            let limited = time + stretch * planned >= limit && Self::may_end(run, limit);
            let end = if limited { limit } else { time + planned };
            let h = end - time;
            match self.attempt(context, run, end, horizon.target) {
                Trial::Accepted { error, ahead } => {
                    let proposed = next_step(h, error, rejected);
                    // A step cut short says nothing against the natural length.
                    let cut = limited || planned < natural;
                    run.last.natural = if cut && !rejected { proposed.max(natural) } else { proposed };
                    run.last.natural = run.last.natural.min(following);
                    self.accept(run, end, ahead);
                    context.statistics.steps += 1;
                    return Ok(());
                }
                Trial::Rejected { error, failure } => {
                    rejected = true;
                    run.last.natural = next_step(h, error, true).min(0.5 * h);
                    if run.last.natural < shortest {
                        return Err(end_of_reach(context, run)
                            .unwrap_or_else(|| underflow(context.model, time, self.method.first(), failure)));
                    }
                }
                Trial::Overlooked(Overlooked { begin, place }) => {
                    rejected = true;
                    (run.last.natural, following) = ((begin * h).max(shortest), (place - begin) * h);
                }
                Trial::Replanned if replans < REPLANS => replans += 1,
                Trial::Replanned => {
                    (rejected, replans) = (true, 0);
                    (run.last.natural, run.singular.ahead, run.singular.pose) = ((0.5 * h).max(shortest), 0.0, None);
                }
            }
            context.statistics.rejected += 1;
        }
    }

    /// Tries a step to `end`.
    fn attempt(&mut self, context: &mut Context, run: &mut Run, end: f64, target: f64) -> Trial {
        let near = Self::is_near(run, end);
        if let Err(failure) = self.try_stages(context, run, end, near) {
            return Trial::Rejected { error: f64::NAN, failure: Some(failure) };
        }
        let error = self.judge(context, run, end, near);
        // Written so that NaN is rejected too.
        let small = error <= 1.0;
        if !small {
            return Trial::Rejected { error, failure: None };
        }
        if let Err(failure) = self.close(context, run, end, near) {
            return Trial::Rejected { error, failure: Some(failure) };
        }
        self.method.finish(&mut RightHandSide::new(context, &run.signals.origin), end, &self.next);
        let unfit = Trial::Rejected { error: f64::NAN, failure: None };
        if !self.method.last().iter().all(|value| value.is_finite()) {
            return unfit;
        }
        let mut ahead = 0.0;
        if is_watched(context.model) {
            self.look_ahead(context);
            if run.following().is_none() {
                let Some(found) = self.survey(context, run, end) else { return Trial::Replanned };
                ahead = found;
            } else if self.watch.jumps() {
                return unfit;
            }
        }
        let passes = run.passes(end);
        let monitored = !self.monitor.is_empty() && end - run.last.end_time > 2.0 * shortest(end);
        if (end > target || passes || monitored) && !self.interpolate(context, run, end, near) {
            return unfit;
        }
        if monitored && let Some(overlooked) = self.overlooked(context, run, end) {
            return Trial::Overlooked(overlooked);
        }
        if passes && !self.note_passage(context, run, end - run.last.end_time) {
            return Trial::Replanned;
        }
        Trial::Accepted { error, ahead }
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
        self.tolerate(context, &run.last.end, true);
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

    /// A law that is steep within the step just tried, where the dense output does not accelerate as the equations demand.
    fn overlooked(&mut self, context: &mut Context, run: &Run, end: f64) -> Option<Overlooked> {
        let (time, h) = (run.last.end_time, end - run.last.end_time);
        let Context { model, machine, statistics, settings, .. } = context;
        let motion = |place: f64, motion: &mut [f64]| interpolate(&run.last.dense, place, motion);
        let mut span = Span { model, machine, origin: &run.signals.origin, time, h, motion };
        let (n, tolerances) = (model.coordinates(), &self.tolerances);
        let excess = |place: f64, accelerations: &[f64]| {
            statistics.evaluations += 1;
            accelerations.iter().enumerate().fold(0.0, |worst, (index, acceleration)| {
                let lack = h * acceleration - slope(&run.last.dense, place, 2 * n, n + index);
                math::maximum(worst, lack.abs() / (OVERLOOKED * tolerances[n + index]))
            })
        };
        self.monitor.overlooked(&mut span, SHARE_OF_TOLERANCE * settings.tolerance, excess)
    }

    /// Projects the end of the step onto the loop equations.
    fn close(&mut self, context: &mut Context, run: &Run, end: f64, near: bool) -> Result<(), Failure> {
        if context.model.active().is_empty() {
            return Ok(());
        }
        let Context { model, machine, projection, settings, .. } = context;
        let (q, v) = self.next.split_at_mut(model.coordinates());
        machine.load_signals(model, &run.signals.origin, end);
        let tolerance = if near { settings.tolerance.min(TIGHT) } else { settings.tolerance };
        projection.positions(model, machine, q, tolerance, f64::INFINITY)?;
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

    /// Absolute tolerances of q and v. Rates count relative to themselves, but not below one scale a second.
    fn tolerate(&mut self, context: &Context, front: &[f64], next: bool) {
        let n = context.model.coordinates();
        let tolerance = (SHARE_OF_TOLERANCE * context.settings.tolerance).max(FINEST);
        for (index, coordinate) in context.model.program().coordinates.iter().enumerate() {
            let after = if next { self.next[n + index].abs() } else { 0.0 };
            let rate = front[n + index].abs().max(after);
            self.tolerances[index] = tolerance * coordinate.scale;
            self.tolerances[n + index] = tolerance * coordinate.scale.max(rate);
        }
    }
}
