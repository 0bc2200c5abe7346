//! Integration of Eqs. (22) by Taylor series, each step from the loop-closed state that the last one left.
//!
//! The polynomial of a step is its dense output. Its length follows from its last coefficients (Jorba & Zou, 2005). A step is rejected
//! if the loops do not stay closed along it, or if its end does not accelerate as the equations there demand. Where a series does not exist (a law that is not analytic at this very
//! state, a singular pose), one step of the explicit method leads on; [`Statistics::fallbacks`] counts them.

use super::continuation::Continuation;
use super::dynamic::{Dynamic, Horizon};
use super::{Context, Failure};
use crate::model::Model;
use crate::series::{Jet, MAX_ORDER};

/// Share of the tolerance that one step may use: what the user sees is the sum of the errors of many steps.
const SHARE_OF_TOLERANCE: f64 = 0.03;
/// Rounding is larger than an error below this.
const FINEST: f64 = 1e-15;
/// A step that would end at most this much further ends at the limit.
const STRETCH: f64 = 1.01;
/// A step that is cut short ends its series when two terms are this much smaller than the tolerance.
const NEGLIGIBLE: f64 = 1e-3;
/// Loops may open so much along a step, in units of the tolerance.
const OPENING: f64 = 10.0;
/// Share of the step that the last coefficients permit: the terms after the last one count too.
const SAFETY: f64 = 0.9;
/// A step is at most so many times as long as the one before.
const GROW: f64 = 4.0;
/// Longest step, for motions whose series end [s].
const LONGEST: f64 = 1e4;
/// A step shorter than this share of the one before is cut short.
const CUT: f64 = 0.9;
/// So often a step is halved.
const HALVINGS: usize = 12;
/// Shortest step, in units of the spacing of floating-point times.
const SHORTEST: f64 = 16.0;

/// Storage for Taylor series.
#[derive(Clone, Debug)]
pub struct Taylor {
    jet: Jet,
    next: Vec<f64>,
    /// (q, v) at the front, on the loops.
    closed: Vec<f64>,
    /// What the jet holds begins at the front.
    known: Start,
}

/// Whether there is a series at the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Start {
    Unknown,
    Regular,
    Singular,
}

/// What comes of a state that the front has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// It is on the loops.
    Closed,
    /// It must still be projected.
    Open,
}

impl Taylor {
    /// Storage for a model with an arm form.
    pub fn new(model: &Model) -> Option<Self> {
        let size = 2 * model.coordinates();
        let jet = Jet::new(model)?;
        Some(Self { jet, next: vec![0.0; size], closed: vec![0.0; size], known: Start::Unknown })
    }

    /// Numbers in the dense output of a step.
    pub fn dense_length(model: &Model) -> usize {
        model.program().arms.as_ref().map_or(0, Jet::room)
    }

    /// To be called when the front is not the one that the last step left.
    pub fn forget(&mut self) {
        self.known = Start::Unknown;
    }

    /// Takes one step.
    pub fn single(
        &mut self,
        context: &mut Context,
        explicit: &mut Dynamic,
        run: &mut Continuation,
        horizon: Horizon,
    ) -> Result<(), Failure> {
        self.begin(context, run);
        let done = self.known == Start::Regular && self.step(context, run, horizon);
        if done { Ok(()) } else { self.lead_on(context, explicit, run, horizon) }
    }

    /// (q, v) at the target, from the front or from the polynomial.
    pub fn read(&mut self, context: &mut Context, run: &Continuation, target: f64, motion: &mut [f64]) -> Reading {
        if run.front_time == target {
            self.begin(context, run);
            let regular = self.known == Start::Regular;
            motion.copy_from_slice(if regular { &self.closed } else { &run.front });
            return if regular { Reading::Closed } else { Reading::Open };
        }
        self.jet.evaluate(&run.dense, run.order as usize, target - run.dense_from, motion);
        Reading::Closed
    }

    /// Puts the front on the loops, if that has not been done.
    fn begin(&mut self, context: &mut Context, run: &Continuation) {
        if self.known == Start::Unknown {
            self.next.copy_from_slice(&run.front);
            self.known = match self.start(context, run, run.front_time) {
                Some(_) => Start::Regular,
                None => Start::Singular,
            };
        }
    }

