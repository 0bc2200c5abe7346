//! From a scene to the page that shows it in motion.

use std::collections::BTreeMap;
use std::sync::Arc;

use cotree::compile::{Compiled, compile_asking, compile_with_equations, everything};
use cotree::export::description::{Description, ScalarVariable, StartValue};
use cotree::formulate::Formulated;
use cotree::model::{Dimension, DisplayUnit, Experiment, Exponents, Place, Unit, Units};
use cotree::resolve::loosened::Loosened;
use cotree::scene::{Faults, Requested, Scene, Span};
use cotree_draw::drawing::Geometry;
use cotree_draw::pose::{draw, frames, positions};
use cotree_fmu::instance::{Inaccuracy, Instance, InstanceError};
use cotree_fmu::model::Model as Runnable;

use crate::MotionlessError;
use crate::accuracy;
use crate::overview::{Overview, overview};
use crate::page::{
    AbsentValue, Around, Display, DriverLaw, EntryGap, GroundPoint, Live, MotionSource, Page, PageModel, PageVariable,
    PlainNumber, StoredRun, Touch, WrittenLength, WrittenPlace, point_names, prose,
};

/// A stored run has at most so many samples.
const SAMPLES: f64 = 1000.0;
/// The documentation of an FMU moves up to so many bodies, and a page lets so many be touched: it formulates the scene once more, with every variable.
const MOST_BODIES: usize = 100;
/// What is recorded of bodies, joints and loads for the picture, by the last word of a variable's name.
const SEEN: [&str; 13] =
    ["x", "y", "angle", "vx", "vy", "fx", "fy", "fn", "force", "torque", "mode", "sliding", "impulse"];

/// Where the motion of a page comes from.
#[derive(Clone, Debug)]
pub enum MotionOrigin {
    /// The runtime for browsers, in the page.
    Solver(Vec<u8>),
    /// A run that is stored in the page, up to this time \[s\].
    Stored(f64),
    /// The program that has made the page, as long as it lasts; then a run that is stored in it.
    Elsewhere,
}

/// What is made of the equations before they go.
pub(crate) struct Picture {
    pub geometry: Geometry,
    pub points: Vec<Vec<String>>,
    pub ground: Vec<GroundPoint>,
    pub line: bool,
    /// What the scene wants its values shown in.
    units: Units,
}

/// The scene as it was asked for, and its page, with the solver inside if there is a module for it.
///
/// # Errors
/// Everything that is wrong with the scene; the page is an error if its motion cannot be computed at all.
pub fn page(scene: &Scene, module: Option<Vec<u8>>) -> Result<(Compiled, Result<Page, MotionlessError>), Faults> {
    page_with(scene, module.map_or(MotionOrigin::Stored(f64::INFINITY), MotionOrigin::Solver))
}

/// The same for a page in a file or in a frame, whose solver is the program that makes it as long as that lasts.
///
/// # Errors
/// As of [`page`].
pub fn page_solved_elsewhere(scene: &Scene) -> Result<(Compiled, Result<Page, MotionlessError>), Faults> {
    page_with(scene, MotionOrigin::Elsewhere)
}

fn page_with(scene: &Scene, origin: MotionOrigin) -> Result<(Compiled, Result<Page, MotionlessError>), Faults> {
    let (mut compiled, mut formulated) = compile_with_equations(scene)?;
    let Overview { drawing, facts } = overview(&mut formulated);
    let ends = match origin {
        MotionOrigin::Solver(_) => accuracy::end(&compiled),
        MotionOrigin::Stored(_) | MotionOrigin::Elsewhere => None,
    };
    let mut live = moving(scene, &compiled, origin, "view")?;
    if let Ok(Live { model, motion: MotionSource::Solver { .. } | MotionSource::Elsewhere { .. } }) = &mut live {
        model.touch = touch(scene, &model.variables);
        record_coordinates(model);
    }
    let ends = ends.or_else(|| live.as_ref().ok()?.model.cut.clone());
    accuracy::warn_of_end(&mut compiled, ends);
    let page = live.map(|live| Page {
        title: compiled.description.model_name.clone(),
        description: prose(&compiled.description.description),
        still: drawing.svg(),
        facts,
        sections: String::new(),
        live,
    });
    Ok((compiled, page))
}

