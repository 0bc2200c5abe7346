//! The steps of Runge-Kutta methods: proposed, tried, accepted or taken again with another length.

use crate::constraints::domains::outside_soon;
use crate::constraints::projection::largest_gap;
use crate::context::{Context, Settings};
use crate::events::{Objection, Overlooked};
use crate::failure::Failure;
use crate::integrator::range::Range;
use crate::model::Model;
use crate::motion::Run;
use crate::motion::last_step::LONGEST;
use crate::singular::dependence::{end_of_reach, is_refused};

/// A step that would end at most this much further ends at the limit.
pub(crate) const STRETCH: f64 = 1.01;
/// Shortest step, in units of the spacing of floating-point times.
const SHORTEST: f64 = 16.0;
/// Times nearer to zero than this are spaced as if they were there \[s\].
const EARLY: f64 = 1e-6;

/// What rounding errors open loops by in a step at most, in units of the scales.
const ROUNDING: f64 = 1e-10;
/// The shortest step at a time.
pub(crate) fn shortest(time: f64) -> f64 {
    SHORTEST * f64::EPSILON * time.abs().max(EARLY)
}

/// How far from the loops a step may end, in units of the scales: further, and the rate of a driver has jumped within it, which no acceleration shows.
pub(crate) fn reach(settings: &Settings) -> f64 {
    settings.tolerance.max(ROUNDING)
}

/// A proposed step within its limits; one that is no number is as long as they permit.
pub(crate) fn within(proposed: f64, shortest: f64, max_step: f64) -> f64 {
    proposed.min(LONGEST).min(max_step).max(shortest)
}

/// How far steps may go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Horizon {
    /// The communication point that is wanted.
    pub target: f64,
    /// Nothing is evaluated after this time.
    pub limit: f64,
}

/// What came of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    /// The run has come further, or sees the place where it is differently now.
    Stepped,
    /// None is taken: another method is to take it.
    Declined,
}

/// A step to be tried.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attempt {
    pub end: f64,
    /// The communication point that is wanted.
    pub target: f64,
    /// Has an attempt at this step been rejected?
    pub rejected: bool,
    /// The length that the error permits.
    pub natural: f64,
    /// Does the step end at a limit? A step cut short is no evidence against the natural length.
    pub limited: bool,
}

impl Attempt {
    /// The step is the last one of the run now; its error permits this length of the next one.
    pub fn accepted(&self, proposed: f64) -> Trial {
        Trial::Accepted { next: if self.limited && !self.rejected { proposed.max(self.natural) } else { proposed } }
    }
}

/// What came of an attempt.
pub(crate) enum Trial {
    /// The step is the last one of the run now; the next one is so long.
    Accepted { next: f64 },
    /// To be tried with this length.
    Rejected { shorter: f64, cause: Option<Failure> },
    /// A law is steep somewhere within the step.
    Overlooked(Overlooked),
    /// No other length is better.
    Failed(Failure),
    /// There could be a singular pose in the step.
    Unsteady,
}

impl Trial {
    /// A step that begins at a time, to which there is an objection.
    pub fn objected(model: &Model, time: f64, objection: Objection) -> Self {
        match objection {
            Objection::Overlooked(overlooked) => Self::Overlooked(overlooked),
            Objection::SlidingMode(index) => {
                Self::Failed(Failure::SlidingMode { time, coordinate: model.program().coordinates[index].name.clone() })
            }
        }
    }
}

/// A Runge-Kutta method with an estimate of its error. It keeps what it needs for the next step; what a saved state needs besides is in the run.
pub(crate) trait Integrator {
    /// Prepares for a step from the end of the last one: its derivative, and a first length.
    fn begin(&mut self, context: &mut Context, run: &mut Run) -> Result<(), Failure>;

    /// Tries a step, judges it, and makes it the last one of the run if it is accepted.
    fn attempt(&mut self, context: &mut Context, run: &mut Run, attempt: &Attempt) -> Trial;

    /// The derivative where the step begins.
    fn first(&self) -> &[f64];

    /// How close loop equations come to the others.
    fn range(&self) -> &Range;

    /// Does another method, which passes singular poses, take over as soon as one may be near?
    fn yields(settings: &Settings) -> bool;
}

