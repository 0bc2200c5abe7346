//! A scene that is driven at one joint with constant speed, through one turn or a given range.

use std::collections::{BTreeSet, HashMap};
use std::f64::consts::TAU;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::component::body::{POINT_VARIABLES, VARIABLES};
use cotree::formulate;
use cotree::model::{Body, Class, Dimension, JointId, Mechanism, Part, Place, Quantity};
use cotree::run::{RunError, SimulateError};
use cotree::scene::constant::evaluate;
use cotree::scene::{Driver, Faults, Input, Load, Scene, Text};
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;

use super::samples::{ANGULAR, Derivatives, SLIDING, Samples};
use super::{Drive, MotionError};

/// Samples of one turn, and of a range, that are shown.
pub const COUNT: usize = 720;
/// The tolerance of the runs: the finest but for rounding errors.
const TOLERANCE: f64 = 1e-12;
/// A start nearer to the first sample than this share of a step is there.
const AT_ONCE: f64 = 1e-9;
/// Samples of each piece of a cam's law between two of its switches, at least, and so many for each that is shown, at most.
const PIECE: f64 = 12.0;
const FINEST: usize = 256;
/// The driver that moves the input.
const DRIVER: &str = "cotree_drive";
/// Where the input is held.
const PLACE: &str = "cotree_place";

/// Values of variables over the input.
#[derive(Clone, Debug)]
pub struct Table {
    /// First input and step.
    grid: [f64; 2],
    /// Is it one turn after which everything is as before?
    pub periodic: bool,
    columns: HashMap<String, Vec<f64>>,
}

impl Table {
    /// A variable; none if the scene lacks what it needs.
    pub fn get(&self, name: &str) -> Option<Samples> {
        Some(Samples::new(self.grid, self.columns.get(name)?.clone(), self.periodic))
    }

    /// The same with what belongs to each sample instead, or besides.
    fn with(self, columns: HashMap<String, Vec<f64>>) -> Table {
        Table { columns: self.columns.into_iter().chain(columns).collect(), ..self }
    }

    /// Values that are made of others, for each sample.
    pub fn made<const N: usize>(&self, names: [String; N], of: impl Fn([f64; N]) -> f64) -> Option<Samples> {
        let columns: Vec<&Vec<f64>> = names.iter().map(|name| self.columns.get(name)).collect::<Option<_>>()?;
        let value = |index: usize| of(std::array::from_fn(|name| columns[name][index]));
        Some(Samples::new(self.grid, (0..self.count()).map(value).collect(), self.periodic))
    }

    /// The derivative of a variable by the input, from its neighbours: for what has no rate of its own.
    pub fn slope(&self, of: &Samples, turns: bool) -> Samples {
        let slope = if turns { of.unwound().slope() } else { of.slope() };
        Samples::new(self.grid, slope.values()[..self.count()].to_vec(), self.periodic)
    }

    /// What the drive exerts.
    pub fn effort(&self) -> Option<Samples> {
        [Quantity::Torque, Quantity::Force].into_iter().find_map(|effort| self.get(&effort.of(DRIVER)))
    }

    pub fn count(&self) -> usize {
        self.columns.values().map(Vec::len).next().unwrap_or(0)
    }

    pub fn input(&self, index: usize) -> f64 {
        self.grid[0] + self.grid[1] * index as f64
    }
}

/// The motion that a driver prescribes, by its component.
pub fn motion_by(driver: &str) -> Derivatives {
    if driver == "displacement" { SLIDING } else { ANGULAR }
}

/// The motions of a joint that a driver can prescribe.
pub fn motions_of(joint: &Part) -> impl Iterator<Item = Derivatives> {
    let component = joint.component();
    let reported = |motion: &Derivatives| motion.iter().all(|quantity| component.variables.contains(quantity));
    component.drivers.iter().map(|driver| motion_by(driver)).filter(reported)
}

/// What a joint's motion is called: the joint's first one has its name.
pub fn called(joint: &Part, motion: Derivatives) -> String {
    match motions_of(joint).next() {
        Some(first) if first == motion => joint.name.clone(),
        _ => motion[0].of(&joint.name),
    }
}

