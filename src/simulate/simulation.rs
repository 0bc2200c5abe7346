//! One run, from one time to the next at which something is to be done.

use std::io;
use std::sync::Arc;

use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use super::{Experiment, Run, RunError, count, point};

/// A run on its way, which hands over time and the reported values at every communication point.
pub(super) struct Simulation<'a, R> {
    run: &'a Run<'a>,
    pub instance: Instance,
    /// The next communication point, and how many there are.
    next: u64,
    count: u64,
    /// Times at which inputs change, the last one first.
    knots: Vec<f64>,
    values: Vec<f64>,
    report: R,
}

impl<'a, R: FnMut(f64, &[f64]) -> io::Result<()>> Simulation<'a, R> {
    /// Finds the initial state, and reports it.
    ///
    /// # Errors
    /// Values that cannot be set, no initial state, or `report` fails.
    pub fn new(run: &'a Run<'a>, model: Arc<Model>, report: R) -> Result<Self, RunError> {
        let Experiment { start, stop, tolerance, .. } = run.experiment;
        let mut instance = Instance::new(model);
        instance.setup(start, Some(stop), Some(tolerance))?;
        for &(variable, value) in &run.settings {
            instance.set(variable, value)?;
        }
        run.set_inputs(&mut instance, start)?;
        instance.initialise()?;
        let (mut knots, values) = (run.knots(), vec![0.0; run.reported.len()]);
        knots.reverse();
        let mut simulation = Self { run, instance, next: 0, count: count(run.experiment), knots, values, report };
        simulation.advance()?;
        Ok(simulation)
    }

    /// When something is to be done next; none at the end.
    pub fn next_time(&self) -> Option<f64> {
        let point = (self.next < self.count).then(|| point(self.run.experiment, self.next))?;
        Some(self.knots.last().map_or(point, |&knot| knot.min(point)))
    }

    /// Steps to that time, and does it.
    ///
    /// # Errors
    /// The motion cannot be continued, or `report` fails.
    pub fn advance(&mut self) -> Result<(), RunError> {
        let Some(time) = self.next_time() else { return Ok(()) };
        if time > self.instance.time() {
            self.instance.step_to(time)?;
        }
        if self.knots.last() == Some(&time) {
            self.knots.pop();
            self.run.set_inputs(&mut self.instance, time)?;
        }
        if time == point(self.run.experiment, self.next) {
            for (value, &variable) in self.values.iter_mut().zip(&self.run.reported) {
                *value = self.instance.get(variable)?;
            }
            self.next += 1;
            (self.report)(time, &self.values)?;
        }
        Ok(())
    }
}
