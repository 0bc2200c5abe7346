//! Single runs: one for the results, several for the time.

use std::sync::Arc;
use std::time::Duration;

use cotree::model::Experiment;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::machine::Machine;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use thiserror::Error;

use super::clock::{Clock, Elapsed};
use super::trajectory::Trajectory;

/// Results are compared at so many times at equal distances, and at so many within a step: its polynomial has few extrema.
pub(crate) const POINTS: usize = 1024;
const POINTS_A_STEP: usize = 6;
/// A run of more steps than this is looked at by so many of them.
const MOST_STOPS: f64 = 1e5;
/// In so many steps at most, and at so many extrema: values are read from polynomials, but all of them are kept.
const MOST_STEPS: usize = 2048;
const MOST_EXTREMA: usize = 4096;
/// Repetitions take so long together, at least.
const LONG_ENOUGH: Duration = Duration::from_millis(20);
const ENERGY: &str = "energy.total";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Budget {
    Run,
    Reference,
}

/// Why a run or a measurement has no result.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BenchError {
    /// It costs more than its budget.
    #[error("it takes too long")]
    TooLong,
    /// Anything else, as a message.
    #[error("{0}")]
    Other(String),
}

cotree::diagnostic::from_messages!(BenchError as BenchError::Other: InstanceError);

pub struct BenchSubject<'a> {
    pub model: &'a Arc<Model>,
    pub variables: &'a [usize],
    pub experiment: Experiment,
}

pub struct TimedMotion {
    pub trajectory: Trajectory,
    energy: Vec<f64>,
    pub residual: f64,
    /// The simulation at its end.
    pub instance: Instance,
}

impl BenchSubject<'_> {
    /// The variables at these times.
    ///
    /// # Errors
    /// The motion cannot be continued, or it takes too long.
    pub fn run(
        &self,
        engine: Option<Engine>,
        tolerance: f64,
        budget: Budget,
        times: &[f64],
    ) -> Result<TimedMotion, BenchError> {
        let most = self.most(budget);
        let mut instance = self.start(engine, tolerance)?;
        let mut machine = Machine::new(self.model);
        let energy = instance.variable(ENERGY);
        let mut trajectory = Trajectory::of(self.variables.len());
        let (mut energies, mut worst) = (Vec::new(), 0.0);
        for &time in times {
            if time > instance.time() {
                instance.step_to(time)?;
            }
            if instance.statistics().evaluations > most {
                return Err(BenchError::TooLong);
            }
            for (row, &variable) in trajectory.values.iter_mut().zip(self.variables) {
                row.push(instance.reading(variable)?);
            }
            if let Some(energy) = energy {
                energies.push(instance.reading(energy)?);
            }
            worst = f64::max(worst, residual(self.model, &mut machine, &instance));
        }
        Ok(TimedMotion { trajectory, energy: energies, residual: worst, instance })
    }

    /// How long the fastest of several repetitions takes, and all of them.
    pub(crate) fn time(&self, engine: Option<Engine>, tolerance: f64) -> Option<(Duration, Elapsed)> {
        let (mut fastest, mut total) = (Duration::MAX, Elapsed::default());
        while total.processor < LONG_ENOUGH {
            let mut instance = self.start(engine, tolerance).ok()?;
            let clock = Clock::now();
            instance.step_to(self.experiment.stop).ok()?;
            let elapsed = clock.elapsed();
            fastest = fastest.min(elapsed.processor);
            // Terminates even if the clock does not advance.
            total.add(Elapsed { processor: elapsed.processor.max(Duration::from_micros(1)), ..elapsed });
        }
        Some((fastest, total))
    }

    /// The simulation at its start.
    ///
    /// # Errors
    /// There is no consistent one.
    pub fn start(&self, engine: Option<Engine>, tolerance: f64) -> Result<Instance, BenchError> {
        let mut instance = Instance::new(self.model.clone());
        let Experiment { start, stop, .. } = self.experiment;
        let setup = instance.setup(start, Some(stop), Some(tolerance));
        let engine = setup.and_then(|()| engine.map_or(Ok(()), |engine| instance.set_engine(engine)));
        engine.and_then(|()| instance.initialise())?;
        Ok(instance)
    }

    /// When results are compared: at equal distances, within the steps of this run, which are short where much happens, and where its variables turn back.
    pub fn times(&self, engine: Option<Engine>, tolerance: f64) -> Result<Vec<f64>, BenchError> {
        let mut times = self.even(POINTS);
        times.extend(within(&self.step_ends(engine, tolerance)?));
        times.sort_by(f64::total_cmp);
        times.dedup();
        let trajectory = self.run(engine, tolerance, Budget::Reference, &times)?.trajectory;
        let mut extrema = trajectory.extrema(&times);
        extrema.truncate(MOST_EXTREMA);
        times.extend(extrema);
        times.sort_by(f64::total_cmp);
        times.dedup();
        Ok(times)
    }

    /// Where steps of a run begin and end.
    fn step_ends(&self, engine: Option<Engine>, tolerance: f64) -> Result<Vec<f64>, BenchError> {
        let Experiment { start, stop, .. } = self.experiment;
        let least = (stop - start) / MOST_STOPS;
        let most = self.most(Budget::Reference);
        let mut instance = self.start(engine, tolerance)?;
        let mut ends = vec![start];
        while instance.time() < stop {
            // Just beyond the last step: so the next one is taken.
            let next = instance.end_of_step().next_up().max(instance.time() + least).min(stop);
            instance.step_to(next)?;
            if instance.statistics().evaluations > most {
                return Err(BenchError::TooLong);
            }
            ends.push(instance.end_of_step().min(stop));
        }
        Ok(ends)
    }

    /// More evaluations than this take too long.
    fn most(&self, budget: Budget) -> u64 {
        let cost = self.model.program().tapes.acceleration.instructions().len().max(1) as u64;
        if budget == Budget::Run { 300_000_000 / cost } else { 2_000_000_000 / cost }
    }

    pub fn even(&self, count: usize) -> Vec<f64> {
        let Experiment { start, stop, .. } = self.experiment;
        let at = |point: usize| start + (stop - start) * point as f64 / count as f64;
        (0..count).map(at).chain([stop]).collect()
    }
}

