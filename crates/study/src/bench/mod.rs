//! Speed against error of a model: every method at many tolerances, against a converged reference.

pub(crate) mod clock;
mod reference;
pub mod runs;
mod table;
pub mod trajectory;

use std::sync::Arc;

use cotree::model::Experiment;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use serde::{Serialize, Serializer};

use clock::Elapsed;
pub use reference::{Reference, ReferenceComparison};
pub use runs::BenchError;
use runs::{BenchSubject, Budget, TimedMotion};

const TOLERANCES: [f64; 10] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12];
/// An error that is not above so many times that of the reference may be the reference's own.
const RESOLVED: f64 = 3.0;
/// The energy counts as kept if the reference changes it by less than this, relative to its largest value.
const KEPT: f64 = 1e-8;
/// A thread that has less than this share of a processor is on a busy machine.
const BUSY: f64 = 0.9;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bench {
    pub name: String,
    /// When the measurement starts and ends \[s\].
    pub span: [f64; 2],
    pub reference: Reference,
    pub points: usize,
    /// What the clock measures: processor time of the thread, or wall time where the platform does not measure it.
    pub clock: &'static str,
    /// The share of a processor that the measured thread had.
    pub share: f64,
    pub energy_kept: bool,
    /// Relative accuracy that rounding errors permit, the coarsest of all runs; 0 if nothing limits it.
    pub attainable: f64,
    /// One for each method and tolerance, methods together.
    pub runs: Vec<BenchRun>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BenchRun {
    /// `auto`, `taylor`, `explicit`, `implicit`, or `loops` if the drivers determine the motion.
    pub method: &'static str,
    pub tolerance: f64,
    #[serde(flatten, serialize_with = "flat")]
    pub result: Result<MeasuredRun, BenchError>,
}

/// What a run without result is written as: every number is null.
#[derive(Serialize)]
struct Unmeasured {
    cpu_seconds: Option<f64>,
    error: Option<f64>,
    steps: Option<u64>,
    evaluations: Option<u64>,
    problem: String,
}

fn flat<S: Serializer>(result: &Result<MeasuredRun, BenchError>, serializer: S) -> Result<S::Ok, S::Error> {
    match result {
        Ok(measured) => measured.serialize(serializer),
        Err(problem) => {
            let problem = problem.to_string();
            Unmeasured { cpu_seconds: None, error: None, steps: None, evaluations: None, problem }.serialize(serializer)
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeasuredRun {
    /// Time of the fastest of several repetitions, initialisation and outputs left out \[s\]; null if one of them failed.
    pub cpu_seconds: Option<f64>,
    /// Largest error of any reported variable at any of the compared times, relative to the variable's largest value.
    pub error: f64,
    /// Is the error clearly above that of the reference?
    pub resolved: bool,
    pub steps: u64,
    pub rejected: u64,
    /// Evaluations of the accelerations, or series of the motion.
    pub evaluations: u64,
    pub factorisations: u64,
    pub jacobians: u64,
    /// Largest residual of the loop equations at the compared times, relative to their scales.
    pub constraint_residual: f64,
    /// Largest change of the energy, relative to its largest value; only where the motion keeps it.
    pub energy_drift: Option<f64>,
}

/// A method: what it is called, and the engine, unless the program chooses.
type Method = (&'static str, Option<Engine>);

/// A run that is about to be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Next {
    pub method: &'static str,
    pub tolerance: f64,
    /// How many runs have been measured, and how many there are.
    pub done: usize,
    pub all: usize,
}

/// Measures a model.
///
/// # Errors
/// There is no reference: the model cannot be simulated, or not in reasonable time.
pub fn measure(model: &Arc<Model>, variables: &[usize], experiment: Experiment) -> Result<Bench, BenchError> {
    measure_watched(model, variables, experiment, &mut |_| true)
}

/// Measures as [`measure`] does; once there is a reference `watch` is given each run, and returns whether it is to be measured. Where it is not, the runs before it are the result.
///
/// # Errors
/// The errors of [`measure`].
pub fn measure_watched(
    model: &Arc<Model>,
    variables: &[usize],
    experiment: Experiment,
    watch: &mut dyn FnMut(Next) -> bool,
) -> Result<Bench, BenchError> {
    let subject = BenchSubject { model, variables, experiment };
    let methods = methods(model);
    let (times, mut exact, reference) = reference::find(&subject, &methods)?;
    let energy_kept = exact.energy_drift().is_some_and(|drift| drift < KEPT);
    let (mut runs, mut total, mut attainable) = (Vec::new(), Elapsed::default(), exact.instance.attainable_accuracy());
    let all = methods.len() * TOLERANCES.len();
    let planned = methods.iter().flat_map(|&method| TOLERANCES.map(|tolerance| (method, tolerance)));
    let mut slow = None;
    for ((method, engine), tolerance) in planned {
        if !watch(Next { method, tolerance, done: runs.len(), all }) {
            break;
        }
        // Finer tolerances would take longer still.
        let is_slow = slow == Some(method);
        let found =
            if is_slow { Err(BenchError::TooLong) } else { subject.run(engine, tolerance, Budget::Run, &times) };
        let result = found.map(|mut found| {
            let cpu_seconds = subject.time(engine, tolerance).map(|(fastest, all)| {
                total.add(all);
                fastest.as_secs_f64()
            });
            attainable = f64::max(attainable, found.instance.attainable_accuracy());
            let error = found.trajectory.distance(&exact.trajectory);
            let resolved = error > RESOLVED * reference.error;
            MeasuredRun { cpu_seconds, resolved, ..MeasuredRun::of(&found, error, energy_kept) }
        });
        slow = matches!(result, Err(BenchError::TooLong)).then_some(method).or(slow);
        runs.push(BenchRun { method, tolerance, result });
    }
    Ok(Bench {
        name: model.program().name.clone(),
        span: [experiment.start, experiment.stop],
        reference,
        points: times.len(),
        clock: clock::NAME,
        share: total.share(),
        energy_kept,
        attainable,
        runs,
    })
}

impl MeasuredRun {
    fn of(found: &TimedMotion, error: f64, energy_kept: bool) -> Self {
        let statistics = found.instance.statistics();
        Self {
            cpu_seconds: None,
            error,
            resolved: true,
            steps: statistics.steps,
            rejected: statistics.rejected,
            evaluations: statistics.evaluations,
            factorisations: statistics.factorisations,
            jacobians: statistics.jacobians,
            constraint_residual: found.residual,
            energy_drift: found.energy_drift().filter(|_| energy_kept),
        }
    }
}

/// What the model can be moved with; first what it uses by itself.
fn methods(model: &Model) -> Vec<Method> {
    let series = model.program().arms.is_some().then_some(("taylor", Some(Engine::Taylor)));
    let others = [("explicit", Some(Engine::Dop853)), ("implicit", Some(Engine::Radau))];
    std::iter::once(("auto", None)).chain(series).chain(others).collect()
}

#[cfg(test)]
mod tests {
    use cotree_fmu::instance::InstanceError;

    use super::*;

    #[test]
    fn a_run_without_result_has_the_same_keys_and_says_why() {
        let run = BenchRun { method: "explicit", tolerance: 1e-6, result: Err(BenchError::TooLong) };
        let written = serde_json::to_value(&run).expect("JSON");
        for key in ["cpu_seconds", "error", "steps", "evaluations"] {
            assert_eq!(written.get(key), Some(&serde_json::Value::Null), "{key}");
        }
        assert_eq!(written["problem"], "it takes too long");
        let reference = Reference { method: "auto", tolerance: 1e-13, error: 0.0, other: None, confirmed: false };
        let name = "four_bar".to_owned();
        let refused = BenchRun { result: Err(InstanceError::NoExchange.into()), ..run.clone() };
        let (points, clock, share, runs) = (1024, "processor time", 0.5, vec![run, refused]);
        let (span, energy_kept, attainable) = ([0.0, 1.0], false, 4e-8);
        let bench = Bench { name, span, reference, points, clock, share, energy_kept, attainable, runs };
        let table = bench.report().text(&cotree::model::Units::default());
        assert!(table.contains("rounding errors leave a relative accuracy of about 4e-8"), "{table}");
        assert!(table.contains("too slow") && table.contains("no result") && table.contains("no Model Exchange"));
        assert!(table.contains("50 % of a processor"), "{table}");
    }
}
