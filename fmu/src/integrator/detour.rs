//! Past a singular pose by another method, where what the program chooses has not passed it.
//!
//! The steps begin again where the motion was before it came near the pose; what has been read since then lies before the pose, and is right. Two runs with
//! different tolerances must agree: next to the pose the other method may be no better. The explicit method is tried first: steps that stiffness does not keep short
//! stay away from the pose. Those that it does keep short follow the branch of the linkage, if it has one degree of freedom.

use serde::{Deserialize, Serialize};

use super::control::{Horizon, Progress, take_step};
use super::run::Run;
use super::stiffness::{Choice, Engines};
use crate::context::{Context, Settings};
use crate::failure::Failure;
use crate::math;
use crate::model::Model;
use crate::program::Engine;
use crate::singular::curve::Curve;
use crate::singular::dependence::singular_ahead;
use crate::singular::passing::Passage;

/// Tolerances of a method past a pose that was not passed otherwise, in units of the one asked for: shorter steps come to the pose elsewhere.
/// Two results must agree to so many tolerances.
const DETOURS: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.05];
const AGREED: f64 = 10.0;
/// At finer tolerances rounding errors next to the pose are larger.
const FINEST: f64 = 1e-10;
/// It begins so far from the pose at least, in units of the scales: next to the pose it would be no better.
const AHEAD: f64 = 0.002;
/// Rounding errors are divided by the way to the pose: times the tolerance it is so much at least.
const CLEAR: f64 = 2e-12;
/// At most so many steps judge how a pose was passed.
const FURTHEST: usize = 4096;

/// How a singular pose is passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Way {
    Explicit,
    Implicit,
    /// Along the branch of the linkage.
    Along,
}

/// Another method takes the steps past a singular pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Detour {
    pub way: Way,
    /// Until then \[s\].
    pub until: f64,
    /// With this tolerance.
    pub tolerance: f64,
    /// In steps no longer than this \[s\].
    pub longest: f64,
}

impl Detour {
    /// Is it one that a run would write?
    pub fn is_sound(self) -> bool {
        self.until.is_finite() && [self.tolerance, self.longest].iter().all(|size| size.is_finite() && *size > 0.0)
    }
}

/// From where a pose is passed by another method.
struct Origin {
    time: f64,
    motion: Vec<f64>,
    /// The poses that were passed before.
    passages: Vec<Passage>,
    /// The branch, once it is known.
    curve: Option<Curve>,
}

impl Origin {
    /// Where the first of the runs that has been far enough from a pose before was so last.
    fn before(context: &Context, runs: [&Run; 2], pose: f64) -> Option<Self> {
        let is_clear = |&(time, motion): &(f64, &[f64])| {
            // Written so that NaN is too near.
            let way = speed(context.model, motion) * (pose - time);
            way >= AHEAD && way * context.settings.tolerance >= CLEAR
        };
        let (time, motion) = runs.iter().filter_map(|run| run.singular.refuge.first()).find(is_clear)?;
        let mut passages = runs[0].singular.passages.clone();
        passages.retain(|passage| passage.time <= time);
        Some(Self { time, motion: motion.to_vec(), passages, curve: None })
    }
}

