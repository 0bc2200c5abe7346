//! Which engine takes the next step: the one that the program names, or the implicit one while the motion is stiff.
//!
//! Now and then the fastest rate at which anything can change is estimated. If the step is as long as that rate permits, whatever the accuracy, the
//! implicit method goes on, on trial: it stays while its steps are longer than those that the rate would permit the other engine, in the proportion of
//! what the steps cost. On trial they must be so by a margin, because the errors of implicit steps are larger at the same tolerance; later the proportion is that of
//! the instructions alone, so that a few short steps do not end what has proved itself. Costs are counted in instructions, not timed, so that the same run always
//! takes the same steps.

use serde::{Deserialize, Serialize};

use super::accuracy::{Accuracy, Masses};
use super::control::{Horizon, Progress, because, take_step};
use super::explicit::Explicit;
use super::implicit::Implicit;
use super::memory::Memory;
use super::taylor::{self, Reading, Taylor, order_for};
use crate::constraints::domains;
use crate::context::Context;
use crate::context::Settings;
use crate::events::work_of_laws;
use crate::failure::Failure;
use crate::model::{Model, State, motion};
use crate::motion::Run;
use crate::pace::Pace;
use crate::program::Engine;
use crate::singular::branch;
use crate::singular::dependence::{end_of_reach, not_passed, singular_ahead};
use crate::singular::detect::{COARSE, SIGHTED};

/// Steps before the first test of the fastest rate. After each test that finds nothing it takes twice as many, after each trial that fails four times.
const FIRST_LOOK: u32 = 32;
const MOST_PATIENCE: u32 = 4096;
/// So many steps in a row must be held back: next to a singular pose everything can change fast too, but only there.
const SUSPECT_STEPS: u32 = 4;
/// So many steps after a singular pose it is passed.
const STEPS_AFTER_POSE: f64 = 4.0;
/// Where a curve is followed past a pose the loops are closed this well at least: branches that miss each other by d of the lengths are the root of d apart, 1e-5
/// for the smallest d that is followed, and a projection no better than that goes over to the other one.
const FOLLOWING: f64 = 1e-7;
/// So many steps in a row must speak for the return.
const VOTES: u32 = 8;
/// Steps that change by more than this factor are on their way back from a switch.
const RECOVERING: f64 = 2.0;
/// A step times the fastest rate: what the explicit method may take, and series for each of their orders. From this share on it holds them back; at coarse
/// tolerances, where the lengths of steps at the limit of stability differ by factors, in their geometric mean, none being less than the other share.
const STABLE: f64 = 5.0;
const STABLE_BY_ORDER: f64 = 0.3;
const HELD_BACK: f64 = 0.7;
const FREE: f64 = 0.2;
/// A tape run with derivatives along four directions in half of the steps, three runs each, and along three at each of the nodes in all steps, in runs of the
/// tape.
const TANGENTS: f64 = 1.5;
const TANGENTS_AT_NODES: f64 = 4.0;
/// Runs of the tape in an implicit step: one at the nodes counts twice. And if each stage has a Jacobian of its own.
const IMPLICIT_RUNS: f64 = 12.0;
const IMPLICIT_RUNS_EACH: f64 = 7.0;
/// Evaluations of an explicit step.
const EXPLICIT_EVALUATIONS: f64 = 13.0;
/// What steps take beside their instructions, in those of a tape; an instruction of a series in those of a tape. Fitted to the times of steps of the models.
const IMPLICIT_BEGINNING: f64 = 350.0;
const EXPLICIT_BEGINNING: f64 = 500.0;
const IN_SERIES: f64 = 0.35;
/// So many implicit steps are a trial.
const TRIAL: u32 = 32;
/// So many times longer than that proportion the steps of a trial must be: at the same tolerance their errors are larger.
const WORTHWHILE: f64 = 1.2;

/// What a run remembers of the choice.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Choice {
    /// Is the implicit method the current one?
    stiff: bool,
    /// Steps since the last test, or steps in a row that speak for the return.
    count: u32,
    /// Steps before the next test.
    patience: u32,
    /// Steps in a row at which the other engine may have been held back, and the product of their lengths relative to [`HELD_BACK`].
    suspected: u32,
    shares: f64,
    /// The step at which the other engine was held back \[s\].
    held_back: f64,
    /// Implicit steps of the trial that are left.
    trial: u32,
    /// Has it been the current one?
    has_been_stiff: bool,
    /// Does stiffness hold steps back that come to a singular pose?
    passing: bool,
}