    /// Starts a series at `next`; returns how far the loops were open there.
    fn start(&mut self, context: &mut Context, run: &Continuation, time: f64) -> Option<f64> {
        let Context { model, machine, settings, .. } = context;
        machine.load_signals(model, &run.origin, time);
        self.jet.update(machine.registers());
        let order = order_for(settings.tolerance);
        let open = self.jet.begin(model, machine.registers(), order, &self.next).ok()?;
        let (q, v) = self.closed.split_at_mut(model.coordinates());
        self.jet.coordinates(0, q);
        self.jet.coordinates(1, v);
        (open.is_finite() && self.closed.iter().all(|value| value.is_finite())).then_some(open)
    }

    /// One step from the front; false if there is no series to step along.
    fn step(&mut self, context: &mut Context, run: &mut Continuation, horizon: Horizon) -> bool {
        let time = run.front_time;
        let shortest = SHORTEST * f64::EPSILON * time.abs().max(1e-6);
        let tolerance = share(context.settings.tolerance);
        let room = horizon.limit - time;
        self.expand(context, run, room.min(context.settings.max_step));
        let order = run.order as usize;
        context.statistics.evaluations += 1;
        let natural = self.natural_step(order, tolerance);
        let longest = if run.step > 0.0 { GROW * run.step } else { LONGEST };
        let mut h = natural.min(longest).min(LONGEST).min(context.settings.max_step);
        for _ in 0..HALVINGS {
            // Written so that NaN is too short.
            let long = h >= shortest;
            if !long {
                return false;
            }
            let end = if STRETCH * h >= room { horizon.limit } else { time + h };
            self.jet.evaluate(&run.dense, order, end - time, &mut self.next);
            let goal = OPENING * tolerance;
            let closed = self.start(context, run, end).is_some_and(|open| open <= goal);
            if closed && self.jet.defect(order, end - time) <= goal {
                // A step cut short by a limit says nothing against the natural length.
                run.step = if end == horizon.limit { h.max(run.step) } else { end - time };
                run.dense_from = time;
                run.front_time = end;
                run.front.copy_from_slice(&self.next);
                context.statistics.steps += 1;
                return true;
            }
            context.statistics.rejected += 1;
            h = 0.5 * (end - time);
        }
        false
    }

    /// The step that the tolerance permits. Rates decide, or positions if the step is so long that their error is larger.
    fn natural_step(&self, order: usize, tolerance: f64) -> f64 {
        let step = SAFETY * self.jet.reach(order, tolerance, 1);
        if step > order as f64 { step.min(SAFETY * self.jet.reach(order, tolerance, 0)) } else { step }
    }

    /// The rest of the series at the front, as far as the step may need it.
    fn expand(&mut self, context: &Context, run: &mut Continuation, room: f64) {
        let order = order_for(context.settings.tolerance);
        let goal = NEGLIGIBLE * share(context.settings.tolerance);
        // Only a step much shorter than its natural length needs fewer terms.
        let cut = run.step == 0.0 || room < CUT * run.step;
        let (mut last, mut power, mut small) = (2, room, 0);
        loop {
            if cut {
                let rate = last as f64 * power;
                let size = self.jet.size(last);
                small = if rate * size <= goal { small + 1 } else { 0 };
                if small == 2 && rate * room * size <= goal {
                    break;
                }
                power *= room;
            }
            if last == order {
                break;
            }
            last += 1;
            self.jet.advance(last - 2);
        }
        run.order = last as u32;
        let polynomial = self.jet.polynomial(last);
        run.dense[..polynomial.len()].copy_from_slice(polynomial);
    }

    /// One step of the explicit method.
    fn lead_on(
        &mut self,
        context: &mut Context,
        explicit: &mut Dynamic,
        run: &mut Continuation,
        horizon: Horizon,
    ) -> Result<(), Failure> {
        explicit.forget();
        run.step = 0.0;
        run.order = 0;
        context.machine.load(context.model, &run.origin);
        explicit.single(context, run, horizon)?;
        context.statistics.fallbacks += 1;
        self.known = Start::Unknown;
        Ok(())
    }
}

/// What one step may be wrong by at a tolerance.
fn share(tolerance: f64) -> f64 {
    (SHARE_OF_TOLERANCE * tolerance).max(FINEST)
}

/// Orders that cost least at a tolerance; the optimum is flat.
fn order_for(tolerance: f64) -> usize {
    if tolerance >= 1e-5 {
        12
    } else if tolerance >= 1e-7 {
        16
    } else if tolerance >= 1e-11 {
        18
    } else {
        MAX_ORDER
    }
}
