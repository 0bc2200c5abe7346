//! A scene and everything that can be asked of it.

use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

use cotree::export::FmiVersion;
use cotree::report::csv::Table;
use cotree::report::statistics::Accumulator;
use cotree::scene::Text;
use cotree::run::{Ended, Ensemble, Measure, Run, points};
use cotree::{Compiled, Scene};
use cotree_fmu::model::Model;
use cotree_study::analysis::{At, Sensitivities, Study};
use cotree_study::bench;
use cotree_study::fit::{FitError, Request, Vary, fit};
use cotree_text::Prose;
use cotree_text::written::Notation;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;
use serde_json::json;

use crate::outcome::{RunError, file_error, interrupted, run_error, scene_error, study_error, wrong};
use crate::request::{self, Columns, Times, Value};

/// How often a running call asks whether the user has pressed Ctrl-C.
const PATIENCE: Duration = Duration::from_millis(50);

/// A scene, with its text: that is what is pickled.
#[pyclass(frozen, module = "cotree._cotree")]
pub struct Core {
    scene: Scene,
    /// What was compiled last, for these additional outputs.
    compiled: Mutex<Option<(Vec<String>, Arc<Ready>)>>,
}

/// A scene that can run.
struct Ready {
    compiled: Compiled,
    model: Arc<Model>,
}

/// A member's values: a row for each time, and why there are no more.
type Rows<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Option<String>);

/// Names with units, the outputs, and their derivatives.
type Derivatives<'py> =
    (Vec<(String, String)>, Vec<(String, String)>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>);

/// The same at rest, with the time.
type AtRest<'py> =
    (Vec<f64>, Vec<(String, String)>, Vec<(String, String)>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>);

#[pymethods]
impl Core {
    /// Reads a scene from a text in TOML or JSON; `name` is that of its file.
    #[new]
    fn new(py: Python<'_>, text: Vec<u8>, name: &str) -> PyResult<Self> {
        let scene = py.detach(|| Scene::from_bytes(Path::new(name), text));
        Ok(Core { scene: scene.map_err(|faults| scene_error(&faults))?, compiled: Mutex::default() })
    }

    /// A scene from files that were read before, each with its path and text, its own first.
    #[staticmethod]
    fn restored(py: Python<'_>, files: Vec<(String, String)>) -> PyResult<Self> {
        let scene = py.detach(|| Scene::from_files(&files));
        Ok(Core { scene: scene.map_err(|faults| scene_error(&faults))?, compiled: Mutex::default() })
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
        let ready = self.ready(py, None)?;
        Ok(ready.compiled.warnings.as_ref().map(|faults| faults.to_json().to_string()))
    }

    /// Every variable as JSON.
    fn variables(&self, py: Python<'_>) -> PyResult<String> {
        let ready = self.ready(py, None)?;
        let variable = |variable: &cotree::export::description::ScalarVariable| {
            let range = variable.causality.range();
            let (start, [min, max]) = range.map_or_else(Default::default, |(start, bounds)| (Some(start), bounds));
            json!({ "name": variable.name, "description": variable.description, "unit": variable.unit.si,
                    "causality": variable.causality.name(), "start": start, "min": min, "max": max })
        };
        Ok(json!(ready.compiled.description.variables.iter().map(variable).collect::<Vec<_>>()).to_string())
    }

    /// Names and units of the outputs.
    fn outputs(&self, py: Python<'_>, outputs: Option<Vec<String>>) -> PyResult<Vec<(String, String)>> {
        let ready = self.ready(py, outputs)?;
        let variables = &ready.compiled.description.variables;
        let named = |index: usize| (variables[index].name.clone(), variables[index].unit.si.clone());
        Ok(ready.compiled.reported().into_iter().map(named).collect())
    }

