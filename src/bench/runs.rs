//! Single runs: once for what they find, again for how long they take.

use std::sync::Arc;
use std::time::{Duration, Instant};

use cotree_fmu::instance::Instance;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use cotree_fmu::solver::Statistics;

use crate::mechanism::Experiment;

/// Points of time at which results are compared.
const POINTS: u32 = 64;
/// Repetitions take so long together, at least.
const LONG_ENOUGH: Duration = Duration::from_millis(20);
/// A variable that stays below this [SI units] is compared by its absolute error.
const SMALL: f64 = 1e-6;
/// What is wrong with a run that costs more than it may.
pub(super) const TOO_LONG: &str = "it takes too long";
/// The name of the system's energy.
const ENERGY: &str = "energy.total";

/// How much work a run may be, in operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Budget {
    /// One of many.
    Run,
    /// The one that all others are compared with.
    Reference,
}

/// The motion at the compared times.
pub(super) struct Trajectory {
    /// One row for each variable.
    values: Vec<Vec<f64>>,
    energy: Vec<f64>,
    /// Largest residual of the loop equations.
    pub residual: f64,
    pub statistics: Statistics,
}

/// Moves the model through the experiment.
pub(super) fn run(
    model: &Arc<Model>,
    variables: &[usize],
    experiment: Experiment,
    engine: Option<Engine>,
    tolerance: f64,
    budget: Budget,
) -> Result<Trajectory, String> {
    let cost = model.program().tapes.acceleration.instructions.len().max(1) as u64;
    let most = if budget == Budget::Run { 300_000_000 } else { 2_000_000_000 } / cost;
    let mut instance = start(model, experiment, engine, tolerance)?;
    let mut machine = Machine::new(model);
    let energy = instance.variable(ENERGY);
    let values = vec![Vec::new(); variables.len()];
    let mut found = Trajectory { values, energy: Vec::new(), residual: 0.0, statistics: Statistics::default() };
    for point in 0..=POINTS {
        advance(&mut instance, time_of(experiment, point), most)?;
        for (row, &variable) in found.values.iter_mut().zip(variables) {
            row.push(instance.get(variable).map_err(|error| error.to_string())?);
        }
        if let Some(energy) = energy {
            found.energy.push(instance.get(energy).map_err(|error| error.to_string())?);
        }
        found.residual = found.residual.max(residual(model, &mut machine, &instance));
    }
    found.statistics = instance.statistics();
    Ok(found)
}

/// How long the fastest of several repetitions takes \[s\].
pub(super) fn time(model: &Arc<Model>, experiment: Experiment, engine: Option<Engine>, tolerance: f64) -> f64 {
    let (mut fastest, mut total) = (f64::INFINITY, Duration::ZERO);
    while total < LONG_ENOUGH {
        let Ok(mut instance) = start(model, experiment, engine, tolerance) else { return f64::NAN };
        let begin = Instant::now();
        if instance.step_to(experiment.stop).is_err() {
            return f64::NAN;
        }
        let elapsed = begin.elapsed();
        fastest = fastest.min(elapsed.as_secs_f64());
        // Even a clock that stands still comes to an end.
        total += elapsed.max(Duration::from_micros(10));
    }
    fastest
}

fn start(
    model: &Arc<Model>,
    experiment: Experiment,
    engine: Option<Engine>,
    tolerance: f64,
) -> Result<Instance, String> {
    let mut instance = Instance::new(model.clone());
    let Experiment { start, stop, .. } = experiment;
    let setup = instance.setup(start, Some(stop), Some(tolerance));
    let engine = setup.and_then(|()| engine.map_or(Ok(()), |engine| instance.set_engine(engine)));
    engine.and_then(|()| instance.initialise()).map_err(|error| error.to_string())?;
    Ok(instance)
}

fn time_of(experiment: Experiment, point: u32) -> f64 {
    let Experiment { start, stop, .. } = experiment;
    if point == POINTS { stop } else { start + (stop - start) * f64::from(point) / f64::from(POINTS) }
}

/// Moves on in parts, so that a run without end is noticed.
fn advance(instance: &mut Instance, target: f64, most: u64) -> Result<(), String> {
    const PARTS: u32 = 16;
    let from = instance.time();
    for part in 1..=PARTS {
        let time = if part == PARTS { target } else { from + (target - from) * f64::from(part) / f64::from(PARTS) };
        if time > instance.time() {
            instance.step_to(time).map_err(|error| error.to_string())?;
        }
        if instance.statistics().evaluations > most {
            return Err(TOO_LONG.to_owned());
        }
    }
    Ok(())
}

/// The largest residual of the loop equations, relative to their scales.
fn residual(model: &Model, machine: &mut Machine, instance: &Instance) -> f64 {
    let tape = &model.program().tapes.constraint;
    machine.load(model, &instance.state());
    machine.run(tape);
    let constraints = model.program().constraints.iter().enumerate();
    constraints.fold(0.0, |worst: f64, (row, constraint)| worst.max(machine.result(tape, row).abs() / constraint.scale))
}

impl Trajectory {
    /// The largest error of any variable at any time, relative to the variable's largest value.
    pub fn distance(&self, exact: &Self) -> f64 {
        let rows = self.values.iter().zip(&exact.values).map(|(values, exact)| {
            let largest = exact.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
            let scale = if largest > SMALL { largest } else { 1.0 };
            values.iter().zip(exact).map(|(value, exact)| (value - exact).abs() / scale).fold(0.0, f64::max)
        });
        rows.fold(0.0, f64::max)
    }

    /// The largest change of the energy, relative to its largest value, if the energy is computed.
    pub fn energy_drift(&self) -> Option<f64> {
        let start = *self.energy.first()?;
        let largest = self.energy.iter().fold(f64::MIN_POSITIVE, |largest, energy| largest.max(energy.abs()));
        Some(self.energy.iter().map(|energy| (energy - start).abs() / largest).fold(0.0, f64::max))
    }
}
