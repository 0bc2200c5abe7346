//! Integration of Eqs. (22) by Radau IIA of order 5, each step projected onto the loop equations: for stiff motion.
//!
//! Step sizes follow the predictive controller of Gustafsson (1994) and the rules of the authors' program `radau5.f`. A Jacobian serves as long as
//! Newton's iterations converge fast; where it was evaluated is remembered, so that a run continued from a saved state finds the same bits.

mod batched;
mod control;
mod memory;
mod passage;
mod radau;
mod watch;

use super::right_hand_side::RightHandSide;
use super::run::Run;
use crate::constraints::accelerations::finite;
use crate::context::Context;
use crate::events::{Monitor, Overlooked, Span};
use crate::failure::Failure;
use crate::integrator::control::{Horizon, STRETCH, shortest, underflow, within};
use crate::math;
use crate::model::Model;
use crate::program::Engine;
use crate::singular::closeness::read;
use crate::singular::dependence::singular_ahead;
use batched::Batched;
use control::{SAFETY, SHRINK, fourth_root};
use passage::{COURSE, Survey};
use radau::{DENSE_ORDER, Newton, REAL, Radau, evaluate};

pub(super) use memory::Memory;

/// Newton's iterations end at this share of the root of what an error estimate may be: a step is better than its error estimate by as much.
const NEWTON_SHARE: f64 = 0.1;
/// A contraction of Newton's iterations for which the Jacobian is kept.
const FRESH_ENOUGH: f64 = 1e-3;
/// Where in a step the Jacobian is evaluated, if the motion before says what is there.
const MIDDLE: f64 = 0.6;
/// A first step is rejected by this factor.
const FIRST_REJECTED: f64 = 0.1;
/// Smallest error that the controller remembers.
const REMEMBERED: f64 = 1e-2;
/// Near a singular pose the loops are closed this well.
const TIGHT: f64 = 1e-10;
/// So often a step is taken again because of a singular pose before it is made shorter.
const REPLANS: u32 = 4;
/// What the accelerations that the polynomial of a step lacks somewhere would change in it, in units of what its error estimate may be: more, and
/// they are those of a law that no stage has seen.
const OVERLOOKED: f64 = 100.0;
/// The motion before is continued over at most so many times its last step for a first guess.
const EXTRAPOLATED: f64 = 8.0;

/// Storage for implicit steps; by default, none.
#[derive(Clone, Debug, Default)]
pub struct Implicit {
    radau: Radau,
    batched: Batched,
    next: Vec<f64>,
    tolerances: Vec<f64>,
    /// One direction, and the derivative of everything along it.
    tangents: Vec<f64>,
    column: Vec<f64>,
    /// Is the derivative at the front known?
    known: bool,
    /// Is the Jacobian the one of the anchor?
    current: bool,
    /// 1 / r^2 of each loop equation at the front, where r is how far it is from the others.
    front: Vec<f64>,
    /// The same at the stages of the step just tried, and where distances are compared with.
    first: Vec<f64>,
    late: Vec<f64>,
    ends: Vec<f64>,
    reference: Vec<f64>,
    /// The dense output of the step just tried, and a state on it.
    polynomial: Vec<f64>,
    point: Vec<f64>,
    monitor: Monitor,
    /// A tolerance, and what the error estimate of one step may be at it.
    share: [f64; 2],
}