impl Choice {
    pub fn new() -> Self {
        Self {
            stiff: false,
            count: 0,
            patience: FIRST_LOOK,
            suspected: 0,
            shares: 1.0,
            held_back: 0.0,
            trial: 0,
            has_been_stiff: false,
            passing: false,
        }
    }

    /// Has there been no test yet that found nothing?
    fn is_new(&self) -> bool {
        self.patience == FIRST_LOOK
    }

    /// Is the implicit method the current one?
    pub fn is_stiff(&self) -> bool {
        self.stiff
    }

    /// Is it one that a run would write?
    pub fn is_sound(&self) -> bool {
        self.held_back.is_finite()
            && self.held_back >= 0.0
            && self.suspected < SUSPECT_STEPS
            && self.trial <= TRIAL
            && self.shares.is_finite()
            && self.shares > 0.0
            && (FIRST_LOOK..=MOST_PATIENCE).contains(&self.patience)
    }

    /// Counts a step that is no evidence of stiffness; is it time to test, or to test again?
    fn looks(&mut self) -> bool {
        self.count += 1;
        self.count >= self.patience || self.suspected > 0
    }

    /// Takes note of what a test has found: the share of a step in the longest one that is stable. One step of less than `least` is enough to end the suspicion.
    fn record(&mut self, share: f64, least: f64) {
        self.suspected += 1;
        self.shares *= share / HELD_BACK;
        let all = self.suspected == SUSPECT_STEPS;
        self.stiff = all && self.shares > 1.0;
        self.has_been_stiff |= self.stiff;
        self.trial = if self.stiff { TRIAL } else { 0 };
        // Written so that NaN is free.
        let may_be = share > least;
        if all || !may_be {
            (self.count, self.suspected, self.shares, self.passing) = (0, 0, 1.0, false);
            self.patience = MOST_PATIENCE.min(self.patience * if self.stiff { 4 } else { 2 });
        }
    }

    /// Counts an implicit step for or against the return; says whether that is enough.
    fn returns(&mut self, back: bool) -> bool {
        self.trial = self.trial.saturating_sub(1);
        self.count = if back { self.count + 1 } else { 0 };
        self.stiff = self.count < VOTES;
        if !self.stiff {
            self.count = 0;
        }
        !self.stiff
    }
}

/// Is no singular pose near, as far as is known?
fn is_regular(run: &Run) -> bool {
    run.singular.ahead == 0.0
        && run.singular.pose.is_none_or(|pose| pose < run.last.end_time - STEPS_AFTER_POSE * run.last.natural)
}

/// What a step times the fastest rate may be, if it is not implicit.
fn stable(settings: &Settings) -> f64 {
    match settings.engine {
        Engine::Taylor => STABLE.max(STABLE_BY_ORDER * order_for(settings.tolerance) as f64),
        _ => STABLE,
    }
}

/// One step of the explicit method where there is no series, perhaps again, unless that is because the loops are at the end of their reach, or next to a singular
/// pose.
fn fallback_step(
    context: &mut Context,
    (taylor, memory): (&mut Taylor, &mut taylor::TaylorMemory),
    explicit: &mut Explicit,
    run: &mut Run,
    (horizon, again): (Horizon, bool),
) -> Result<(), Failure> {
    if let Some(failure) = end_of_reach(context, run) {
        return Err(failure);
    }
    // Its stages would be evaluated where they do not know the branch.
    if run.in_zone(run.last.end_time) {
        return Err(not_passed(context, run));
    }
    explicit.forget();
    run.last.order = 0;
    // Where there is none for long, at rest say, steps grow.
    if !again {
        run.last.natural = 0.0;
    }
    // What is no series may hold no numbers, and the dense output of the explicit method is shorter.
    run.last.dense.fill(0.0);
    *memory = taylor::TaylorMemory::default();
    context.machine.load(context.model, &run.signals.origin);
    explicit_step(explicit, context, run, horizon)?;
    context.statistics.fallbacks += 1;
    taylor.forget();
    Ok(())
}

