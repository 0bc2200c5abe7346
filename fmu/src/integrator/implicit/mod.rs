//! Integration of Eqs. (22) by Radau IIA of order 5, each step projected onto the loop equations: for stiff motion.
//!
//! Step sizes follow the predictive controller of Gustafsson (1994) and the rules of the authors' program `radau5.f`. A Jacobian serves as long as
//! Newton's iterations converge fast; where it was evaluated is remembered, so that a run continued from a saved state finds the same bits.
//!
//! Singular poses are not passed: a step in which a loop equation comes much closer to the others is taken again with half the length, and next to a pose none
//! is taken at all.

mod batched;
mod control;
mod jacobian;
mod memory;
mod radau;
mod rate;

use super::right_hand_side::RightHandSide;
use crate::context::{Context, Settings};
use crate::events::{Monitor, Objection, Span};
use crate::failure::Failure;
use crate::integrator::accelerations::finite;
use crate::integrator::control::{
    Attempt, Horizon, Integrator, Progress, Trial, because, reach, rejected, shortest, take_step,
};
use crate::integrator::range::Range;
use crate::linalg::lane::{Lane, ZERO};
use crate::math;
use crate::model::Model;
use crate::motion::Run;
use crate::program::Engine;
use batched::Batched;
use control::{IMPLICIT_SAFETY, SHRINK, fourth_root};
use radau::{DENSE_ORDER, Newton, REAL, Radau, evaluate};

pub(super) use memory::ImplicitMemory;

/// Newton's iterations end at this share of the root of what an error estimate may be: a step is better than its error estimate by as much.
const NEWTON_SHARE: f64 = 0.1;
/// A contraction of Newton's iterations for which the Jacobian is kept.
const FRESH_ENOUGH: f64 = 1e-3;
/// A first step is rejected by this factor.
const FIRST_REJECTED: f64 = 0.1;
/// Smallest error that the controller remembers.
const REMEMBERED: f64 = 1e-2;
/// What the accelerations that the polynomial of a step lacks somewhere would change in it, in units of what its error estimate may be: more, and
/// they are those of a law that no stage has seen.
const IMPLICIT_OVERLOOKED: f64 = 100.0;

/// Storage for implicit steps; by default, none.
#[derive(Clone, Debug, Default)]
pub struct Implicit {
    /// That of the run whose step is being taken.
    memory: ImplicitMemory,
    radau: Radau,
    batched: Batched,
    next: Vec<f64>,
    tolerances: Vec<f64>,
    column: Vec<f64>,
    /// Derivatives of everything along two directions, and columns by q and by v that the power method has come to.
    tangents: Vec<Lane>,
    powers: Vec<[f64; 2]>,
    /// Is the derivative where the step begins known?
    known: bool,
    /// Is the Jacobian the one of the anchor?
    current: bool,
    /// How close loop equations come to the others.
    range: Range,
    /// The dense output of the step just tried.
    polynomial: Vec<f64>,
    monitor: Monitor,
    /// A tolerance, and what the error estimate of one step may be at it.
    share: [f64; 2],
}

impl Integrator for Implicit {
    fn begin(&mut self, context: &mut Context, run: &mut Run) -> Result<(), Failure> {
        if !self.known {
            self.radau.begin(&mut RightHandSide::new(context, &run.signals.origin), run.last.end_time, &run.last.end);
            self.known = true;
            self.range.begin(context.model, context.machine);
        }
        finite(context.model, run.last.end_time, &self.radau.first()[context.model.coordinates()..])
            .map_err(|failure| because(context, run, failure))?;
        if self.radau.has_each() {
            // Each attempt has Jacobians of its own.
        } else if !self.memory.anchored || self.memory.contraction > FRESH_ENOUGH {
            self.anchor_ahead(context, run);
        } else if !self.current {
            self.differentiate(context, run);
        }
        if run.last.natural == 0.0 {
            run.last.natural = self.first_step(context, &run.last.end);
        }
        Ok(())
    }

    fn try_step(&mut self, context: &mut Context, run: &mut Run, attempt: &mut Attempt) -> Trial {
        let h = attempt.end - run.last.end_time;
        let solved = match self.solve(context, run, attempt) {
            Ok(solved) => solved,
            Err(Unsolved::Bad { shorter, cause }) => {
                if !self.radau.has_each() {
                    self.anchor_at_the_start(context, run);
                }
                return rejected(context, shorter * h, cause);
            }
            Err(Unsolved::Unsteady) => return attempt.unsteady::<Self>(context, run),
            Err(Unsolved::Objection(objection)) => return attempt.objected(context, run, objection),
        };
        let Solved { error, iterations, contraction } = solved;
        let proposed = self.propose(&self.memory, h, error, [f64::from(iterations), contraction], attempt.rejected);
        self.accept(context.model, run, attempt.end, [error, contraction]);
        attempt.accepted(context, run, proposed)
    }

