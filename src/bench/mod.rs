//! Speed against error of a model: every method at many tolerances, against a converged reference.

mod diagram;
mod runs;
mod table;

use std::sync::Arc;

use cotree_fmu::model::Model;
use cotree_fmu::program::{Engine, Motion};
use serde::{Serialize, Serializer};

use crate::mechanism::Experiment;
use runs::{Budget, TOO_LONG, Trajectory, run};

/// The tolerances that are measured.
const TOLERANCES: [f64; 10] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12];
/// Tolerances that are tried for the reference, from the finest on.
const REFERENCES: [f64; 7] = [1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7];
/// A run whose error is not above so many times that of the reference is not told apart from it.
const RESOLVED: f64 = 3.0;
/// The only method where drivers determine the motion.
const LOOPS: &str = "loops";
/// Two methods agree if they differ by no more than this, or by so many times the error of the reference.
const AGREEMENT: f64 = 1e-6;
const AGREEMENT_FACTOR: f64 = 100.0;
/// The energy counts as kept if the reference changes it by less than this, relative to its largest value.
const KEPT: f64 = 1e-8;

/// Speed and error of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bench {
    /// The scene's name.
    pub name: String,
    /// When the measurement starts and ends \[s\].
    pub span: [f64; 2],
    /// What counts as exact.
    pub reference: Reference,
    /// Does the motion keep its energy?
    pub energy_kept: bool,
    /// One for each method and tolerance, methods together.
    pub runs: Vec<Run>,
}

/// A converged run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reference {
    /// Its method.
    pub method: &'static str,
    /// Its tolerance.
    pub tolerance: f64,
    /// How far a run at ten times the tolerance is from it.
    pub error: f64,
    /// The finest run of another method that ends in time, and how far it is from the reference.
    pub other: Option<Comparison>,
    /// Does that run agree with the reference?
    pub confirmed: bool,
}

/// A run of another method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Its method.
    pub method: &'static str,
    /// Its tolerance.
    pub tolerance: f64,
    /// Distance from the reference.
    pub distance: f64,
}

/// What a method does at a tolerance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// `auto`, `taylor`, `explicit`, `implicit`, or `loops` if the drivers determine the motion.
    pub method: &'static str,
    /// Relative tolerance.
    pub tolerance: f64,
    /// The rest, or why there is none.
    #[serde(flatten, serialize_with = "flat")]
    pub result: Result<Measured, String>,
}

/// What a run without result is written as: every number is null.
#[derive(Serialize)]
struct Unmeasured<'a> {
    cpu_seconds: Option<f64>,
    error: Option<f64>,
    steps: Option<u64>,
    evaluations: Option<u64>,
    problem: &'a str,
}

fn flat<S: Serializer>(result: &Result<Measured, String>, serializer: S) -> Result<S::Ok, S::Error> {
    match result {
        Ok(measured) => measured.serialize(serializer),
        Err(problem) => {
            Unmeasured { cpu_seconds: None, error: None, steps: None, evaluations: None, problem }.serialize(serializer)
        }
    }
}

/// What a run costs and how good it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Time of the fastest of several repetitions on one thread, initialisation and outputs left out \[s\].
    pub cpu_seconds: f64,
    /// Largest error of any reported variable at any of the compared times, relative to the variable's largest value.
    pub error: f64,
    /// Is the error clearly above that of the reference?
    pub resolved: bool,
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Evaluations of the accelerations, or series of the motion.
    pub evaluations: u64,
    /// Factorisations of the implicit method.
    pub factorisations: u64,
    /// Jacobians of the implicit method.
    pub jacobians: u64,
    /// Largest residual of the loop equations at the compared times, relative to their scales.
    pub constraint_residual: f64,
    /// Largest change of the energy, relative to its largest value; only where the motion keeps it.
    pub energy_drift: Option<f64>,
}

