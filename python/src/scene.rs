//! A scene and everything that can be asked of it.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};

use cotree::compile::compile_asking;
use cotree::diagnostic::{every, lines};
use cotree::export::runtime;
use cotree::model::Experiment;
use cotree::report::csv::CsvTable;
use cotree::report::statistics::Accumulator;
use cotree::run::settings::settable;
use cotree::run::{Ended, Ensemble, FailedRun, Measure, MeasureError, Run};
use cotree::scene::{EditError, Requested};
use cotree::{Compiled, Faults, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_page::moving;
use cotree_study::analysis::{EarlyEnd, LinearisedAt, Sensitivities, Study, StudyError};
use cotree_study::bench;
use cotree_study::fit::{FitError, FitRequest, FitTrial, Vary, fit_watched};
use cotree_text::Prose;
use cotree_text::written::EquationFormat;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use serde_json::json;

use crate::listening::{self, PATIENCE, Watched, interruptible};
use crate::outcome::{
    LogRow, RunError, failed, file_error, interrupted, log_rows, run_error, scene_error, study_error, unlike_the_scene,
    warn, wrong,
};
use crate::pages;
use crate::request::{self, Columns, Times, Value};
use crate::running::Running;

/// So many variants of a scene are kept compiled: other outputs, other known values at the start.
const MOST_KEPT: usize = 8;

/// A scene, with its text: that is what is pickled.
#[pyclass(frozen, module = "cotree._cotree")]
pub struct Core {
    scene: Scene,
    /// What was compiled, the last first.
    compiled: Mutex<Vec<(Variant, Arc<Ready>)>>,
    /// What was resolved for studies, the last first: copies share what they formulate.
    studied: Mutex<Vec<((Requested, Vec<String>), Study)>>,
}

/// What is compiled of a scene: these outputs in place of its own, if any are given, and variables that are known at the start although `[initial]` leaves them out.
#[derive(Clone, Default, PartialEq)]
struct Variant {
    outputs: Vec<String>,
    known: Vec<String>,
}

/// A scene that can run.
pub struct Ready {
    pub compiled: Compiled,
    pub model: Arc<Model>,
    /// An instance that no run uses now.
    spare: Mutex<Option<Box<Instance>>>,
}

/// A member's times and values, a row for each, why there are no more, the event that has ended it, and what has happened.
type Rows<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Option<String>, Option<String>, Vec<LogRow>);

/// How a member has ended.
struct Outcome<C> {
    collected: C,
    /// Why it failed.
    failure: Option<String>,
    /// The event that has ended it.
    event: Option<String>,
    log: Vec<LogRow>,
}

/// What members have in common: a compiled scene, times, settings, what is reported, inputs over time.
type Asking<'a> = (&'a Ready, (Experiment, &'a [f64]), &'a [(String, Value)], Vec<usize>, Option<Columns>);

/// One of the experiments of a fit: settings of its own, what was measured, inputs over time.
type Fitted = (Vec<(String, Value)>, Columns, Option<Columns>);

/// Names with units, the outputs, and their derivatives.
type Derivatives<'py> =
    (Vec<(String, String)>, Vec<(String, String)>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>);

/// Of one of many runs the times, the outputs (time, output), their derivatives (time, output, name), and how the last time changes if an event has ended the run.
type RunDerivatives<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray3<f64>>,
    Option<Bound<'py, PyArray1<f64>>>,
);

/// What is found of a run, and how an event has ended it.
type ToEnd = (Sensitivities, Option<EarlyEnd>);

/// Why one of many runs has no derivatives.
enum ManyError {
    Value(String),
    Study(StudyError),
}

/// The same at rest, with the time.
type AtRest<'py> =
    (Vec<f64>, Vec<(String, String)>, Vec<(String, String)>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>);

#[pymethods]
impl Core {
    /// Reads a scene from a text in TOML or JSON; `name` is that of its file.
    #[new]
    fn new(py: Python<'_>, text: Vec<u8>, name: &str) -> PyResult<Self> {
        let scene = py.detach(|| Scene::from_bytes(Path::new(name), text));
        Ok(Core::of(scene.map_err(|faults| scene_error(&faults))?))
    }

    /// A scene from files that were read before, each with its path and text, its own first.
    #[staticmethod]
    fn restored(py: Python<'_>, files: Vec<(String, String)>) -> PyResult<Self> {
        let scene = py.detach(|| Scene::from_files(&files));
        Ok(Core::of(scene.map_err(|faults| scene_error(&faults))?))
    }

    /// The scene with other values: names, and what is written in their place.
    fn replaced(&self, py: Python<'_>, changes: Vec<(String, String)>) -> PyResult<Self> {
        let scene = py.detach(|| self.scene.replaced(&changes)).map_err(|error| match error {
            EditError::Scene(faults) => scene_error(&faults),
            error => wrong(error.to_string()),
        })?;
        Ok(Core::of(scene))
    }