    /// Runs all members: `names` are set to the rows of `values`, after `settings`. Times and values of each, and why it ended early.
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
    ) -> PyResult<Vec<Rows<'py>>> {
        let ready = self.ready(py, outputs)?;
        let reported = ready.compiled.reported();
        let width = reported.len();
        let all: Vec<f64> = points(times.experiment(ready.compiled.description.experiment)?).collect();
        let ended = self.members(
            py,
            (&ready, &times, &settings, reported, inputs),
            (names, values, threads),
            || Vec::with_capacity(all.len() * width),
            |rows: &mut Vec<f64>, _, values| rows.extend_from_slice(values),
        )?;
        let rows = |(values, failure): (Vec<f64>, Option<String>)| {
            let count = if width == 0 { all.len() } else { values.len() / width };
            let matrix = PyArray1::from_vec(py, values).reshape([count, width])?;
            Ok((PyArray1::from_slice(py, &all[..count]), matrix, failure))
        };
        ended.into_iter().map(rows).collect()
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
        let measures: Result<Vec<Measure>, String> = measures.iter().map(|text| text.parse()).collect();
        let measures = measures.map_err(wrong)?;
        let ready = self.ready(py, Some(measures.iter().map(|measure| measure.variable.clone()).collect()))?;
        let variables = &ready.compiled.description.variables;
        let place = |name: &String| variables.iter().position(|variable| variable.name == *name);
        let reported: Option<Vec<usize>> = measures.iter().map(|measure| place(&measure.variable)).collect();
        let reported = reported.ok_or_else(|| wrong("a variable that was asked for is not computed"))?;
        let columns = measures.iter().zip(&reported);
        let columns = columns.map(|(own, &index)| (own.to_string(), own.unit(&variables[index].unit.si).to_owned()));
        let columns = columns.collect();
        let ended = self.members(
            py,
            (&ready, &times, &settings, reported, inputs),
            (names, values, threads),
            Vec::new,
            Accumulator::add_all,
        )?;
        let (mut table, mut failures) = (Vec::with_capacity(ended.len() * measures.len()), Vec::new());
        for (kept, failure) in ended {
            let number = |(index, own): (usize, &Measure)| match kept.get(index) {
                Some(kept) if failure.is_none() => own.of(kept),
                _ => f64::NAN,
            };
            table.extend(measures.iter().enumerate().map(number));
            failures.push(failure);
        }
        let table = PyArray1::from_vec(py, table).reshape([failures.len(), measures.len()])?;
        Ok((columns, table, failures))
    }

    /// Writes the FMU.
    fn export(&self, py: Python<'_>, path: PathBuf, fmi: &str) -> PyResult<()> {
        let version = request::word("fmi", fmi, &FmiVersion::WORDS)?;
        py.detach(|| cotree_page::export_fmu(&self.scene, version, path)).map_err(|error| match error {
            cotree::ExportFailure::Scene(faults) => scene_error(&faults),
            cotree::ExportFailure::File(error) => file_error(error),
        })
    }

    /// The equations of motion in a notation.
    fn equations(&self, py: Python<'_>, notation: &str) -> PyResult<String> {
        let notation = request::word("notation", notation, &Notation::WORDS)?;
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

    /// The drawing at the start, as SVG.
    fn drawing(&self, py: Python<'_>) -> PyResult<String> {
        let (_, drawing) =
            py.detach(|| cotree_draw::graph::linear_graphs(&self.scene)).map_err(|faults| scene_error(&faults))?;
        Ok(drawing.svg())
    }

    /// The page that shows the mechanism in motion.
    fn page(&self, py: Python<'_>, runtime: Option<Vec<u8>>) -> PyResult<String> {
        let made =
            py.detach(|| cotree_page::moving::page(&self.scene, runtime).map(|(_, page)| page.map(|page| page.html())));
        made.map_err(|faults| scene_error(&faults))?.map_err(RunError::new_err)
    }

    /// Where the mechanism rests, as JSON.
    fn equilibrium(&self, py: Python<'_>, settings: Vec<(String, Value)>) -> PyResult<String> {
        let mut study = self.study(&settings)?;
        let found = py.detach(|| study.equilibrium()).map_err(study_error)?;
        Ok(found.report().data.to_string())
    }

    /// Linear systems as JSON: at the equilibrium, or at these times.
    fn linearize(&self, py: Python<'_>, times: Option<Vec<f64>>, settings: Vec<(String, Value)>) -> PyResult<String> {
        let mut study = self.study(&settings)?;
        let start = study.experiment().start;
        let at = match times {
            None => At::Equilibrium,
            Some(times) if times.is_empty() => At::Times(vec![start]),
            Some(times) => {
                if times.iter().any(|time| !time.is_finite() || *time < start) || !times.is_sorted() {
                    return Err(wrong(format!("times are to be ascending, from the start, {start:?} s, on")));
                }
                At::Times(times)
            }
        };
        let found = py.detach(|| study.linearize(&at)).map_err(study_error)?;
        Ok(found.report().data.to_string())
    }

    /// Vibrations as JSON.
    fn modes(&self, py: Python<'_>, at: Option<f64>, settings: Vec<(String, Value)>) -> PyResult<String> {
        let mut study = self.study(&settings)?;
        let start = study.experiment().start;
        if at.is_some_and(|at| !at.is_finite() || at < start) {
            return Err(wrong(format!("at: is before the start, {start:?} s")));
        }
        let found = py.detach(|| study.modes(at)).map_err(study_error)?;
        Ok(found.report().data.to_string())
    }

    /// Outputs and parameters with their units; the outputs (time, output); their derivatives (time, output, parameter).
    fn sensitivities<'py>(
        &self,
        py: Python<'py>,
        times: Vec<f64>,
        tolerance: Option<f64>,
        of: Option<Vec<String>>,
        to: Vec<String>,
        settings: Vec<(String, Value)>,
    ) -> PyResult<Derivatives<'py>> {
        let mut study = Self::study_of(&self.reporting(of), &settings)?;
        let mut experiment = study.experiment();
        if times.iter().any(|time| !time.is_finite() || *time < experiment.start) || !times.is_sorted() {
            return Err(wrong(format!("times are to be ascending, from the start, {:?} s, on", experiment.start)));
        }
        experiment.tolerance = tolerance.unwrap_or(experiment.tolerance);
        study.set_experiment(request::possible(experiment)?);
        derivatives(py, py.detach(|| study.sensitivities(&to, &times)).map_err(study_error)?)
    }

    /// The same where the mechanism rests, with the time that this stands for.
    fn equilibrium_sensitivities<'py>(
        &self,
        py: Python<'py>,
        of: Option<Vec<String>>,
        to: Vec<String>,
        settings: Vec<(String, Value)>,
    ) -> PyResult<AtRest<'py>> {
        let mut study = Self::study_of(&self.reporting(of), &settings)?;
        let found = py.detach(|| study.equilibrium_sensitivities(&to)).map_err(study_error)?;
        let times = found.times.clone();
        let (outputs, parameters, values, derivatives) = derivatives(py, found)?;
        Ok((times, outputs, parameters, values, derivatives))
    }

    /// Derivatives of eigenvalues, as JSON.
    fn mode_sensitivities(&self, py: Python<'_>, to: Vec<String>, settings: Vec<(String, Value)>) -> PyResult<String> {
        let mut study = self.study(&settings)?;
        let found = py.detach(|| study.mode_sensitivities(&to)).map_err(study_error)?;
        Ok(found.report().data.to_string())
    }

    /// Peaks and crossings with their derivatives, as JSON.
    fn peaks(
        &self,
        py: Python<'_>,
        times: Times,
        of: Option<Vec<String>>,
        to: Vec<String>,
        levels: Vec<(String, f64)>,
        settings: Vec<(String, Value)>,
    ) -> PyResult<String> {
        let mut scene = self.reporting(of);
        for (name, _) in &levels {
            let known = scene.outputs.expressions.iter().any(|own| own.name.text == *name);
            if !known && !scene.outputs.variables.iter().any(|own| own.text == *name) {
                scene.outputs.variables.push(Text::from(name.as_str()));
            }
        }
        let mut study = Self::study_of(&scene, &settings)?;
        let experiment = times.experiment(study.experiment())?;
        study.set_experiment(experiment);
        let at: Vec<f64> = points(experiment).collect();
        let found = py.detach(|| study.features(&to, &at, &levels)).map_err(study_error)?;
        Ok(found.report().data.to_string())
    }

    /// Values that fit what was measured, as JSON: names with bounds, standard deviations of columns.
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn fit(
        &self,
        py: Python<'_>,
        times: Times,
        settings: Vec<(String, Value)>,
        measured: Columns,
        vary: Vec<(String, Option<Value>, Option<Value>)>,
        deviations: Vec<(String, Value)>,
    ) -> PyResult<String> {
        let (at, names, columns) = measured;
        let scene = self.scene.reporting(names.iter().map(String::as_str));
        let table = Table::new(names, at, columns).map_err(|message| wrong(format!("measured: {message}")))?;
        let vary = vary
            .into_iter()
            .map(|(name, low, high)| Vary { name, bounds: [low, high].map(|own| own.map(Value::into_text)) });
        let deviations = deviations.into_iter().map(|(name, value)| (name, value.into_text())).collect();
        let request = Request { table, vary: vary.collect(), deviations };
        let mut study = Self::study_of(&scene, &settings)?;
        study.set_experiment(times.experiment(study.experiment())?);
        let found = py.detach(|| fit(&mut study, &request)).map_err(|error| match error {
            FitError::Study(error) => study_error(error),
            FitError::Request(faults) => wrong(faults.join("\n")),
            FitError::Undetermined(message) => RunError::new_err(message),
        })?;
        Ok(found.report().data.to_string())
    }

    /// Speed against error, as JSON.
    fn bench(&self, py: Python<'_>) -> PyResult<String> {
        let ready = self.ready(py, None)?;
        let measured = py
            .detach(|| bench::measure(&ready.model, &ready.compiled.reported(), ready.compiled.description.experiment));
        let measured = measured.map_err(RunError::new_err)?;
        serde_json::to_string(&measured).map_err(file_error)
    }
}

