//! Steps of several runs at once: what [`super::stepping`] does for one.

use super::control::Horizon;
use super::memory::Memory;
use super::stepping::Stepper;
use super::taylor::{Motions, Proposed};
use crate::context::{Context, Settings};
use crate::failure::Failure;
use crate::machine::Machine;
use crate::model::Model;
use crate::motion::Run;

/// One of the runs, with what it works with.
pub(crate) struct Member<'a> {
    pub model: &'a Model,
    pub machine: &'a mut Machine,
    pub stepper: &'a mut Stepper,
    pub run: &'a mut Run,
    pub memory: &'a mut Memory,
    pub settings: Settings,
}

impl Member<'_> {
    /// May its next step be found together with those of others?
    pub fn joins(&self, tolerance: f64) -> bool {
        let taylor = self.stepper.taylor.as_ref();
        let same = self.settings.tolerance == tolerance && !self.model.is_driven();
        same && taylor.is_some_and(|taylor| taylor.joins(self.run, self.memory, &self.settings))
    }

    /// Takes the next step by itself. On failure nothing has happened.
    pub fn step_alone(&mut self) -> Result<(), Failure> {
        self.save();
        let Self { model, machine, stepper, run, memory, settings } = self;
        let (mut engines, mut context) = stepper.parts(model, machine, memory, settings);
        let context = &mut context;
        context.machine.load(model, &run.signals.origin);
        let horizon = Horizon { target: run.last.end_time.next_up(), limit: settings.limit() };
        let done = engines.advance(context, run, horizon);
        if done.is_err() {
            self.restore();
        }
        done
    }

    /// Keeps the run before a step that may fail.
    fn save(&mut self) {
        let (run, memory) = &mut self.stepper.checkpoint;
        run.copy_from(self.run);
        memory.copy_from(self.memory);
    }

    /// The run as it was before the step that failed.
    fn restore(&mut self) {
        let (run, memory) = &self.stepper.checkpoint;
        self.run.copy_from(run);
        self.memory.copy_from(memory);
        self.stepper.forget();
    }

    /// Takes its place among the others: what its series need of its parameters.
    pub fn enter(&mut self, motions: &mut Motions, place: usize) {
        self.machine.load(self.model, &self.run.signals.origin);
        motions.enter(place, self.machine.registers(), &self.run.last.end);
    }

    /// What the series need of the signals where the next step begins, or at this time.
    pub fn signal(&mut self, motions: &mut Motions, place: usize, time: Option<f64>) {
        if motions.has_signals() {
            let time = time.unwrap_or(self.run.last.end_time);
            self.machine.load_signals(self.model, &self.run.signals.origin, time);
            motions.signal(place, self.model, self.machine.registers());
        }
    }

    /// Is there a series where it begins?
    pub fn begins(&mut self, motions: &Motions, place: usize) -> bool {
        if let Some(taylor) = &mut self.stepper.taylor {
            taylor.join(|reciprocal_pivots| motions.reciprocal_pivots(place, reciprocal_pivots));
        }
        motions.is_regular(place)
    }

    /// The next step, of this length if nothing else limits it; none if it must be taken alone.
    pub fn propose(&mut self, motions: &Motions, place: usize, length: f64) -> Option<Proposed> {
        let Self { model, machine, stepper, run, settings, .. } = self;
        let Stepper { projection, statistics, taylor, .. } = &mut **stepper;
        let context = Context { model, machine, projection, statistics, settings };
        let step = taylor.as_mut()?.propose_with(&context, run, (motions, place), length)?;
        run.last.order = motions.order() as u32;
        motions.polynomial(place, &mut run.last.dense);
        Some(step)
    }

    /// Accepts the step; false if it must be taken alone.
    ///
    /// # Errors
    /// What is wrong where it ends. Nothing has happened then.
    pub fn conclude(&mut self, motions: &Motions, place: usize, step: &Proposed) -> Result<bool, Failure> {
        // Nothing else at the end of a step can fail.
        let may_fail = self.run.singular.trail.decides();
        if may_fail {
            self.save();
        }
        let Self { model, machine, stepper, run, memory, settings } = self;
        let (mut engines, mut context) = stepper.parts(model, machine, memory, settings);
        let context = &mut context;
        let Some(taylor) = engines.taylor.as_deref_mut() else { return Ok(false) };
        if !taylor.conclude_with(context, (run, engines.memory), step, motions, place) {
            return Ok(false);
        }
        let done = engines.conclude(context, run, motions.amplification(place));
        if done.is_err() {
            self.restore();
        }
        done.map(|()| true)
    }
}