/// An explicit step, which no other method takes over next to a singular pose.
fn explicit_step(
    explicit: &mut Explicit,
    context: &mut Context,
    run: &mut Run,
    horizon: Horizon,
) -> Result<(), Failure> {
    match take_step(explicit, context, run, horizon)? {
        Progress::Declined => Err(singular_ahead(context, run)),
        Progress::Stepped => Ok(()),
    }
}

/// Why a law has no value where the last step ends, if one has none.
fn undefined(context: &mut Context, run: &Run) -> Option<Failure> {
    let Context { model, machine, .. } = context;
    if !model.program().tapes.domains.domains.iter().any(domains::is_noticed_here_alone) {
        return None;
    }
    machine.load_signals(model, &run.signals.origin, run.last.end_time);
    machine.load_motion(model, &run.last.end);
    domains::undefined(model, machine)
}

/// Takes note of where a step has ended.
fn note_end(context: &mut Context, run: &mut Run) -> Result<(), Failure> {
    branch::watch(context, run)?;
    run.last.undefined = undefined(context, run).is_some();
    Ok(())
}

/// The engines of a model, side by side.
pub(crate) struct Engines<'a> {
    pub taylor: Option<&'a mut Taylor>,
    pub explicit: &'a mut Explicit,
    pub implicit: &'a mut Implicit,
    /// Where there are no series.
    pub masses: Option<&'a mut Masses>,
    pub accuracy: &'a mut Accuracy,
    /// What they remember of the run whose steps are taken.
    pub memory: &'a mut Memory,
}

/// Steps to a communication point.
pub(crate) struct Advance {
    horizon: Horizon,
    pace: Pace,
    /// What an implicit step costs, and one of the engine that the settings name.
    costs: [f64; 2],
}

