//! Jacobians and factors of an implicit step, and the first guess of its stages.

use super::radau::evaluate;
use super::{IMPLICIT_OVERLOOKED, Implicit, ImplicitMemory, second_derivative};
use crate::context::Context;
use crate::model::State;
use crate::motion::Run;

/// Where in a step the Jacobian is evaluated, if the motion before says what is there.
const MIDDLE: f64 = 0.6;
/// The motion before is continued over at most so many times its last step for a first guess.
const EXTRAPOLATED: f64 = 8.0;

impl Implicit {
    /// Puts q at a state between the ends of the last step, projected there, where stiff springs are as tight as the motion of the step demands: a small error of the
    /// positions is a large one of the forces.
    pub fn tighten(&mut self, context: &mut Context, run: &Run, memory: &mut ImplicitMemory, state: &mut State) {
        std::mem::swap(&mut self.memory, memory);
        self.restore_factors(context, run);
        std::mem::swap(&mut self.memory, memory);
        let Context { model, machine, .. } = context;
        machine.load(model, state);
        machine.evaluate(&model.program().tapes.acceleration, &mut self.column);
        let dt = state.time() - run.last.start_time;
        let q = state.positions_mut();
        for (index, place) in self.column.iter_mut().enumerate() {
            *place -= second_derivative(&run.last.dense, q.len(), index, dt);
        }
        self.radau.correct(&mut self.column);
        let share = self.share(context.settings.tolerance);
        let mut coordinates = context.model.program().coordinates.iter().zip(&self.column);
        // More is no spring's: a law has another value at this very instant. Written so that NaN is left alone too.
        let small =
            coordinates.all(|(coordinate, change)| change.abs() <= IMPLICIT_OVERLOOKED * share * coordinate.scale);
        if small {
            q.iter_mut().zip(&self.column).for_each(|(q, change)| *q += change);
        }
    }

    /// The factors of the last step, if they were lost with a saved state.
    fn restore_factors(&mut self, context: &mut Context, run: &Run) {
        if !self.current {
            self.differentiate(context, run);
        }
        if self.radau.factored() != self.memory.step {
            self.radau.factor(self.memory.step);
        }
    }

    /// Makes a place within the next step, as the motion before promises it, that of the Jacobian: it serves all nodes alike.
    pub(super) fn anchor_ahead(&mut self, context: &mut Context, run: &mut Run) {
        let before = run.last.end_time - run.last.start_time;
        if !self.memory.smooth || run.last.natural == 0.0 || run.last.natural > EXTRAPOLATED * before {
            return self.anchor_at_the_start(context, run);
        }
        let ImplicitMemory { anchor, anchored, .. } = &mut self.memory;
        anchor[0] = run.last.end_time + MIDDLE * run.last.natural;
        evaluate(&run.last.dense, before + MIDDLE * run.last.natural, &mut anchor[1..]);
        *anchored = true;
        self.differentiate(context, run);
    }

    /// Makes the start of the step the place of the Jacobian, if it is not.
    pub(super) fn anchor_at_the_start(&mut self, context: &mut Context, run: &mut Run) {
        let ImplicitMemory { anchor, anchored, .. } = &mut self.memory;
        if *anchored && anchor[0] == run.last.end_time && self.current {
            return;
        }
        anchor[0] = run.last.end_time;
        anchor[1..].copy_from_slice(&run.last.end);
        *anchored = true;
        self.differentiate(context, run);
    }

    /// The Jacobian at the anchor.
    pub(super) fn differentiate(&mut self, context: &mut Context, run: &Run) {
        let Context { model, machine, .. } = context;
        let ImplicitMemory { anchor, .. } = &self.memory;
        machine.load_signals(model, &run.signals.origin, anchor[0]);
        machine.load_motion(model, &anchor[1..]);
        let (by_q, by_v) = self.radau.jacobian_mut();
        self.batched.differentiate(model, machine, by_q, by_v);
        self.current = true;
        context.statistics.jacobians += 1;
    }

    /// Jacobians, if each stage has its own, and factors for a step of that length; false if there are none.
    pub(super) fn linearise(&mut self, context: &mut Context, run: &mut Run, h: f64) -> bool {
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
        radau.last_stage((run.last.end_time, h), &mut self.memory.anchor);
        (self.memory.anchored, self.current) = (true, true);
        regular
    }

    /// A first guess of the stages.
    pub(super) fn guess(&mut self, run: &Run, h: f64) {
        let before = run.last.end_time - run.last.start_time;
        if !self.memory.smooth || h > EXTRAPOLATED * before {
            return self.radau.guess_nothing();
        }
        self.radau.guess(&run.last.end, |node, motion| {
            evaluate(&run.last.dense, before + node * h, motion);
        });
    }
}