impl Core {
    /// The compiled scene; with these outputs in place of its own, if any are given.
    fn ready(&self, py: Python<'_>, outputs: Option<Vec<String>>) -> PyResult<Arc<Ready>> {
        let key = outputs.clone().unwrap_or_default();
        if let Some((known, ready)) = &*self.compiled.lock().unwrap_or_else(PoisonError::into_inner)
            && *known == key
        {
            return Ok(Arc::clone(ready));
        }
        let ready = Arc::new(py.detach(|| self.compile(outputs))?);
        *self.compiled.lock().unwrap_or_else(PoisonError::into_inner) = Some((key, Arc::clone(&ready)));
        Ok(ready)
    }

    /// The scene; with these outputs in place of its own, if any are given.
    fn reporting(&self, outputs: Option<Vec<String>>) -> Scene {
        match outputs.filter(|names| !names.is_empty()) {
            Some(names) => self.scene.reporting(names.iter().map(String::as_str)),
            None => self.scene.clone(),
        }
    }

    fn compile(&self, outputs: Option<Vec<String>>) -> PyResult<Ready> {
        let scene = self.reporting(outputs);
        let compiled = cotree::compile(&scene).map_err(|faults| scene_error(&faults))?;
        let model = Model::new(compiled.program.clone()).map_err(|error| RunError::new_err(error.to_string()))?;
        Ok(Ready { compiled, model: Arc::new(model) })
    }

