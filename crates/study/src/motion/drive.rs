//! A mechanism that is driven at one joint with constant speed, through one turn or a given range.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::f64::consts::TAU;
use std::sync::Arc;

use cotree::compile::{Compiled, compile_resolved};
use cotree::component::body::{POINT_VARIABLES, VARIABLES};
use cotree::formulate;
use cotree::model::{
    Body, Class, Experiment, Formula, JointId, Mechanism, Output, Owner, Part, Place, Quantity, Unit, Variable,
};
use cotree::run::{Run, RunError, SimulateError};
use cotree::scene::constant::evaluate;
use cotree::scene::{Faults, Resolved, Source};
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;

use super::samples::{ANGULAR, Derivatives, SLIDING, Samples};
use super::{DrivenJoint, MotionError};

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
pub struct InputTable {
    /// First input and step.
    grid: [f64; 2],
    /// Is it one turn after which everything is as before?
    pub periodic: bool,
    columns: HashMap<String, Vec<f64>>,
}

impl InputTable {
    /// A variable; none if the scene lacks what it needs.
    pub fn get(&self, name: &str) -> Option<Samples> {
        Some(Samples::new(self.grid, self.columns.get(name)?.clone(), self.periodic))
    }

    /// The same with what belongs to each sample instead, or besides.
    fn with(self, columns: HashMap<String, Vec<f64>>) -> InputTable {
        InputTable { columns: self.columns.into_iter().chain(columns).collect(), ..self }
    }