/// The moving part of the page in an FMU's documentation.
///
/// # Errors
/// Why the page stands still.
pub fn documentation(scene: &Scene, compiled: &Compiled, origin: MotionOrigin) -> Result<Live, MotionlessError> {
    let count = scene.bodies.len();
    if count > MOST_BODIES {
        return Err(MotionlessError(format!(
            "the mechanism has {count} bodies, more than {most}; `cotree view` makes a page of it that moves",
            most = MOST_BODIES
        )));
    }
    moving(scene, compiled, origin, "export")?
}

/// The model and its motion, from the scene with every variable that can be computed; `command` is that which makes the page.
fn moving(
    scene: &Scene,
    compiled: &Compiled,
    origin: MotionOrigin,
    command: &str,
) -> Result<Result<Live, MotionlessError>, Faults> {
    let (everything, mut formulated) = compile_asking(scene, &with_places(scene)?)?;
    let picture = picture(&mut formulated);
    let renew = format!("cotree {command} SCENE.toml --runtimes target/runtimes");
    Ok(assemble(compiled, &everything, picture, origin, renew))
}

/// Every variable that can be computed, and the places of the ground's points.
fn with_places(scene: &Scene) -> Result<Requested, Faults> {
    let (mut names, _) = everything(scene)?;
    if scene.dimension == Dimension::Two {
        let ground =
            scene.ground.iter().flat_map(|point| ["x", "y"].map(|axis| format!("ground.{}.{axis}", point.name.text)));
        names.extend(ground);
    }
    Ok(Requested::Also(names))
}

/// What can be touched; none if the scene is on a line, has no text, many bodies, states of its own or values that are held, or cannot be formulated with its numbers as parameters: some must be known
/// beforehand.
fn touch(scene: &Scene, known: &[PageVariable]) -> Option<Touch> {
    let (file, text) = scene.source.files().next()?;
    if scene.dimension == Dimension::One || text.is_empty() || scene.bodies.len() > MOST_BODIES {
        return None;
    }
    let Loosened { scene: loose, numbers, laws, formulas } = scene.loosened();
    let (everything, formulated) = compile_asking(&loose, &with_places(&loose).ok()?).ok()?;
    if everything.program.states > 0 || formulated.equations.system.mechanism.has_instants() {
        return None;
    }
    let units = &formulated.equations.system.mechanism.display;
    let found = |name: &str| everything.description.variables.iter().find(|variable| variable.name == name);
    let written = |name: String, span: Span, bare: bool| {
        let unit = found(&name).map(|variable| &variable.unit);
        let si = || DisplayUnit { name: unit.map(|unit| unit.si.clone()).unwrap_or_default(), factor: 1.0 };
        let unit = unit.and_then(|unit| unit.display.clone()).unwrap_or_else(si);
        WrittenPlace::new(name, text, span.whole(text), &unit, bare)
    };
    let numbers = numbers.into_iter().filter_map(|number| {
        let variable = variable(found(&number.parameter)?, units);
        Some(PlainNumber { name: number.name, variable, written: written(number.parameter, number.span, false) })
    });
    let laws = laws.into_iter().map(|law| {
        let place = law.span.whole(text);
        let Around { before, after } = law_and_more(text.get(place.start..place.end).unwrap_or_default());
        DriverLaw {
            angle: found(&law.parameter).is_some_and(|variable| variable.unit.si == "rad"),
            driver: law.driver,
            parameter: law.parameter,
            output: law.output,
            place: [place.start, place.end],
            before,
            after,
        }
    });
    let places = values(scene).into_iter().filter(|(_, span, _)| !span.is_nowhere() && span.end <= text.len());
    let places: Vec<WrittenPlace> = places.map(|(name, span, bare)| written(name, span, bare)).collect();
    let coordinates: Vec<String> =
        everything.program.coordinates.iter().map(|coordinate| coordinate.name.clone()).collect();
    let is_known = |name: &String| known.iter().any(|variable| variable.name == *name);
    let absent = known.iter().filter(|variable| places.iter().all(|place| place.name != variable.name));
    let absent =
        absent.filter(|variable| variable.kind == "input" || variable.initial || coordinates.contains(&variable.name));
    let absent: Vec<AbsentValue> = absent.filter_map(|variable| absent_value(scene, variable)).collect();
    coordinates.iter().all(is_known).then(|| Touch {
        program: everything.program.to_bytes().unwrap_or_default(),
        variables: everything.description.variables.iter().map(|variable| variable.name.clone()).collect(),
        coordinates: coordinates.clone(),
        numbers: numbers.collect(),
        formulas: formulas
            .into_iter()
            .map(|formula| WrittenLength { name: formula.name, text: formula.text, output: formula.output })
            .collect(),
        laws: laws.collect(),
        absent,
        gaps: ["inputs", "initial"].into_iter().filter_map(|table| entry_gap(scene, table)).collect(),
        written: places,
        file: file.to_owned(),
        text: text.to_owned(),
    })
}

