//! What accuracy costs: errors and work at several tolerances, measured on the model itself. Work is counted, not timed, so
//! the same model gives the same figures everywhere.

use std::sync::Arc;

use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use cotree_fmu::series::Jet;
use cotree_fmu::solver::Statistics;

use super::curve::Curve;
use crate::mechanism::Experiment;

/// The tolerances that are measured.
const TOLERANCES: [f64; 7] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];
/// The tolerance of the run that counts as exact.
pub const REFERENCE: f64 = 1e-12;
/// Points of time at which results are compared.
const POINTS: u32 = 64;
/// About how many operations the reference run may take. Longer experiments are measured on their first part only.
const BUDGET: u64 = 50_000_000;
/// The shortest part of an experiment that is measured is 2^-HALVINGS of it: for motion that is absurdly fast.
const HALVINGS: i32 = 100;
/// A variable that stays below this [SI units] is compared by its absolute error.
const SMALL: f64 = 1e-6;

/// Errors and work of one model at its default parameters and inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// When the measurement starts and ends \[s\].
    pub span: [f64; 2],
    /// What integrated.
    pub engine: Engine,
    /// One for each tolerance.
    pub measurements: Vec<Measurement>,
}

/// What one tolerance gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Relative tolerance.
    pub tolerance: f64,
    /// Largest error of any variable at any time, relative to the variable's largest value.
    pub error: f64,
    /// What the solver did.
    pub statistics: Statistics,
}

/// Simulates the model at each tolerance and compares the variables with those of a run at [`REFERENCE`].
///
/// # Errors
/// The model cannot be simulated.
pub fn measure(model: &Arc<Model>, variables: &[usize], experiment: Experiment) -> Result<Accuracy, InstanceError> {
    let part = Experiment { stop: affordable(model, experiment)?, ..experiment };
    let (exact, _) = run(model, variables, part, REFERENCE)?;
    let measurements = TOLERANCES.into_iter().map(|tolerance| -> Result<_, InstanceError> {
        let (values, statistics) = run(model, variables, part, tolerance)?;
        Ok(Measurement { tolerance, error: largest_error(&values, &exact), statistics })
    });
    let span = [part.start, part.stop];
    Ok(Accuracy { span, engine: model.program().engine, measurements: measurements.collect::<Result<_, _>>()? })
}

/// When a run at the reference tolerance has used up its budget. Stops where it stands after parts of the experiment that
/// double in length, so it never takes much more than that.
fn affordable(model: &Arc<Model>, experiment: Experiment) -> Result<f64, InstanceError> {
    let tape = model.program().tapes.acceleration.instructions.len().max(1) as u64;
    let cost = Jet::new(model).map_or(tape, |jet| jet.cost() as u64);
    let mut instance = start(model, experiment, REFERENCE)?;
    for halvings in (1..=HALVINGS).rev() {
        let time = experiment.start + (experiment.stop - experiment.start) * 0.5f64.powi(halvings);
        if time > instance.time() {
            instance.step_to(time)?;
        }
        if instance.statistics().evaluations * cost > BUDGET / 2 {
            return Ok(time);
        }
    }
    Ok(experiment.stop)
}

/// The variables at all points of time, and what the solver did.
fn run(
    model: &Arc<Model>,
    variables: &[usize],
    part: Experiment,
    tolerance: f64,
) -> Result<(Vec<Vec<f64>>, Statistics), InstanceError> {
    let mut instance = start(model, part, tolerance)?;
    let mut values = vec![Vec::new(); variables.len()];
    for point in 1..=POINTS {
        let time = part.start + (part.stop - part.start) * f64::from(point) / f64::from(POINTS);
        if time > instance.time() {
            instance.step_to(time)?;
        }
        for (values, &variable) in values.iter_mut().zip(variables) {
            values.push(instance.get(variable)?);
        }
    }
    Ok((values, instance.statistics()))
}

fn start(model: &Arc<Model>, experiment: Experiment, tolerance: f64) -> Result<Instance, InstanceError> {
    let mut instance = Instance::new(model.clone());
    instance.setup(experiment.start, Some(experiment.stop), Some(tolerance))?;
    instance.initialise()?;
    Ok(instance)
}

fn largest_error(values: &[Vec<f64>], exact: &[Vec<f64>]) -> f64 {
    let errors = values.iter().zip(exact).map(|(values, exact)| {
        let largest = exact.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let scale = if largest > SMALL { largest } else { 1.0 };
        values.iter().zip(exact).map(|(value, exact)| (value - exact).abs() / scale).fold(0.0, f64::max)
    });
    errors.fold(0.0, f64::max)
}

impl Accuracy {
    /// What the work is counted in.
    pub fn work(&self) -> &'static str {
        match self.engine {
            Engine::Taylor => "Taylor series",
            Engine::Dop853 | Engine::Radau => "evaluations of the accelerations",
        }
    }

    /// Errors over evaluations, if there is a curve to draw.
    pub fn curve(&self) -> Option<Curve> {
        let points = self.measurements.iter().map(|measurement| {
            let label = format!("{:e}", measurement.tolerance);
            ([measurement.statistics.evaluations as f64, measurement.error], label)
        });
        let points: Vec<_> = points.filter(|([x, y], _)| *x > 0.0 && *y > 0.0).collect();
        let title = "error over work, at each tolerance".into();
        let axes = [self.work().into(), "largest relative error".into()];
        (points.len() > 1).then_some(Curve { title, axes, points })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_relative_to_the_largest_value() {
        let exact = [vec![100.0, -200.0], vec![0.0, 1e-9]];
        assert_eq!(largest_error(&[vec![100.0, -198.0], vec![0.0, 1e-9]], &exact), 0.01);
        assert!((largest_error(&[vec![100.0, -200.0], vec![0.0, 1e-9 + 0.5]], &exact) - 0.5).abs() < 1e-12);
    }
}