/// Does a driver prescribe this motion of this joint?
pub fn moves(driver: &Part, (id, motion): (JointId, Derivatives), joint: &Part) -> bool {
    let beside = driver.joint() == Some(id) || driver.is_angular() && driver.bodies() == joint.bodies();
    beside && motion_by(driver.component().name) == motion
}

/// The scene driven from a place on, forwards or backwards, reporting everything that can be computed beside what it reports already.
pub fn driven(scene: &Scene, mechanism: &Mechanism, drive: &Drive, from: f64, direction: f64) -> Scene {
    driven_by(scene, mechanism, drive, &format!("{from:?} + {:?}*t", direction * drive.pace()))
}

/// The scene whose input follows a law.
fn driven_by(scene: &Scene, mechanism: &Mechanism, drive: &Drive, law: &str) -> Scene {
    let joint = &mechanism.joints[drive.joint.0];
    let mut driven = scene.clone();
    let moves_it = |driver: &&Part| moves(driver, (drive.joint, drive.motion), joint);
    let replaced: Vec<&str> = mechanism.drivers.iter().filter(moves_it).map(|part| &*part.name).collect();
    driven.drivers.retain(|driver| !replaced.contains(&driver.name.text.as_str()));
    let driver = match drive.motion {
        SLIDING => Driver::displacement(&joint.name, law),
        _ => Driver::angle(&joint.name, law),
    };
    driven = driven.driver(DRIVER, driver);
    // Rates follow from the drive; positions pick the assembly.
    let position = |name: &str| matches!(name.rsplit('.').next(), Some("angle" | "x" | "y" | "s" | "length"));
    driven.initial.retain(|initial| position(&initial.variable.text));
    driven.initial.iter_mut().for_each(|initial| initial.known = false);
    let asked: Vec<String> = scene.outputs.variables.iter().map(|name| name.text.clone()).collect();
    let more = names(mechanism).into_iter().filter(|name| !asked.contains(name));
    driven.outputs.variables.extend(more.map(|name| Text::from(name.as_str())));
    driven.experiment.start = Some(0.0.into());
    driven.experiment.tolerance = Some(TOLERANCE.into());
    driven
}

/// The motion of all bodies, points and loads, and all that the joints report.
pub fn names(mechanism: &Mechanism) -> Vec<String> {
    let plane = mechanism.dimension == Dimension::Two;
    let mut names = Vec::new();
    let mut push = |owner: &str, quantities: &[Quantity]| {
        let there = quantities.iter().filter(|quantity| plane || quantity.is_on_a_line());
        names.extend(there.map(|quantity| quantity.of(owner)));
    };
    for place in mechanism.body_places() {
        push(&mechanism.place_name(place), if matches!(place, Place::Centre(_)) { VARIABLES } else { POINT_VARIABLES });
    }
    let ground = (0..mechanism.ground.len()).map(Place::Ground);
    ground.for_each(|point| push(&mechanism.place_name(point), &POINT_VARIABLES[..2]));
    mechanism.joints.iter().for_each(|joint| push(&joint.name, joint.component().variables));
    for load in &mechanism.loads {
        let moves = load.component().variables.iter().copied().filter(|quantity| quantity.class() != Class::Effort);
        push(&load.name, &moves.collect::<Vec<_>>());
    }
    names
}

/// Runs a driven scene over so many steps of the input. Efforts are left out if the scene lacks masses for them, or where those at rest are asked for.
fn run(
    mut scene: Scene,
    mechanism: &Mechanism,
    drive: &Drive,
    [step, count]: [f64; 2],
) -> Result<HashMap<String, Vec<f64>>, SimulateError> {
    scene.experiment.step = Some((step / drive.pace()).into());
    scene.experiment.stop = Some((step * count / drive.pace()).into());
    let moved = scene.clone().output(&effort(drive));
    let compiled = match (drive.speed != 0.0).then(|| compile(&moved)) {
        Some(Err(faults)) if !lacks_masses(&faults) => return Err(faults.into()),
        Some(Ok(compiled)) => compiled,
        Some(Err(_)) | None => compile(&without_efforts(scene, mechanism))?,
    };
    let results = compiled.simulate()?;
    Ok(results.columns().iter().map(|column| (column.name.clone(), column.values.clone())).collect())
}

