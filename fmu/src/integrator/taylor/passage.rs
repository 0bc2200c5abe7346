//! Singular poses on the way of a Taylor step.

use super::{Start, Taylor, order_near};
use crate::context::Context;
use crate::failure::Failure;
use crate::integrator::continuation::Continuation;
use crate::singular::dependence::undecided;
use crate::singular::detect::{locate, refine};
use crate::singular::leaving::{CORRECTIONS, Search, Verdict};

/// A row that has passed a pose has less than this share of its distance about there.
const HALF: f64 = 0.5;

/// The rounding errors of the last coefficients are larger than this next to a singular pose; the step is as much shorter than one at this
/// tolerance as keeps the true terms small.
const NOISE: f64 = 1e-9;
const MARGIN: f64 = 1.3;

impl Taylor {
    /// Finds the next singular pose along the polynomial, near a guess of how far it is ahead.
    pub(super) fn locate(&mut self, context: &mut Context, run: &Continuation, guess: f64) -> Option<f64> {
        locate(guess, |time| self.share_at(context, run, time))
    }

    /// Looks for a singular pose that a step has passed without a plan. Says whether there was one.
    pub(super) fn look_back(&mut self, context: &mut Context, run: &mut Continuation, end: f64) -> bool {
        let h = end - run.front_time;
        let Some(guess) = self.guard.turned(h) else { return false };
        let near = self.share_at(context, run, guess) < HALF;
        let found = if near { self.locate(context, run, guess).filter(|ahead| *ahead < h) } else { None };
        if let Some(ahead) = found {
            (run.ahead, run.pose) = (ahead, Some(run.front_time + ahead));
        }
        self.come_back(context, run, end);
        found.is_some()
    }

    /// The smallest distance from a singular pose along the polynomial, as a share of that at the front.
    fn share_at(&mut self, context: &mut Context, run: &Continuation, dt: f64) -> f64 {
        self.jet.evaluate(&run.dense, run.order as usize, dt, &mut self.next);
        let Context { model, machine, .. } = context;
        let time = run.front_time + dt;
        machine.load_signals(model, &run.origin, time);
        self.jet.update(machine.registers());
        match self.jet.probe(model, machine.registers(), &self.next) {
            Ok(()) => {
                self.jet.closeness(model, &mut self.guard.next);
                self.guard.share()
            }
            Err(_) => 0.0,
        }
    }

    /// Leaves a singular pose: finds the state a step later from which the motion comes back to this pose with these rates.
    ///
    /// # Errors
    /// The rates do not say on which of the branches that meet here.
    pub(super) fn leave(&mut self, context: &mut Context, run: &mut Continuation) -> Result<(), Failure> {
        let (time, pose) = (run.front_time, run.pose_here());
        for mut search in Search::all(context, run) {
            if self.shoot(context, run, &mut search) {
                run.dense_from = time + search.h;
                run.front_time = time + search.h;
                run.front.copy_from_slice(&self.closed);
                let mut there = self.closed.clone();
                self.glide(run, pose, &mut there);
                run.note_left(context.model, context.settings.tolerance, [time, pose], &there);
                (run.ahead, run.pose) = (0.0, Some(pose));
                run.series = None;
                run.step = run.step.max(search.h);
                context.statistics.steps += 1;
                self.known = Start::Unknown;
                return Ok(());
            }
        }
        Err(undecided(context, run))
    }

    /// Tries to find the state so long after the front; it is then in `closed`, and its series in the continuation.
    fn shoot(&mut self, context: &mut Context, run: &mut Continuation, search: &mut Search) -> bool {
        let (n, h, time) = (context.model.coordinates(), search.h, run.front_time);
        self.next.copy_from_slice(&run.front);
        for index in 0..n {
            self.next[index] += h * self.next[n + index];
        }
        for _ in 0..CORRECTIONS {
            if self.start(context, run, time + h, true).is_none() {
                return false;
            }
            self.expand(context, run, f64::INFINITY, order_near(context.settings.tolerance));
            let order = run.order as usize;
            self.jet.evaluate(&run.dense, order, -h, &mut self.next);
            match search.correct(context.model, &run.front, &self.closed, &mut self.next) {
                Verdict::Again => {}
                Verdict::Failed => return false,
                Verdict::Found => {
                    let tolerance = context.settings.tolerance.max(NOISE);
                    return self.natural_step(order, tolerance) >= MARGIN * h;
                }
            }
        }
        false
    }

    /// Notes that the step from the front passes a singular pose; false if the branches do not meet there.
    pub(super) fn note_passage(&mut self, context: &mut Context, run: &mut Continuation, end: f64) -> bool {
        let h = end - run.front_time;
        let ahead = refine(run.ahead, h, |dt| self.share_at(context, run, dt));
        self.jet.evaluate(&run.dense, run.order as usize, ahead, &mut self.next);
        let meets = run.note_passage(context.model, context.settings.tolerance, run.front_time + ahead, &self.next);
        if meets {
            self.come_back(context, run, end);
        } else {
            self.known = Start::Unknown;
        }
        meets
    }

    /// Begins the series at the end of the step again, after looking elsewhere.
    fn come_back(&mut self, context: &mut Context, run: &Continuation, end: f64) {
        self.jet.evaluate(&run.dense, run.order as usize, end - run.front_time, &mut self.next);
        self.start(context, run, end, false);
    }
}
