//! A simulation from the outside: parameters, inputs over time, results at regular times.

mod gaps;
mod journey;
mod log;
mod many;
mod measure;
mod members;
mod results;
pub mod settings;

use std::sync::Arc;

use cotree_fmu::instance::{Inaccuracy, Instance, InstanceError, TOLERANCES};
use cotree_fmu::model::Model;
use cotree_fmu::program::check::ProgramError;

use crate::export::description::Description;
use crate::model::Experiment;
use crate::report::csv::CsvTable;
pub use gaps::Gaps;
use journey::{Journey, travel};
pub use log::{Logged, What};
pub use many::{Ended, Ensemble, Settings};
pub use measure::{Measure, MeasureError, Statistic};
pub use results::{Column, Results, SimulateError};
pub use settings::SettingError;

/// What to simulate.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    pub description: &'a Description,
    /// Times and tolerance.
    pub experiment: Experiment,
    /// Variables and the values they are set to.
    pub settings: Vec<(usize, f64)>,
    /// Inputs over time: variable and column of the table.
    pub inputs: Option<(&'a CsvTable, Vec<usize>)>,
    /// Variables to report.
    pub reported: Vec<usize>,
}

/// How a run ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finish {
    /// That rounding errors are larger than the tolerance, if they are.
    pub inaccuracy: Option<Inaccuracy>,
    /// Events of the scene, and how often each has happened.
    pub events: Vec<(String, u32)>,
    /// Everything that has happened, in order: events, and what limits, contacts and ropes have done.
    pub log: Vec<Logged>,
    /// The event that has ended the run before its stop time, and when \[s\].
    pub ended: Option<(String, f64)>,
}

/// Why a simulation ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The runtime refuses the program.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// The instance refused.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// A result could not be handed over.
    #[error(transparent)]
    Output(#[from] std::io::Error),
}

/// A run that has failed: why, and what had happened until then.
#[derive(Debug, thiserror::Error)]
#[error("{error}")]
pub struct FailedRun {
    /// Why.
    #[source]
    pub error: RunError,
    /// Everything that has happened before, in order.
    pub log: Vec<Logged>,
}

impl From<FailedRun> for RunError {
    fn from(failed: FailedRun) -> Self {
        failed.error
    }
}

impl Run<'_> {
    /// Simulates, and hands over the reported values at every communication point; one that has none there is NaN. An event of the scene may end the run: the values there are the last ones.
    ///
    /// # Errors
    /// Values that cannot be set, a motion that cannot be continued, or `report` fails.
    pub fn start(
        &self,
        model: Arc<Model>,
        report: impl FnMut(f64, &[f64]) -> std::io::Result<()>,
    ) -> Result<Finish, RunError> {
        self.start_in(&mut Instance::new(model), report)
    }

    /// The same in an instance of the model that may have simulated before: a new one takes as long as some steps.
    ///
    /// # Errors
    /// As of [`Run::start`].
    pub fn start_in(
        &self,
        instance: &mut Instance,
        report: impl FnMut(f64, &[f64]) -> std::io::Result<()>,
    ) -> Result<Finish, RunError> {
        Ok(self.start_at(instance, points(self.experiment), report)?)
    }

    /// The same with other communication points: ascending times within the experiment \[s\].
    ///
    /// # Errors
    /// As of [`Run::start`], with what has happened before.
    pub fn start_at(
        &self,
        instance: &mut Instance,
        times: impl IntoIterator<Item = f64>,
        report: impl FnMut(f64, &[f64]) -> std::io::Result<()>,
    ) -> Result<Finish, FailedRun> {
        let mut journey = Journey::new(self, report);
        travel(&mut journey, instance, times.into_iter());
        journey.end(instance)
    }

    /// The initial state.
    fn begin(&self, instance: &mut Instance) -> Result<(), RunError> {
        let Experiment { start, stop, tolerance, .. } = self.experiment;
        instance.reset();
        instance.setup(start, Some(stop), Some(tolerance))?;
        for &(variable, value) in &self.settings {
            instance.set(variable, value)?;
        }
        self.set_inputs(instance, start)?;
        instance.record_instants();
        Ok(instance.initialise()?)
    }

    /// Sets the inputs as [`set_inputs`] does, if there are any.
    fn set_inputs(&self, instance: &mut Instance, time: f64) -> Result<(), RunError> {
        let Experiment { start, stop, .. } = self.experiment;
        let Some((table, variables)) = &self.inputs else { return Ok(()) };
        Ok(set_inputs(instance, (table, variables), time, time > start && time == stop)?)
    }
}

