//! What accuracy costs: errors and work at several tolerances, measured on the model itself. Work is counted, not timed, so
//! the same model gives the same figures everywhere.

use std::sync::Arc;

use cotree::compile::Compiled;
use cotree::diagnostic::{Fault, Span};
use cotree::model::Experiment;
use cotree_draw::plot::PlotCurve;
use cotree_fmu::context::Statistics;
use cotree_fmu::instance::Inaccuracy;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use cotree_fmu::taylor::Jet;
use cotree_study::bench::runs::{BenchSubject, Budget};

use crate::MotionlessError;

const TOLERANCES: [f64; 7] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, FINEST];
/// The smallest of the compared tolerances.
pub const FINEST: f64 = 1e-10;
/// The tolerance of the run that counts as exact.
pub const REFERENCE: f64 = 1e-12;
/// Points of time at which results are compared: fewer than `cotree bench` takes, so that reading them stays within the budget.
const POINTS: u32 = 256;
/// About how many operations the reference run may take. Longer experiments are measured on their first part only.
const BUDGET: u64 = 50_000_000;
/// The shortest part of an experiment that is measured is 2^-HALVINGS of it: for motion that is absurdly fast.
const HALVINGS: i32 = 100;
/// No part is longer than the whole through this: work that grows tenfold within a part exceeds its budget by little.
const PARTS: f64 = 256.0;
/// Work per time that exceeds its mean by this factor at the end of the measurement counts as accelerating.
const GROWN: f64 = 4.0;

/// Errors and work of one model at its default parameters and inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// When the measurement starts and ends \[s\].
    pub span: [f64; 2],
    /// Did the work grow faster and faster until the measurement had to end?
    pub growing: bool,
    pub engine: Engine,
    pub measurements: Vec<Measurement>,
    /// Relative accuracy that rounding errors permit; 0 if nothing limits it.
    pub attainable: f64,
    /// That it is not as good as the tolerance of the experiment.
    pub inaccuracy: Option<Inaccuracy>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    pub tolerance: f64,
    /// Largest error of any variable at any time, relative to the variable's largest value.
    pub error: f64,
    pub statistics: Statistics,
}

/// What accuracy costs with this model.
///
/// # Errors
/// Why it cannot be measured.
pub fn of(compiled: &Compiled) -> Result<Accuracy, MotionlessError> {
    let model = Arc::new(Model::new(compiled.program.clone())?);
    measure(&model, &compiled.reported(), compiled.description.experiment)
}

/// Until when a run costs no more than the measurement of its accuracy may \[s\].
pub fn affordable(compiled: &Compiled, accuracy: &Result<Accuracy, MotionlessError>) -> f64 {
    let experiment = compiled.description.experiment;
    match (accuracy, Model::new(compiled.program.clone())) {
        (Ok(accuracy), _) => accuracy.span[1],
        (Err(_), Ok(model)) => reach(&Arc::new(model), experiment),
        (Err(_), Err(_)) => experiment.start,
    }
}

/// Warns of motion whose work grows without bound, as its accuracy shows.
pub fn warn_of_growth(compiled: &mut Compiled, accuracy: &Result<Accuracy, MotionlessError>) {
    let Some(accuracy) = accuracy.as_ref().ok().filter(|accuracy| accuracy.growing) else { return };
    let message = format!(
        "the motion becomes more and more expensive: the cost of accuracy is measured until t = {:.3} s only",
        accuracy.span[1]
    );
    let help = "check for negative damping, or a law that increases the motion without bound";
    compiled.warn(vec![Fault::warning("scene::growing_motion", message, Span::default()).help(help)]);
}

/// Warns of an experiment that cannot be run to its end, and says why.
pub fn warn_of_end(compiled: &mut Compiled, why: Option<String>) {
    let Some(why) = why else { return };
    let message = format!("the motion ends before the experiment: {why}");
    let help = "pages and pictures show the motion up to there";
    compiled.warn(vec![Fault::warning("scene::ends_early", message, Span::default()).help(help)]);
}

/// Why a run of the experiment cannot go on, as far as looking costs no more than measuring its accuracy.
pub fn end(compiled: &Compiled) -> Option<String> {
    let experiment = compiled.description.experiment;
    let model = Arc::new(Model::new(compiled.program.clone()).ok()?);
    let mut reached = experiment.start;
    within_budget(&model, experiment, experiment.tolerance, &mut reached).err().map(|error| error.to_string())
}