/// A law as it is written, with room for a number that is added to it, in SI units. A sum binds least, but a unit needs its brackets.
fn law_and_more(written: &str) -> Around {
    let quote = written.get(..1).filter(|quote| matches!(*quote, "\"" | "'"));
    let law = quote.and_then(|quote| written.strip_prefix(quote)?.strip_suffix(quote)).unwrap_or(written);
    let begins = law.len()
        - law.trim_start_matches(|letter: char| letter.is_whitespace() || "+-.0123456789".contains(letter)).len();
    let (number, unit) = law.split_at(exponent(law, begins));
    let is_plain = unit.trim_start().starts_with(|letter: char| letter.is_alphabetic() || letter == '°')
        && !unit.contains(['*', '+', '-']);
    let law = match is_plain && number.trim().parse::<f64>().is_ok() {
        true => format!("{}[{}]", number.trim_end(), unit.trim()),
        false => law.to_owned(),
    };
    let quote = quote.unwrap_or("\"");
    Around { before: format!("{quote}{law} "), after: quote.to_owned() }
}

/// Where a number ends whose digits end here: behind its exponent, if it has one.
fn exponent(text: &str, digits: usize) -> usize {
    let rest = text.get(digits..).unwrap_or_default();
    let Some(exponent) = rest.strip_prefix(['e', 'E']) else { return digits };
    let unsigned = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
    let after = unsigned.trim_start_matches(|letter: char| letter.is_ascii_digit());
    if after.len() == unsigned.len() { digits } else { text.len() - after.len() }
}

/// How the scene's text gets a value that it does not have.
fn absent_value(scene: &Scene, variable: &PageVariable) -> Option<AbsentValue> {
    /// Stands for the number.
    const NUMBER: &str = "\u{1}";
    let value = if variable.unit.is_empty() { NUMBER.to_owned() } else { format!("\"{NUMBER} {}\"", variable.unit) };
    let table = if variable.kind == "input" { "inputs" } else { "initial" };
    let gap = scene.gap(table).ok()?;
    let around = |value: &str| {
        let entry = gap.entry(&variable.name, value);
        let (before, after) = entry.split_once(NUMBER)?;
        Some(Around { before: before.to_owned(), after: after.to_owned() })
    };
    let known = if table == "inputs" { around(&gap.table("start", &value))? } else { around(&value)? };
    Some(AbsentValue { name: variable.name.clone(), table, known, guess: around(&gap.table("guess", &value))? })
}

fn entry_gap(scene: &Scene, table: &'static str) -> Option<(&'static str, EntryGap)> {
    let gap = scene.gap(table).ok()?;
    Some((table, EntryGap { at: gap.at, head: gap.head, separator: gap.separator, tail: gap.tail }))
}

