//! What the command has beside runs and studies: the same functions of the library, for Python.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cotree::Faults;
use cotree::compile::{compile_asking, everything, quantity};
use cotree::diagnostic::{lines, suggest};
use cotree::export::runtime::{Platform, Runtime, default_folder};
use cotree::export::{ExportError, FmiVersion};
use cotree::formulate::assemblies::{CoordinateValue as Placed, assemblies as found_from};
use cotree::formulate::{Formulated, formulate_written};
use cotree::import::import;
use cotree::model::{Unit, Units, identifier};
use cotree::report::csv::CsvTable;
use cotree::report::data::Report;
use cotree::report::inspect::Contents;
use cotree::report::statistics::{RunStatistics, VariableFigures};
use cotree::scene::Requested;
use cotree::task::Task;
use cotree_draw::graph::GraphDrawing;
use cotree_draw::png::{Size, png as drawn_as_png};
use cotree_draw::pose::{draw, draw_at};
use cotree_draw::{dxf, study};
use cotree_page::film::{self, Take, Taken};
use cotree_page::moving::MotionOrigin;
use cotree_page::{accuracy, documentation, moving, overview};
use cotree_study::analysis::{Study, state_at};
use cotree_study::compare;
use cotree_study::fit::Vary;
use cotree_study::motion::{self, MotionError, MotionRequest};
use cotree_study::optimize::{self, Aim, Goal, MeasureLimit, OptimizeError};
use cotree_study::sweep::{Design, DesignFactor, Sampling};
use cotree_study::synthesis;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::json;

use crate::listening::{self, Watched, interruptible};
use crate::outcome::{RunError, failed, file_error, scene_error, study_error, warn, warn_of, wrong};
use crate::request::{self, Columns, Times, Value};
use crate::scene::{Core, for_browsers, listened};

/// More pictures than this are a mistake in the rate or the speed.
const MOST_PICTURES: u32 = 100_000;

/// As JSON, as the command prints it, as its table (CSV), and as its picture (SVG), if there is one.
type Told = (String, String, String, Option<String>);

/// Settings by name.
type Settings = Vec<(String, Value)>;

fn told(report: &Report, data: String, units: &Units, picture: Option<String>) -> Told {
    (data, report.text(units), report.csv(&Units::default()), picture)
}

/// Equations of a study, with what was set.
fn formulated(py: Python<'_>, core: &Core, settings: &Settings) -> PyResult<Formulated> {
    let study = core.study(None, settings, None)?;
    let faults = |list| Faults::new(core.scene().source.clone(), list);
    py.detach(|| formulate_written(study.mechanism(), &[])).map_err(|list| study_error(faults(list).into(), settings))
}

/// What a mechanism does in one turn or stroke of its input.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "keywords in Python")]
pub fn turned(
    py: Python<'_>,
    core: &Bound<'_, Core>,
    names: (Option<String>, Option<String>, Option<String>),
    speed: Option<Value>,
    range: Option<(Value, Value)>,
    every: Option<Value>,
    dwell: Option<Value>,
    fluctuation: Option<f64>,
    settings: Settings,
) -> PyResult<Told> {
    let core = core.get();
    let study = core.study(None, &settings, None)?;
    let (input, output, point) = names;
    let request = MotionRequest { input, output, point, ..MotionRequest::default() };
    let [input_unit, of_output] = motion::units(core.scene(), &request).map_err(|error| refused(error, &settings))?;
    let number = |name: &str, value: &Value, unit: &Unit| {
        value.read(unit).map_err(|message| wrong(format!("{name}: {message}")))
    };
    let given = |name: &str, value: &Option<Value>, unit: &Unit| {
        value.as_ref().map(|value| number(name, value, unit)).transpose()
    };
    let range = range
        .map(|(from, to)| Ok::<_, PyErr>([number("range", &from, &input_unit)?, number("range", &to, &input_unit)?]));
    let units = study.display().clone().before(&motion::usual());
    let request = MotionRequest {
        speed: given("speed", &speed, &input_unit.per_second())?,
        range: range.transpose()?,
        every: given("every", &every, &input_unit)?,
        dwell: given("dwell", &dwell, &of_output)?,
        fluctuation,
        units: units.clone(),
        ..request
    };
    let found = interruptible(py, || motion::study_of(core.scene(), study.mechanism(), &request))?;
    let found = found.map_err(|error| refused(error, &settings))?;
    let data = serde_json::to_string(&found).map_err(file_error)?;
    Ok(told(&found.report(), data, &units, Some(study::motion::plot(&found, &units).svg())))
}