    /// The files that it was read from.
    fn files(&self) -> Vec<(String, String)> {
        self.scene.source.files().map(|(name, text)| (name.to_owned(), text.to_owned())).collect()
    }

    fn name(&self) -> String {
        self.scene.name.text.clone()
    }

    /// Warnings as JSON; the scene's faults are raised.
    fn check(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let ready = self.ready(py, Variant::default())?;
        Ok(ready.compiled.warnings.as_ref().map(|faults| faults.to_json().to_string()))
    }

    /// Every variable as JSON.
    fn variables(&self, py: Python<'_>) -> PyResult<String> {
        let ready = self.ready(py, Variant::default())?;
        let variable = |variable: &cotree::export::description::ScalarVariable| {
            let range = variable.causality.range();
            let (start, [min, max]) = range.map_or_else(Default::default, |(start, bounds)| (Some(start), bounds));
            json!({ "name": variable.name, "description": variable.description, "unit": variable.unit.si,
                    "causality": variable.causality.name(), "start": start, "min": min, "max": max })
        };
        Ok(json!(ready.compiled.description.variables.iter().map(variable).collect::<Vec<_>>()).to_string())
    }

    /// Runs all members: `names` are set to the rows of `values`, after `settings`. Names and units of the outputs; times and values of each member, and why it ended early.
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        times: Times,
        settings: Vec<(String, Value)>,
        outputs: Option<Vec<String>>,
        inputs: Option<Columns>,
        names: Vec<String>,
        values: PyReadonlyArray2<'py, f64>,
        threads: usize,
    ) -> PyResult<(Vec<(String, String)>, Vec<Rows<'py>>)> {
        let (ready, reported) = self.reporting(py, outputs, &settings, &names)?;
        let columns = ready.columns(&reported);
        let width = reported.len();
        let experiment = times.experiment(ready.compiled.description.experiment)?;
        let all = times.points(experiment);
        let ended = self.members(
            py,
            (&ready, (experiment, &all), &settings, reported, inputs),
            (names, values, threads),
            || (Vec::with_capacity(all.len()), Vec::with_capacity(all.len() * width)),
            |(times, rows): &mut (Vec<f64>, Vec<f64>), time, values| {
                times.push(time);
                rows.extend_from_slice(values);
            },
        )?;
        let rows = |outcome: Outcome<(Vec<f64>, Vec<f64>)>| {
            let (times, values) = outcome.collected;
            let matrix = PyArray1::from_vec(py, values).reshape([times.len(), width])?;
            Ok((PyArray1::from_vec(py, times), matrix, outcome.failure, outcome.event, outcome.log))
        };
        Ok((columns, ended.into_iter().map(rows).collect::<PyResult<_>>()?))
    }

    /// The same, keeping only these measures of each member, such as `max(rod.angle)`: a row of numbers a member, not a number where a run ended early.
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn measure<'py>(
        &self,
        py: Python<'py>,
        times: Times,
        settings: Vec<(String, Value)>,
        measures: Vec<String>,
        inputs: Option<Columns>,
        names: Vec<String>,
        values: PyReadonlyArray2<'py, f64>,
        threads: usize,
    ) -> PyResult<(Vec<(String, String)>, Bound<'py, PyArray2<f64>>, Vec<Option<String>>)> {
        let measures: Result<Vec<Measure>, MeasureError> = measures.iter().map(|text| text.parse()).collect();
        let measures = measures.map_err(wrong)?;
        let variables: Vec<String> = measures.iter().map(|measure| measure.variable.clone()).collect();
        let (ready, _) = self.reporting(py, Some(variables), &settings, &names)?;
        let variables = &ready.compiled.description.variables;
        let place = |name: &String| variables.iter().position(|variable| variable.name == *name);
        let reported: Option<Vec<usize>> = measures.iter().map(|measure| place(&measure.variable)).collect();
        let reported = reported.ok_or_else(|| wrong("a variable that was asked for is not computed"))?;
        let columns = measures.iter().zip(&reported);
        let columns =
            columns.map(|(column, &index)| (column.to_string(), column.unit(&variables[index].unit.si).to_owned()));
        let columns = columns.collect();
        let experiment = times.experiment(ready.compiled.description.experiment)?;
        let all = times.points(experiment);
        let ended = self.members(
            py,
            (&ready, (experiment, &all), &settings, reported, inputs),
            (names, values, threads),
            Vec::new,
            Accumulator::add_all,
        )?;
        let (mut table, mut failures) = (Vec::with_capacity(ended.len() * measures.len()), Vec::new());
        for Outcome { collected: kept, failure, .. } in ended {
            let number = |(index, measure): (usize, &Measure)| match kept.get(index) {
                Some(kept) if failure.is_none() => measure.of(kept),
                _ => f64::NAN,
            };
            table.extend(measures.iter().enumerate().map(number));
            failures.push(failure);
        }
        let table = PyArray1::from_vec(py, table).reshape([failures.len(), measures.len()])?;
        Ok((columns, table, failures))
    }

    /// Begins a run that is taken step by step.
    fn start(
        &self,
        py: Python<'_>,
        times: Times,
        settings: Vec<(String, Value)>,
        outputs: Option<Vec<String>>,
    ) -> PyResult<Running> {
        let (ready, reported) = self.reporting(py, outputs, &settings, &[])?;
        let experiment = times.experiment(ready.compiled.description.experiment)?;
        Running::start(py, (ready, reported), experiment, &settings)
    }

    /// Texts with units as numbers, in the SI unit of what can be set by this name.
    fn numbers(&self, py: Python<'_>, name: String, values: Vec<Value>) -> PyResult<Vec<f64>> {
        let settings: Vec<(String, Value)> = values.into_iter().map(|value| (name.clone(), value)).collect();
        let ready = self.ready_for(py, None, &settings, &[])?;
        let numbers = request::settings(&ready.compiled.description, &settings)?;
        Ok(numbers.into_iter().map(|(_, value)| value).collect())
    }

    /// The units of what can be set, by its names.
    fn units(&self, py: Python<'_>, names: Vec<String>) -> PyResult<Vec<String>> {
        let ready = self.ready_for(py, None, &[], &names)?;
        let description = &ready.compiled.description;
        let unit =
            |name: &String| Ok(description.variables[settable(description, name).map_err(wrong)?].unit.si.clone());
        names.iter().map(unit).collect()
    }

    /// The communication points of a run.
    fn points<'py>(&self, py: Python<'py>, times: Times) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let ready = self.ready(py, Variant::default())?;
        Ok(PyArray1::from_vec(py, times.points(times.experiment(ready.compiled.description.experiment)?)))
    }

    /// The equations of motion in a notation.
    fn equations(&self, py: Python<'_>, notation: &str) -> PyResult<String> {
        let notation = request::word("notation", notation, &EquationFormat::WORDS)?;
        py.detach(|| cotree_text::written::equations(&self.scene, notation)).map_err(|faults| scene_error(&faults))
    }

    /// The derivation of the equations.
    fn steps(&self, py: Python<'_>, notation: &str) -> PyResult<String> {
        let prose = request::word("notation", notation, &Prose::WORDS)?;
        py.detach(|| cotree_text::written::steps(&self.scene, prose)).map_err(|faults| scene_error(&faults))
    }

    /// The mechanism in figures and names.
    fn summary(&self, py: Python<'_>) -> PyResult<String> {
        let summary = py.detach(|| self.scene.summary()).map_err(|faults| scene_error(&faults))?;
        Ok(summary.to_string())
    }

    /// The page that shows the mechanism in motion: with the solver for browsers if this folder has it, else with this process as its solver if it may serve, else with a run that is stored in it.
    fn page(&self, py: Python<'_>, runtimes: Option<PathBuf>, served: bool) -> PyResult<String> {
        let module = for_browsers(runtimes.as_deref())?;
        let is_served = served && module.is_none();
        let server = is_served.then(pages::address).transpose().map_err(file_error)?;
        let scene = &self.scene;
        let made = py.detach(|| match &server {
            Some(address) => {
                let (_, page) = moving::page_solved_elsewhere(scene)?;
                Ok(page.map(|page| page.html_served_from(address)))
            }
            None => moving::page(scene, module).map(|(_, page)| page.map(|page| page.html())),
        });
        made.map_err(|faults: Faults| scene_error(&faults))?.map_err(failed)
    }

    /// Where the mechanism rests, as JSON.
    fn equilibrium(&self, py: Python<'_>, settings: Vec<(String, Value)>) -> PyResult<String> {
        let mut study = self.study(None, &settings, None)?;
        let found = interruptible(py, || study.equilibrium())?.map_err(|error| study_error(error, &settings))?;
        Ok(found.report().data.to_string())
    }

    /// Linear systems as JSON: at the equilibrium, or at these times.
    fn linearize(
        &self,
        py: Python<'_>,
        times: Option<Vec<f64>>,
        settings: Vec<(String, Value)>,
        inputs: Option<Columns>,
    ) -> PyResult<String> {
        let mut study = self.study(None, &settings, inputs)?;
        let start = study.experiment().start;
        let at = match times {
            None => LinearisedAt::Equilibrium,
            Some(times) if times.is_empty() => LinearisedAt::Times(vec![start]),
            Some(times) => {
                if times.iter().any(|time| !time.is_finite() || *time < start) || !times.is_sorted() {
                    return Err(wrong(format!("times must be increasing, from the start, {start:?} s, on")));
                }
                LinearisedAt::Times(times)
            }
        };
        let found = interruptible(py, || study.linearize(&at))?.map_err(|error| study_error(error, &settings))?;
        Ok(found.report().data.to_string())
    }

    /// Vibrations as JSON.
    fn modes(
        &self,
        py: Python<'_>,
        at: Option<f64>,
        settings: Vec<(String, Value)>,
        inputs: Option<Columns>,
    ) -> PyResult<String> {
        let mut study = self.study(None, &settings, inputs)?;
        let start = study.experiment().start;
        if at.is_some_and(|at| !at.is_finite() || at < start) {
            return Err(wrong(format!("at: is before the start, {start:?} s")));
        }
        let found = interruptible(py, || study.modes(at))?.map_err(|error| study_error(error, &settings))?;
        Ok(found.report().data.to_string())
    }

    /// Outputs and parameters with their units; the outputs (time, output); their derivatives (time, output, parameter).
    fn sensitivities<'py>(
        &self,
        py: Python<'py>,
        times: Times,
        of: Option<Vec<String>>,
        to: Vec<String>,
        settings: Vec<(String, Value)>,
        inputs: Option<Columns>,
    ) -> PyResult<Derivatives<'py>> {
        let mut study = self.study(of, &settings, inputs)?;
        let requested = times.experiment(study.experiment())?;
        let points = times.points(requested);
        study.set_experiment(Experiment {
            start: requested.start,
            tolerance: requested.tolerance,
            ..study.experiment()
        });
        derivatives(
            py,
            interruptible(py, || study.sensitivities(&to, &points))?.map_err(|error| study_error(error, &settings))?,
        )
    }

    /// The same of many runs, in threads, up to their ends: the names of the outputs, and what is found of each run. A row of values for the names, which are what is differentiated by, for each run.
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn sensitivities_many<'py>(
        &self,
        py: Python<'py>,
        times: Times,
        of: Vec<String>,
        varied: (Vec<String>, PyReadonlyArray2<'py, f64>),
        settings: Vec<(String, Value)>,
        inputs: Option<Columns>,
        threads: usize,
    ) -> PyResult<(Vec<String>, Vec<RunDerivatives<'py>>)> {
        let (names, values) = varied;
        let rows: Vec<Vec<f64>> = values.as_array().rows().into_iter().map(|row| row.to_vec()).collect();
        let varied = names.iter().zip(rows.first().into_iter().flatten()).map(|(name, &value)| (name.clone(), value));
        let others = settings.into_iter().filter(|(name, _)| !names.contains(name));
        let first: Vec<(String, Value)> =
            others.chain(varied.map(|(name, value)| (name, Value::Number(value)))).collect();
        let mut study = self.study(Some(of), &first, inputs)?;
        let requested = times.experiment(study.experiment())?;
        let points = times.points(requested);
        let Experiment { start, tolerance, .. } = requested;
        study.set_experiment(Experiment { start, tolerance, ..study.experiment() });
        let one = |study: &mut Study, row: &[f64]| -> Result<ToEnd, ManyError> {
            for (name, &value) in names.iter().zip(row) {
                study.set(name, |_| Ok(value)).map_err(|message| ManyError::Value(format!("{name}: {message}")))?;
            }
            study.sensitivities_to_end(&names, &points).map_err(ManyError::Study)
        };
        let (first_row, rest) = rows.split_first().ok_or_else(|| wrong("at: there are no runs"))?;
        let raised = |error| match error {
            ManyError::Value(message) => wrong(message),
            ManyError::Study(error) => study_error(error, &first),
        };
        // What the first formulates the others share.
        let mut found = vec![interruptible(py, || one(&mut study, first_row))?.map_err(raised)?];
        let processors = || std::thread::available_parallelism().map_or(1, usize::from);
        let threads = if threads == 0 { processors() } else { threads }.min(rest.len());
        if threads == 1 {
            for row in rest {
                found.push(interruptible(py, || one(&mut study, row))?.map_err(raised)?);
            }
        } else if threads > 1 {
            let stop = Arc::new(AtomicBool::new(false));
            let work = || {
                in_threads(
                    threads,
                    rest,
                    || {
                        listening::follow(&stop);
                        study.clone()
                    },
                    |study, row| one(study, row),
                )
            };
            for each in py.detach(|| listened(&stop, work))? {
                found.push(each.map_err(raised)?);
            }
        }
        let outputs = found[0].0.outputs.iter().map(|(name, _)| name.clone()).collect();
        let run = |(found, ended): ToEnd| {
            let times = PyArray1::from_slice(py, &found.times);
            let (_, _, values, derivatives) = derivatives(py, found)?;
            Ok((times, values, derivatives, ended.map(|end| PyArray1::from_vec(py, end.changes))))
        };
        Ok((outputs, found.into_iter().map(run).collect::<PyResult<_>>()?))
    }

    /// The same where the mechanism rests, with the time that this stands for.
    fn equilibrium_sensitivities<'py>(
        &self,
        py: Python<'py>,
        of: Option<Vec<String>>,
        to: Vec<String>,
        settings: Vec<(String, Value)>,
    ) -> PyResult<AtRest<'py>> {
        let mut study = self.study(of, &settings, None)?;
        let found = interruptible(py, || study.equilibrium_sensitivities(&to))?
            .map_err(|error| study_error(error, &settings))?;
        let times = found.times.clone();
        let (outputs, parameters, values, derivatives) = derivatives(py, found)?;
        Ok((times, outputs, parameters, values, derivatives))
    }

    /// Derivatives of eigenvalues, as JSON.
    fn mode_sensitivities(&self, py: Python<'_>, to: Vec<String>, settings: Vec<(String, Value)>) -> PyResult<String> {
        let mut study = self.study(None, &settings, None)?;
        let found =
            interruptible(py, || study.mode_sensitivities(&to))?.map_err(|error| study_error(error, &settings))?;
        Ok(found.report().data.to_string())
    }

    /// Peaks and crossings with their derivatives, as JSON.
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn peaks(
        &self,
        py: Python<'_>,
        times: Times,
        of: Option<Vec<String>>,
        to: Vec<String>,
        levels: Vec<(String, Value)>,
        settings: Vec<(String, Value)>,
        inputs: Option<Columns>,
    ) -> PyResult<String> {
        let crossed = levels.iter().map(|(name, _)| name.clone());
        let requested = match of.filter(|names| !names.is_empty()) {
            Some(names) => Requested::these(names.into_iter().chain(crossed)),
            None => Requested::also(crossed),
        };
        let mut study = self.study_of(&requested, &settings, inputs)?;
        let level = |(name, value): &(String, Value)| {
            let unit = study.output_unit(name).cloned().unwrap_or_default();
            let value = value.read(&unit).map_err(|message| wrong(format!("crossing: {name}: {message}")))?;
            Ok((name.clone(), value))
        };
        let levels = levels.iter().map(level).collect::<PyResult<Vec<_>>>()?;
        let experiment = times.experiment(study.experiment())?;
        study.set_experiment(experiment);
        let at = times.points(experiment);
        let found =
            interruptible(py, || study.features(&to, &at, &levels))?.map_err(|error| study_error(error, &settings))?;
        Ok(found.report().data.to_string())
    }

    /// Values that fit what was measured in experiments, as JSON: names with bounds, standard deviations of columns.
    fn fit(
        &self,
        py: Python<'_>,
        times: Times,
        experiments: Vec<Fitted>,
        vary: Vec<(String, Option<Value>, Option<Value>)>,
        deviations: Vec<(String, Value)>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let (mut studies, mut tables) = (Vec::new(), Vec::new());
        let mut set = Vec::new();
        for (settings, (at, names, columns), inputs) in experiments {
            let mut study = self.study_of(&Requested::these(&names), &settings, inputs)?;
            study.set_experiment(times.experiment(study.experiment())?);
            studies.push(study);
            let table = CsvTable::with_gaps(names, at, columns);
            tables.push(table.map_err(|message| wrong(format!("measured: {message}")))?);
            set.extend(settings);
        }
        let vary = vary.into_iter().map(|(name, low, high)| Vary {
            name,
            bounds: [low, high].map(|bound| bound.map(|value| value.to_string())),
        });
        let deviations = deviations.into_iter().map(|(name, value)| (name, value.to_string())).collect();
        let request = FitRequest { tables, vary: vary.collect(), deviations };
        let watched = Watched::new(progress);
        let most = cotree_study::fit::most_evaluations(request.vary.len());
        let mut trials = 0;
        let mut watch = |_: FitTrial<'_>| {
            trials += 1;
            watched.tell(trials, most)
        };
        let found = interruptible(py, || fit_watched(&mut studies, &request, &mut watch))?;
        watched.raised()?;
        let found = found.map_err(|error| match error {
            FitError::Study(error) => study_error(error, &set),
            FitError::Request(faults) => wrong(lines(&faults)),
            FitError::Undetermined(why) => failed(why),
        })?;
        Ok(found.report().data.to_string())
    }

    /// Speed against error, as JSON.
    fn bench(&self, py: Python<'_>) -> PyResult<String> {
        let ready = self.ready(py, Variant::default())?;
        let experiment = ready.compiled.description.experiment;
        let measured = interruptible(py, || bench::measure(&ready.model, &ready.compiled.reported(), experiment))?;
        let measured = measured.map_err(failed)?;
        serde_json::to_string(&measured).map_err(file_error)
    }
}

