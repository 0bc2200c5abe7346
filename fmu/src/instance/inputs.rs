//! Inputs with their derivatives as values of their own, initial values, and steps in parts: what FMI 3.0 asks for.

use super::{Instance, InstanceError};
use crate::program::Source;

impl Instance {
    /// The input that a variable is.
    pub fn input_of(&self, variable: usize) -> Option<usize> {
        match self.model.program().variables.get(variable)?.source {
            Source::Input(index) => Some(index as usize),
            _ => None,
        }
    }

    /// Is a variable neither a parameter nor an input nor time?
    pub fn is_calculated(&self, variable: usize) -> bool {
        let found = self.model.program().variables.get(variable).map(|variable| variable.source);
        !matches!(found, None | Some(Source::Parameter(_) | Source::Input(_) | Source::Time))
    }

    /// The name of an input.
    pub fn input_name(&self, input: usize) -> String {
        self.model.program().inputs[input].name.clone()
    }

    /// An input, or its derivative of order 1 or 2.
    pub fn input(&mut self, input: usize, order: usize) -> f64 {
        self.catch_up();
        self.now.state.input_polynomial(input)[order]
    }

    /// Sets an input or a derivative of it to a finite value, and nothing else: the others keep theirs, unless derivatives follow from values.
    pub fn set_input(&mut self, input: usize, order: usize, value: f64) {
        self.catch_up();
        if order > 0 {
            self.give_derivatives(input);
        } else if self.set_differenced(input, value) {
            return;
        }
        let mut polynomial = self.now.state.input_polynomial(input);
        polynomial[order] = value;
        self.set_polynomial(input, polynomial);
    }

    /// The value or guess that a variable begins with, if that can be set.
    pub fn initial_value(&self, variable: usize) -> Option<f64> {
        let parameter = self.model.program().variables.get(variable)?.initial?;
        self.now.state.parameters().get(parameter as usize).copied()
    }

    /// Can a guess be set, but no value?
    pub fn is_guess(&self, variable: usize) -> bool {
        let parameter = self.model.program().variables.get(variable).and_then(|variable| variable.initial);
        parameter.is_some_and(|parameter| !self.model.is_imposed(parameter as usize))
    }

    /// Adds a change of an input or a derivative of it to the direction.
    pub fn add_input_direction(&mut self, input: usize, order: usize, change: f64) {
        let layout = self.model.layout();
        let first = [layout.inputs(), layout.input_rates(), layout.input_accelerations()][order];
        self.tangent.direction()[first + input] += change;
    }

    /// Adds a change of time alone to the direction.
    pub fn add_time_direction(&mut self, change: f64) {
        let time = self.model.layout().time();
        self.tangent.direction()[time] += change;
    }

    /// Has a parameter or an input changed at this communication point?
    pub fn is_changed(&self) -> bool {
        self.now.run.is_changed()
    }

    /// Moves on to the end of the integrator's next step, or to the end of a communication step that has been checked if that comes first. Says whether a law changes over to another piece there.
    pub fn step_towards(&mut self, time: f64) -> Result<bool, InstanceError> {
        let (from, run) = (self.time(), &self.now.run);
        // A driven mechanism has no steps of its own; and steps that end at communication points are not cut.
        if self.instants.is_some() {
            self.pass_instants(time, true)?;
            return Ok(self.take_happened());
        }
        if !self.model.program().has_own_steps() || run.ends_at_communication_points() {
            self.go_to(time)?;
            return Ok(false);
        }
        if run.is_changed() || run.step_end() <= from {
            // The integrator takes its whole step, of which only the very beginning is looked at.
            self.go_to(from.next_up().min(time))?;
        }
        let end = self.now.run.step_end();
        if self.time() < time.min(end) {
            self.go_to(time.min(end))?;
        }
        Ok(end <= time && self.now.memory.switches())
    }

    /// Makes one step of all parts since the last communication point, before which something had `changed` or not: the future is to depend on that only.
    pub fn join_steps(&mut self, changed: bool) {
        self.now.run.join(changed);
    }
}
