//! The loop of a step, whatever the method: proposed, tried, accepted or taken again with another length; and what Runge-Kutta methods have in common.

use super::times;
use crate::constraints::domains::outside_soon;
use crate::constraints::projection::largest_gap;
use crate::context::{Context, Settings};
use crate::events::{Objection, Overlooked};
use crate::failure::Failure;
use crate::integrator::range::Range;
use crate::machine::EVER;
use crate::model::Model;
use crate::motion::Run;
use crate::motion::last_step::LONGEST_STEP;
use crate::singular::dependence::{end_of_reach, is_refused};

/// A step that would end at most this much further ends at the limit.
pub(crate) const STRETCH: f64 = 1.01;
/// Shortest step, in units of the spacing of floating-point times.
const SHORTEST: f64 = 16.0;
/// Times nearer to zero than this are spaced as if they were there \[s\].
pub(crate) const EARLY: f64 = 1e-6;

/// What rounding errors open loops by in a step at most, in units of the scales.
const ROUNDING_OF_LOOPS: f64 = 1e-10;
/// The shortest step at a time.
pub(crate) fn shortest(time: f64) -> f64 {
    SHORTEST * f64::EPSILON * time.abs().max(EARLY)
}

/// How far from the loops a step may end, in units of the scales: further, and the rate of a driver has jumped within it, which no acceleration shows.
pub(crate) fn reach(settings: &Settings) -> f64 {
    settings.tolerance.max(ROUNDING_OF_LOOPS)
}

/// A proposed step within its limits; one that is no number is as long as they permit.
pub(crate) fn within(proposed: f64, shortest: f64, max_step: f64) -> f64 {
    proposed.min(LONGEST_STEP).min(max_step).max(shortest)
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

/// What came of an attempt at a step.
pub(crate) enum Trial {
    /// The run has come further, or sees the place where it is differently now.
    Done,
    /// To be tried with this length, and what was wrong with the longer one.
    Shorter(f64, Option<Failure>),
    /// Another method is to take the step.
    Declined,
    /// No other length is better.
    Failed(Failure),
}

/// What is known of a step before it is tried.
pub(crate) enum Proposal<S> {
    Step(S),
    /// There is none to be tried.
    Nothing(Progress),
}

/// A method that takes steps. It keeps what it needs for the next one; what a saved state needs besides is in the run.
pub(crate) trait Method {
    /// What bounds a step, and its length.
    type Step;
    /// So often a step is tried.
    const ATTEMPTS: usize;

    /// Prepares for a step from the end of the last one, no shorter than the shortest one.
    fn plan(&mut self, context: &mut Context, run: &mut Run, horizon: Horizon)
    -> Result<Proposal<Self::Step>, Failure>;

    /// Tries a step, judges it, and makes it the last one of the run if it is accepted.
    fn attempt(&mut self, context: &mut Context, run: &mut Run, step: &mut Self::Step) -> Trial;

    /// The step is to be tried with another length.
    fn shorten(&mut self, context: &mut Context, run: &mut Run, step: &mut Self::Step, h: f64);

    /// No length does that is long enough, because of this.
    fn give_up(&mut self, context: &mut Context, run: &Run, cause: Option<Failure>) -> Result<Progress, Failure>;

    /// After a step that has been accepted: may the run go on?
    fn goes_on(&self, context: &mut Context, run: &Run) -> Result<(), Failure>;
}

/// One accepted step from the end of the last one, unless the method declines it.
#[inline]
pub(crate) fn take_step<M: Method>(
    method: &mut M,
    context: &mut Context,
    run: &mut Run,
    horizon: Horizon,
) -> Result<Progress, Failure> {
    let mut step = match method.plan(context, run, horizon)? {
        Proposal::Step(step) => step,
        Proposal::Nothing(progress) => return Ok(progress),
    };
    let shortest = shortest(run.last.end_time);
    for _ in 0..M::ATTEMPTS {
        match method.attempt(context, run, &mut step) {
            Trial::Done => return method.goes_on(context, run).map(|()| Progress::Stepped),
            Trial::Shorter(h, cause) => {
                method.shorten(context, run, &mut step, h);
                // Written so that NaN is too short.
                let long = h >= shortest;
                if !long {
                    return method.give_up(context, run, cause);
                }
            }
            Trial::Declined => return Ok(Progress::Declined),
            Trial::Failed(failure) => return Err(failure),
        }
    }
    method.give_up(context, run, None)
}

/// A step of a Runge-Kutta method to be tried.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attempt {
    pub end: f64,
    horizon: Horizon,
    /// Has an attempt at this step been rejected?
    pub rejected: bool,
    /// The length that the error permits.
    natural: f64,
    /// Does the step end at a limit? A step cut short is no evidence against the natural length.
    limited: bool,
    /// The laws of the step are those of the times within this span: after a jump where it begins, before one where it ends.
    span: [f64; 2],
    /// How long after the step a law is steep that an attempt has overlooked.
    until_steep: f64,
}

impl Attempt {
    fn new(context: &mut Context, run: &Run, horizon: Horizon, begin: f64) -> Self {
        let step = Self {
            end: run.last.end_time,
            horizon,
            rejected: false,
            natural: run.last.natural,
            limited: false,
            span: [begin, f64::INFINITY],
            until_steep: f64::INFINITY,
        };
        step.with(context, run, run.last.natural)
    }

