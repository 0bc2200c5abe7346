//! Integration of Eqs. (22): steps of DOP853, each projected onto the loop equations.

use super::accelerations::finite;
use super::continuation::Continuation;
use super::explicit::{Derivative, Explicit, interpolate, next_step};
use super::length::{STRETCH, shortest, within};
use super::{Context, Failure, Statistics};
use crate::machine::Machine;
use crate::model::{Model, State};

/// Share of the tolerance that one step may use: what the user sees is the sum of the errors of many steps.
const SHARE_OF_TOLERANCE: f64 = 0.01;
/// Rounding is larger than an error below this.
const FINEST: f64 = 1e-14;
/// Most attempts at steps between two communication points.
pub(super) const MOST_STEPS: u64 = 10_000_000;

/// Storage for dynamic motion.
#[derive(Clone, Debug)]
pub struct Dynamic {
    explicit: Explicit,
    next: Vec<f64>,
    tolerances: Vec<f64>,
    /// Is the derivative at the front known?
    known: bool,
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
pub(super) struct Motion<'a> {
    model: &'a Model,
    machine: &'a mut Machine,
    statistics: &'a mut Statistics,
    origin: &'a State,
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

pub(super) fn motion<'a>(context: &'a mut Context<'_>, origin: &'a State) -> Motion<'a> {
    Motion { model: context.model, machine: context.machine, statistics: context.statistics, origin }
}

impl Dynamic {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let size = 2 * model.coordinates();
        Self { explicit: Explicit::new(size), next: vec![0.0; size], tolerances: vec![0.0; size], known: false }
    }

    /// To be called when the front is not the one that the last step left.
    pub fn forget(&mut self) {
        self.known = false;
    }

    /// Takes one step.
    pub fn single(&mut self, context: &mut Context, run: &mut Continuation, horizon: Horizon) -> Result<(), Failure> {
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
        true
    }

    /// The derivative at the front, and a first step size if there is none.
    fn begin(&mut self, context: &mut Context, run: &mut Continuation) -> Result<(), Failure> {
        let time = run.front_time;
        if !self.known {
            self.explicit.begin(&mut motion(context, &run.origin), time, &run.front);
            self.known = true;
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
        let mut rejected = false;
        loop {
            let natural = within(run.step, shortest, context.settings.max_step);
            let limited = time + STRETCH * natural >= horizon.limit;
            let end = if limited { horizon.limit } else { time + natural };
            let h = end - time;
            let (error, failure) = self.attempt(context, run, end, horizon.target);
            let proposed = next_step(h, error, rejected);
            if error <= 1.0 && failure.is_none() {
                // A step cut short by a limit says nothing against the natural length.
                run.step = if limited && !rejected { proposed.max(natural) } else { proposed };
                self.accept(run, end);
                context.statistics.steps += 1;
                return Ok(());
            }
            rejected = true;
            context.statistics.rejected += 1;
            run.step = proposed.min(0.5 * h);
            if run.step < shortest {
                return Err(underflow(context.model, time, self.explicit.first(), failure));
            }
        }
    }

    /// Tries a step to `end`. Returns its error in units of the tolerance, and what else is against it.
    fn attempt(
        &mut self,
        context: &mut Context,
        run: &mut Continuation,
        end: f64,
        target: f64,
    ) -> (f64, Option<Failure>) {
        let (time, h) = (run.front_time, end - run.front_time);
        self.explicit.attempt(&mut motion(context, &run.origin), time, &run.front, h, &mut self.next);
        self.tolerate(context, &run.front, true);
        let error = self.explicit.error(h, &self.tolerances);
        // Written so that NaN is rejected too.
        let small = error <= 1.0;
        if !small {
            return (error, None);
        }
        if let Err(failure) = self.close(context, run, end) {
            return (error, Some(failure));
        }
        let mut f = motion(context, &run.origin);
        self.explicit.finish(&mut f, end, &self.next);
        let mut finite = self.explicit.last().iter().all(|value| value.is_finite());
        if end > target {
            self.explicit.dense(&mut f, time, &run.front, h, &self.next, &mut run.dense);
            run.dense_from = time;
            finite &= run.dense.iter().all(|value| value.is_finite());
        }
        (if finite { error } else { f64::NAN }, None)
    }

    /// Projects the end of the step onto the loop equations.
    fn close(&mut self, context: &mut Context, run: &Continuation, end: f64) -> Result<(), Failure> {
        if context.model.active().is_empty() {
            return Ok(());
        }
        let Context { model, machine, projection, settings, .. } = context;
        let (q, v) = self.next.split_at_mut(model.coordinates());
        machine.load_signals(model, &run.origin, end);
        projection.positions(model, machine, q, settings.tolerance, f64::INFINITY)?;
        projection.rates(model, machine, v, settings.tolerance)
    }

    fn accept(&mut self, run: &mut Continuation, end: f64) {
        self.explicit.roll();
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

/// No step is short enough; names the coordinate that accelerates most, judging by the derivative at the front.
pub(super) fn underflow(model: &Model, time: f64, derivative: &[f64], cause: Option<Failure>) -> Failure {
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
