//! Singular poses on the way of a Taylor step.

use super::{Start, Taylor, order_for};
use crate::math;
use crate::solver::continuation::Continuation;
use crate::solver::dependence::undecided;
use crate::solver::singular::{locate, refine};
use crate::solver::{Context, Failure};

/// A row that has passed a pose has less than this share of its distance about there.
const HALF: f64 = 0.5;

/// Lengths that are tried for the step out of a singular pose, each half of the one before.
const LENGTHS: usize = 12;
/// The first one turns nothing by more than this [rad, or scales].
const TURN: f64 = 0.3;
/// Corrections of the state after the step.
const CORRECTIONS: usize = 40;
/// A correction that is not smaller than this share of the one before is the last one.
const SLOW: f64 = 0.7;
/// What may be left of a correction: the pose itself cannot be known better, since its loops close to second order.
const POSE: f64 = 1e-6;
/// The same of the rates, relative to the largest.
const RATE: f64 = 1e-4;
/// The rounding errors of the last coefficients are larger than this next to a singular pose; the step is as much shorter than one at this
/// tolerance as keeps the true terms small.
const NOISE: f64 = 1e-9;
const MARGIN: f64 = 1.3;
/// The rates of a step's polynomial are right to so many tolerances.
const LOOSE: f64 = 10.0;
/// Corrections smaller than this are rounding errors.
const ROUNDING: f64 = 1e-14;

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
        let Context { model, machine, settings, .. } = context;
        let time = run.front_time + dt;
        machine.load_signals(model, &run.origin, time);
        self.jet.update(machine.registers());
        match self.jet.begin(model, machine.registers(), order_for(settings.tolerance), &self.next) {
            Ok(_) => {
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
        let n = context.model.coordinates();
        let time = run.front_time;
        let coordinates = &context.model.program().coordinates;
        let speeds = coordinates.iter().zip(&run.front[n..]);
        let speed = speeds.fold(0.0, |largest, (coordinate, v)| math::maximum(largest, v.abs() / coordinate.scale));
        let longest = TURN / speed;
        let mut h = if run.step > 0.0 { f64::min(run.step, longest) } else { longest }.min(context.settings.max_step);
        let pose = run.pose.filter(|_| run.in_zone(time)).unwrap_or(time);
        if h.is_finite() {
            for _ in 0..LENGTHS {
                if self.shoot(context, run, h, speed) {
                    run.dense_from = time + h;
                    run.front_time = time + h;
                    run.front.copy_from_slice(&self.closed);
                    let mut there = self.closed.clone();
                    self.glide(run, pose, &mut there);
                    run.note_left(context.model, context.settings.tolerance, [time, pose], &there);
                    (run.ahead, run.pose) = (0.0, Some(pose));
                    run.series = None;
                    run.step = run.step.max(h);
                    context.statistics.steps += 1;
                    self.known = Start::Unknown;
                    return Ok(());
                }
                h *= 0.5;
            }
        }
        Err(undecided(context, run))
    }

    /// Tries to find the state so long after the front; it is then in `closed`, and its series in the continuation.
    fn shoot(&mut self, context: &mut Context, run: &mut Continuation, h: f64, speed: f64) -> bool {
        let n = context.model.coordinates();
        let time = run.front_time;
        self.next.copy_from_slice(&run.front);
        for index in 0..n {
            self.next[index] += h * self.next[n + index];
        }
        let mut before = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            if self.start(context, run, time + h, true).is_none() {
                return false;
            }
            self.expand(context, run, f64::INFINITY);
            let order = run.order as usize;
            self.jet.evaluate(&run.dense, order, -h, &mut self.next);
            let coordinates = &context.model.program().coordinates;
            let mut left = [0.0, 0.0];
            for (index, coordinate) in coordinates.iter().enumerate() {
                let dq = run.front[index] - self.next[index];
                let dv = run.front[n + index] - self.next[n + index];
                left[0] = math::maximum(left[0], dq.abs() / coordinate.scale);
                left[1] = math::maximum(left[1], dv.abs() / (coordinate.scale * speed));
                self.next[index] = self.closed[index] + dq + h * dv;
                self.next[n + index] = self.closed[n + index] + dv;
            }
            let size = math::maximum(left[0], h * speed * left[1]);
            if !size.is_finite() {
                return false;
            }
            if size <= ROUNDING || size > SLOW * before {
                let tolerance = context.settings.tolerance.max(NOISE);
                let reaches = self.natural_step(order, tolerance) >= MARGIN * h;
                let tolerance = context.settings.tolerance;
                return reaches && left[0] <= POSE.max(tolerance) && left[1] <= RATE.max(LOOSE * tolerance);
            }
            before = size;
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
