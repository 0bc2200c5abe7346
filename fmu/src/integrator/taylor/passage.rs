//! Singular poses on the way of a Taylor step.

use super::propose::{POLYNOMIAL_REACH, order_near, share};
use super::{Start, Taylor};
use crate::constraints::reciprocals::SAME_BRANCH;
use crate::context::Context;
use crate::events::{Choices, half_width};
use crate::failure::Failure;
use crate::integrator::control::{Progress, shortest};
use crate::math;
use crate::model::State;
use crate::motion::Run;
use crate::singular::dependence::{not_passed, undecided};
use crate::singular::detect::{COARSE, HALF, LANDING, leapt_over, locate, refine};
use crate::singular::leaving::{STATE_CORRECTIONS, Search, Verdict};
use crate::singular::passing::{finds_avoided, note_left, note_passage};

/// A pose predicted no further ahead than so many natural steps is located: a row that has just begun to fall falls faster and faster.
const FORESEEN: f64 = 3.0;

/// The rounding errors of the last coefficients are larger than this next to a singular pose: a step is as long as one at this tolerance.
const NOISE_OF_COEFFICIENTS: f64 = 1e-9;

/// Is a singular pose ahead, near enough to be located before a step of this length?
pub(super) fn is_foreseen(run: &Run, natural: f64) -> bool {
    run.singular.ahead > 0.0 && run.singular.ahead < FORESEEN * natural
}

impl Taylor {
    /// Finds the next singular pose along the polynomial, near a guess of how far it is ahead.
    pub(super) fn locate(&mut self, context: &mut Context, run: &Run, guess: f64) -> Option<f64> {
        locate(guess, |time| self.share_at(context, run, time))
    }

    /// Locates the next singular pose, if one may be near. Says whether there is one.
    pub(super) fn locate_ahead(&mut self, context: &mut Context, run: &mut Run, natural: f64) -> bool {
        let near = is_foreseen(run, natural);
        if near {
            let guess = f64::min(run.singular.ahead, POLYNOMIAL_REACH * natural);
            let found = self.locate(context, run, guess).unwrap_or(0.0);
            run.singular.expect(run.last.end_time, found);
        }
        near && run.singular.ahead > 0.0
    }

    /// Locates a singular pose that a step has passed without a plan. Says whether there was one.
    pub(super) fn locate_behind(&mut self, context: &mut Context, run: &mut Run, end: f64) -> bool {
        let h = end - run.last.end_time;
        let Some(guess) = self.guard.turned(h) else { return false };
        let near = self.share_at(context, run, guess) < HALF;
        let found = if near { self.locate(context, run, guess).filter(|ahead| *ahead < h) } else { None };
        if let Some(ahead) = found {
            (run.singular.ahead, run.singular.pose) = (ahead, Some(run.last.end_time + ahead));
        }
        self.restore_end(context, run, end);
        found.is_some()
    }

    /// Has a step leapt over a pose that nothing had announced, and where branches do not meet? Where they do, the motion goes straight on as it has.
    pub(super) fn has_leapt(&mut self, context: &mut Context, run: &mut Run, end: f64) -> bool {
        if self.guard.start.is_empty() {
            return false;
        }
        let (h, share, known) = (end - run.last.end_time, self.guard.share(), run.singular.ahead);
        // A row that comes much closer could have gone past the others.
        if share * SAME_BRANCH >= 1.0 {
            return false;
        }
        let mut looked = false;
        let found = leapt_over(h, share, |time| {
            looked = true;
            self.share_at(context, run, time)
        });
        if let Some(ahead) = found {
            run.singular.ahead = ahead;
            if self.finds_avoided(context, run, h) {
                return true;
            }
        }
        run.singular.ahead = known;
        if looked {
            self.restore_end(context, run, end);
        }
        false
    }

    /// True if a singular pose could be in a step that is proposed, and its ends not show it.
    pub(super) fn may_leap(&mut self, context: &Context, run: &Run, h: f64) -> bool {
        let coarse = context.settings.tolerance >= COARSE && !self.memory.turns_far && !self.guard.start.is_empty();
        coarse && !self.jet.stays_clear(&mut self.changes, (&run.last.dense, run.last.order as usize), h)
    }