impl Engines<'_> {
    /// Takes the last steps again by another method, from before they came near a singular pose that what the program chooses has not passed: to the end of the
    /// detour, or to the target if that is nearer.
    ///
    /// # Errors
    /// The failure, if there is no way round it.
    pub fn pass_otherwise(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        (checkpoint, horizon): (&Run, Horizon),
        failure: Failure,
    ) -> Result<(), Failure> {
        let (Failure::BranchLost { time, .. } | Failure::NotPassed { time, .. }) = failure else {
            return Err(failure);
        };
        // The pose that is not passed lies ahead.
        let pose = run.singular.pose.filter(|pose| *pose > time).unwrap_or(time);
        let tolerance = context.settings.tolerance;
        // What has been read lies before the pose.
        let ahead = checkpoint.last.end_time <= pose && checkpoint.stiffness.detour.is_none();
        let Some(mut origin) =
            Origin::before(context, [run, checkpoint], pose).filter(|_| ahead && tolerance >= FINEST)
        else {
            return Err(failure);
        };
        let begin = origin.time;
        let until = f64::min(pose + (pose - begin), horizon.limit);
        let all = Horizon { target: until, limit: until };
        let mut found: Option<Vec<f64>> = None;
        let implicit = self.implicit.has_each().then_some(Way::Implicit);
        let near = (run.last.end_time, run.last.end.clone());
        let ways = [Some(Way::Explicit), implicit, Some(Way::Along)].into_iter().flatten();
        for (way, share) in ways.flat_map(|way| DETOURS.map(|share| (way, share))) {
            if way == Way::Along && origin.curve.is_none() {
                let state = run.state_at(context.model, near.0, &near.1);
                let share = (near.0 - begin) / (pose - begin);
                let ends = [&*origin.motion, &near.1];
                origin.curve = Curve::trace(context.model, context.machine, &state, ends, share);
                if origin.curve.is_none() {
                    break;
                }
            }
            // The same steps would agree whatever they are worth.
            let longest = share.sqrt() * (until - begin);
            let detour = Detour { way, until, tolerance: share * tolerance, longest };
            if self.go_round(context, run, checkpoint, (detour, &origin), all).is_err() {
                continue;
            }
            let end = run.last.end.clone();
            let agrees = found.is_some_and(|other| difference(context.model, &other, &end) <= AGREED * tolerance);
            if agrees && until <= horizon.target {
                return Ok(());
            }
            if agrees {
                let same = Horizon { target: horizon.target, limit: until };
                return self.go_round(context, run, checkpoint, (detour, &origin), same);
            }
            found = Some(end);
        }
        Err(failure)
    }

    /// Whether short steps have left the branch in a singular pose shows some way behind it only: what is read before that is judged by steps beyond it.
    ///
    /// # Errors
    /// The motion has left its branch.
    pub fn look_on(&mut self, context: &mut Context, run: &mut Run, probe: &mut Run) -> Result<(), Failure> {
        if !run.is_undecided() {
            return Ok(());
        }
        probe.copy_from(run);
        let (mut verdict, accuracy) = (Ok(()), self.accuracy.clone());
        for _ in 0..FURTHEST {
            if verdict.is_err() || !probe.is_undecided() {
                break;
            }
            let next = Horizon { target: probe.last.end_time.next_up(), limit: f64::INFINITY };
            verdict = self.advance(context, probe, next);
        }
        *self.accuracy = accuracy;
        self.forget_steps();
        match verdict {
            Err(failure @ Failure::BranchLost { .. }) => Err(failure),
            // Whatever stops the motion later, it says so then.
            _ => {
                run.singular.trail.judge(probe.last.end_time);
                Ok(())
            }
        }
    }

    /// The steps past a pose, from where the motion was before it came near.
    fn go_round(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        checkpoint: &Run,
        (detour, origin): (Detour, &Origin),
        horizon: Horizon,
    ) -> Result<(), Failure> {
        run.copy_from(checkpoint);
        self.forget(run);
        run.singular.go_back();
        run.singular.passages.clone_from(&origin.passages);
        (run.last.start_time, run.last.end_time) = (origin.time, origin.time);
        run.last.end.copy_from_slice(&origin.motion);
        run.stiffness = Choice::on(Some(detour));
        run.curve.clone_from(&origin.curve);
        close(context, run, detour.tolerance)?;
        self.advance(context, run, horizon)
    }

    /// A step past the pose, or the end of the detour.
    pub(super) fn step_round(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        horizon: Horizon,
        detour: Detour,
    ) -> Result<(), Failure> {
        if run.last.end_time >= detour.until {
            (run.stiffness, run.curve) = (Choice::on(None), None);
            run.last.natural = 0.0;
            if let Some(taylor) = &mut self.taylor {
                taylor.forget();
            }
            return Ok(());
        }
        let max_step = context.settings.max_step.min(detour.longest);
        let engine = if detour.way == Way::Implicit { Engine::Radau } else { Engine::Dop853 };
        let settings = Settings { tolerance: detour.tolerance, max_step, engine, ..*context.settings };
        let Context { model, machine, projection, statistics, .. } = context;
        let context = &mut Context { model, machine, projection, statistics, settings: &settings };
        run.last.order = 0;
        context.statistics.fallbacks += 1;
        let taken = match detour.way {
            Way::Explicit => return take_step(self.explicit, context, run, horizon).map(|_| ()),
            Way::Implicit => take_step(self.implicit, context, run, horizon)?,
            Way::Along => take_step(self.along, context, run, horizon)?,
        };
        match taken {
            Progress::Stepped => Ok(()),
            Progress::Declined => Err(singular_ahead(context, run)),
        }
    }
}

/// Closes the loops where the steps begin: the ends of series are closed by the next one only.
fn close(context: &mut Context, run: &mut Run, tolerance: f64) -> Result<(), Failure> {
    let Context { model, machine, projection, .. } = context;
    machine.load(model, &run.signals.origin);
    machine.load_signals(model, &run.signals.origin, run.last.end_time);
    machine.load_motion(model, &run.last.end);
    let (q, v) = run.last.end.split_at_mut(model.coordinates());
    projection.positions(model, machine, q, tolerance, f64::INFINITY)?;
    projection.rates(model, machine, v, tolerance)
}

/// How fast the fastest coordinate is, in scales a second.
fn speed(model: &Model, state: &[f64]) -> f64 {
    let rates = model.program().coordinates.iter().zip(&state[model.coordinates()..]);
    rates.fold(0.0, |most, (coordinate, rate)| math::maximum(most, rate.abs() / coordinate.scale))
}

/// The largest difference of two motions, in units of the scales and of the rates.
fn difference(model: &Model, one: &[f64], other: &[f64]) -> f64 {
    let n = model.coordinates();
    let coordinates = model.program().coordinates.iter().enumerate();
    let fastest = coordinates.clone().fold(1.0, |most, (k, c)| math::maximum(most, one[n + k].abs() / c.scale));
    coordinates.fold(0.0, |most, (k, coordinate)| {
        let [position, rate] = [0, n].map(|first| (one[first + k] - other[first + k]).abs() / coordinate.scale);
        math::maximum(most, math::maximum(position, rate / fastest))
    })
}