    fn first(&self) -> &[f64] {
        self.radau.first()
    }

    fn range(&self) -> &Range {
        &self.range
    }

    fn cross_jump(&mut self) {
        self.forget();
        (self.memory.anchored, self.memory.step) = (false, 0.0);
    }

    fn yields(settings: &Settings) -> bool {
        settings.engine == Engine::Taylor
    }
}

/// Why a step is not accepted.
enum Unsolved {
    /// It should be shorter by this factor.
    Bad {
        shorter: f64,
        cause: Option<Failure>,
    },
    /// There could be a singular pose in it.
    Unsteady,
    Objection(Objection),
}

/// How a step was solved.
struct Solved {
    error: f64,
    iterations: i32,
    contraction: f64,
}

impl Implicit {
    /// Storage for a model, if its program may ask for implicit steps: it grows with the square of the coordinates.
    pub fn new(model: &Model) -> Self {
        let program = model.program();
        if program.automatic || program.engine == Engine::Radau { Self::allocate(model) } else { Self::default() }
    }

    /// Is there storage for a model?
    pub fn is_allocated(&self, model: &Model) -> bool {
        self.next.len() == 2 * model.coordinates()
    }

    /// Storage for a model.
    pub fn allocate(model: &Model) -> Self {
        let n = model.coordinates();
        let radau = Radau::new(n);
        Self {
            memory: ImplicitMemory::new(model),
            batched: Batched::new(model, radau.has_each()),
            radau,
            next: vec![0.0; 2 * n],
            tolerances: vec![0.0; 2 * n],
            column: vec![0.0; n],
            tangents: vec![ZERO; model.program().registers as usize],
            powers: vec![[0.0; 2]; n],
            known: false,
            current: false,
            range: Range::new(model),
            polynomial: vec![0.0; (DENSE_ORDER + 1) * n],
            monitor: Monitor::new(model),
            share: [0.0; 2],
        }
    }

    /// One step from the end of the last one, unless the method declines it.
    pub fn step(
        &mut self,
        context: &mut Context,
        (run, memory): (&mut Run, &mut ImplicitMemory),
        horizon: Horizon,
    ) -> Result<Progress, Failure> {
        std::mem::swap(&mut self.memory, memory);
        let done = take_step(self, context, run, horizon);
        std::mem::swap(&mut self.memory, memory);
        done
    }

    /// To be called when the next step does not begin where this method left the last one.
    pub fn forget(&mut self) {
        self.known = false;
        self.current = false;
    }

    /// Has each stage of a step its own Jacobian?
    pub fn has_each(&self) -> bool {
        self.radau.has_each()
    }

    /// (q, v) at the target, from the end of the last step or from the dense output; says whether it was interpolated.
    pub fn read(run: &Run, target: f64, motion: &mut [f64]) -> bool {
        if run.last.end_time == target {
            motion.copy_from_slice(&run.last.end);
            return false;
        }
        evaluate(&run.last.dense, target - run.last.start_time, motion);
        true
    }

    /// Solves a step, closes the loops at its end, and looks at it for singular poses and laws that it has not seen.
    fn solve(&mut self, context: &mut Context, run: &mut Run, attempt: &Attempt) -> Result<Solved, Unsolved> {
        let (end, h) = (attempt.end, attempt.end - run.last.end_time);
        let bad = |shorter: f64, cause| Unsolved::Bad { shorter, cause };
        let (iterations, contraction) = self.iterate(context, run, h).map_err(|shorter| bad(shorter, None))?;
        let error = self.estimate(context, run, attempt);
        let small = error < 1.0;
        if !small {
            let first = self.memory.step == 0.0;
            let shorter =
                if first { FIRST_REJECTED } else { (IMPLICIT_SAFETY / fourth_root(error)).clamp(SHRINK, 0.9) };
            return Err(bad(shorter, None));
        }
        self.radau.end(&run.last.end, &mut self.next);
        self.range.restart();
        self.range.note_nodes(context.model, self.batched.registers());
        if !self.range.is_steady() {
            return Err(Unsolved::Unsteady);
        }
        self.close(context, run, end).map_err(|failure| bad(0.5, Some(failure)))?;
        let solved = Solved { error, iterations, contraction };
        self.objection(context, run, end).map_or(Ok(solved), |objection| Err(Unsolved::Objection(objection)))
    }

