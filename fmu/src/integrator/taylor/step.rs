//! One step: propose a length, try it, judge it, accept or shorten it.

use super::propose::{Step, is_fall, is_near, is_near_pose};
use super::{Start, Taylor};
use crate::context::Context;
use crate::events::Choices;
use crate::failure::Failure;
use crate::integrator::control::{Horizon, Method, Progress, Proposal, Trial, rejected};
use crate::motion::Run;
use crate::singular::dependence::{STOPPED, end_of_reach, is_singular, not_passed};

/// A step shorter than this share of its natural length needs no test at its end if there are no loops to be closed there, and no laws of the
/// motion, which may be steep where no coefficient tells of it.
const SURE: f64 = 0.5;
/// So often a step is shortened.
const ATTEMPTS: usize = 12;
/// A step that would end near a singular pose is cut to this share.
const POSE_CUT: f64 = 0.6;
/// A pose predicted further ahead than so many steps is not to be relied on.
pub(super) const PREDICTED: f64 = 1.8;
/// Across a singular pose rounding errors that point away from the branch grow so large, in units of those of rates; the loops take them off.
const NOISE_OFF_BRANCH: f64 = 1e-7;
/// What is left of the defect of such a step without what the loops take off, in units of what another step may miss.
const FLATTENED_DEFECT: f64 = 100.0;

impl Method for Taylor {
    type Step = Step;
    const ATTEMPTS: usize = ATTEMPTS;

    #[inline]
    fn plan(&mut self, context: &mut Context, run: &mut Run, horizon: Horizon) -> Result<Proposal<Step>, Failure> {
        self.propose(context, run, horizon)
    }

    #[inline]
    fn attempt(&mut self, context: &mut Context, run: &mut Run, step: &mut Step) -> Trial {
        self.try_step(context, run, step)
    }

    fn shorten(&mut self, _: &mut Context, _: &mut Run, step: &mut Step, h: f64) {
        step.h = h;
    }

    fn give_up(&mut self, _: &mut Context, _: &Run, _: Option<Failure>) -> Result<Progress, Failure> {
        Ok(Progress::Declined)
    }

    /// A driven mechanism does not go on from where branches of its motion lie as close together as errors of steps: the loops are at the end of their reach there, or
    /// drivers turn back.
    fn goes_on(&self, context: &mut Context, run: &Run) -> Result<(), Failure> {
        let near = context.model.is_driven() && self.guard.begins_within(STOPPED);
        let stops = near && is_singular(context, run);
        let failure = if stops { end_of_reach(context, run) } else { None };
        failure.map_or(Ok(()), Err)
    }
}

impl Taylor {
    /// Tries a step of the proposed length.
    fn try_step(&mut self, context: &mut Context, run: &mut Run, step: &mut Step) -> Trial {
        let (end, switch) = step.end(run.last.end_time);
        let h = end - run.last.end_time;
        // What lies behind the switch says nothing about the step up to it.
        self.jet.force(if switch.is_some() { step.branches } else { Choices::default() });
        if let Some(begin) = self.overlooked(context, run, h, step.goal) {
            step.most = begin;
            return rejected(context, begin, None);
        }
        if !is_near_pose(run) && !self.agrees(context, run, h, step.goal) {
            return Trial::Declined;
        }
        let passes = step.located && run.singular.ahead < h;
        // Located before the series at the end begins, which would else have to begin again.
        step.passed = passes.then(|| self.refined(context, run, h));
        if !self.jet.end_found(end, h, &mut self.next) {
            self.jet.evaluate(&run.last.dense, step.order, h, &mut self.next);
        }
        if switch.is_some() && step.located && run.in_zone_of(end, h.max(run.last.natural)) {
            // Nothing may be evaluated there: the next step leaves the pose.
            self.finish(context, run, step, (end, switch));
            return Trial::Done;
        }
        let is_sure = h < SURE * step.natural || is_fall(context, step.order);
        if switch.is_none() && is_sure && self.needs_no_test(context) {
            self.known = Start::Unknown;
            self.accept(context, run, end, true);
            return Trial::Done;
        }
        let goal = if passes { step.goal.max(NOISE_OFF_BRANCH) } else { step.goal };
        let closed = self.start(context, run, end, false).is_some_and(|open| open <= goal);
        if closed && let Some(shorter) = self.too_near(context, run, step, h) {
            return Trial::Shorter(shorter, None);
        }
        if closed && (self.jet.defect(step.order, h) <= goal || self.is_noise(context, run, step, end)) {
            self.conclude(context, run, step, (end, switch));
            return Trial::Done;
        }
        let shorter = rejected(context, 0.5 * h, None);
        let blocked = step.located && run.singular.ahead < h && run.in_zone(run.last.end_time + 0.5 * h);
        if !blocked {
            return shorter;
        }
        // No step passes the pose, and a shorter one would end where nothing may be evaluated.
        if self.finds_avoided(context, run, h) { Trial::Done } else { Trial::Failed(not_passed(context, run)) }
    }