/// The variable that says what the drive exerts.
fn effort(drive: &Drive) -> String {
    if drive.motion == SLIDING { Quantity::Force } else { Quantity::Torque }.of(DRIVER)
}

fn without_efforts(mut scene: Scene, mechanism: &Mechanism) -> Scene {
    scene.outputs.variables.retain(|name| !is_effort(mechanism, &name.text));
    scene
}

/// The bodies whose mass or moment of inertia the efforts of a driven scene need and do not have.
///
/// # Errors
/// The driven scene is at fault.
pub fn lacking(scene: &Scene, mechanism: &Mechanism, drive: &Drive) -> Result<Vec<String>, Faults> {
    let driven = driven(scene, mechanism, drive, drive.start, 1.0).output(&effort(drive));
    let driven = driven.resolve()?.mechanism;
    let lacking = formulate::lacking(&driven).map_err(|list| Faults::new(scene.source.clone(), list))?;
    // Of each effort one body is named; a mass that is missing is missing for some.
    let needed: BTreeSet<usize> = lacking.into_iter().map(|(_, body, _)| body).collect();
    let lacks = |(index, body): &(usize, &Body)| needed.contains(index) || !needed.is_empty() && body.mass.is_none();
    Ok(driven.bodies.iter().enumerate().filter(lacks).map(|(_, body)| body.name.to_string()).collect())
}

fn lacks_masses(faults: &Faults) -> bool {
    faults.list.iter().any(|fault| fault.code == "scene::missing_mass")
}

fn is_effort(mechanism: &Mechanism, name: &str) -> bool {
    let Some((owner, word)) = name.rsplit_once('.') else { return false };
    let joint = mechanism.joints.iter().find(|joint| joint.name == owner);
    let quantity = joint.and_then(|joint| joint.component().variables.iter().find(|quantity| quantity.word() == word));
    quantity.is_some_and(|quantity| quantity.class() == Class::Effort)
}

/// One turn or the range, with one more load if there is one.
pub fn sample(scene: &Scene, mechanism: &Mechanism, drive: &Drive, load: Option<Load>) -> Result<Table, SimulateError> {
    let scene = match load {
        Some(load) => scene.clone().load("cotree_unit_load", load),
        None => scene.clone(),
    };
    let table = match drive.range {
        None => turn(&scene, mechanism, drive),
        Some(range) => stroke(&scene, mechanism, drive, range),
    }?;
    if drive.speed != 0.0 {
        return Ok(table);
    }
    let at_rest = at_rest(&scene, mechanism, drive, &table)?;
    Ok(table.with(at_rest))
}

/// What acts in each pose of a table while nothing moves, and what else the scene asks for. Where time matters it is that of the start.
fn at_rest(
    scene: &Scene,
    mechanism: &Mechanism,
    drive: &Drive,
    table: &Table,
) -> Result<HashMap<String, Vec<f64>>, SimulateError> {
    let asked = |name: &str| scene.outputs.variables.iter().any(|asked| asked.text == name);
    let expression = |name: &str| scene.outputs.expressions.iter().any(|own| own.name.text == name);
    let effort = effort(drive);
    let is_wanted = |name: &str| asked(name) || expression(name) || name == effort || is_effort(mechanism, name);
    let mut still = driven_by(scene, mechanism, drive, PLACE).input(PLACE, Input::new(table.input(0)));
    still = assembled_at(still, mechanism, |name| Some(*table.columns.get(name)?.first()?));
    let compiled = compile(&still.output(&effort))?;
    let model = Arc::new(Model::new(compiled.program.clone()).map_err(RunError::from)?);
    if !model.is_driven() {
        let what = "where nothing moves forces are those of a rest only if the input determines the whole pose: give a speed, or hold what else can move";
        return Err(SimulateError::Settings(vec![what.to_owned()]));
    }
    let variables = &compiled.description.variables;
    let named = |index: usize| (index, variables[index].name.clone());
    let reported = compiled.reported().into_iter().map(named).filter(|(_, name)| is_wanted(name));
    let reported: Vec<(usize, String)> = reported.collect();
    let mut instance = Instance::new(model);
    let mut columns: HashMap<String, Vec<f64>> = reported.iter().map(|(_, name)| (name.clone(), Vec::new())).collect();
    for index in 0..table.count() {
        pose(&mut instance, mechanism, table, index).map_err(RunError::from)?;
        for (variable, name) in &reported {
            let value = instance.get(*variable).map_err(RunError::from)?;
            columns.entry(name.clone()).or_default().push(value);
        }
    }
    Ok(columns)
}