/// Times within steps that end there. Of many steps, of each few neighbours the shortest: there the motion is fastest.
fn within(ends: &[f64]) -> impl Iterator<Item = f64> {
    let steps: Vec<[f64; 2]> = ends.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    let length = |step: &[f64; 2]| step[1] - step[0];
    let neighbours = steps.len().div_ceil(MOST_STEPS).max(1);
    let shortest = |steps: &[[f64; 2]]| steps.iter().copied().min_by(|a, b| length(a).total_cmp(&length(b)));
    let chosen: Vec<[f64; 2]> = steps.chunks(neighbours).filter_map(shortest).collect();
    let places = |[from, to]: [f64; 2]| {
        (1..=POINTS_A_STEP).map(move |place| from + (to - from) * place as f64 / POINTS_A_STEP as f64)
    };
    chosen.into_iter().flat_map(places)
}

/// The largest residual of the loop equations, relative to their scales.
fn residual(model: &Model, machine: &mut Machine, instance: &Instance) -> f64 {
    let tape = &model.program().tapes.constraint;
    machine.load(model, &instance.state());
    machine.run(tape);
    let constraints = model.program().constraints.iter().enumerate();
    constraints.fold(0.0, |worst: f64, (row, constraint)| worst.max(machine.result(tape, row).abs() / constraint.scale))
}

impl TimedMotion {
    /// The largest change of the energy, relative to its largest value, if the energy is computed.
    pub fn energy_drift(&self) -> Option<f64> {
        let start = *self.energy.first()?;
        let largest = self.energy.iter().fold(f64::MIN_POSITIVE, |largest, energy| largest.max(energy.abs()));
        Some(self.energy.iter().map(|energy| (energy - start).abs() / largest).fold(0.0, f64::max))
    }
}