/// Simulates the model at each tolerance and compares the variables with those of a run at [`REFERENCE`].
fn measure(model: &Arc<Model>, variables: &[usize], experiment: Experiment) -> Result<Accuracy, MotionlessError> {
    let Experiment { start, mut stop, .. } = experiment;
    let growing = within_budget(model, experiment, REFERENCE, &mut stop)?;
    let subject = BenchSubject { model, variables, experiment: Experiment { stop, ..experiment } };
    let at = |point: u32| start + (stop - start) * f64::from(point) / f64::from(POINTS);
    let times: Vec<f64> = (1..=POINTS).map(at).collect();
    let run = |tolerance| subject.run(None, tolerance, Budget::Reference, &times);
    let mut exact = run(REFERENCE)?;
    let attainable = exact.instance.attainable_accuracy();
    let inaccuracy = match attainable > experiment.tolerance {
        true => run(experiment.tolerance)?.instance.take_inaccuracy(),
        false => None,
    };
    let measurements = TOLERANCES.into_iter().map(|tolerance| {
        let found = run(tolerance)?;
        let error = found.trajectory.distance(&exact.trajectory);
        Ok(Measurement { tolerance, error, statistics: found.instance.statistics() })
    });
    Ok(Accuracy {
        span: [start, stop],
        growing,
        engine: model.program().engine,
        measurements: measurements.collect::<Result<_, MotionlessError>>()?,
        attainable,
        inaccuracy,
    })
}

/// When a run at a tolerance has used up its budget, and whether its work grows faster and faster by then. Each part of the
/// experiment is at most as long as all before it, a small share of the whole, and no longer than a quarter of what is left should take.
/// `reached` is that time, or the last one before the motion cannot be continued.
fn within_budget(
    model: &Arc<Model>,
    experiment: Experiment,
    tolerance: f64,
    reached: &mut f64,
) -> Result<bool, MotionlessError> {
    *reached = experiment.start;
    let tape = model.program().tapes.acceleration.instructions().len().max(1) as u64;
    let cost = Jet::new(model).map_or(tape, |jet| jet.cost() as u64);
    let whole = experiment.stop - experiment.start;
    let shortest = 0.5f64.powi(HALVINGS);
    let mut instance = BenchSubject { model, variables: &[], experiment }.start(None, tolerance)?;
    // In shares of the whole: work per second exceeds all numbers where the whole is 1e-280 s.
    let (mut length, mut used) = (shortest, 0);
    while *reached < experiment.stop {
        // Next to a start that is not zero the shortest parts are nothing.
        let time = (*reached + length * whole).max(reached.next_up()).min(experiment.stop);
        if time > instance.time() {
            instance.step_to(time)?;
        }
        *reached = time;
        let before = std::mem::replace(&mut used, instance.statistics().evaluations * cost);
        let (elapsed, last) = ((time - experiment.start) / whole, (used - before).max(1) as f64 / length);
        if used > BUDGET / 2 {
            return Ok(last > GROWN * used as f64 / elapsed);
        }
        let allowed = (BUDGET - used) as f64 / 4.0 / last;
        length = allowed.min(elapsed).min(1.0 / PARTS).max(shortest);
    }
    Ok(false)
}

/// Until when a run costs no more than the measurement may: until its motion cannot be continued, if that comes first.
fn reach(model: &Arc<Model>, experiment: Experiment) -> f64 {
    let mut reached = experiment.start;
    // A run that ends early has got as far as it says.
    let _ = within_budget(model, experiment, REFERENCE, &mut reached);
    reached
}

impl Accuracy {
    pub fn work(&self) -> &'static str {
        match self.engine {
            Engine::Taylor => "Taylor series",
            Engine::Dop853 | Engine::Radau => "evaluations of the accelerations",
        }
    }

    /// Errors over tolerances, each with its work, if there is a curve to draw.
    pub fn curve(&self) -> Option<PlotCurve> {
        let points = self.measurements.iter().map(|measurement| {
            let label = format!("{}", measurement.statistics.evaluations);
            ([measurement.tolerance, measurement.error], label)
        });
        let points: Vec<_> = points.filter(|([x, y], _)| *x > 0.0 && *y > 0.0).collect();
        let title = format!("error at each tolerance, with the number of {}", self.work());
        let axes = ["tolerance".into(), "largest relative error".into()];
        (points.len() > 1).then_some(PlotCurve { title, axes, points })
    }
}