    /// Is the defect of a step next to a singular pose, or across it, what rounding errors make of it?
    fn is_noise(&mut self, context: &mut Context, run: &Run, step: &Step, end: f64) -> bool {
        let passes = step.located && run.passes(end);
        let most = if passes { FLATTENED_DEFECT * step.goal } else { step.goal };
        is_near(run) && self.flattened_defect(context, run, end) <= most
    }

    /// Are there neither loops nor laws that the end of a step could be tested for?
    fn needs_no_test(&self, context: &Context) -> bool {
        let is_even = self.jet.is_even() || !self.jet.has_laws() && self.holds_nothing(context);
        is_even && self.layers.is_empty() && self.next.iter().all(|value| value.is_finite())
    }

    /// Are all loops those of contacts that are open, or of what is removed or not engaged?
    fn holds_nothing(&self, context: &Context) -> bool {
        let first = context.model.layout().discrete();
        let is_idle =
            |mask: &Option<u32>| mask.is_some_and(|mask| context.machine.registers()[first + mask as usize] == 0.0);
        self.masks.iter().all(is_idle)
    }

    /// The length of a shorter step, if this one could go over to another branch, or would end near a singular pose.
    fn too_near(&mut self, context: &mut Context, run: &mut Run, step: &mut Step, h: f64) -> Option<f64> {
        if step.follows {
            return self.guard.jumps().then_some(0.5 * h);
        }
        if !self.guard.ends_near() {
            return None;
        }
        run.singular.ahead = 0.0;
        // The one that was located is none, or not there.
        step.missed |= std::mem::replace(&mut step.located, false);
        let found = if step.missed { None } else { self.locate(context, run, h) };
        let Some(ahead) = found else { return Some(POSE_CUT * h) };
        (run.singular.ahead, run.singular.pose, step.located) = (ahead, Some(run.last.end_time + ahead), true);
        Some(step.planned(ahead))
    }

    /// Accepts a step that has been tested, unless it shows that a singular pose is not what it seemed to be.
    fn conclude(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        step: &mut Step,
        (end, switch): (f64, Option<(f64, Choices)>),
    ) {
        if !step.follows && self.guard.began_near() {
            self.known = Start::Singular;
            return;
        }
        if step.predicted && !step.located {
            step.located = self.locate_behind(context, run, end);
        }
        let passes = step.located && run.passes(end);
        if !step.follows && !passes && self.has_leapt(context, run, end) {
            // Judged again from here, along the curve.
            return;
        }
        self.finish(context, run, step, (end, switch));
    }

    /// Accepts a step to this end, unless the branches do not meet in the pose that it passes.
    fn finish(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        step: &Step,
        (end, switch): (f64, Option<(f64, Choices)>),
    ) {
        let h = end - run.last.end_time;
        if step.located && run.singular.ahead < h && !self.note_passage(context, run, step.passed, end) {
            // Judged again from here, by the step just spoiled.
            return;
        }
        let left = step.located.then_some(f64::max(run.singular.ahead - h, 0.0));
        let falls = run.singular.ahead > 0.0 && run.singular.ahead < PREDICTED * run.last.natural;
        let cut = end == step.limit || falls || switch.is_some() || step.most.is_finite();
        self.accept(context, run, end, cut);
        run.singular.ahead = left.unwrap_or(run.singular.ahead);
        self.enter(switch, step.shortest);
    }

    /// The end of the step becomes that of the run.
    pub(super) fn accept(&mut self, context: &mut Context, run: &mut Run, end: f64, cut: bool) {
        let h = end - run.last.end_time;
        run.singular.ahead = self.guard.ahead(h);
        run.singular.follow_on(self.guard.arrival(h));
        self.guard.roll();
        self.memory.series = Some(self.tight);
        let last = &mut run.last;
        // A step cut short says nothing against the natural length.
        last.natural = if cut { h.max(last.natural) } else { h };
        (last.start_time, last.end_time) = (last.end_time, end);
        last.end.copy_from_slice(&self.next);
        self.memory.unseen = self.memory.unseen.saturating_add(1);
        context.statistics.steps += 1;
    }
}