impl Variant {
    /// With these outputs, if any are given.
    fn of(outputs: Option<Vec<String>>) -> Self {
        Variant { outputs: outputs.unwrap_or_default(), known: Vec::new() }
    }
}

impl Core {
    fn of(scene: Scene) -> Self {
        Core { scene, compiled: Mutex::default(), studied: Mutex::default() }
    }

    /// The scene itself.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The compiled scene.
    fn ready(&self, py: Python<'_>, variant: Variant) -> PyResult<Arc<Ready>> {
        let kept = || self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, ready)) = kept().iter().find(|(known, _)| *known == variant) {
            return Ok(Arc::clone(ready));
        }
        let ready = Arc::new(py.detach(|| self.compile(&variant))?);
        let mut kept = kept();
        kept.insert(0, (variant, Arc::clone(&ready)));
        kept.truncate(MOST_KEPT);
        Ok(ready)
    }

    /// The compiled scene, with what is set or varied known at its start.
    pub fn ready_for(
        &self,
        py: Python<'_>,
        outputs: Option<Vec<String>>,
        settings: &[(String, Value)],
        varied: &[String],
    ) -> PyResult<Arc<Ready>> {
        let names = settings.iter().map(|(name, _)| name).chain(varied);
        let variant = Variant { known: self.known(names), ..Variant::of(outputs) };
        let without = variant.known.is_empty();
        self.ready(py, variant.clone()).map_err(|error| {
            // The scene is right by itself: what was set does not fit.
            let alone = Variant { outputs: Vec::new(), ..variant };
            let faults = if without { None } else { cotree::compile(&self.scene_of(&alone)).err() };
            faults.and_then(|faults| unlike_the_scene(&faults, settings)).unwrap_or(error)
        })
    }

    /// The compiled scene, and what is reported: its outputs, or variables, parameters and inputs by these names, each once.
    fn reporting(
        &self,
        py: Python<'_>,
        outputs: Option<Vec<String>>,
        settings: &[(String, Value)],
        varied: &[String],
    ) -> PyResult<(Arc<Ready>, Vec<usize>)> {
        let Some(requested) = outputs.filter(|names| !names.is_empty()) else {
            let ready = self.ready_for(py, None, settings, varied)?;
            let reported = ready.compiled.reported();
            return Ok((ready, reported));
        };
        let ready = self.ready(py, Variant::default())?;
        let given = ready.compiled.description.variables.iter().filter(|variable| !variable.causality.follows_motion());
        let given: HashSet<&str> = given.map(|variable| variable.name.as_str()).collect();
        let computed = requested.iter().filter(|name| !given.contains(name.as_str())).cloned().collect();
        let ready = self.ready_for(py, Some(computed), settings, varied)?;
        let mut reported: Vec<usize> = Vec::new();
        for name in &requested {
            let place = ready.compiled.description.variables.iter().position(|variable| variable.name == *name);
            let place = place.ok_or_else(|| wrong(format!("outputs: `{name}` is not computed")))?;
            if !reported.contains(&place) {
                reported.push(place);
            }
        }
        Ok((ready, reported))
    }

    /// When a run that begins again starts, and with which values; none if these need another program than the run has.
    pub fn restarted(
        &self,
        ready: &Arc<Ready>,
        times: &Times,
        settings: &[(String, Value)],
    ) -> PyResult<Option<(Experiment, cotree::run::Settings)>> {
        let known = self.known(settings.iter().map(|(name, _)| name));
        let kept = || self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let is_of = |(variant, own): &(Variant, Arc<Ready>)| Arc::ptr_eq(own, ready) && variant.known == known;
        if !kept().iter().any(is_of) {
            return Ok(None);
        }
        let description = &ready.compiled.description;
        Ok(Some((times.experiment(description.experiment)?, request::settings(description, settings)?)))
    }

    /// Variables among the names that are set, but neither parameters nor inputs nor in `[initial]`: positions and velocities that the scene leaves open.
    fn known<'n>(&self, names: impl Iterator<Item = &'n String>) -> Vec<String> {
        let scene = &self.scene;
        let is_written = |name: &str| {
            let parameters = scene.parameters.iter().map(|parameter| &parameter.name.text);
            let inputs = scene.inputs.iter().map(|input| &input.name.text);
            let initial = scene.initial.iter().map(|value| &value.variable.text);
            parameters.chain(inputs).chain(initial).any(|known| known == name)
        };
        let mut left: Vec<&String> = names.filter(|name| !is_written(name)).collect();
        left.sort_unstable();
        left.dedup();
        if left.is_empty() {
            return Vec::new();
        }
        let variables = scene.variables().unwrap_or_default();
        left.into_iter().filter(|name| variables.contains_key(*name)).cloned().collect()
    }

    /// The scene with these outputs and with what is known at its start.
    fn scene_of(&self, variant: &Variant) -> Scene {
        with_known(&self.scene, &variant.known)
    }

    fn compile(&self, variant: &Variant) -> PyResult<Ready> {
        let compiled = compile_asking(&self.scene_of(variant), &requested(Some(variant.outputs.clone())));
        let (compiled, _) = compiled.map_err(|faults| scene_error(&faults))?;
        let model = Model::new(compiled.program.clone()).map_err(|error| RunError::new_err(error.to_string()))?;
        Ok(Ready { compiled, model: Arc::new(model), spare: Mutex::default() })
    }

    pub fn study(
        &self,
        outputs: Option<Vec<String>>,
        settings: &[(String, Value)],
        inputs: Option<Columns>,
    ) -> PyResult<Study> {
        self.study_of(&requested(outputs), settings, inputs)
    }

    /// A study with nothing set: of what was asked before a copy.
    fn resolved(&self, requested: &Requested, known: Vec<String>) -> PyResult<Study> {
        let kept = || self.studied.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, study)) = kept().iter().find(|((key, names), _)| key == requested && *names == known) {
            return Ok(study.clone());
        }
        let scene = with_known(&self.scene, &known);
        let study = Study::asking(&scene, requested).map_err(|faults| scene_error(&faults))?;
        let mut kept = kept();
        kept.insert(0, ((requested.clone(), known), study.clone()));
        kept.truncate(MOST_KEPT);
        Ok(study)
    }

    pub fn study_of(
        &self,
        requested: &Requested,
        settings: &[(String, Value)],
        inputs: Option<Columns>,
    ) -> PyResult<Study> {
        let mut study = self.resolved(requested, self.known(settings.iter().map(|(name, _)| name)))?;
        if let Some((times, names, columns)) = inputs {
            request::apart(&names, settings)?;
            let table = request::table(names, times, columns)?;
            study.set_inputs(table).map_err(|message| wrong(format!("inputs: {message}")))?;
        }
        let wrongs = settings.iter().map(|(name, value)| {
            study.set(name, |unit| value.read(unit)).map_err(|message| format!("{name}: {message}"))
        });
        every(wrongs).map_err(|faults: Vec<String>| wrong(faults.join("\n")))?;
        Ok(study)
    }

    /// Runs members: one thread listens for Ctrl-C, the calling one; it runs them itself if it is to be the only one.
    fn members<C: Send>(
        &self,
        py: Python<'_>,
        (ready, (experiment, times), settings, reported, inputs): Asking<'_>,
        (names, values, threads): (Vec<String>, PyReadonlyArray2<'_, f64>, usize),
        begin: impl Fn() -> C + Send + Sync,
        point: impl Fn(&mut C, f64, &[f64]) + Send + Sync,
    ) -> PyResult<Vec<Outcome<C>>> {
        let description = &ready.compiled.description;
        let inputs = request::inputs(description, inputs, settings)?;
        let settings = request::settings(description, settings)?;
        let members = members(description, &names, &values)?;
        let table = inputs.as_ref().map(|(table, variables)| (table, variables.clone()));
        let run = Run { description, experiment, settings, inputs: table, reported };
        if let [settings] = members.as_slice() {
            let ended = [interruptible(py, || ready.alone(run, times, settings, begin(), point))?];
            warn_of(py, &ended)?;
            return ended.into_iter().map(outcome).collect();
        }
        let stop = Arc::new(AtomicBool::new(false));
        let ensemble = Ensemble::new(run, Arc::clone(&ready.model), threads, &stop).map_err(file_error)?.at(times);
        let ended = if ensemble.threads() == 1 {
            interruptible(py, || ensemble.run(&members, begin, watched(&stop, point)))?
        } else {
            let begin = || {
                listening::follow(&stop);
                begin()
            };
            py.detach(|| listened(&stop, || ensemble.run(&members, begin, point)))?
        };
        warn_of(py, &ended)?;
        ended.into_iter().map(outcome).collect()
    }
}