/// One accepted step from the end of the last one, unless the method declines it.
pub(crate) fn take_step<M: Integrator>(
    method: &mut M,
    context: &mut Context,
    run: &mut Run,
    horizon: Horizon,
) -> Result<Progress, Failure> {
    // Next to a singular pose no step is taken.
    if run.begins_at_pose() {
        return Ok(Progress::Declined);
    }
    method.begin(context, run)?;
    if run.singular.is_close(method.range().start()) && is_refused(context, run) {
        return Ok(Progress::Declined);
    }
    let shortest = shortest(run.last.end_time);
    let (mut rejected, mut until_steep) = (false, f64::INFINITY);
    loop {
        let attempt = propose(context, run, horizon, (rejected, until_steep.is_finite()));
        let h = attempt.end - run.last.end_time;
        let trial = method.attempt(context, run, &attempt);
        let accepted = matches!(trial, Trial::Accepted { .. });
        *(if accepted { &mut context.statistics.steps } else { &mut context.statistics.rejected }) += 1;
        match trial {
            Trial::Accepted { next } => {
                run.last.natural = next.min(until_steep);
                return Ok(Progress::Stepped);
            }
            Trial::Rejected { shorter, cause } => {
                (rejected, run.last.natural) = (true, shorter);
                if shorter < shortest {
                    return Err(no_step(context, run, method.first(), cause));
                }
            }
            Trial::Overlooked(Overlooked { begin, place }) => {
                (rejected, run.last.natural, until_steep) = (true, (begin * h).max(shortest), (place - begin) * h);
            }
            Trial::Failed(failure) => return Err(failure),
            Trial::Unsteady => {
                if M::yields(context.settings) || is_refused(context, run) {
                    return Ok(Progress::Declined);
                }
                if 0.5 * h < shortest {
                    return Err(no_step(context, run, method.first(), None));
                }
                (rejected, run.last.natural) = (true, 0.5 * h);
            }
        }
    }
}

/// The next attempt. A step that ends before a law gets steep is not stretched into it.
fn propose(context: &Context, run: &Run, horizon: Horizon, (rejected, steep): (bool, bool)) -> Attempt {
    let (time, limit) = (run.last.end_time, horizon.limit);
    let longest = run.following().unwrap_or(LONGEST).min(context.settings.max_step);
    let natural = within(run.last.natural, shortest(time), longest);
    let stretch = if steep { 1.0 } else { STRETCH };
    let limited = time + stretch * natural >= limit;
    let end = if limited { limit } else { time + natural };
    Attempt { end, target: horizon.target, rejected, natural, limited }
}

/// No step is short enough: the loops are at the end of their reach, or something moves too fast. Names the coordinate that accelerates most, judging
/// by the derivative where the step begins.
fn no_step(context: &mut Context, run: &Run, derivative: &[f64], cause: Option<Failure>) -> Failure {
    if let Some(jump) = cause.as_ref().and_then(|cause| driver_jump(context, run, cause)) {
        return jump;
    }
    end_of_reach(context, run).unwrap_or_else(|| {
        let failure = underflow(context.model, run.last.end_time, derivative, cause);
        because(context, run, failure)
    })
}

/// What drives the mechanism jumps, if that is why the loops were not closed after the shortest step: what moves without a jump has not moved yet.
fn driver_jump(context: &mut Context, run: &Run, cause: &Failure) -> Option<Failure> {
    let &Failure::Drift { time, .. } = cause else { return None };
    let Context { model, machine, settings, .. } = context;
    machine.load_signals(model, &run.signals.origin, time);
    machine.load_positions(model, &run.last.end[..model.coordinates()]);
    let tape = &model.program().tapes.constraint;
    machine.run(tape);
    let residuals: Vec<f64> = tape.results(machine.registers()).collect();
    let gap = largest_gap(model, model.active(), &residuals);
    let scale = if gap.angular { 1.0 } else { model.program().length };
    (gap.size > reach(settings) * scale).then_some(Failure::DriverJumps { time, gap })
}

/// A law without a value where the last step ends, if there is one: it is the cause of the failure.
pub(crate) fn because(context: &mut Context, run: &Run, failure: Failure) -> Failure {
    let last = &run.last;
    outside_soon(context.model, context.machine, &run.signals.origin, last.end_time, &last.end).unwrap_or(failure)
}

fn underflow(model: &Model, time: f64, derivative: &[f64], cause: Option<Failure>) -> Failure {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_proposal_becomes_a_finite_step() {
        let least = shortest(0.0);
        for proposed in [0.0, 1e-300, 1.0, f64::INFINITY, f64::NAN] {
            let step = within(proposed, least, f64::INFINITY);
            assert!((least..=LONGEST).contains(&step), "{proposed} becomes {step}");
        }
        assert_eq!(within(1.0, least, 0.5), 0.5);
        assert!(shortest(1e9) > f64::EPSILON * 1e9);
    }
}