    /// The same with columns that have moved by so many of these slopes.
    pub fn moved(&self, slopes: &HashMap<String, Vec<f64>>, step: f64) -> InputTable {
        let columns = self.columns.iter().map(|(name, values)| {
            let moved = match slopes.get(name) {
                Some(slopes) => values.iter().zip(slopes).map(|(value, slope)| value + step * slope).collect(),
                None => values.clone(),
            };
            (name.clone(), moved)
        });
        InputTable { columns: columns.collect(), ..*self }
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
    let is_same = driver.joint() == Some(id) || driver.is_angular() && driver.bodies() == joint.bodies();
    is_same && motion_by(driver.component().name) == motion
}

/// What is driven: a mechanism without what the input replaces, what is looked at in it, and the text that it came from.
#[derive(Clone, Debug)]
pub struct Moved {
    pub mechanism: Mechanism,
    pub watched: Vec<Output>,
    /// True if the mechanism has the masses that its efforts need.
    pub has_efforts: bool,
    pub source: Source,
}

impl Moved {
    pub(super) fn compiled(&self, outputs: Vec<Output>) -> Result<Compiled, Faults> {
        let resolved = Resolved { mechanism: self.mechanism.clone(), outputs, warnings: Vec::new() };
        compile_resolved(resolved, &self.source).map(|(compiled, _)| compiled)
    }
}

/// The mechanism driven from a place on, forwards or backwards.
pub fn driven(moved: &Moved, drive: &DrivenJoint, from: f64, direction: f64) -> Moved {
    let rate = Formula::Number(direction * drive.pace());
    let mut driven = driven_by(moved, drive, Formula::Number(from) + rate * Formula::Time);
    driven.mechanism.experiment = begun(driven.mechanism.experiment);
    driven
}

/// The experiment from the time 0 on, as accurately as can be.
fn begun(experiment: Experiment) -> Experiment {
    Experiment { start: 0.0, stop: experiment.stop - experiment.start, tolerance: TOLERANCE, ..experiment }
}

/// The driven mechanism until its input has gone this way.
fn lasting(mut driven: Moved, drive: &DrivenJoint, way: f64) -> Moved {
    let stop = way / drive.pace();
    driven.mechanism.experiment = Experiment { stop, step: stop, ..driven.mechanism.experiment };
    driven
}

/// The mechanism whose input follows a law. Rates follow from the drive; positions pick the assembly.
fn driven_by(moved: &Moved, drive: &DrivenJoint, law: Formula) -> Moved {
    let mechanism = &moved.mechanism;
    let joint = &mechanism.joints[drive.joint.0];
    let moves_it = |driver: &Part| moves(driver, (drive.joint, drive.motion), joint);
    let driver = match drive.motion {
        SLIDING => Part::displacement_driver(DRIVER, (drive.joint, joint), law),
        _ => Part::angle_driver(DRIVER, (drive.joint, joint), law),
    };
    let (left, watched) = mechanism.without_drivers(&moved.watched, moves_it);
    Moved { mechanism: left.guessed().driven(driver), watched, ..moved.clone() }
}

/// What is asked of a driven mechanism: what is looked at, all motions and reactions, and what the drive exerts.
fn requested(driven: &Moved, drive: &DrivenJoint) -> Vec<Output> {
    let Moved { mechanism, watched, .. } = driven;
    let mut there: HashSet<String> = watched.iter().map(|output| output.name.clone()).collect();
    let driver = mechanism.drivers.last().map(|driver| Variable { owner: driver.owner, quantity: effort(drive) });
    let all = variables(mechanism).into_iter().chain(driver).map(|variable| mechanism.output(variable));
    watched.iter().cloned().chain(all.filter(|output| there.insert(output.name.clone()))).collect()
}

/// The names of the motions and reactions that are asked for.
pub fn names(mechanism: &Mechanism) -> Vec<String> {
    variables(mechanism).into_iter().map(|variable| mechanism.variable_name(variable)).collect()
}

/// The motion of all bodies, points and loads, and all that the joints report.
fn variables(mechanism: &Mechanism) -> Vec<Variable> {
    let mut variables = Vec::new();
    let mut push = |owner: Owner, quantities: &[Quantity]| {
        let there = quantities.iter().filter(|&&quantity| mechanism.has(quantity));
        variables.extend(there.map(|&quantity| Variable { owner, quantity }));
    };
    for place in mechanism.body_places() {
        push(Owner::Place(place), if matches!(place, Place::Centre(_)) { VARIABLES } else { POINT_VARIABLES });
    }
    let ground = (0..mechanism.ground.len()).map(Place::Ground);
    ground.for_each(|point| push(Owner::Place(point), &POINT_VARIABLES[..2]));
    mechanism.joints.iter().for_each(|joint| push(joint.owner, joint.component().variables));
    for load in &mechanism.loads {
        let moves = load.component().variables.iter().copied().filter(|quantity| quantity.class() != Class::Effort);
        push(load.owner, &moves.collect::<Vec<_>>());
    }
    variables
}

/// A driven mechanism, compiled once for motions of any length.
pub(super) struct DrivenMechanism {
    compiled: Compiled,
    pub model: Arc<Model>,
    pace: f64,
}

impl DrivenMechanism {
    fn new(driven: &Moved, drive: &DrivenJoint) -> Result<DrivenMechanism, SimulateError> {
        DrivenMechanism::of(driven.compiled(outputs(driven, drive))?, drive)
    }

    /// From where the scene starts in a direction, with these outputs only.
    pub fn watching(
        moved: &Moved,
        drive: &DrivenJoint,
        direction: f64,
        outputs: Vec<Output>,
    ) -> Result<DrivenMechanism, SimulateError> {
        DrivenMechanism::of(driven(moved, drive, drive.start, direction).compiled(outputs)?, drive)
    }

    /// Without efforts.
    pub fn of_motion(driven: &Moved, drive: &DrivenJoint) -> Result<DrivenMechanism, SimulateError> {
        DrivenMechanism::of(driven.compiled(motions(driven, drive))?, drive)
    }

    fn of(compiled: Compiled, drive: &DrivenJoint) -> Result<DrivenMechanism, SimulateError> {
        let model = Arc::new(Model::new(compiled.program.clone()).map_err(RunError::from)?);
        Ok(DrivenMechanism { compiled, model, pace: drive.pace() })
    }