    /// Newton's iterations for the stages: how many, and their contraction; or the factor by which a step should be shorter.
    fn iterate(&mut self, context: &mut Context, run: &mut Run, h: f64) -> Result<(i32, f64), f64> {
        let share = self.share(context.settings.tolerance);
        self.tolerate(context, &run.last.end, h, share);
        self.guess(run, h);
        if !self.linearise(context, run, h) {
            return Err(0.5);
        }
        let noise = self.noise(&run.last.end, h);
        let goal = (NEWTON_SHARE * share.sqrt()).max(noise);
        let Implicit { radau, tolerances, batched, .. } = self;
        let mut f = batched.states(context, &run.signals.origin);
        let step = (run.last.end_time, run.last.end.as_slice(), h);
        match radau.solve(&mut f, step, tolerances, [goal, noise]) {
            Newton::Converged { iterations, contraction } => Ok((iterations, contraction)),
            Newton::Failed { shorter } => Err(shorter),
        }
    }

    /// The error of the step just solved, in units of the tolerances.
    fn estimate(&mut self, context: &mut Context, run: &Run, attempt: &Attempt) -> f64 {
        let step = (run.last.end_time, run.last.end.as_slice(), attempt.end - run.last.end_time);
        let again = self.memory.step == 0.0 || attempt.rejected;
        let mut f = RightHandSide::new(context, &run.signals.origin);
        self.radau.error(&mut f, step, &self.tolerances, again)
    }

    /// What the laws have against the step just solved: they are steep where its polynomial does not accelerate as the equations demand, or push to and fro. What stiff
    /// springs and dampers make of the former is filtered out, as from the error of the step.
    fn objection(&mut self, context: &mut Context, run: &Run, end: f64) -> Option<Objection> {
        let h = end - run.last.end_time;
        if self.monitor.is_empty() || h <= 2.0 * shortest(end) {
            return None;
        }
        let Self { radau, polynomial, column, monitor, tolerances, .. } = self;
        let Context { model, machine, statistics, settings, .. } = context;
        let n = model.coordinates();
        radau.dense(&run.last.end, h, polynomial);
        let motion = |place: f64, motion: &mut [f64]| evaluate(polynomial, place * h, motion);
        let (time, shortest) = (run.last.end_time, shortest(end));
        let mut span = Span {
            model,
            machine,
            origin: &run.signals.origin,
            time,
            h,
            shortest,
            tolerance: settings.tolerance,
            motion,
            places: 0,
        };
        let excess = |filtered: bool, place: f64, accelerations: &[f64]| {
            statistics.evaluations += 1;
            for (index, (residual, acceleration)) in column.iter_mut().zip(accelerations).enumerate() {
                *residual = acceleration - second_derivative(polynomial, n, index, place * h);
            }
            if !filtered {
                let rates = column.iter().zip(&tolerances[n..]);
                return rates.fold(0.0, |worst, (residual, rate)| math::maximum(worst, h * residual.abs() / rate))
                    / IMPLICIT_OVERLOOKED;
            }
            radau.correct(column);
            let errors = column.iter().zip(tolerances.iter().zip(&tolerances[n..]));
            errors.fold(0.0, |worst, (q, (position, rate))| {
                math::maximum(worst, math::maximum(q.abs() / position, REAL / h * q.abs() / rate) / IMPLICIT_OVERLOOKED)
            })
        };
        let objection = monitor.objection(&mut span, settings.tolerance, true, excess);
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
        let radau = &self.radau;
        let relax = &mut |change: &mut [f64]| radau.relax(change);
        projection.positions_along(model, machine, q, settings.tolerance, reach(settings), relax)?;
        projection.rates(model, machine, v, settings.tolerance)
    }

    fn accept(&mut self, model: &Model, run: &mut Run, end: f64, [error, contraction]: [f64; 2]) {
        let h = end - run.last.end_time;
        self.radau.dense(&run.last.end, h, &mut run.last.dense);
        run.last.order = 0;
        run.singular.step_without_poses(run.last.end_time);
        run.last.start_time = run.last.end_time;
        run.last.end_time = end;
        model.forget_integrals(&mut self.next);
        run.last.end.copy_from_slice(&self.next);
        let memory = &mut self.memory;
        (memory.step, memory.error) = (h, error.max(REMEMBERED));
        (memory.contraction, memory.smooth) = (contraction, true);
        self.known = false;
    }
}

/// q'' of the dense output.
fn second_derivative(dense: &[f64], n: usize, index: usize, dt: f64) -> f64 {
    (2..=DENSE_ORDER).rev().fold(0.0, |sum, k| sum * dt + (k * (k - 1)) as f64 * dense[k * n + index])
}