    /// This attempt with another length. A step that ends before a law gets steep is not stretched into it.
    fn with(self, context: &mut Context, run: &Run, natural: f64) -> Self {
        let (time, limit) = (run.last.end_time, self.horizon.limit);
        let longest = run.following().unwrap_or(LONGEST_STEP).min(context.settings.max_step);
        let natural = within(natural, shortest(time), longest);
        let stretch = if self.until_steep.is_finite() { 1.0 } else { STRETCH };
        let [begin, _] = self.span;
        let furthest = limit.min(time + stretch * natural);
        if let Some([before, end]) = times::ahead(context.model, context.machine, &run.signals.origin, [time, furthest])
        {
            return Self { end, natural, limited: true, span: [begin, before], ..self };
        }
        let limited = furthest >= limit;
        let end = if limited { limit } else { time + natural };
        Self { end, natural, limited, span: [begin, f64::INFINITY], ..self }
    }

    /// True if the step goes beyond the communication point that is wanted.
    pub fn passes_target(&self) -> bool {
        self.end > self.horizon.target
    }

    /// The step is the last one of the run now; its error permits this length of the next one.
    pub fn accepted(&self, context: &mut Context, run: &mut Run, proposed: f64) -> Trial {
        let next = if self.limited && !self.rejected { proposed.max(self.natural) } else { proposed };
        run.last.natural = next.min(self.until_steep);
        context.statistics.steps += 1;
        Trial::Done
    }

    /// There is an objection to the step.
    pub fn objected(&mut self, context: &mut Context, run: &Run, objection: Objection) -> Trial {
        let (time, h) = (run.last.end_time, self.end - run.last.end_time);
        match objection {
            Objection::Overlooked(Overlooked { begin, place }) => {
                self.until_steep = (place - begin) * h;
                rejected(context, (begin * h).max(shortest(time)), None)
            }
            Objection::SlidingMode(index) => {
                context.statistics.rejected += 1;
                let coordinate = context.model.program().coordinates[index].name.clone();
                Trial::Failed(Failure::SlidingMode { time, coordinate })
            }
        }
    }

    /// There could be a singular pose in the step.
    pub fn unsteady<M: Integrator>(&self, context: &mut Context, run: &Run) -> Trial {
        let trial = rejected(context, 0.5 * (self.end - run.last.end_time), None);
        if M::yields(context.settings) || is_refused(context, run) { Trial::Declined } else { trial }
    }
}

/// An attempt that is to be repeated with another length.
pub(crate) fn rejected(context: &mut Context, shorter: f64, cause: Option<Failure>) -> Trial {
    context.statistics.rejected += 1;
    Trial::Shorter(shorter, cause)
}

/// A Runge-Kutta method with an estimate of its error.
pub(crate) trait Integrator {
    /// Prepares for a step from the end of the last one: its derivative, and a first length.
    fn begin(&mut self, context: &mut Context, run: &mut Run) -> Result<(), Failure>;

    /// Tries a step, judges it, and makes it the last one of the run if it is accepted.
    fn try_step(&mut self, context: &mut Context, run: &mut Run, attempt: &mut Attempt) -> Trial;

    /// The derivative where the step begins.
    fn first(&self) -> &[f64];

    /// How close loop equations come to the others.
    fn range(&self) -> &Range;

    /// A law jumps where the next step begins: what is known of the motion before that does not hold after it.
    fn cross_jump(&mut self);

    /// Does another method, which passes singular poses, take over as soon as one may be near?
    fn yields(settings: &Settings) -> bool;
}

/// Does something while laws are those of the times within a span.
fn confined<T>(context: &mut Context, span: [f64; 2], what: impl FnOnce(&mut Context) -> T) -> T {
    context.machine.confine(span);
    let done = what(context);
    context.machine.confine(EVER);
    done
}

impl<M: Integrator> Method for M {
    type Step = Attempt;
    const ATTEMPTS: usize = usize::MAX;

    fn plan(&mut self, context: &mut Context, run: &mut Run, horizon: Horizon) -> Result<Proposal<Attempt>, Failure> {
        // Next to a singular pose no step is taken.
        if run.begins_at_pose() {
            return Ok(Proposal::Nothing(Progress::Declined));
        }
        let jump = times::at_start(context.model, context.machine, &run.signals.origin, run.last.end_time);
        if jump.is_some() {
            self.cross_jump();
            run.last.natural = 0.0;
        }
        let begin = jump.unwrap_or(f64::NEG_INFINITY);
        confined(context, [begin, f64::INFINITY], |context| self.begin(context, run))?;
        if run.singular.is_close(self.range().start()) && is_refused(context, run) {
            return Ok(Proposal::Nothing(Progress::Declined));
        }
        Ok(Proposal::Step(Attempt::new(context, run, horizon, begin)))
    }

    fn attempt(&mut self, context: &mut Context, run: &mut Run, step: &mut Attempt) -> Trial {
        confined(context, step.span, |context| self.try_step(context, run, step))
    }

    fn shorten(&mut self, context: &mut Context, run: &mut Run, step: &mut Attempt, h: f64) {
        run.last.natural = h;
        *step = Attempt { rejected: true, ..step.with(context, run, h) };
    }

    fn give_up(&mut self, context: &mut Context, run: &Run, cause: Option<Failure>) -> Result<Progress, Failure> {
        Err(no_step(context, run, self.first(), cause))
    }

    fn goes_on(&self, _: &mut Context, _: &Run) -> Result<(), Failure> {
        Ok(())
    }
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
            assert!((least..=LONGEST_STEP).contains(&step), "{proposed} becomes {step}");
        }
        assert_eq!(within(1.0, least, 0.5), 0.5);
        assert!(shortest(1e9) > f64::EPSILON * 1e9);
    }
}