    /// Runs over so many steps of the input.
    pub fn run(&self, step: f64, count: f64) -> Result<HashMap<String, Vec<f64>>, RunError> {
        let description = &self.compiled.description;
        let [step, stop] = [step, step * count].map(|way| way / self.pace);
        let experiment = Experiment { stop, step, ..description.experiment };
        let reported = self.compiled.reported();
        let mut columns = vec![Vec::new(); reported.len()];
        let names: Vec<String> = reported.iter().map(|&index| description.variables[index].name.clone()).collect();
        Run { description, experiment, settings: Vec::new(), inputs: None, reported }.start(
            self.model.clone(),
            |_, values| {
                columns.iter_mut().zip(values).for_each(|(column, value)| column.push(*value));
                Ok(())
            },
        )?;
        Ok(names.into_iter().zip(columns).collect())
    }
}

/// What is sampled. Efforts are left out if the mechanism lacks masses for them, or where those at rest are asked for.
pub(super) fn outputs(driven: &Moved, drive: &DrivenJoint) -> Vec<Output> {
    match drive.speed != 0.0 && driven.has_efforts {
        true => requested(driven, drive),
        false => motions(driven, drive),
    }
}

/// The same without efforts.
fn motions(driven: &Moved, drive: &DrivenJoint) -> Vec<Output> {
    requested(driven, drive).into_iter().filter(|output| !is_effort(&driven.mechanism, output)).collect()
}

/// What the drive exerts.
fn effort(drive: &DrivenJoint) -> Quantity {
    if drive.motion == SLIDING { Quantity::Force } else { Quantity::Torque }
}

/// The bodies whose mass or moment of inertia the efforts of a driven mechanism need and do not have.
///
/// # Errors
/// The driven mechanism is at fault.
pub fn lacking(moved: &Moved, drive: &DrivenJoint) -> Result<Vec<String>, Faults> {
    let driven = driven(moved, drive, drive.start, 1.0);
    let outputs = requested(&driven, drive);
    let lacking =
        formulate::lacking(&driven.mechanism, &outputs).map_err(|list| Faults::new(moved.source.clone(), list))?;
    // Of each effort one body is named; a mass that is missing is missing for some.
    let needed: BTreeSet<usize> = lacking.into_iter().map(|lacking| lacking.body).collect();
    let lacks = |(index, body): &(usize, &Body)| needed.contains(index) || !needed.is_empty() && body.mass.is_none();
    Ok(driven.mechanism.bodies.iter().enumerate().filter(lacks).map(|(_, body)| body.name.to_string()).collect())
}

/// Does the drive determine the motion?
pub fn is_determined(moved: &Moved, drive: &DrivenJoint) -> bool {
    let driven = driven(moved, drive, drive.start, 1.0);
    driven.compiled(requested(&driven, drive)).is_ok()
}

/// True for an effort of a joint, or of the driver that moves the input.
fn is_effort(driven: &Mechanism, output: &Output) -> bool {
    let drives = |owner: Owner| driven.drivers.last().is_some_and(|driver| driver.owner == owner);
    driven.variable_of(output).is_some_and(|variable| {
        let Variable { owner, quantity } = variable;
        quantity.class() == Class::Effort && (matches!(owner, Owner::Joint(_)) || drives(owner))
    })
}

/// One turn or the range, with one more load if there is one.
pub fn sample(moved: &Moved, drive: &DrivenJoint, load: Option<Part>) -> Result<InputTable, MotionError> {
    let loaded = load.map(|load| Moved { mechanism: moved.mechanism.loaded(load), ..moved.clone() });
    let moved = loaded.as_ref().unwrap_or(moved);
    let table = match drive.range {
        None => turn(moved, drive),
        Some(range) => stroke(moved, drive, range),
    }?;
    if drive.speed != 0.0 {
        return Ok(table);
    }
    let at_rest = at_rest(moved, drive, &table)?;
    Ok(table.with(at_rest))
}

/// What acts in each pose of a table while nothing moves, and what else is looked at. Where time matters it is that of the start.
fn at_rest(moved: &Moved, drive: &DrivenJoint, table: &InputTable) -> Result<HashMap<String, Vec<f64>>, MotionError> {
    let mechanism = &moved.mechanism;
    let (still, input) = mechanism.with_input(PLACE, Unit::default(), table.input(0));
    let mut still = driven_by(&Moved { mechanism: still, ..moved.clone() }, drive, Formula::Input(input));
    let first = |variable| Some(*table.columns.get(&mechanism.variable_name(variable))?.first()?);
    still.mechanism = still.mechanism.posed(first);
    still.mechanism.experiment = begun(still.mechanism.experiment);
    let outputs = requested(&still, drive);
    let is_wanted = |output: &&Output| moved.watched.contains(output) || is_effort(&still.mechanism, output);
    let wanted: HashSet<String> = outputs.iter().filter(is_wanted).map(|output| output.name.clone()).collect();
    let compiled = still.compiled(outputs)?;
    let model = Arc::new(Model::new(compiled.program.clone()).map_err(RunError::from)?);
    if !model.is_driven() {
        let what = "static forces need a configuration that the input determines: give a speed, or constrain the other degrees of freedom";
        return Err(MotionError::Request(what.to_owned()));
    }
    let variables = &compiled.description.variables;
    let named = |index: usize| (index, variables[index].name.clone());
    let reported = compiled.reported().into_iter().map(named).filter(|(_, name)| wanted.contains(name));
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
fn pose(instance: &mut Instance, mechanism: &Mechanism, table: &InputTable, index: usize) -> Result<(), InstanceError> {
    instance.reset();
    instance.setup(0.0, None, Some(TOLERANCE))?;
    let bodies = mechanism.bodies.iter().flat_map(|body| POSE.map(|quantity| quantity.of(&body.name)));
    let guesses = bodies.filter_map(|name| Some((*table.columns.get(&name)?.get(index)?, name)));
    for (value, name) in guesses.chain([(table.input(index), PLACE.to_owned())]) {
        let can_be_set = |variable: &usize| instance.is_input(*variable) || instance.initial_value(*variable).is_some();
        if let Some(variable) = instance.variable(&name).filter(can_be_set) {
            instance.set(variable, value)?;
        }
    }
    instance.initialise()
}

/// What is driven, at the first of its samples, and where they are.
pub(super) struct Way {
    pub driven: Moved,
    pub begin: f64,
    pub step: f64,
    pub count: usize,
}

/// One turn from the first round angle after the start, or the range.
pub(super) fn way(moved: &Moved, drive: &DrivenJoint) -> Result<Way, SimulateError> {
    match drive.range {
        None => Ok(way_of_turn(moved, drive)),
        Some(range) => way_of_stroke(moved, drive, range),
    }
}

/// A step between samples that are shown, the steps of the samples, and how far these are beside round angles.
fn steps(drive: &DrivenJoint) -> [f64; 3] {
    let [shown, step] = [COUNT, COUNT * drive.fineness].map(|count| TAU / count as f64);
    [shown, step, if drive.between { 0.5 * step } else { 0.0 }]
}

fn way_of_turn(moved: &Moved, drive: &DrivenJoint) -> Way {
    let [shown, step, offset] = steps(drive);
    let begin = ((drive.start - offset) / shown - 1e-9).ceil() * shown + offset;
    Way { driven: lasting(driven(moved, drive, begin, 1.0), drive, TAU), begin, step, count: COUNT * drive.fineness }
}

/// The table of a turn begins at angle 0 if the turn closes.
fn turn(moved: &Moved, drive: &DrivenJoint) -> Result<InputTable, SimulateError> {
    let way = way_of_turn(moved, drive);
    let columns = DrivenMechanism::new(&way.driven, drive)?.run(way.step, way.count as f64)?;
    match closes(&columns, &moved.mechanism, way.count) {
        true => Ok(way.closed(columns, drive)),
        false => Ok(InputTable { grid: [way.begin, way.step], periodic: false, columns }),
    }
}

impl Way {
    /// The table of a turn with these columns; none if the turn does not close.
    pub fn table_of_turn(
        &self,
        columns: HashMap<String, Vec<f64>>,
        mechanism: &Mechanism,
        drive: &DrivenJoint,
    ) -> Option<InputTable> {
        closes(&columns, mechanism, self.count).then(|| self.closed(columns, drive))
    }

    fn closed(&self, columns: HashMap<String, Vec<f64>>, drive: &DrivenJoint) -> InputTable {
        let [_, step, offset] = steps(drive);
        InputTable { grid: [offset, step], periodic: true, columns: self.ordered(columns, drive) }
    }

    /// Columns of a turn from angle 0 on.
    pub fn ordered(&self, mut columns: HashMap<String, Vec<f64>>, drive: &DrivenJoint) -> HashMap<String, Vec<f64>> {
        let [shown, _, offset] = steps(drive);
        let first = ((self.begin - offset) / shown).round();
        let shift = (first as i64).rem_euclid(COUNT as i64) as usize * drive.fineness;
        for column in columns.values_mut() {
            column.truncate(self.count);
            column.rotate_right(shift);
        }
        columns
    }
}

/// So many samples for each that is shown does the shortest piece of a cam's law need; an error if these are too many.
pub fn fineness(mechanism: &Mechanism, table: &InputTable) -> Result<usize, MotionError> {
    let mut most = 1.0f64;
    for cam in mechanism.profiles(&mechanism.parameter_values()) {
        let Some(angle) = table.get(&Quantity::Angle.of(&cam.name)) else { continue };
        let unwound = angle.unwound();
        let step = unwound.values().windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        let needed = cam.shortest_piece().map_or(1.0, |piece| (PIECE * step / piece).ceil());
        if needed > FINEST as f64 {
            let piece = cam.shortest_piece().unwrap_or(0.0).to_degrees();
            let message = format!(
                "the law of cam `{}` has a piece over only {piece:.3e} deg, which the samples of the motion miss: let it rise over a larger angle",
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
fn way_of_stroke(moved: &Moved, drive: &DrivenJoint, [from, to]: [f64; 2]) -> Result<Way, SimulateError> {
    let mechanism = &moved.mechanism;
    let count = drive.shown * drive.fineness;
    let step = (to - from) / count as f64;
    let way = from - drive.start;
    let mut there = lasting(driven(moved, drive, from, drive.direction()), drive, (to - from).abs());
    if way.abs() > AT_ONCE * step.abs() {
        let approach = lasting(driven(moved, drive, drive.start, way.signum()), drive, way.abs());
        let columns = DrivenMechanism::of_motion(&approach, drive)?.run(way.abs(), 1.0)?;
        let last = |variable| columns.get(&mechanism.variable_name(variable))?.last().copied();
        there.mechanism = there.mechanism.posed(last);
    }
    Ok(Way { driven: there, begin: from, step, count })
}

fn stroke(moved: &Moved, drive: &DrivenJoint, range: [f64; 2]) -> Result<InputTable, SimulateError> {
    let Way { driven, begin, step, count } = way_of_stroke(moved, drive, range)?;
    let columns = DrivenMechanism::new(&driven, drive)?.run(step.abs(), count as f64)?;
    Ok(InputTable { grid: [begin, step], periodic: false, columns })
}

/// The variables that say where a body is.
pub const POSE: [Quantity; 3] = [Quantity::X, Quantity::Y, Quantity::Angle];

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
pub fn change_points(moved: &Moved, drive: &DrivenJoint) -> Result<Vec<f64>, SimulateError> {
    let compiled = driven(moved, drive, drive.start, 1.0).compiled(Vec::new())?;
    let model = Arc::new(Model::new(compiled.program).map_err(RunError::from)?);
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
///
/// # Errors
/// The driven mechanism is at fault.
pub fn reach(moved: &Moved, drive: &DrivenJoint, direction: f64, most: f64) -> Result<f64, SimulateError> {
    if most <= 0.0 {
        return Ok(0.0);
    }
    let driven = lasting(driven(moved, drive, drive.start, direction), drive, most);
    let driven = DrivenMechanism::new(&driven, drive)?;
    let try_it = |way: f64| driven.run(way, 1.0).ok();
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
    let Some(columns) = try_it(before) else { return Ok(good) };
    let rates = moved.mechanism.bodies.iter().filter_map(|body| {
        let last = |quantity: Quantity| columns.get(&quantity.of(&body.name))?.last().copied();
        let rates = [last(Quantity::Omega)? / drive.pace(), last(Quantity::Alpha)? / drive.pace().powi(2)];
        rates.iter().all(|rate| rate.is_finite()).then_some(rates)
    });
    let fastest = rates.max_by(|a, b| a[0].abs().total_cmp(&b[0].abs()));
    Ok(match fastest {
        Some([rate, growth]) if rate.abs() * turn > 30.0 && growth != 0.0 => before + (rate / (2.0 * growth)).abs(),
        _ => good,
    })
}