/// What came of a trial.
enum Trial {
    /// With a singular pose so far after the end (0 for none).
    Accepted { error: f64, iterations: i32, contraction: f64, ahead: f64 },
    /// To be tried with a step shorter by that factor.
    Rejected { shorter: f64, failure: Option<Failure> },
    /// A singular pose was not where it was expected.
    Replanned,
    /// A singular pose may be in the step.
    Unsteady,
    /// Branches only come close to each other in the step.
    Avoided,
    /// A law is steep somewhere within the step.
    Overlooked(Overlooked),
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
        let rows = || vec![0.0; model.program().tapes.closeness.len()];
        Self {
            batched: Batched::new(model, radau.has_each()),
            radau,
            next: vec![0.0; 2 * n],
            tolerances: vec![0.0; 2 * n],
            tangents: vec![0.0; model.program().registers as usize],
            column: vec![0.0; n],
            known: false,
            current: false,
            front: rows(),
            first: rows(),
            late: rows(),
            ends: rows(),
            reference: rows(),
            polynomial: vec![0.0; (DENSE_ORDER + 1) * n],
            point: vec![0.0; 2 * n],
            monitor: Monitor::new(model),
            share: [0.0; 2],
        }
    }

    /// To be called when the front is not the one that the last step left.
    pub fn forget(&mut self) {
        self.known = false;
        self.current = false;
    }

    /// Has each stage of a step its own Jacobian?
    pub fn has_each(&self) -> bool {
        self.radau.has_each()
    }

    /// (q, v) at the target, from the front or from the dense output; says whether it was interpolated.
    pub fn read(run: &Run, target: f64, motion: &mut [f64]) -> bool {
        if run.last.end_time == target {
            motion.copy_from_slice(&run.last.end);
            return false;
        }
        evaluate(&run.last.dense, target - run.last.start_time, motion);
        // Where the loops hold less a projection would take the motion off its branch.
        !Self::is_at_pose(run, target)
    }

    /// The factors of the last step, if they were lost with a saved state.
    pub fn prepare(&mut self, context: &mut Context, run: &Run) {
        if !self.current {
            self.differentiate(context, run);
        }
        if self.radau.factored() != run.radau.step {
            self.radau.factor(run.radau.step);
        }
    }

    /// Puts q, projected between the steps, where stiff springs are as tight as the motion of the step demands: there a small error of the positions
    /// is a large one of the forces. The state must be in the registers, and
    /// [`Implicit::prepare`] have been called before.
    pub fn tighten(&mut self, context: &mut Context, run: &Run, q: &mut [f64]) {
        let Context { model, machine, .. } = context;
        let dt = machine.registers()[model.layout().time()] - run.last.start_time;
        machine.evaluate(&model.program().tapes.acceleration, &mut self.column);
        for (index, place) in self.column.iter_mut().enumerate() {
            *place -= second_derivative(&run.last.dense, q.len(), index, dt);
        }
        self.radau.correct(&mut self.column);
        if self.column.iter().all(|value| value.is_finite()) {
            q.iter_mut().zip(&self.column).for_each(|(q, change)| *q += change);
        }
    }

    /// One accepted step from the front; or none, and false, if there may be a singular pose in it and another engine can take over.
    pub fn advance(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        horizon: Horizon,
        handing_over: bool,
    ) -> Result<bool, Failure> {
        self.begin(context, run)?;
        if self.is_close(run)
            && let Some(failure) = singular_ahead(context, run)
        {
            return if handing_over { Ok(false) } else { Err(failure) };
        }
        let time = run.last.end_time;
        let shortest = shortest(time);
        let limit = if run.in_zone(horizon.limit) { f64::INFINITY } else { horizon.limit };
        let (mut rejected, mut replans, mut following) = (false, 0, f64::INFINITY);
        loop {
            let natural = within(run.last.natural, shortest, context.settings.max_step);
            let planned = COURSE.planned(run.singular.ahead, natural).max(shortest);
            // A step that ends before a law gets steep is not stretched into it.
            let stretch = if following.is_finite() { 1.0 } else { STRETCH };
            let limited = time + stretch * planned >= limit && Self::may_end(run, limit);
            let end = if limited { limit } else { time + planned };
            let h = end - time;
            match self.attempt(context, run, end, rejected) {
                Trial::Accepted { error, iterations, contraction, ahead } => {
                    let proposed = self.propose(&run.radau, h, error, [f64::from(iterations), contraction], rejected);
                    let passes = run.passes(end);
                    self.accept(run, end, error, contraction);
                    run.singular.expect(end, ahead);
                    // A step cut short by a limit says nothing against the natural length.
                    let cut = limited || planned < natural;
                    run.last.natural =
                        if cut && (planned < natural || !rejected) { proposed.max(natural) } else { proposed };
                    if passes {
                        run.last.natural = run.last.natural.min(natural.max(h));
                    }
                    run.last.natural = run.last.natural.min(following);
                    context.statistics.steps += 1;
                    return Ok(true);
                }
                Trial::Replanned if replans < REPLANS => {
                    replans += 1;
                    context.statistics.rejected += 1;
                }
                Trial::Replanned | Trial::Unsteady => {
                    (rejected, replans) = (true, 0);
                    context.statistics.rejected += 1;
                    run.last.natural = 0.5 * h;
                    if handing_over && !self.has_each() {
                        return Ok(false);
                    }
                    if let Some(failure) = singular_ahead(context, run) {
                        return if handing_over { Ok(false) } else { Err(failure) };
                    }
                    if run.last.natural < shortest {
                        return Err(underflow(context.model, time, self.radau.first(), None));
                    }
                }
                Trial::Overlooked(Overlooked { begin, place }) => {
                    rejected = true;
                    context.statistics.rejected += 1;
                    (run.last.natural, following) = ((begin * h).max(shortest), (place - begin) * h);
                }
                Trial::Avoided if handing_over => return Ok(false),
                Trial::Avoided => return Err(Self::avoided(context, run)),
                Trial::Rejected { shorter, failure } => {
                    rejected = true;
                    context.statistics.rejected += 1;
                    run.last.natural = shorter * h;
                    if run.last.natural < shortest {
                        return Err(underflow(context.model, time, self.radau.first(), failure));
                    }
                    if !self.radau.has_each() {
                        self.anchor_at_the_front(context, run);
                    }
                }
            }
        }
    }

    /// The derivative at the front, a Jacobian, and a first step size if there is none.
    fn begin(&mut self, context: &mut Context, run: &mut Run) -> Result<(), Failure> {
        if !self.known {
            self.radau.begin(&mut RightHandSide::new(context, &run.signals.origin), run.last.end_time, &run.last.end);
            self.known = true;
            read(context.model, context.machine, &mut self.front);
        }
        finite(context.model, run.last.end_time, &self.radau.first()[context.model.coordinates()..])?;
        if self.radau.has_each() {
            // Each attempt has Jacobians of its own.
        } else if !run.radau.anchored || run.radau.contraction > FRESH_ENOUGH {
            self.anchor_ahead(context, run);
        } else if !self.current {
            self.differentiate(context, run);
        }
        if run.last.natural == 0.0 {
            run.last.natural = self.first_step(context, &run.last.end);
        }
        Ok(())
    }

    /// Makes a place within the next step, as the motion before promises it, that of the Jacobian: it serves all nodes alike.
    fn anchor_ahead(&mut self, context: &mut Context, run: &mut Run) {
        let before = run.last.end_time - run.last.start_time;
        if !run.radau.smooth || run.last.natural == 0.0 || run.last.natural > EXTRAPOLATED * before {
            return self.anchor_at_the_front(context, run);
        }
        let Memory { anchor, anchored, .. } = &mut run.radau;
        anchor[0] = run.last.end_time + MIDDLE * run.last.natural;
        evaluate(&run.last.dense, before + MIDDLE * run.last.natural, &mut anchor[1..]);
        *anchored = true;
        self.differentiate(context, run);
    }

    /// Makes the front the place of the Jacobian, if it is not.
    fn anchor_at_the_front(&mut self, context: &mut Context, run: &mut Run) {
        let Memory { anchor, anchored, .. } = &mut run.radau;
        if *anchored && anchor[0] == run.last.end_time && self.current {
            return;
        }
        anchor[0] = run.last.end_time;
        anchor[1..].copy_from_slice(&run.last.end);
        *anchored = true;
        self.differentiate(context, run);
    }

    /// The Jacobian at the anchor.
    fn differentiate(&mut self, context: &mut Context, run: &Run) {
        let Context { model, machine, .. } = context;
        let Memory { anchor, .. } = &run.radau;
        machine.load_signals(model, &run.signals.origin, anchor[0]);
        machine.load_motion(model, &anchor[1..]);
        let (by_q, by_v) = self.radau.jacobian_mut();
        self.batched.differentiate(model, machine, by_q, by_v);
        self.current = true;
        context.statistics.jacobians += 1;
    }

    /// Tries a step to `end`.
    fn attempt(&mut self, context: &mut Context, run: &mut Run, end: f64, rejected: bool) -> Trial {
        let (time, h) = (run.last.end_time, end - run.last.end_time);
        let reject = |shorter: f64| Trial::Rejected { shorter, failure: None };
        let share = self.share(context.settings.tolerance);
        self.tolerate(context, &run.last.end, h, share);
        self.guess(run, h);
        if !self.linearise(context, run, h) {
            return reject(0.5);
        }
        let noise = self.noise(&run.last.end, h);
        let goal = (NEWTON_SHARE * share.sqrt()).max(noise);
        let Implicit { radau, tolerances, batched, .. } = self;
        let mut f = batched.states(context, &run.signals.origin);
        let step = (time, run.last.end.as_slice(), h);
        let (iterations, contraction) = match radau.solve(&mut f, step, tolerances, [goal, noise]) {
            Newton::Converged { iterations, contraction } => (iterations, contraction),
            Newton::Failed { shorter } => return reject(shorter),
        };
        let first = run.radau.step == 0.0;
        let error = radau.error(&mut f, step, tolerances, first || rejected);
        let error = self.judge(context, run, end, error);
        let small = error < 1.0;
        if !small {
            return reject(match error {
                _ if first => FIRST_REJECTED,
                error => (SAFETY / fourth_root(error)).clamp(SHRINK, 0.9),
            });
        }
        self.radau.end(&run.last.end, &mut self.next);
        let ahead = if self.has_each() {
            match self.survey(context, run, end) {
                Survey::Clear(ahead) => ahead,
                Survey::Elsewhere(ahead) => {
                    (run.singular.ahead, run.singular.pose) = (ahead, (ahead > 0.0).then_some(time + ahead));
                    return Trial::Replanned;
                }
                Survey::Unsteady => return Trial::Unsteady,
            }
        } else if self.is_steady(context.model) {
            0.0
        } else {
            return Trial::Unsteady;
        };
        if let Err(failure) = self.close(context, run, end) {
            return Trial::Rejected { shorter: 0.5, failure: Some(failure) };
        }
        if let Some(overlooked) = self.overlooked(context, run, end) {
            return Trial::Overlooked(overlooked);
        }
        if run.passes(end) && !self.note_passage(context, run, end) {
            return Trial::Avoided;
        }
        Trial::Accepted { error, iterations, contraction, ahead }
    }

    /// A law that is steep within the step just solved, where its polynomial does not accelerate as the equations demand. What stiff springs and
    /// dampers make of that is filtered out, as from the error of the step.
    fn overlooked(&mut self, context: &mut Context, run: &Run, end: f64) -> Option<Overlooked> {
        let h = end - run.last.end_time;
        if self.monitor.is_empty() || h <= 2.0 * shortest(end) {
            return None;
        }
        let Self { radau, polynomial, column, monitor, tolerances, .. } = self;
        let Context { model, machine, statistics, settings, .. } = context;
        let n = model.coordinates();
        radau.dense(&run.last.end, h, polynomial);
        let motion = |place: f64, motion: &mut [f64]| evaluate(polynomial, place * h, motion);
        let mut span = Span { model, machine, origin: &run.signals.origin, time: run.last.end_time, h, motion };
        let excess = |place: f64, accelerations: &[f64]| {
            statistics.evaluations += 1;
            for (index, (lack, acceleration)) in column.iter_mut().zip(accelerations).enumerate() {
                *lack = acceleration - second_derivative(polynomial, n, index, place * h);
            }
            radau.correct(column);
            let errors = column.iter().zip(tolerances.iter().zip(&tolerances[n..]));
            errors.fold(0.0, |worst, (q, (position, rate))| {
                math::maximum(worst, math::maximum(q.abs() / position, REAL / h * q.abs() / rate) / OVERLOOKED)
            })
        };
        monitor.overlooked(&mut span, settings.tolerance, excess)
    }

    /// Jacobians, if each stage has its own, and factors for a step of that length; false if there are none.
    fn linearise(&mut self, context: &mut Context, run: &mut Run, h: f64) -> bool {
        if !self.radau.has_each() && self.radau.factored() == h {
            return true;
        }
        context.statistics.factorisations += 1;
        if !self.radau.has_each() {
            return self.radau.factor(h);
        }
        context.statistics.jacobians += 1;
        let Implicit { radau, batched, .. } = self;
        let regular =
            radau.linearise(&mut batched.states(context, &run.signals.origin), (run.last.end_time, &run.last.end, h));
        radau.last_stage((run.last.end_time, h), &mut run.radau.anchor);
        (run.radau.anchored, self.current) = (true, true);
        regular
    }

    /// A first guess of the stages.
    fn guess(&mut self, run: &Run, h: f64) {
        let before = run.last.end_time - run.last.start_time;
        if !run.radau.smooth || h > EXTRAPOLATED * before {
            return self.radau.guess_nothing();
        }
        self.radau.guess(&run.last.end, |node, motion| {
            evaluate(&run.last.dense, before + node * h, motion);
        });
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
        projection.positions_along(model, machine, q, settings.tolerance, f64::INFINITY, relax)?;
        let mut tolerance = settings.tolerance;
        if Self::is_near(run, end) {
            // What the loops are open by is divided by the distance from the pose.
            tolerance = tolerance.min(TIGHT);
            projection.positions(model, machine, q, tolerance, f64::INFINITY)?;
        }
        projection.rates(model, machine, v, tolerance)
    }

    fn accept(&mut self, run: &mut Run, end: f64, error: f64, contraction: f64) {
        let h = end - run.last.end_time;
        self.radau.dense(&run.last.end, h, &mut run.last.dense);
        run.last.order = 0;
        run.last.start_time = run.last.end_time;
        run.last.end_time = end;
        run.last.end.copy_from_slice(&self.next);
        let memory = &mut run.radau;
        (memory.step, memory.error) = (h, error.max(REMEMBERED));
        (memory.contraction, memory.smooth) = (contraction, true);
        self.known = false;
    }
}

/// q'' of the dense output.
fn second_derivative(dense: &[f64], n: usize, index: usize, dt: f64) -> f64 {
    (2..=DENSE_ORDER).rev().fold(0.0, |sum, k| sum * dt + (k * (k - 1)) as f64 * dense[k * n + index])
}