/// A scene in which these positions and velocities are known at the start.
fn with_known(scene: &Scene, names: &[String]) -> Scene {
    names.iter().fold(scene.clone(), |scene, name| scene.initial(name, 0.0))
}

fn outcome<C>((collected, ended): (C, Ended)) -> PyResult<Outcome<C>> {
    match ended {
        Ok(finish) => {
            let (event, log) = (finish.ended.map(|(event, _)| event), log_rows(finish.log));
            Ok(Outcome { collected, failure: None, event, log })
        }
        Err(FailedRun { error, log }) => {
            let failure = Some(run_error(error).ok_or_else(interrupted)?);
            Ok(Outcome { collected, failure, event: None, log: log_rows(log) })
        }
    }
}

impl Ready {
    /// Names and units of variables.
    pub fn columns(&self, reported: &[usize]) -> Vec<(String, String)> {
        let variables = &self.compiled.description.variables;
        let named = |&index: &usize| (variables[index].name.clone(), variables[index].unit.si.clone());
        reported.iter().map(named).collect()
    }

    /// One run, in this thread and in the instance that is kept for that.
    fn alone<C>(
        &self,
        mut run: Run,
        times: &[f64],
        settings: &[(usize, f64)],
        mut collected: C,
        point: impl Fn(&mut C, f64, &[f64]),
    ) -> (C, Ended) {
        run.settings.extend_from_slice(settings);
        let spare = || self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = spare().take();
        let mut instance = kept.unwrap_or_else(|| Instance::boxed(Arc::clone(&self.model)));
        let ended = run.start_at(&mut instance, times.iter().copied(), |time, values| {
            if listening::wants_end() {
                return Err(std::io::ErrorKind::Interrupted.into());
            }
            point(&mut collected, time, values);
            Ok(())
        });
        *spare() = Some(instance);
        (collected, ended)
    }
}