impl Engines<'_> {
    /// Before the first step.
    pub fn set_out(&self, context: &Context, run: &Run, horizon: Horizon) -> Advance {
        Advance { horizon, pace: Pace::new(context, run.last.end_time), costs: self.costs(context) }
    }

    /// Takes one step.
    #[inline]
    pub fn take_one(&mut self, context: &mut Context, run: &mut Run, advance: &mut Advance) -> Result<(), Failure> {
        let Advance { horizon, pace, costs: [implicit, other] } = advance;
        let horizon = *horizon;
        if run.last.undefined
            && let Some(failure) = undefined(context, run)
        {
            return Err(failure);
        }
        pace.check(context, run.last.end_time, horizon.target)
            .map_err(|too_many| end_of_reach(context, run).unwrap_or_else(|| because(context, run, too_many)))?;
        let is_implicit = context.settings.engine == Engine::Radau || self.memory.choice.stiff;
        let each = if is_implicit { *implicit } else { *other };
        pace.spend(context, [run.last.end_time, horizon.target], each)?;
        context.settings.check_patience(run.last.end_time)?;
        if context.settings.engine == Engine::Radau {
            if self.implicit_step(context, run, horizon)? == Progress::Declined {
                return Err(singular_ahead(context, run));
            }
        } else if self.memory.choice.stiff {
            self.stiff_step(context, run, horizon)?;
        } else {
            self.other_step(context, run, horizon)?;
        }
        let Self { taylor, masses, accuracy, .. } = self;
        accuracy.note(context, run, |context, run| match taylor {
            Some(taylor) => taylor.amplification(context, run),
            None => masses.as_mut()?.amplification(context, run),
        });
        pace.count(context, each);
        note_end(context, run)
    }

    /// The next step begins elsewhere than the last one ended.
    pub(super) fn forget_steps(&mut self) {
        self.explicit.forget();
        self.implicit.forget();
        if let Some(taylor) = &mut self.taylor {
            taylor.forget();
        }
    }

    /// (q, v) at a target that the last step has reached; says whether they must be projected.
    pub fn read(&mut self, context: &mut Context, run: &Run, target: f64, motion: &mut [f64]) -> bool {
        match (context.settings.engine, &mut self.taylor) {
            _ if self.memory.implicit.is_last() => Implicit::read(run, target, motion),
            (Engine::Taylor, Some(taylor)) if run.last.order > 0 || run.last.end_time == target => {
                taylor.read(context, (run, &self.memory.taylor), target, motion) == Reading::Open
            }
            _ => self.explicit.read(run, target, motion),
        }
    }

    /// Corrects what has been read between implicit steps and projected.
    pub fn tighten(&mut self, context: &mut Context, run: &Run, state: &mut State) {
        if self.memory.implicit.is_last() && state.time() != run.last.end_time {
            self.implicit.tighten(context, run, &mut self.memory.implicit, state);
        }
    }

    /// Something changes within the last implicit step: takes that step again, up to the change, for its polynomial is of a lower order than its end, and the
    /// errors of many changes would add up. Where that is not possible the motion goes on from the polynomial.
    pub fn end_at_change(&mut self, context: &mut Context, run: &mut Run, state: &mut State) {
        let (begin, end, natural) = (run.last.start_time, run.last.end_time, run.last.natural);
        let passes = run.singular.pose.is_some_and(|pose| (begin..=end).contains(&pose));
        let within = self.memory.implicit.is_last() && begin < state.time() && state.time() < end;
        if !within || passes {
            return;
        }
        run.shift_poses(begin);
        self.memory.implicit.forget();
        self.implicit.forget();
        context.machine.load(context.model, &run.signals.origin);
        run.last.end_time = begin;
        let size = run.last.end.len();
        run.last.end.copy_from_slice(&run.last.dense[..size]);
        let horizon = Horizon { target: state.time(), limit: state.time() };
        let mut stepped = true;
        while stepped && run.last.end_time < horizon.target {
            stepped = matches!(self.implicit_step(context, run, horizon), Ok(Progress::Stepped));
        }
        if stepped && run.last.end_time == horizon.target {
            let motion = motion(context.model.layout());
            for state in [state, &mut run.signals.before] {
                state.registers_mut()[motion.clone()].copy_from_slice(&run.last.end);
            }
        }
        run.last.natural = natural;
    }

    fn implicit_step(&mut self, context: &mut Context, run: &mut Run, horizon: Horizon) -> Result<Progress, Failure> {
        self.implicit.step(context, (run, &mut self.memory.implicit), horizon)
    }

    fn stiff_step(&mut self, context: &mut Context, run: &mut Run, horizon: Horizon) -> Result<(), Failure> {
        let goes_on = self.implicit_step(context, run, horizon)? == Progress::Stepped;
        self.memory.taylor.series = None;
        let possible = self.memory.choice.held_back.max(stable(context.settings) / self.implicit.rate(context.model));
        if !goes_on {
            self.memory.choice = Choice { has_been_stiff: true, passing: true, ..Choice::new() };
        }
        // Steps that a switch has made short say nothing of stiffness, while they grow again.
        let change = run.last.natural / (run.last.end_time - run.last.start_time);
        let settled = (1.0 / RECOVERING..RECOVERING).contains(&change);
        let proportion = match self.memory.choice.trial {
            0 => self.cost_ratio(context),
            _ => WORTHWHILE * self.time_ratio(context),
        };
        let short = settled && run.last.natural < possible * proportion;
        if !goes_on || is_regular(run) && self.memory.choice.returns(short) {
            // Series find their own step.
            run.last.natural = if context.settings.engine == Engine::Taylor { 0.0 } else { possible };
            self.explicit.forget();
            if let Some(taylor) = &mut self.taylor {
                taylor.forget();
            }
        }
        Ok(())
    }

    fn other_step(&mut self, context: &mut Context, run: &mut Run, horizon: Horizon) -> Result<(), Failure> {
        self.memory.implicit.forget();
        if self.memory.choice.has_been_stiff && run.singular.ahead > 0.0 && !self.memory.choice.passing {
            self.memory.choice.passing = self.share_of_stable(context, run) > HELD_BACK;
        }
        // Stiffness keeps the steps so short that they are much better than the tolerance; next to the pose rounding errors are not.
        let asked = context.settings.tolerance;
        let tolerance = match run.following() {
            Some(_) => asked.min(FOLLOWING),
            None if self.memory.choice.passing && !is_regular(run) => asked.max(COARSE),
            None if self.memory.taylor.turns_far => asked.min(SIGHTED),
            None => asked,
        };
        let settings = &Settings { tolerance, ..*context.settings };
        let Context { model, machine, projection, statistics, .. } = context;
        let context = &mut Context { model, machine, projection, statistics, settings };
        match (context.settings.engine, &mut self.taylor) {
            (Engine::Taylor, Some(taylor)) => {
                let again = run.last.order == 0;
                if taylor.advance(context, (run, &mut self.memory.taylor), horizon)? == Progress::Declined {
                    fallback_step(context, (taylor, &mut self.memory.taylor), self.explicit, run, (horizon, again))?;
                }
            }
            _ => {
                run.last.order = 0;
                explicit_step(self.explicit, context, run, horizon)?;
            }
        }
        // A step that something else has cut, a tick say, is not held back: no method would take a longer one.
        if run.last.end_time < horizon.limit {
            self.test_for_stiffness(context, run);
        }
        Ok(())
    }

    /// Now and then, whether stiffness holds the steps back.
    fn test_for_stiffness(&mut self, context: &mut Context, run: &mut Run) {
        // Without laws of positions and rates nothing is stiff. The implicit method knows nothing of singular poses.
        let lawful = self.taylor.as_ref().is_none_or(|taylor| taylor.has_laws());
        if context.settings.automatic
            && lawful
            && (is_regular(run) || self.memory.choice.is_new())
            && self.memory.choice.looks()
        {
            let share = self.share_of_stable(context, run);
            let least = if context.settings.tolerance >= COARSE { FREE } else { HELD_BACK };
            self.memory.choice.record(share, least);
            self.memory.choice.held_back = run.last.natural;
        }
    }

    /// The last step's share of what the fastest rate permits.
    fn share_of_stable(&mut self, context: &mut Context, run: &Run) -> f64 {
        let rate = self.implicit.fastest_rate(context, run);
        self.implicit.forget();
        run.last.natural * rate / stable(context.settings)
    }

    /// What an implicit step costs, in steps of the engine that the settings name.
    fn cost_ratio(&self, context: &Context) -> f64 {
        let [implicit, other] = self.costs(context);
        implicit / other.max(1.0)
    }

    /// How long an implicit step takes, in steps of the engine that the settings name.
    fn time_ratio(&self, context: &Context) -> f64 {
        let [implicit, other] = self.costs(context);
        let laws = work_of_laws(context.model) as f64;
        let other = match (context.settings.engine, &self.taylor) {
            (Engine::Taylor, Some(_)) => IN_SERIES * other,
            _ => EXPLICIT_BEGINNING + laws + other,
        };
        (IMPLICIT_BEGINNING + laws + implicit) / other.max(1.0)
    }

    /// Runs of the tape in an implicit step, with derivatives or without.
    fn runs(&self, model: &Model) -> f64 {
        let n = model.coordinates() as f64;
        match self.implicit.has_each() {
            true => IMPLICIT_RUNS_EACH + (2.0 * n / 3.0).ceil() * TANGENTS_AT_NODES,
            false => IMPLICIT_RUNS + (2.0 * n / 4.0).ceil() * TANGENTS,
        }
    }

    /// About what an implicit step costs, and one of the engine that the settings name, in instructions of a tape.
    fn costs(&self, context: &Context) -> [f64; 2] {
        let model: &Model = context.model;
        let n = model.coordinates() as f64;
        let tape = model.program().tapes.acceleration.instructions().len() as f64;
        let algebra = match self.implicit.has_each() {
            true => 9.0 * n * n * n + 3.0 * 9.0 * n * n,
            // A real and a complex factorisation.
            false => 5.0 * n * n * n / 3.0 + 4.0 * 5.0 * n * n,
        };
        let implicit = self.runs(model) * tape + algebra / 3.0;
        let other = match (context.settings.engine, &self.taylor) {
            (Engine::Taylor, Some(taylor)) => taylor.cost(),
            _ => EXPLICIT_EVALUATIONS * tape,
        };
        [implicit, other]
    }
}
