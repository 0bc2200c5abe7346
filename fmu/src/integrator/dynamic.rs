//! Integration of Eqs. (22): steps of DOP853, each projected onto the loop equations.

mod passage;
mod watch;

use super::continuation::{Continuation, ZONE};
use super::explicit::{Derivative, Explicit, interpolate, next_step, slope};
use crate::constraints::accelerations::finite;
use crate::context::{Context, Statistics};
use crate::events::{Monitor, Overlooked, Span};
use crate::failure::Failure;
use crate::integrator::control::{LONGEST, STRETCH, shortest, within};
use crate::machine::Machine;
use crate::math;
use crate::model::{Model, State};
use crate::singular::dependence::end_of_reach;
use crate::singular::detect::{Plan, plan};
pub(crate) use passage::COURSE;
use watch::{Stages, Watch};

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
/// Most attempts at steps between two communication points.
pub(crate) const MOST_STEPS: u64 = 10_000_000;

/// Storage for dynamic motion.
#[derive(Clone, Debug)]
pub struct Dynamic {
    explicit: Explicit,
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

/// How far steps may go.
#[derive(Clone, Copy, Debug)]
pub struct Horizon {
    /// The communication point that is wanted.
    pub target: f64,
    /// Nothing is evaluated after this time.
    pub limit: f64,
}

/// (q, v)' with the signals continued from `origin`.
pub(crate) struct Motion<'a> {
    pub model: &'a Model,
    pub machine: &'a mut Machine,
    pub statistics: &'a mut Statistics,
    pub origin: &'a State,
}

impl Derivative for Motion<'_> {
    fn evaluate(&mut self, time: f64, y: &[f64], derivative: &mut [f64]) {
        let n = self.model.coordinates();
        self.machine.load_signals(self.model, self.origin, time);
        self.machine.load_motion(self.model, y);
        let (rates, accelerations) = derivative.split_at_mut(n);
        rates.copy_from_slice(&y[n..]);
        self.machine.evaluate(&self.model.program().tapes.acceleration, accelerations);
        self.statistics.evaluations += 1;
    }
}

pub(crate) fn motion<'a>(context: &'a mut Context<'_>, origin: &'a State) -> Motion<'a> {
    Motion { model: context.model, machine: context.machine, statistics: context.statistics, origin }
}