/// Where the values of parameters, inputs and initial values are written, and whether a unit beside them holds for bare numbers.
pub(crate) fn values(scene: &Scene) -> Vec<(String, Span, bool)> {
    let parameters = scene.parameters.iter().map(|parameter| (&parameter.name, parameter.value.span, true));
    let inputs = scene.inputs.iter().filter_map(|input| Some((&input.name, input.start.as_ref()?.span, true)));
    let initial = scene.initial.iter().map(|initial| (&initial.variable, initial.value.span, false));
    parameters.chain(inputs).chain(initial).map(|(name, span, bare)| (name.text.clone(), span, bare)).collect()
}

/// A body is pulled from the pose that is seen: a run has its coordinates.
fn record_coordinates(model: &mut PageModel) {
    let names = model.touch.iter().flat_map(|touch| &touch.coordinates);
    let lacking: Vec<String> = names.filter(|name| !model.recorded.contains(name)).cloned().collect();
    model.recorded.extend(lacking);
}

pub(crate) fn picture(formulated: &mut Formulated) -> Picture {
    let mechanism = &*formulated.equations.system.mechanism.clone();
    let frames = frames(formulated);
    let places = positions(formulated, (0..mechanism.ground.len()).map(Place::Ground));
    let ground = mechanism.ground.iter().zip(places);
    Picture {
        points: point_names(mechanism),
        line: mechanism.dimension == Dimension::One,
        ground: ground.map(|(point, at)| GroundPoint { name: point.name.clone(), at }).collect(),
        units: mechanism.display.clone(),
        geometry: draw(formulated).geometry(&frames),
    }
}

fn assemble(
    compiled: &Compiled,
    everything: &Compiled,
    picture: Picture,
    origin: MotionOrigin,
    renew: String,
) -> Result<Live, MotionlessError> {
    let description = &everything.description;
    let named = |indices: &[usize], of: &Description| -> Vec<String> {
        indices.iter().map(|&index| of.variables[index].name.clone()).collect()
    };
    let outputs = named(&compiled.reported(), &compiled.description);
    let has = |name: &String| description.variables.iter().any(|variable| variable.name == *name);
    let recorded: Vec<usize> = (0..description.variables.len())
        .filter(|&index| {
            let variable = &description.variables[index];
            variable.causality.follows_motion() && (outputs.contains(&variable.name) || is_seen(&variable.name))
        })
        .collect();
    let mut model = PageModel {
        geometry: picture.geometry,
        points: picture.points,
        ground: picture.ground,
        line: picture.line,
        variables: description.variables.iter().map(|scalar| variable(scalar, &picture.units)).collect(),
        units: displayed(&description.variables, &picture.units),
        outputs: outputs.iter().filter(|name| has(name)).cloned().collect(),
        recorded: named(&recorded, description),
        stored: Vec::new(),
        cut: None,
        warning: None,
        renew,
        experiment: description.experiment.into(),
        touch: None,
    };
    let motion = match origin {
        MotionOrigin::Solver(module) => {
            let program = everything.program.to_bytes()?;
            MotionSource::Solver { module, program }
        }
        MotionOrigin::Stored(until) => MotionSource::Stored(stored(everything, &recorded, until, &mut model)?),
        MotionOrigin::Elsewhere => {
            let program = everything.program.to_bytes()?;
            MotionSource::Elsewhere { program, run: stored(everything, &recorded, f64::INFINITY, &mut model)? }
        }
    };
    Ok(Live { model, motion })
}