/// What is done at each communication point, where the run also ends if the user wants it: most points need no step of their own.
fn watched<C>(
    stop: &AtomicBool,
    point: impl Fn(&mut C, f64, &[f64]) + Send + Sync,
) -> impl Fn(&mut C, f64, &[f64]) + Send + Sync {
    move |collected, time, values| {
        if listening::wants_end() {
            stop.store(true, Ordering::Relaxed);
        }
        point(collected, time, values);
    }
}

/// Computes in other threads, while this one listens.
pub fn listened<T: Send>(stop: &AtomicBool, compute: impl FnOnce() -> T + Send) -> PyResult<T> {
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        scope.spawn(move || send.send(compute()));
        loop {
            match receive.recv_timeout(PATIENCE) {
                Ok(computed) => return Ok(computed),
                Err(mpsc::RecvTimeoutError::Disconnected) => return Err(wrong("a run has panicked")),
                Err(mpsc::RecvTimeoutError::Timeout) => {
                    if let Err(signal) = Python::attach(|py| py.check_signals()) {
                        stop.store(true, Ordering::Relaxed);
                        return Err(signal);
                    }
                }
            }
        }
    })
}

/// That rounding errors are larger than the tolerance in some runs.
fn warn_of<C>(py: Python<'_>, ended: &[(C, Ended)]) -> PyResult<()> {
    let mut found = ended.iter().filter_map(|(_, ended)| ended.as_ref().ok()?.inaccuracy.as_ref());
    let Some(first) = found.next() else { return Ok(()) };
    let of = if ended.len() > 1 { format!("{} of {} runs: ", 1 + found.count(), ended.len()) } else { String::new() };
    warn(py, &of, first)
}