    fn study(&self, settings: &[(String, Value)]) -> PyResult<Study> {
        Self::study_of(&self.scene, settings)
    }

    fn study_of(scene: &Scene, settings: &[(String, Value)]) -> PyResult<Study> {
        let mut study = Study::new(scene).map_err(|faults| scene_error(&faults))?;
        for (name, value) in settings {
            study.set(name, |unit| value.read(unit)).map_err(|message| wrong(format!("{name}: {message}")))?;
        }
        Ok(study)
    }

    /// Runs members in threads, while this one listens for Ctrl-C.
    fn members<C: Send>(
        &self,
        py: Python<'_>,
        (ready, times, settings, reported, inputs): (&Ready, &Times, &[(String, Value)], Vec<usize>, Option<Columns>),
        (names, values, threads): (Vec<String>, PyReadonlyArray2<'_, f64>, usize),
        begin: impl Fn() -> C + Send + Sync,
        point: impl Fn(&mut C, f64, &[f64]) + Send + Sync,
    ) -> PyResult<Vec<(C, Option<String>)>> {
        let description = &ready.compiled.description;
        let experiment = times.experiment(description.experiment)?;
        let settings = request::settings(description, settings)?;
        let inputs = request::inputs(description, inputs)?;
        let members = members(description, &names, &values)?;
        let stop = AtomicBool::new(false);
        let table = inputs.as_ref().map(|(table, variables)| (table, variables.clone()));
        let run = Run { description, experiment, settings, inputs: table, reported };
        let ensemble = Ensemble::new(run, Arc::clone(&ready.model), threads, &stop).map_err(file_error)?;
        let ended = py.detach(|| {
            std::thread::scope(|scope| {
                let (send, receive) = mpsc::channel();
                scope.spawn(move || send.send(ensemble.run(&members, begin, point)));
                loop {
                    match receive.recv_timeout(PATIENCE) {
                        Ok(ended) => return Ok(ended),
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
        })?;
        warn_of(py, &ended)?;
        let outcome = |(collected, ended): (C, Ended)| match ended {
            Ok(_) => Ok((collected, None)),
            Err(error) => Ok((collected, Some(run_error(error).ok_or_else(interrupted)?))),
        };
        ended.into_iter().map(outcome).collect()
    }
}

/// That rounding errors are larger than the tolerance in some runs.
fn warn_of<C>(py: Python<'_>, ended: &[(C, Ended)]) -> PyResult<()> {
    let mut found = ended.iter().filter_map(|(_, ended)| ended.as_ref().ok()?.as_ref());
    let Some(first) = found.next() else { return Ok(()) };
    let of = if ended.len() > 1 { format!("{} of {} runs: ", 1 + found.count(), ended.len()) } else { String::new() };
    let text = CString::new(format!("{of}{first}; {}", first.help())).map_err(|error| wrong(error.to_string()))?;
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)
}

/// As arrays: the outputs (time, output), and their derivatives (time, output, parameter).
fn derivatives(py: Python<'_>, found: Sensitivities) -> PyResult<Derivatives<'_>> {
    let size = [found.times.len(), found.outputs.len(), found.parameters.len()];
    let values: Vec<f64> = found.values.iter().flat_map(|row| row.iter().copied()).collect();
    // Rows first: the last index is the parameter.
    let derivatives: Vec<f64> =
        found.derivatives.iter().flat_map(|matrix| matrix.transpose().data.as_vec().clone()).collect();
    let values = PyArray1::from_vec(py, values).reshape([size[0], size[1]])?;
    let derivatives = PyArray1::from_vec(py, derivatives).reshape(size)?;
    Ok((found.outputs, found.parameters, values, derivatives))
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