    /// The smallest distance from a singular pose along the polynomial, as a share of that where the step begins.
    fn share_at(&mut self, context: &mut Context, run: &Run, dt: f64) -> f64 {
        self.jet.evaluate(&run.last.dense, run.last.order as usize, dt, &mut self.next);
        let Context { model, machine, .. } = context;
        let time = run.last.end_time + dt;
        machine.load_signals(model, &run.signals.origin, time);
        self.update(machine.registers());
        match self.jet.probe(model, machine.registers(), &self.next) {
            Ok(()) => {
                self.jet.reciprocal_pivots(&mut self.guard.next);
                self.guard.share()
            }
            Err(_) => 0.0,
        }
    }

    /// Leaves a singular pose: finds the state a step later from which the motion comes back to this pose with these rates. The step ends where a law
    /// switches before.
    ///
    /// # Errors
    /// The rates do not say on which of the branches that meet here, or no step leads on along it.
    pub(super) fn leave(&mut self, context: &mut Context, run: &mut Run) -> Result<Progress, Failure> {
        let (time, pose, shortest) = (run.last.end_time, run.pose_here(), shortest(run.last.end_time));
        self.choose(context, run);
        for mut search in Search::all(context, run) {
            // Nothing is evaluated near the pose.
            let ends_near = (time + search.h - pose).abs() < (LANDING - 1.0) * (pose - time);
            if ends_near || !self.shoot(context, run, &mut search) {
                continue;
            }
            let Some((length, switch)) = self.piece(context, run, search.h) else { continue };
            if let Some((_, branches)) = switch.filter(|_| length < shortest) {
                return self.switch_at_once(context, run, branches);
            }
            let order = run.last.order as usize;
            self.jet.move_start(&mut run.last.dense, order, -search.h);
            self.depart(context, run, [pose, length]);
            run.last.natural = run.last.natural.max(search.h);
            self.enter(switch, shortest);
            (self.known, self.memory.series) = (Start::Unknown, None);
            return Ok(Progress::Stepped);
        }
        Err(if run.in_zone(time) { not_passed(context, run) } else { undecided(context, run) })
    }

    /// The series about the end of the last step leads away from a pose, and the next step goes along it for this length.
    fn depart(&mut self, context: &mut Context, run: &mut Run, [pose, length]: [f64; 2]) {
        let (start, order) = (run.last.end_time, run.last.order as usize);
        let mut there = self.closed.clone();
        self.jet.evaluate(&run.last.dense, order, pose - start, &mut there);
        self.jet.evaluate(&run.last.dense, order, length, &mut run.last.end);
        (run.last.start_time, run.last.end_time) = (start, start + length);
        if pose <= run.last.end_time {
            note_left(run, context.model, [start, pose], &there);
        }
        (run.singular.ahead, run.singular.pose) = (f64::max(pose - run.last.end_time, 0.0), Some(pose));
        context.statistics.steps += 1;
    }

    /// Makes the series find the way on the branches of the laws where the step begins.
    fn choose(&mut self, context: &mut Context, run: &Run) {
        let Context { model, machine, .. } = context;
        machine.load_signals(model, &run.signals.origin, run.last.end_time);
        self.jet.force(self.memory.branches);
        let choices = self.jet.choices_at(model, machine.registers(), &run.last.end);
        self.jet.force(choices);
    }

    /// How far within h a step is on one branch of all laws, and which ones begin there, if the series begins h after it. None if the series does not tell: it
    /// sees no layer that lies before it.
    fn piece(&mut self, context: &Context, run: &Run, h: f64) -> Option<(f64, Option<(f64, Choices)>)> {
        let (order, tolerance) = (run.last.order as usize, share(context.settings.tolerance));
        self.follow_laws(order);
        self.layers.reverse();
        let known = self.layers.are_gentle(h, half_width(tolerance));
        let switch = self.jet.end_of_piece(order, -h, h);
        (known && self.jet.sighted(order, h, tolerance) >= h).then(|| (switch.map_or(h, |(length, _)| length), switch))
    }

    /// Tries to find the state so long after the start of the step; it is then in `closed`, and its series in the run.
    fn shoot(&mut self, context: &mut Context, run: &mut Run, search: &mut Search) -> bool {
        let (n, h, time) = (context.model.coordinates(), search.h, run.last.end_time);
        self.next.copy_from_slice(&run.last.end);
        for index in 0..n {
            self.next[index] += h * self.next[n + index];
        }
        for _ in 0..STATE_CORRECTIONS {
            if self.start(context, run, time + h, true).is_none() {
                return false;
            }
            let tolerance = context.settings.tolerance;
            self.expand_to(run, f64::INFINITY, order_near(tolerance), tolerance);
            let order = run.last.order as usize;
            self.jet.evaluate(&run.last.dense, order, -h, &mut self.next);
            match search.correct(context.model, &run.last.end, &self.closed, &mut self.next) {
                Verdict::Again => {}
                Verdict::Failed => return false,
                Verdict::Found => return self.natural_length(order, tolerance.max(NOISE_OF_COEFFICIENTS)) >= h,
            }
        }
        false
    }