/// The solver for browsers, if a folder of runtimes has it.
pub fn for_browsers(runtimes: Option<&Path>) -> PyResult<Option<Vec<u8>>> {
    runtimes.map_or(Ok(None), runtime::for_browsers).map_err(file_error)
}

/// These outputs in place of those of the scene, if any are given.
fn requested(outputs: Option<Vec<String>>) -> Requested {
    outputs.filter(|names| !names.is_empty()).map_or(Requested::Own, Requested::These)
}

/// As arrays: the outputs (time, output), and their derivatives (time, output, parameter).
fn derivatives(py: Python<'_>, found: Sensitivities) -> PyResult<Derivatives<'_>> {
    let size = [found.times.len(), found.outputs.len(), found.parameters.len()];
    let values: Vec<f64> = found.values.iter().flat_map(|row| row.iter().copied()).collect();
    let derivatives = row_first(&found);
    let values = PyArray1::from_vec(py, values).reshape([size[0], size[1]])?;
    let derivatives = PyArray1::from_vec(py, derivatives).reshape(size)?;
    Ok((found.outputs, found.parameters, values, derivatives))
}

/// All derivatives, the last index of which is the parameter.
fn row_first(found: &Sensitivities) -> Vec<f64> {
    found.derivatives.iter().flat_map(|matrix| matrix.transpose().data.as_vec().clone()).collect()
}

/// What is found for each row, in their order, by threads that take the next one; each begins with something of its own.
fn in_threads<T: Send, S>(
    threads: usize,
    rows: &[Vec<f64>],
    begin: impl Fn() -> S + Sync,
    find: impl Fn(&mut S, &[f64]) -> T + Sync,
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let work = || {
        let (mut own, mut found) = (begin(), Vec::new());
        while let Some((place, row)) =
            Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|place| Some((place, rows.get(place)?)))
        {
            found.push((place, find(&mut own, row)));
        }
        found
    };
    let mut found: Vec<(usize, T)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().filter_map(|worker| worker.join().ok()).flatten().collect()
    });
    found.sort_by_key(|(place, _)| *place);
    found.into_iter().map(|(_, own)| own).collect()
}

/// The settings of each member: a row of values for these names.
fn members(
    description: &cotree::export::description::Description,
    names: &[String],
    values: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<cotree::run::Settings>> {
    let [rows, columns] = [values.shape()[0], values.shape()[1]];
    if columns != names.len() {
        return Err(wrong(format!("{} parameters with {columns} columns of values", names.len())));
    }
    let array = values.as_array();
    let row = |row: usize| {
        let named = names.iter().enumerate().map(|(column, name)| (name.clone(), Value::Number(array[[row, column]])));
        request::settings(description, &named.collect::<Vec<_>>())
    };
    (0..rows).map(row).collect()
}