impl Dynamic {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let size = 2 * model.coordinates();
        let (explicit, watch, monitor) = (Explicit::new(size), Watch::new(model), Monitor::new(model));
        Self { explicit, next: vec![0.0; size], tolerances: vec![0.0; size], known: false, watch, monitor }
    }

    /// To be called when the front is not the one that the last step left.
    pub fn forget(&mut self) {
        self.known = false;
    }

    /// Takes one step.
    pub fn single(&mut self, context: &mut Context, run: &mut Continuation, horizon: Horizon) -> Result<(), Failure> {
        if self.leave_at_the_start(context, run)? {
            return Ok(());
        }
        self.begin(context, run)?;
        self.step(context, run, horizon)
    }

    /// (q, v) at the target, from the front or from the dense output; says whether it was interpolated.
    pub fn read(&self, run: &Continuation, target: f64, motion: &mut [f64]) -> bool {
        if run.front_time == target {
            motion.copy_from_slice(&run.front);
            return false;
        }
        let theta = (target - run.dense_from) / (run.front_time - run.dense_from);
        interpolate(&run.dense, theta, motion);
        // Where the loops hold less a projection would take the motion off its branch.
        let zone = ZONE * (run.front_time - run.dense_from);
        run.pose.is_none_or(|pose| (pose - target).abs() > zone)
    }

    /// The derivative at the front, and a first step size if there is none.
    fn begin(&mut self, context: &mut Context, run: &mut Continuation) -> Result<(), Failure> {
        let time = run.front_time;
        if !self.known {
            self.explicit.begin(&mut motion(context, &run.origin), time, &run.front);
            self.known = true;
            self.look_around(context);
        }
        let n = context.model.coordinates();
        finite(context.model, time, &self.explicit.first()[n..])?;
        if run.step == 0.0 {
            self.tolerate(context, &run.front, false);
            let mut f = motion(context, &run.origin);
            run.step = self.explicit.starting_step(&mut f, time, &run.front, &self.tolerances);
        }
        Ok(())
    }

    /// One accepted step from the front.
    fn step(&mut self, context: &mut Context, run: &mut Continuation, horizon: Horizon) -> Result<(), Failure> {
        let time = run.front_time;
        let shortest = shortest(time);
        // No step ends in the zone of a singular pose, whoever asks for it: the dense output serves what lies there.
        let limit = if run.in_zone(horizon.limit) { f64::INFINITY } else { horizon.limit };
        let (mut rejected, mut replans) = (false, 0);
        let mut following = f64::INFINITY;
        loop {
            let longest = run.following().unwrap_or(LONGEST).min(context.settings.max_step);
            let natural = within(run.step, shortest, longest);
            let planned = planned(run.ahead, natural).max(shortest);
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
                    run.step = if cut && !rejected { proposed.max(natural) } else { proposed };
                    run.step = run.step.min(following);
                    self.accept(run, end, ahead);
                    context.statistics.steps += 1;
                    return Ok(());
                }
                Trial::Rejected { error, failure } => {
                    rejected = true;
                    run.step = next_step(h, error, true).min(0.5 * h);
                    if run.step < shortest {
                        return Err(end_of_reach(context, run)
                            .unwrap_or_else(|| underflow(context.model, time, self.explicit.first(), failure)));
                    }
                }
                Trial::Overlooked(Overlooked { begin, place }) => {
                    rejected = true;
                    (run.step, following) = ((begin * h).max(shortest), (place - begin) * h);
                }
                Trial::Replanned if replans < REPLANS => replans += 1,
                Trial::Replanned => {
                    (rejected, replans) = (true, 0);
                    (run.step, run.ahead, run.pose) = ((0.5 * h).max(shortest), 0.0, None);
                }
            }
            context.statistics.rejected += 1;
        }
    }

    /// Tries a step to `end`.
    fn attempt(&mut self, context: &mut Context, run: &mut Continuation, end: f64, target: f64) -> Trial {
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
        self.explicit.finish(&mut motion(context, &run.origin), end, &self.next);
        let unfit = Trial::Rejected { error: f64::NAN, failure: None };
        if !self.explicit.last().iter().all(|value| value.is_finite()) {
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
        let passes = Self::passes(run, end);
        let monitored = !self.monitor.is_empty() && end - run.front_time > 2.0 * shortest(end);
        if (end > target || passes || monitored) && !self.interpolate(context, run, end, near) {
            return unfit;
        }
        if monitored && let Some(overlooked) = self.overlooked(context, run, end) {
            return Trial::Overlooked(overlooked);
        }
        if passes && !self.note_passage(context, run, end - run.front_time) {
            return Trial::Replanned;
        }
        Trial::Accepted { error, ahead }
    }

    /// The stages of a step.
    fn try_stages(&mut self, context: &mut Context, run: &Continuation, end: f64, near: bool) -> Result<(), Failure> {
        let (time, h) = (run.front_time, end - run.front_time);
        let Self { explicit, watch, next, .. } = self;
        if is_watched(context.model) {
            watch.begin_step();
            explicit.attempt(&mut Stages::new(context, &run.origin, watch, near), time, &run.front, h, next);
        } else {
            explicit.attempt(&mut motion(context, &run.origin), time, &run.front, h, next);
        }
        watch.take_failure().map_or(Ok(()), Err)
    }

    /// The error of the step just tried, in units of the tolerance.
    fn judge(&mut self, context: &mut Context, run: &Continuation, end: f64, near: bool) -> f64 {
        let h = end - run.front_time;
        self.tolerate(context, &run.front, true);
        let error = self.explicit.error(h, &self.tolerances);
        let passes = Self::passes(run, end);
        if near && error > 1.0 && (passes || error < ROUGH) {
            let flat = self.flattened_error(context, run, end, h);
            let noise = passes && flat <= NOISE && flat <= NOISE_SHARE * error;
            return if noise { flat.min(1.0) } else { error.min(flat) };
        }
        error
    }

    /// The dense output of the step just tried; false if it is not finite.
    fn interpolate(&mut self, context: &mut Context, run: &mut Continuation, end: f64, near: bool) -> bool {
        let (time, h) = (run.front_time, end - run.front_time);
        let Self { explicit, watch, next, .. } = self;
        if near {
            let mut f = Stages::new(context, &run.origin, watch, true);
            explicit.dense(&mut f, time, &run.front, h, next, &mut run.dense);
        } else {
            explicit.dense(&mut motion(context, &run.origin), time, &run.front, h, next, &mut run.dense);
        }
        run.dense_from = time;
        run.dense.iter().all(|value| value.is_finite())
    }

    /// A law that is steep within the step just tried, where the dense output does not accelerate as the equations demand.
    fn overlooked(&mut self, context: &mut Context, run: &Continuation, end: f64) -> Option<Overlooked> {
        let (time, h) = (run.front_time, end - run.front_time);
        let Context { model, machine, statistics, settings, .. } = context;
        let motion = |place: f64, motion: &mut [f64]| interpolate(&run.dense, place, motion);
        let mut span = Span { model, machine, origin: &run.origin, time, h, motion };
        let (n, tolerances) = (model.coordinates(), &self.tolerances);
        let excess = |place: f64, accelerations: &[f64]| {
            statistics.evaluations += 1;
            accelerations.iter().enumerate().fold(0.0, |worst, (index, acceleration)| {
                let lack = h * acceleration - slope(&run.dense, place, 2 * n, n + index);
                math::maximum(worst, lack.abs() / (OVERLOOKED * tolerances[n + index]))
            })
        };
        self.monitor.overlooked(&mut span, SHARE_OF_TOLERANCE * settings.tolerance, excess)
    }

    /// Projects the end of the step onto the loop equations.
    fn close(&mut self, context: &mut Context, run: &Continuation, end: f64, near: bool) -> Result<(), Failure> {
        if context.model.active().is_empty() {
            return Ok(());
        }
        let Context { model, machine, projection, settings, .. } = context;
        let (q, v) = self.next.split_at_mut(model.coordinates());
        machine.load_signals(model, &run.origin, end);
        let tolerance = if near { settings.tolerance.min(TIGHT) } else { settings.tolerance };
        projection.positions(model, machine, q, tolerance, f64::INFINITY)?;
        projection.rates(model, machine, v, tolerance)
    }

    fn accept(&mut self, run: &mut Continuation, end: f64, ahead: f64) {
        self.explicit.roll();
        match run.following() {
            Some(_) => run.follow_on(self.watch.follow(end - run.front_time)),
            None => run.closing = self.watch.roll(&mut run.smallest),
        }
        run.ahead = ahead;
        if ahead > 0.0 {
            run.pose = Some(end + ahead);
        }
        run.series = Some(false);
        run.front_time = end;
        run.front.copy_from_slice(&self.next);
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

/// Are there loop equations that may come to depend on each other?
fn is_watched(model: &Model) -> bool {
    !model.program().tapes.closeness.is_empty()
}

/// A step of its natural length, unless there is a singular pose so far ahead.
fn planned(ahead: f64, natural: f64) -> f64 {
    match if ahead > 0.0 { plan(&COURSE, ahead, natural) } else { Plan::Free } {
        Plan::Free => natural,
        Plan::Approach(length) | Plan::Pass(length) => length.min(natural),
    }
}

/// No step is short enough; names the coordinate that accelerates most, judging by the derivative at the front.
pub(crate) fn underflow(model: &Model, time: f64, derivative: &[f64], cause: Option<Failure>) -> Failure {
    let n = model.coordinates();
    let coordinates = &model.program().coordinates;
    let speed = |index: usize| {
        let size = derivative[n + index].abs() / coordinates[index].scale;
        if size.is_finite() { size } else { f64::INFINITY }
    };
    let fastest = (0..n).max_by(|&a, &b| speed(a).total_cmp(&speed(b)));
    let coordinate = fastest.map_or_else(|| model.program().name.clone(), |index| coordinates[index].name.clone());
    Failure::StepUnderflow { time, coordinate, cause: cause.map(Box::new) }
}