fn refused(error: MotionError, settings: &Settings) -> PyErr {
    match error {
        MotionError::Scene(faults) => study_error(faults.into(), settings),
        MotionError::Request(message) => wrong(message),
        MotionError::Run(error) => RunError::new_err(error.to_string()),
    }
}

/// The ways in which the loops close, as JSON.
#[pyfunction]
pub fn assemblies(py: Python<'_>, core: &Bound<'_, Core>, starts: usize, settings: Settings) -> PyResult<String> {
    let core = core.get();
    let study = core.study(None, &settings, None)?;
    let faults = |list| Faults::new(core.scene().source.clone(), list);
    let found = interruptible(py, || found_from(study.mechanism(), starts))?;
    let found = found.map_err(|list| study_error(faults(list).into(), &settings))?;
    let values = |values: &[Placed]| -> serde_json::Value {
        values.iter().map(|value| (value.name.clone(), json!(value.value))).collect::<serde_json::Map<_, _>>().into()
    };
    let poses: Vec<_> = found.poses.iter().map(|pose| values(pose)).collect();
    Ok(json!({ "held": values(&found.held), "poses": poses, "found": found.found, "own": found.is_own,
               "continuous": found.is_continuous() })
    .to_string())
}

/// The points of which the scene reports both coordinates.
#[pyfunction]
pub fn traced(core: &Bound<'_, Core>) -> Vec<String> {
    film::points(core.get().scene()).into_iter().map(str::to_owned).collect()
}

/// The profile of a cam in its axes with the shaft as origin: angles, the places of contact, those of the follower's point.
#[pyfunction]
pub fn profile<'py>(
    py: Python<'py>,
    core: &Bound<'_, Core>,
    name: &str,
    count: usize,
    settings: Settings,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
    let study = core.get().study(None, &settings, None)?;
    let mechanism = study.mechanism();
    let cams = mechanism.profiles(&mechanism.parameter_values());
    let Some(cam) = cams.iter().find(|cam| cam.name == name) else {
        let known = suggest::known(name, cams.iter().map(|cam| cam.name.as_str()));
        return Err(wrong(format!("the scene has no cam `{name}`; {known}")));
    };
    let samples = cam.samples(count);
    let from_shaft = |[x, y]: [f64; 2]| [x - cam.hub[0], y - cam.hub[1]];
    let places = |of: &dyn Fn(usize) -> [f64; 2]| {
        let places: Vec<f64> = (0..samples.len()).flat_map(|index| from_shaft(of(index))).collect();
        PyArray1::from_vec(py, places).reshape([samples.len(), 2])
    };
    let angles = PyArray1::from_iter(py, samples.iter().map(|sample| sample.angle));
    Ok((angles, places(&|index| samples[index].contact)?, places(&|index| samples[index].point)?))
}

/// Curves as a drawing for CAD (DXF).
#[pyfunction]
pub fn curves(curves: Vec<(String, Vec<[f64; 2]>)>) -> String {
    dxf::curves(&curves)
}

/// A picture as PNG, so many pixels wide.
#[pyfunction]
pub fn png<'py>(py: Python<'py>, svg: &str, width: f32) -> PyResult<Bound<'py, PyBytes>> {
    let drawn = py.detach(|| drawn_as_png(svg, Size::Wide(width))).map_err(|error| wrong(error.to_string()))?;
    Ok(PyBytes::new(py, &drawn))
}

/// A linkage of another program as the text of a scene, and what was assumed.
#[pyfunction]
pub fn imported(py: Python<'_>, name: &str, text: &str) -> PyResult<(String, Vec<String>)> {
    let made = py.detach(|| import(&identifier(name), text)).map_err(|faults| wrong(faults.join("\n")))?;
    Ok((made.scene, made.notes))
}

/// A run in figures.
#[pyfunction]
pub fn summary(times: Vec<f64>, columns: Vec<(String, String, Vec<f64>)>) -> PyResult<Told> {
    let figures = columns.iter().filter_map(|(name, unit, values)| VariableFigures::of(name, unit, &times, values));
    let span = [times.first(), times.last()].map(|time| time.copied().unwrap_or_default());
    let found = RunStatistics { time_unit: "s".to_owned(), span, variables: figures.collect() };
    let data = serde_json::to_string(&found).map_err(file_error)?;
    Ok(told(&found.report(), data, &Units::default(), None))
}