/// Puts the mechanism at rest into the pose of a sample.
fn pose(instance: &mut Instance, mechanism: &Mechanism, table: &Table, index: usize) -> Result<(), InstanceError> {
    instance.reset();
    instance.setup(0.0, None, Some(TOLERANCE))?;
    let bodies = mechanism.bodies.iter().flat_map(|body| POSE.map(|own| own.of(&body.name)));
    let guesses = bodies.filter_map(|name| Some((*table.columns.get(&name)?.get(index)?, name)));
    for (value, name) in guesses.chain([(table.input(index), PLACE.to_owned())]) {
        let can_be_set = |own: &usize| instance.is_input(*own) || instance.initial_value(*own).is_some();
        if let Some(variable) = instance.variable(&name).filter(can_be_set) {
            instance.set(variable, value)?;
        }
    }
    instance.initialise()
}

/// One turn from the first round angle after the start; the table begins at angle 0 if the turn closes.
fn turn(scene: &Scene, mechanism: &Mechanism, drive: &Drive) -> Result<Table, SimulateError> {
    let count = COUNT * drive.fineness;
    let [shown, step] = [COUNT, count].map(|count| TAU / count as f64);
    let beside = if drive.between { 0.5 * step } else { 0.0 };
    let first = ((drive.start - beside) / shown - 1e-9).ceil();
    let begin = first * shown + beside;
    let scene = driven(scene, mechanism, drive, begin, 1.0);
    let mut columns = run(scene, mechanism, drive, [step, count as f64])?;
    let periodic = closes(&columns, mechanism, count);
    if !periodic {
        return Ok(Table { grid: [begin, step], periodic, columns });
    }
    let shift = (first as i64).rem_euclid(COUNT as i64) as usize * drive.fineness;
    for column in columns.values_mut() {
        column.truncate(count);
        column.rotate_right(shift);
    }
    Ok(Table { grid: [beside, step], periodic, columns })
}

/// So many samples for each that is shown does the shortest piece of a cam's law need; an error if these are too many.
pub fn fineness(mechanism: &Mechanism, table: &Table) -> Result<usize, MotionError> {
    let mut most = 1.0f64;
    for cam in mechanism.profiles(&mechanism.parameter_values()) {
        let Some(angle) = table.get(&Quantity::Angle.of(&cam.name)) else { continue };
        let unwound = angle.unwound();
        let step = unwound.values().windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        let needed = cam.shortest_piece().map_or(1.0, |piece| (PIECE * step / piece).ceil());
        if needed > FINEST as f64 {
            let piece = cam.shortest_piece().unwrap_or(0.0).to_degrees();
            let message = format!(
                "the law of cam `{}` has a piece over {piece:.3e} deg, between whose ends the motion is not looked at: let it rise over a larger angle",
                cam.name
            );
            return Err(MotionError::Request(message));
        }
        most = most.max(needed);
    }
    Ok(most as usize)
}

/// Is everything after one turn as before?
fn closes(columns: &HashMap<String, Vec<f64>>, mechanism: &Mechanism, count: usize) -> bool {
    let same = |body: &str, quantity: Quantity| {
        let ends = columns.get(&quantity.of(body)).and_then(|column| column.first().zip(column.get(count)));
        let Some((first, last)) = ends else { return true };
        let whole = if quantity == Quantity::Angle { ((last - first) / TAU).round() * TAU } else { 0.0 };
        (last - first - whole).abs() < 1e-6 * (1.0 + first.abs())
    };
    mechanism.bodies.iter().all(|body| POSE.into_iter().all(|quantity| same(&body.name, quantity)))
}

