//! Past a singular pose by another method, where what the program chooses has not passed it.
//!
//! The steps begin again where the motion was before it came near the pose; what has been read since then lies before the pose, and is right. Two runs with
//! different tolerances must agree: next to the pose the other method may be no better. The explicit method is tried first; steps that stiffness does not keep short
//! stay away from the pose.

use serde::{Deserialize, Serialize};

use super::control::{Horizon, Progress, take_step};
use super::run::Run;
use super::stiffness::{Choice, Engines};
use crate::context::{Context, Settings};
use crate::failure::Failure;
use crate::math;
use crate::model::Model;
use crate::program::Engine;
use crate::singular::dependence::singular_ahead;

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

/// Another method takes the steps past a singular pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Detour {
    /// The implicit one?
    pub implicit: bool,
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

impl Engines<'_> {
    /// Takes the last steps again by another method, from before they came near a singular pose, if what the program chooses has not passed it.
    pub fn advance_again(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        (checkpoint, horizon): (&Run, Horizon),
        failure: Failure,
    ) -> Result<(), Failure> {
        let (Failure::BranchLost { time, .. } | Failure::NotPassed { time, .. }) = failure else {
            return Err(failure);
        };
        let Some((begin, start)) = checkpoint.singular.refuge.first() else { return Err(failure) };
        // The pose that is not passed lies ahead.
        let pose = run.singular.pose.filter(|pose| *pose > time).unwrap_or(time);
        let way = speed(context.model, start) * (pose - begin);
        // What has been read lies before the pose. Written so that NaN is too near.
        let tolerance = context.settings.tolerance;
        let ahead = checkpoint.last.end_time <= pose && way >= AHEAD && way * tolerance >= CLEAR;
        if checkpoint.stiffness.detour.is_some() || !ahead || tolerance < FINEST {
            return Err(failure);
        }
        let until = f64::min(pose + (pose - begin), horizon.limit);
        let all = Horizon { target: until, limit: until };
        let mut found: Option<Vec<f64>> = None;
        let methods: &[bool] = if self.implicit.has_each() { &[false, true] } else { &[false] };
        for (&implicit, share) in methods.iter().flat_map(|implicit| DETOURS.map(|share| (implicit, share))) {
            // The same steps would agree whatever they are worth.
            let longest = share.sqrt() * (until - begin);
            let detour = Detour { implicit, until, tolerance: share * tolerance, longest };
            if self.go_round(context, run, checkpoint, (detour, all)).is_err() {
                continue;
            }
            let end = run.last.end.clone();
            let agrees = found.is_some_and(|other| difference(context.model, &other, &end) <= AGREED * tolerance);
            if agrees && until <= horizon.target {
                return self.advance(context, run, horizon);
            }
            if agrees {
                let same = Horizon { target: horizon.target, limit: until };
                return self.go_round(context, run, checkpoint, (detour, same));
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
        (detour, horizon): (Detour, Horizon),
    ) -> Result<(), Failure> {
        run.copy_from(checkpoint);
        self.forget(run);
        run.singular.go_back();
        if let Some((begin, start)) = checkpoint.singular.refuge.first() {
            (run.last.start_time, run.last.end_time) = (begin, begin);
            run.last.end.copy_from_slice(start);
        }
        run.stiffness = Choice::on(Some(detour));
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
            run.stiffness = Choice::on(None);
            run.last.natural = 0.0;
            if let Some(taylor) = &mut self.taylor {
                taylor.forget();
            }
            return Ok(());
        }
        let max_step = context.settings.max_step.min(detour.longest);
        let engine = if detour.implicit { Engine::Radau } else { Engine::Dop853 };
        let settings = Settings { tolerance: detour.tolerance, max_step, engine, ..*context.settings };
        let Context { model, machine, projection, statistics, .. } = context;
        let context = &mut Context { model, machine, projection, statistics, settings: &settings };
        run.last.order = 0;
        context.statistics.fallbacks += 1;
        if !detour.implicit {
            return take_step(self.explicit, context, run, horizon).map(|_| ());
        }
        match take_step(self.implicit, context, run, horizon)? {
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