/// The runs of a sweep, each found by its number.
#[pyclass(frozen, module = "cotree._cotree")]
pub struct Runs(Design);

#[pymethods]
impl Runs {
    fn __len__(&self) -> usize {
        self.0.len()
    }

    /// What is varied.
    fn names(&self) -> Vec<String> {
        self.0.factors().iter().map(|factor| factor.name.clone()).collect()
    }

    /// Of a grid how many levels each name has.
    fn shape(&self) -> Option<Vec<usize>> {
        self.0.shape()
    }

    /// Tells designs apart.
    fn digest(&self) -> u64 {
        self.0.digest()
    }

    /// The values of some of the runs: a row for each.
    fn rows<'py>(&self, py: Python<'py>, begin: usize, end: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let runs = begin.min(self.0.len())..end.min(self.0.len());
        let size = [runs.len(), self.0.factors().len()];
        PyArray1::from_vec(py, runs.flat_map(|run| self.0.values(run)).collect()).reshape(size)
    }
}

/// The runs of a sweep.
#[pyfunction]
pub fn design(
    py: Python<'_>,
    core: &Bound<'_, Core>,
    factors: Vec<String>,
    drawn: Option<(bool, usize)>,
    seed: u64,
) -> PyResult<Runs> {
    let names: Vec<String> =
        factors.iter().filter_map(|text| text.split_once('=')).map(|(name, _)| name.trim().to_owned()).collect();
    let ready = core.get().ready_for(py, None, &[], &names)?;
    let description = &ready.compiled.description;
    let read = |text: &String| DesignFactor::read(description, text).map_err(|message| format!("{text}: {message}"));
    let factors =
        cotree::diagnostic::every(factors.iter().map(read)).map_err(|faults: Vec<String>| wrong(faults.join("\n")))?;
    let design = match drawn {
        None => Design::grid(factors),
        Some((latin, count)) => {
            let kind = if latin { Sampling::Latin } else { Sampling::Random };
            Design::random(factors, kind, count, seed)
        }
    };
    Ok(Runs(design.map_err(wrong)?))
}

/// The mechanism at its start or at a time, as SVG or DXF.
#[pyfunction]
pub fn drawing(
    py: Python<'_>,
    core: &Bound<'_, Core>,
    at: Option<f64>,
    settings: Settings,
    format: &str,
) -> PyResult<String> {
    let as_dxf = request::word("format", format, &[("svg", "", false), ("dxf", "", true)])?;
    let mut formulated = formulated(py, core.get(), &settings)?;
    let start = formulated.lowered.program.experiment.start;
    let drawing = match at {
        None => draw(&mut formulated),
        Some(time) if !(time.is_finite() && time >= start) => {
            return Err(wrong(format!("at: {time:?} s is before the start, {start:?} s")));
        }
        Some(time) => {
            let state = interruptible(py, || state_at(&formulated, time))?;
            draw_at(&mut formulated, &state.map_err(|error| RunError::new_err(error.to_string()))?)
        }
    };
    Ok(if as_dxf { drawing.dxf() } else { drawing.svg() })
}

/// The linear graphs, as SVG or for Graphviz.
#[pyfunction]
pub fn graph(py: Python<'_>, core: &Bound<'_, Core>, format: &str) -> PyResult<String> {
    let for_graphviz = request::word("format", format, &[("svg", "", false), ("dot", "", true)])?;
    let mut formulated = formulated(py, core.get(), &Vec::new())?;
    let graphs = GraphDrawing::new(&mut formulated);
    Ok(if for_graphviz { graphs.dot() } else { graphs.svg(&draw(&mut formulated)) })
}

/// What other trees would cost.
#[pyfunction]
pub fn comparison(py: Python<'_>, core: &Bound<'_, Core>) -> PyResult<Told> {
    let scene = core.get().scene();
    let found = interruptible(py, || compare::comparison(scene))?.map_err(|faults| scene_error(&faults))?;
    let data = serde_json::to_string(&found).map_err(file_error)?;
    Ok(told(&found.report(), data, &Units::default(), None))
}