    /// Notes that the step to this end passes a singular pose; false if the branches do not meet there. `known`: how long after the start of the step, if that has been located precisely.
    pub(super) fn note_passage(&mut self, context: &mut Context, run: &mut Run, known: Option<f64>, end: f64) -> bool {
        let h = end - run.last.end_time;
        let pose = match known {
            Some(ahead) => self.go_to(run, ahead),
            None => self.follow_to_pose(context, run, h),
        };
        let meets = note_passage(run, context.model, pose, &self.next);
        if !meets {
            self.known = Start::Unknown;
        } else if known.is_some() {
            // The series at the end has begun.
            self.go_to(run, h);
            context.model.forget_integrals(&mut self.next);
        } else {
            self.restore_end(context, run, end);
        }
        meets
    }

    /// By how much the rates at the end of a step next to a singular pose, or across it, are wrong, without what the loops take off them: rounding errors of the last
    /// coefficients point away from the branch. The end is judged as it is: where the loops are closed again, a stiff spring feels what rounding errors leave of
    /// positions, divided by the distance.
    pub(super) fn flattened_defect(&mut self, context: &mut Context, run: &Run, end: f64) -> f64 {
        self.residual(context, &run.signals.origin, end) * (end - run.last.end_time) / run.last.order as f64
    }

    /// By how much the accelerations of the polynomial where it has last been evaluated, at this time, are not those that the tape demands, without what the loops take
    /// off them, relative to the rates that count.
    pub(super) fn residual(&mut self, context: &mut Context, origin: &State, time: f64) -> f64 {
        let Context { model, machine, projection, settings, .. } = context;
        let n = model.coordinates();
        let (residuals, demanded) = self.residuals.split_at_mut(n);
        self.jet.accelerations_at_end(residuals);
        machine.load_signals(model, origin, time);
        machine.load_motion(model, &self.next);
        machine.evaluate(&model.program().tapes.acceleration, demanded);
        residuals.iter_mut().zip(&*demanded).for_each(|(residual, demanded)| *residual -= demanded);
        projection.flatten(model, machine, residuals);
        let coordinates = model.program().coordinates.iter().zip(&self.next[n..]);
        let least = settings.least_rate;
        let rates = coordinates.map(|(coordinate, rate)| math::maximum(least * coordinate.scale, rate.abs()));
        residuals.iter().zip(rates).fold(0.0, |worst, (residual, rate)| math::maximum(worst, residual.abs() / rate))
    }

    /// Is the pose ahead, which no step of length h passes, one where branches do not meet?
    pub(super) fn finds_avoided(&mut self, context: &mut Context, run: &mut Run, h: f64) -> bool {
        let pose = self.follow_to_pose(context, run, h);
        self.known = Start::Unknown;
        finds_avoided(run, context.model, pose, &self.next)
    }

    /// The time of the pose ahead within a step of length h; the motion there is then in `next`.
    fn follow_to_pose(&mut self, context: &mut Context, run: &Run, h: f64) -> f64 {
        let ahead = self.refined(context, run, h);
        self.go_to(run, ahead)
    }

    /// How long after the start of a step of length h the pose ahead is, precisely.
    pub(super) fn refined(&mut self, context: &mut Context, run: &Run, h: f64) -> f64 {
        refine(run.singular.ahead, h, |dt| self.share_at(context, run, dt))
    }

    /// The motion so long after the start of the step is in `next` from now on; returns the time.
    fn go_to(&mut self, run: &Run, dt: f64) -> f64 {
        self.jet.evaluate(&run.last.dense, run.last.order as usize, dt, &mut self.next);
        run.last.end_time + dt
    }

    /// Begins the series at the end of the step again, after looking elsewhere.
    fn restore_end(&mut self, context: &mut Context, run: &Run, end: f64) {
        self.jet.evaluate(&run.last.dense, run.last.order as usize, end - run.last.end_time, &mut self.next);
        if !self.start_again(context, run, end) {
            self.start(context, run, end, false);
        }
    }
}