/// The run that a page plays by itself, up to this time; the model is told what is in it.
fn stored(
    everything: &Compiled,
    recorded: &[usize],
    until: f64,
    model: &mut PageModel,
) -> Result<StoredRun, MotionlessError> {
    let experiment = everything.description.experiment;
    let stop = until.min(experiment.stop);
    let whole = stop == experiment.stop;
    let part = Experiment { stop, ..experiment };
    let count = ((stop - part.start) / part.step).ceil().clamp(1.0, SAMPLES);
    let SampledRun { times, columns, cut, inaccuracy } = sampled(everything, recorded, part, count as u32)?;
    let columns = columns.iter().map(|column| column.iter().map(|&value| value as f32).collect());
    model.stored = model.recorded.clone();
    let early = || format!("The stored run ends at {stop:.3} s, because it is expensive to compute.");
    model.cut = cut.or_else(|| (!whole).then(early));
    model.warning = inaccuracy.map(|found| format!("Warning: {found}; {}", found.help()));
    Ok(StoredRun { times, columns: columns.collect() })
}

/// Of points the places only.
fn is_seen(name: &str) -> bool {
    let words: Vec<&str> = name.split('.').collect();
    match words[..] {
        [_, _, last] => matches!(last, "x" | "y"),
        [_, last] => SEEN.contains(&last),
        _ => false,
    }
}

/// The units that the scene wants instead of SI units: those of its variables, and of what the page says beside them.
fn displayed(variables: &[ScalarVariable], units: &Units) -> BTreeMap<String, Display> {
    let newton = Unit { exponents: Exponents::NEWTON, si: "N".to_owned(), display: None };
    let others = [Unit::time(), Unit::length(), Unit::angle(), newton];
    let all = variables.iter().map(|variable| &variable.unit).chain(&others);
    let wanted = all.map(|unit| (unit.si.clone(), units.of(unit)));
    wanted.filter(|(si, unit)| *si != unit.name).map(|(si, unit)| (si, Display::from(unit))).collect()
}

fn variable(variable: &ScalarVariable, units: &Units) -> PageVariable {
    let (start, [min, max]) =
        variable.causality.range().map_or_else(Default::default, |(start, bounds)| (Some(start), bounds));
    let known = match variable.start {
        Some(StartValue::Exact(value)) => Some(value),
        _ => None,
    };
    let wanted = units.of(&variable.unit);
    let wanted = (wanted.name != variable.unit.si).then_some(wanted);
    PageVariable {
        name: variable.name.clone(),
        text: variable.description.clone(),
        kind: variable.causality.name(),
        unit: variable.unit.si.clone(),
        display: wanted.or_else(|| variable.unit.display.clone()).map(Display::from),
        start: start.or(known),
        min,
        max,
        initial: known.is_some() && start.is_none(),
    }
}

/// A run at regular times.
pub(super) struct SampledRun {
    pub times: Vec<f64>,
    /// A column for each variable.
    pub columns: Vec<Vec<f64>>,
    /// Why it ends early, if it does.
    pub cut: Option<String>,
    pub inaccuracy: Option<Inaccuracy>,
}

/// A run with the scene's values, in so many equal parts.
///
/// # Errors
/// Why it has no start.
pub(super) fn sampled(
    compiled: &Compiled,
    recorded: &[usize],
    part: Experiment,
    count: u32,
) -> Result<SampledRun, MotionlessError> {
    let model = Runnable::new(compiled.program.clone())?;
    let mut instance = Instance::new(Arc::new(model));
    let (mut times, mut columns) = (Vec::new(), vec![Vec::new(); recorded.len()]);
    let mut sample = |index: u32| -> Result<(), InstanceError> {
        let time = part.start + (part.stop - part.start) * f64::from(index) / f64::from(count.max(1));
        if index == 0 {
            instance.setup(part.start, Some(part.stop), Some(part.tolerance))?;
            instance.initialise()?;
        } else if time > instance.time() {
            instance.step_to(time)?;
        }
        let values: Vec<f64> = recorded.iter().map(|&variable| instance.reading(variable)).collect::<Result<_, _>>()?;
        columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        times.push(time);
        Ok(())
    };
    let ended = (0..=count).try_for_each(&mut sample);
    let inaccuracy = instance.take_inaccuracy();
    match ended {
        Err(error) if times.is_empty() => Err(error.into()),
        ended => Ok(SampledRun { times, columns, cut: ended.err().map(|error| error.to_string()), inaccuracy }),
    }
}