/// A method: what it is called, and the engine, unless the program chooses.
type Method = (&'static str, Option<Engine>);

/// Measures a model.
///
/// # Errors
/// There is no reference: the model cannot be simulated, or not in reasonable time.
pub fn measure(model: &Arc<Model>, variables: &[usize], experiment: Experiment) -> Result<Bench, String> {
    let methods = methods(model);
    let (exact, reference) = reference(model, variables, experiment, &methods)?;
    let energy_kept = exact.energy_drift().is_some_and(|drift| drift < KEPT);
    let mut measured = Vec::new();
    for &(method, engine) in &methods {
        let mut affordable = true;
        for tolerance in TOLERANCES {
            let found = if affordable {
                run(model, variables, experiment, engine, tolerance, Budget::Run)
            } else {
                Err(TOO_LONG.to_owned())
            };
            let result = found.map(|found| {
                let error = found.distance(&exact);
                let statistics = found.statistics;
                Measured {
                    cpu_seconds: runs::time(model, experiment, engine, tolerance),
                    error,
                    resolved: error > RESOLVED * reference.error,
                    steps: statistics.steps,
                    rejected: statistics.rejected,
                    evaluations: statistics.evaluations,
                    factorisations: statistics.factorisations,
                    jacobians: statistics.jacobians,
                    constraint_residual: found.residual,
                    energy_drift: found.energy_drift().filter(|_| energy_kept),
                }
            });
            // Finer tolerances would take longer still.
            affordable = result.as_ref().err().is_none_or(|problem| problem != TOO_LONG);
            measured.push(Run { method, tolerance, result });
        }
    }
    let name = model.program().name.clone();
    Ok(Bench { name, span: [experiment.start, experiment.stop], reference, energy_kept, runs: measured })
}

/// What the model can be moved with; first what it uses by itself.
fn methods(model: &Model) -> Vec<Method> {
    if model.program().motion == Motion::Kinematic {
        return vec![(LOOPS, None)];
    }
    let series = model.program().arms.is_some().then_some(("taylor", Some(Engine::Taylor)));
    let others = [("explicit", Some(Engine::Dop853)), ("implicit", Some(Engine::Radau))];
    std::iter::once(("auto", None)).chain(series).chain(others).collect()
}

/// The finest run that ends in time.
fn reference(
    model: &Arc<Model>,
    variables: &[usize],
    experiment: Experiment,
    methods: &[Method],
) -> Result<(Trajectory, Reference), String> {
    let (method, engine) = methods[0];
    let mut problem = TOO_LONG.to_owned();
    for tolerance in REFERENCES {
        let run = |tolerance| run(model, variables, experiment, engine, tolerance, Budget::Reference);
        match (run(tolerance), run(10.0 * tolerance)) {
            (Ok(exact), Ok(coarser)) => {
                let error = coarser.distance(&exact);
                let other = compare(model, variables, experiment, methods, &exact);
                let limit = (AGREEMENT_FACTOR * error).max(AGREEMENT);
                let confirmed = other.as_ref().is_some_and(|other| other.distance <= limit);
                return Ok((exact, Reference { method, tolerance, error, other, confirmed }));
            }
            (Err(error), _) | (_, Err(error)) => problem = error,
        }
    }
    Err(format!("there is no reference to compare with: {problem}"))
}

/// The best agreement with the reference that another method reaches in time.
fn compare(
    model: &Arc<Model>,
    variables: &[usize],
    experiment: Experiment,
    methods: &[Method],
    exact: &Trajectory,
) -> Option<Comparison> {
    let own = model.program().engine;
    let others = methods.iter().filter(|(_, engine)| engine.is_some_and(|engine| engine != own));
    others.into_iter().find_map(|&(method, engine)| {
        let finest = |tolerance: &f64| {
            let other = run(model, variables, experiment, engine, *tolerance, Budget::Reference).ok()?;
            Some(Comparison { method, tolerance: *tolerance, distance: other.distance(exact) })
        };
        [1e-12, 1e-10, 1e-8].iter().filter_map(finest).min_by(|a, b| a.distance.total_cmp(&b.distance))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_without_result_has_the_same_keys_and_says_why() {
        let run = Run { method: "explicit", tolerance: 1e-6, result: Err(TOO_LONG.to_owned()) };
        let written = serde_json::to_value(&run).expect("JSON");
        for key in ["cpu_seconds", "error", "steps", "evaluations"] {
            assert_eq!(written.get(key), Some(&serde_json::Value::Null), "{key}");
        }
        assert_eq!(written["problem"], TOO_LONG);
        let reference = Reference { method: "auto", tolerance: 1e-13, error: 0.0, other: None, confirmed: false };
        let name = "four_bar".to_owned();
        let refused = Run { result: Err("it left its branch".to_owned()), ..run.clone() };
        let bench = Bench { name, span: [0.0, 1.0], reference, energy_kept: false, runs: vec![run, refused] };
        let table = bench.to_string();
        assert!(table.contains("too slow") && table.contains("no result") && table.contains("it left its branch"));
        assert!(bench.svg().contains("there are no errors to draw"));
    }
}