/// Sets inputs and their rates to the table's: of each column one variable. They are constant until the next row, so this is done at the rows only
/// and the result does not depend on how often it is reported. Where the run stops nothing follows: the rates are those of the way there.
///
/// # Errors
/// A value that cannot be set.
pub fn set_inputs(
    instance: &mut Instance,
    (table, variables): (&CsvTable, &[usize]),
    time: f64,
    stops: bool,
) -> Result<(), InstanceError> {
    for (column, &variable) in variables.iter().enumerate() {
        let (value, after) = table.at(column, time);
        let rate = if stops { table.rate_before(column, time) } else { after };
        instance.set(variable, value)?;
        instance.set_derivative(variable, 1, rate)?;
    }
    Ok(())
}

/// Times of a table's rows after the start of a run and up to its end, each once.
pub fn knots(table: &CsvTable, [start, stop]: [f64; 2]) -> Vec<f64> {
    let mut knots: Vec<f64> = table.times().iter().copied().filter(|&time| time > start && time <= stop).collect();
    knots.dedup();
    knots
}

/// More values than this at one go are a mistake in the step or the stop.
const MOST_POINTS: u64 = 100_000_000;

/// Can a run have these times and this tolerance?
///
/// # Errors
/// What cannot be, `stop`, `step` or `tolerance`, and why.
pub fn check(experiment: Experiment) -> Result<(), (&'static str, String)> {
    let Experiment { start, stop, step, tolerance } = experiment;
    if !start.is_finite() || !stop.is_finite() || stop < start {
        Err(("stop", format!("the stop time, {stop:?} s, is before the start, {start:?} s")))
    } else if !(step > 0.0 && step.is_finite()) {
        Err(("step", format!("the step is {step:?} s, but must be positive")))
    } else if count(experiment) > MOST_POINTS {
        Err(("step", format!("a step of {step:?} s up to {stop:?} s gives more than {MOST_POINTS} rows")))
    } else if !(TOLERANCES[0]..=TOLERANCES[1]).contains(&tolerance) {
        let [finest, coarsest] = TOLERANCES;
        Err((
            "tolerance",
            format!(
                "the tolerance is {tolerance:e}, but must be between {finest:e} (the limit of double precision) and {coarsest}"
            ),
        ))
    } else {
        Ok(())
    }
}

/// Start, every full step, and stop; computed from the start, so that rounding does not add up.
pub fn points(experiment: Experiment) -> impl Iterator<Item = f64> + Clone {
    (0..count(experiment)).map(move |index| point(experiment, index))
}

/// One of them.
fn point(experiment: Experiment, index: u64) -> f64 {
    let Experiment { start, stop, step, .. } = experiment;
    if index < steps(experiment) { start + index as f64 * step } else { stop }
}

/// How many points [`points`] gives.
pub fn count(experiment: Experiment) -> u64 {
    steps(experiment).saturating_add(1)
}

/// A last step that is short only by rounding is no step of its own.
fn steps(Experiment { start, stop, step, .. }: Experiment) -> u64 {
    ((stop - start) / step * (1.0 - 1e-12) - 1e-9).ceil().max(0.0) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(start: f64, stop: f64, step: f64) -> Vec<f64> {
        let experiment = Experiment { start, stop, step, tolerance: 1e-6 };
        let times: Vec<f64> = points(experiment).collect();
        assert_eq!(times.len() as u64, count(experiment));
        times
    }

    #[test]
    fn points_end_exactly_at_the_stop() {
        assert_eq!(times(0.0, 0.3, 0.1).len(), 4);
        assert_eq!(times(0.0, 0.3, 0.1).last(), Some(&0.3));
        assert_eq!(times(0.0, 1.0, 0.4), [0.0, 0.4, 0.8, 1.0]);
        assert_eq!(times(0.0, 10.0, 1e-3).len(), 10_001);
        assert_eq!(times(1.0, 1.0, 0.1), [1.0]);
        assert_eq!(times(0.0, 0.05, 0.1), [0.0, 0.05]);
    }
}