/// Writes the FMU: for these platforms, whose runtimes lie in a folder; for this one if none is named.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "keywords in Python")]
pub fn export(
    py: Python<'_>,
    core: &Bound<'_, Core>,
    path: PathBuf,
    fmi: &str,
    platforms: Vec<String>,
    folder: Option<PathBuf>,
    extent: (bool, bool),
) -> PyResult<()> {
    let (all, lean) = extent;
    let version = request::word("fmi", fmi, &FmiVersion::WORDS)?;
    let runtimes = libraries(&platforms, folder.as_deref())?;
    let module = if lean { None } else { for_browsers(folder.as_deref())? };
    let scene = core.get().scene();
    let written = py.detach(|| {
        let (more, left_out) = if all { everything(scene)? } else { Default::default() };
        let (mut compiled, mut formulated) = compile_asking(scene, &Requested::Also(more))?;
        let overview = overview::overview(&mut formulated);
        compiled.warn(left_out);
        let accuracy = accuracy::of(&compiled);
        let affordable = accuracy::affordable(&compiled, &accuracy);
        let origin = module.map_or(MotionOrigin::Stored(affordable), MotionOrigin::Solver);
        let live = moving::documentation(scene, &compiled, origin);
        let (drawing, facts) = (&overview.drawing, &overview.facts);
        let page = documentation::DocumentationPage { drawing, facts, accuracy: &accuracy, live: &live };
        let written = page.files(&compiled.description, version).map_err(ExportError::from);
        Ok(written.and_then(|extras| compiled.write_fmu(version, extras, &runtimes, &path)))
    });
    written.map_err(|faults: Faults| scene_error(&faults))?.map_err(file_error)
}

fn libraries(platforms: &[String], folder: Option<&Path>) -> PyResult<Vec<Runtime>> {
    if platforms.is_empty() {
        return Ok(vec![Runtime::embedded().map_err(file_error)?]);
    }
    let named =
        platforms.iter().map(|name| Platform::named(name).map_err(|error| wrong(format!("platforms: {error}"))));
    let named = named.collect::<PyResult<Vec<Platform>>>()?;
    let folder = folder.map_or_else(default_folder, Path::to_path_buf);
    named.into_iter().map(|platform| Runtime::find(platform, &folder).map_err(file_error)).collect()
}

/// The variables that a film shows: those without which there is none, and the others.
#[pyfunction]
pub fn film_variables(core: &Bound<'_, Core>) -> PyResult<[Vec<String>; 2]> {
    film::film_variables(core.get().scene()).map_err(|faults| scene_error(&faults))
}

/// A film that moves by itself (SVG), or pictures of it (PNG): of the scene's motion, or of one that is given.
#[pyfunction]
pub fn filmed<'py>(
    py: Python<'py>,
    core: &Bound<'py, Core>,
    motion: Option<Columns>,
    speed: f64,
    pictures: Option<(f64, f32)>,
) -> PyResult<(String, Vec<Bound<'py, PyBytes>>, Option<String>)> {
    for (name, value) in [("speed", Some(speed)), ("fps", pictures.map(|(rate, _)| rate))] {
        if value.is_some_and(|value| !(value > 0.0 && value.is_finite())) {
            return Err(wrong(format!("{name}: must be positive")));
        }
    }
    let scene = core.get().scene();
    let take = Take { rate: pictures.map(|(rate, _)| rate), speed };
    let motion = motion.map(|(times, names, columns)| request::table(names, times, columns)).transpose()?;
    let taken = interruptible(py, || match &motion {
        Some(motion) => film::film_of(scene, motion, take, MOST_PICTURES),
        None => film::film(scene, take, MOST_PICTURES).map(|(_, taken)| taken),
    })?;
    let taken = taken.map_err(|faults| scene_error(&faults))?;
    let Taken { film, cut, inaccuracy } = taken.map_err(failed)?;
    inaccuracy.iter().try_for_each(|found| warn(py, "", found))?;
    let count = film.len();
    let cut = cut.map(|error| format!("{error}; the film has the {count} pictures before that"));
    let Some((_, width)) = pictures else { return Ok((film.svg(), Vec::new(), cut)) };
    let frames = interruptible(py, || {
        let picture = |sample| match listening::wants_end() {
            true => Err("interrupted".to_owned()),
            false => drawn_as_png(&film.frame(sample), Size::Wide(width)).map_err(|error| error.to_string()),
        };
        (0..count).map(picture).collect::<Result<Vec<_>, _>>()
    })?;
    let frames = frames.map_err(wrong)?;
    Ok((String::new(), frames.iter().map(|frame| PyBytes::new(py, frame)).collect(), cut))
}