/// A range from one end to the other. Forces may depend on the direction: to where the samples begin the input only goes.
fn stroke(scene: &Scene, mechanism: &Mechanism, drive: &Drive, [from, to]: [f64; 2]) -> Result<Table, SimulateError> {
    let count = drive.shown * drive.fineness;
    let step = (to - from) / count as f64;
    let way = from - drive.start;
    let mut there = driven(scene, mechanism, drive, from, drive.direction());
    if way.abs() > AT_ONCE * step.abs() {
        let approach = driven(scene, mechanism, drive, drive.start, way.signum());
        let approach = without_efforts(approach, mechanism);
        let columns = run(approach, mechanism, drive, [way.abs(), 1.0])?;
        there = assembled_at(there, mechanism, |name| columns.get(name)?.last().copied());
    }
    let columns = run(there, mechanism, drive, [step.abs(), count as f64])?;
    Ok(Table { grid: [from, step], periodic: false, columns })
}

/// The variables that say where a body is.
pub const POSE: [Quantity; 3] = [Quantity::X, Quantity::Y, Quantity::Angle];

/// The scene with the pose of all bodies as guesses, and nothing else said of its start.
pub fn assembled_at(mut scene: Scene, mechanism: &Mechanism, pose: impl Fn(&str) -> Option<f64>) -> Scene {
    scene.initial.clear();
    for name in mechanism.bodies.iter().flat_map(|body| POSE.map(|own| own.of(&body.name))) {
        if let Some(value) = pose(&name) {
            scene = scene.guess(&name, value);
        }
    }
    scene
}

/// A length that no input of a closed mechanism moves: that of all links together.
pub fn size(mechanism: &Mechanism) -> f64 {
    let parameters = mechanism.parameter_values();
    let points = mechanism.ground.iter().chain(mechanism.bodies.iter().flat_map(|body| &body.points));
    let lengths = points.map(|point| point.at.each_ref().map(|part| evaluate(part, &parameters)));
    2.0 * lengths.map(|[x, y]| x.hypot(y)).sum::<f64>()
}

/// Where branches of the motion cross within a full turn.
///
/// # Errors
/// The motion cannot be found or continued.
pub fn change_points(scene: &Scene, mechanism: &Mechanism, drive: &Drive) -> Result<Vec<f64>, SimulateError> {
    let mut scene = driven(scene, mechanism, drive, drive.start, 1.0);
    scene.outputs.variables.clear();
    let model = Arc::new(Model::new(compile(&scene)?.program).map_err(RunError::from)?);
    let place = |time: f64| (drive.start + drive.pace() * time).rem_euclid(TAU);
    let turned = || {
        let mut instance = Instance::new(model.clone());
        instance.setup(0.0, None, None)?;
        instance.initialise()?;
        instance.step_to(TAU / drive.pace())?;
        Ok(instance.take_passages().iter().map(|passage| place(passage.time)).collect())
    };
    turned().map_err(|failure: InstanceError| RunError::from(failure).into())
}

/// How far the input can move from its start in a direction, up to the most: found by halving, then by the way in which rates grow before a
/// fold of the motion, as 1/sqrt(distance).
pub fn reach(scene: &Scene, mechanism: &Mechanism, drive: &Drive, direction: f64, most: f64) -> f64 {
    let scene = driven(scene, mechanism, drive, drive.start, direction);
    let try_it = |way: f64| run(scene.clone(), mechanism, drive, [way, 1.0]).ok();
    let (mut good, mut bad) = (0.0, most);
    for _ in 0..40 {
        let middle = 0.5 * (good + bad);
        match try_it(middle) {
            Some(_) => good = middle,
            None => bad = middle,
        }
    }
    // A little before the last good pose the rates are not yet disturbed.
    let turn = most / TAU;
    let before = (good - 1e-6 * turn).max(0.0);
    let Some(columns) = try_it(before) else { return good };
    let rates = mechanism.bodies.iter().filter_map(|body| {
        let last = |quantity: Quantity| columns.get(&quantity.of(&body.name))?.last().copied();
        let rates = [last(Quantity::Omega)? / drive.pace(), last(Quantity::Alpha)? / drive.pace().powi(2)];
        rates.iter().all(|rate| rate.is_finite()).then_some(rates)
    });
    let fastest = rates.max_by(|a, b| a[0].abs().total_cmp(&b[0].abs()));
    match fastest {
        Some([rate, growth]) if rate.abs() * turn > 30.0 && growth != 0.0 => before + (rate / (2.0 * growth)).abs(),
        _ => good,
    }
}