/// Linkages for a task, the text of one or its file: what was found, and the scenes of those that are good.
#[pyfunction]
pub fn synthesize(
    py: Python<'_>,
    text: Option<&str>,
    path: Option<PathBuf>,
    all: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Told, Vec<String>)> {
    let watched = Watched::new(progress);
    let found = interruptible(py, || {
        let task = match (text, &path) {
            (_, Some(path)) => Task::read(path)?,
            (text, None) => Task::from_text(text.unwrap_or_default())?,
        };
        Ok((synthesis::synthesize_watched(&task, all, &|done, all| _ = watched.tell(done, all))?, task.warnings))
    })?;
    watched.raised()?;
    let (answer, warnings): (_, Option<Faults>) = found.map_err(|faults: Faults| scene_error(&faults))?;
    warnings.iter().try_for_each(|faults| warn_of(py, faults))?;
    let report = answer.report();
    let picture = (!answer.solutions.is_empty()).then(|| study::synthesis::picture(&answer));
    let scenes = answer.good().filter_map(|solution| solution.scene.clone()).collect();
    Ok((told(&report, report.json(), &synthesis::report::usual(), picture), scenes))
}

/// The best values: names with bounds, what is to be small, large or matched, limits.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "keywords in Python")]
pub fn optimized(
    py: Python<'_>,
    core: &Bound<'_, Core>,
    times: Times,
    settings: Settings,
    vary: Vec<(String, Option<Value>, Option<Value>)>,
    aim: (String, Option<String>, Option<Columns>),
    limits: Vec<String>,
    turn: Option<(String, Option<String>)>,
    extent: (usize, u64, usize),
    progress: Option<Py<PyAny>>,
) -> PyResult<Told> {
    let (starts, seed, threads) = extent;
    let core = core.get();
    let vary = vary
        .into_iter()
        .map(|(name, low, high)| Vary { name, bounds: [low, high].map(|bound| bound.map(|value| value.to_string())) });
    let limit =
        |text: &String| text.parse::<MeasureLimit>().map_err(|message| wrong(format!("subject_to: {text}: {message}")));
    let request = optimize::OptimizeRequest {
        vary: vary.collect(),
        aim: aimed(aim)?,
        limits: limits.iter().map(limit).collect::<PyResult<_>>()?,
        turn: turn.map(|(input, output)| MotionRequest { input: Some(input), output, ..MotionRequest::default() }),
        starts,
        seed,
        threads,
    };
    let mut study: Study = core.study_of(&Requested::these(request.variables()), &settings, None)?;
    study.set_experiment(times.experiment(study.experiment())?);
    let stop = Arc::new(AtomicBool::new(false));
    let watched = Watched::new(progress);
    let goes_on = |now: optimize::SearchProgress| watched.tell(now.done, now.all) && !stop.load(Ordering::Relaxed);
    let found = py.detach(|| {
        listened(&stop, || {
            listening::follow(&stop);
            optimize::optimize(core.scene(), &mut study, &request, &goes_on)
        })
    })?;
    watched.raised()?;
    let found = found.map_err(|error| match error {
        OptimizeError::Study(error) => study_error(error, &settings),
        OptimizeError::Request(faults) => wrong(lines(&faults)),
        error @ (OptimizeError::Unmet { .. } | OptimizeError::Stopped | OptimizeError::OtherBranch) => failed(error),
    })?;
    let report = found.report();
    Ok(told(&report, report.json(), study.display(), None))
}

fn aimed((kind, goal, table): (String, Option<String>, Option<Columns>)) -> PyResult<Aim> {
    if let Some((times, names, columns)) = table {
        let table = CsvTable::new(names, times, columns);
        return Ok(Aim::Match(table.map_err(|message| wrong(format!("{kind}: {message}")))?));
    }
    let goal = goal.unwrap_or_default();
    let goal = goal.parse::<Goal>().map_err(|message| wrong(format!("{kind}: {goal}: {message}")))?;
    Ok(if kind == "maximize" { Aim::Most(goal) } else { Aim::Least(goal) })
}

/// What is in an FMU, as the command says it, and its scene.
#[pyfunction]
pub fn contents(path: PathBuf) -> PyResult<(String, Option<String>)> {
    let contents = Contents::read(&path).map_err(file_error)?;
    Ok((contents.to_string(), contents.scene))
}

/// A time in seconds from a text such as `20 ms`.
#[pyfunction]
pub fn seconds(text: &str) -> PyResult<f64> {
    quantity(text, &Unit::time()).map_err(wrong)
}
