//! The quantities of one turn or stroke.

use std::f64::consts::FRAC_PI_2;

use cotree::model::{BodyId, Formula, Mechanism, Part, Place, Quantity, Units};
use cotree::report::data::shown;
use cotree::scene::constant::evaluate;
use serde::Serialize;

use super::cams::{Cam, cams};
use super::centres::{Centres, RelativeCentres, centres};
use super::clearance::PairClearance;
use super::curve::{self, PointPath};
use super::direction::directions;
use super::drive::{self, InputTable, Moved};
use super::dwell::Dwell;
use super::flywheel::Fluctuation;
use super::friction::{self, DriveFriction};
use super::growth::{Figured, Unbounded};
use super::input::Watched;
use super::report::radius_of;
use super::samples::{ANGULAR, Derivatives, Samples, ValueAt, lagrange};
use super::stops::Stops;
use super::{DrivenJoint, MotionError, MotionRequest, SpecialPlaces, grashof, unit_of};
use crate::contact;

/// Forces below this share of the largest are rounding errors of none.
const NOTHING: f64 = 1e-9;

/// What is looked at.
#[derive(Clone, Copy)]
pub(super) struct Subject<'a> {
    pub moved: &'a Moved,
    pub mechanism: &'a Mechanism,
    pub drive: &'a DrivenJoint,
    pub output: Option<&'a Watched>,
    pub request: &'a MotionRequest,
    /// Bodies without a mass that forces need.
    pub lacking: &'a [String],
    pub places: &'a SpecialPlaces,
    pub stops: Option<&'a Stops>,
    /// True if extremes, centres and contacts are left out.
    pub only_table: bool,
}

/// Where the speed of the input is from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Speed {
    /// It was asked for.
    #[serde(rename = "asked")]
    Requested,
    /// The input has it at the start of the scene.
    OfScene,
    /// Nobody says it.
    #[default]
    Assumed,
}

/// What there is to say of the motion, in SI. What the scene has no masses for is absent.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Figures {
    /// The name of the scene.
    pub name: String,
    /// The driven joint.
    pub input: MovedVariable,
    /// What is of interest.
    pub output: Option<MovedVariable>,
    /// The speed of the input [rad/s] or [m/s]; 0: forces are those at rest.
    pub speed: f64,
    /// Where that is from.
    #[serde(rename = "speed_is")]
    pub origin: Speed,
    /// Does the scene move the input backwards? The figures are those of the way forwards.
    pub reversed: bool,
    /// Does the input turn fully, and is everything then as before?
    pub full_turn: bool,
    /// Bodies of which no mass or moment of inertia is given that forces need: forces are those of the loads and of the other bodies.
    pub lacking: Vec<String>,
    /// The range of the input, if it does not turn fully: where the motion folds, or what was asked for.
    pub range: Option<[f64; 2]>,
    /// Are the ends of that range, but for those at stops, dead points for this input?
    pub dead_points: bool,
    /// Which of them are.
    #[serde(skip)]
    pub(super) folds: [Option<f64>; 2],
    /// What ends the range besides; none if the scene has no limits, contacts and ropes.
    pub stops: Option<Stops>,
    /// Does the turn pass poses in which branches of the motion cross?
    pub change_points: bool,
    /// What kind of four-bar it is.
    pub four_bar: Option<String>,
    /// Where the output stands still: the input and the output there.
    pub limits: Vec<ValueAt>,
    /// The way of the output between its extreme positions.
    pub stroke: Option<f64>,
    /// The longer part of the turn between two limits over the shorter one.
    pub time_ratio: Option<f64>,
    /// How long the output stays next to an end of its stroke.
    pub dwell: Option<Dwell>,
    /// Transmission angles at joints of the driven body \[rad\].
    pub transmission: Vec<TransmissionAngle>,
    /// The largest joint force for a load of 1 N.m or 1 N on the output (Holte, Chase 1994).
    pub joint_force_index: Option<Largest>,
    /// What the drive must exert [N.m] or \[N\].
    pub drive: Option<Extent>,
    /// Its power \[W\].
    pub power: Option<Extent>,
    /// What dry friction takes of it.
    pub friction: Option<DriveFriction>,
    /// Are there neither masses nor loads, and so no forces?
    pub no_forces: bool,
    /// The forces of the joints \[N\].
    pub joints: Vec<JointForce>,
    /// The force on the ground by the moving masses \[N\].
    pub shaking_force: Option<Peak>,
    /// Its moment about the input joint [N.m].
    pub shaking_moment: Option<Extent>,
    /// The inertia that the input feels [kg.m2] or \[kg\].
    pub inertia: Option<Extent>,
    /// Fluctuation of the speed, and flywheel.
    pub fluctuation: Option<Fluctuation>,
    pub path: Option<PointPath>,
    pub cams: Vec<Cam>,
    /// Contacts that would have to pull, and what friction rolling takes.
    pub contacts: Vec<String>,
    /// How close outlines come to each other, if any have been given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance: Option<Vec<PairClearance>>,
    /// The least distance that is permitted \[m\].
    #[serde(skip)]
    pub least_clearance: Option<f64>,
    /// Values over the input.
    pub table: Vec<MotionColumn>,
    /// Those of them that people read.
    #[serde(skip)]
    pub rows: Vec<MotionColumn>,
    /// Centres of the motion of each body against the ground, for each sample \[m\]; none while it does not turn.
    pub instant_centres: Vec<Centres>,
    /// Centres of the motion of each two bodies against each other.
    pub relative_centres: Vec<RelativeCentres>,
}

/// What moves.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MovedVariable {
    pub name: String,
    /// Is it an angle?
    pub angular: bool,
    /// Its SI unit.
    pub unit: String,
}

impl MovedVariable {
    fn new(name: &str, unit: &str) -> MovedVariable {
        MovedVariable { name: name.to_owned(), angular: unit == "rad", unit: unit.to_owned() }
    }
}

/// The extremes of a quantity.
#[derive(Clone, Debug, Serialize)]
pub struct Extent {
    pub min: ValueAt,
    pub max: ValueAt,
    pub rms: f64,
    pub mean: f64,
    /// Where it grows without bound: the figures are those of the rest.
    pub unbounded: Option<Unbounded>,
}

/// The largest size of a force.
#[derive(Clone, Debug, Serialize)]
pub struct Peak {
    pub max: ValueAt,
    pub rms: f64,
    /// Where it grows without bound: the figures are those of the rest.
    pub unbounded: Option<Unbounded>,
}

/// The largest value of a ratio.
#[derive(Clone, Debug, Serialize)]
pub struct Largest {
    #[serde(flatten)]
    pub at: ValueAt,
    /// Where it grows without bound: the figure is that of the rest.
    pub unbounded: Option<Unbounded>,
}

/// The force of a joint.
#[derive(Clone, Debug, Serialize)]
pub struct JointForce {
    pub joint: String,
    #[serde(flatten)]
    pub peak: Peak,
}

/// The transmission angle at a joint of the driven body.
#[derive(Clone, Debug, Serialize)]
pub struct TransmissionAngle {
    pub joint: String,
    pub min: ValueAt,
    pub max: ValueAt,
}

/// A quantity over the input.
#[derive(Clone, Debug, Serialize)]
pub struct MotionColumn {
    pub name: String,
    pub unit: String,
    pub values: Vec<f64>,
}

impl MotionColumn {
    /// So many of its values, every so many.
    pub(super) fn every(&self, first: usize, every: usize, count: usize) -> MotionColumn {
        let values = self.values.iter().skip(first).step_by(every.max(1)).take(count).copied().collect();
        MotionColumn { values, ..self.clone() }
    }
}

/// Works everything out.
pub(super) fn of(subject: &Subject, table: &InputTable) -> Result<Figures, MotionError> {
    let Subject { moved, drive, .. } = *subject;
    let smooth = friction::without(moved, drive)?;
    // What a load makes joints carry besides, friction left out, is in proportion to it.
    let moving = smooth.as_ref().map_or(moved, |(smooth, _)| smooth);
    let loaded = load(subject).map(|load| drive::sample(moving, drive, Some(load))).transpose()?;
    of_tables(subject, table, smooth.as_ref(), loaded.as_ref())
}

/// A unit load on the output, if that is a joint.
pub(super) fn load(subject: &Subject) -> Option<Part> {
    let (joint, motion) = subject.output?.joint?;
    unit_load(&subject.mechanism.joints[joint.0], motion)
}

/// The same of the samples, those without friction that sticks, if there is any, and those with a unit load on the output.
pub(super) fn of_tables(
    subject: &Subject,
    table: &InputTable,
    smooth: Option<&(Moved, InputTable)>,
    loaded: Option<&InputTable>,
) -> Result<Figures, MotionError> {
    let Subject { moved, mechanism, drive, output, request, lacking, places, stops, only_table } = *subject;
    let mut figures = Figures::empty(mechanism, drive, table);
    figures.folds = if let SpecialPlaces::Folds(folds) = places { *folds } else { [None; 2] };
    let [low, high] = figures.folds;
    figures.range = drive.range.map(|[from, to]| [low.unwrap_or(from), high.unwrap_or(to)]);
    figures.dead_points = figures.folds.iter().any(Option::is_some);
    figures.stops = stops.cloned().map(|stops| stops.with_changes(mechanism, table));
    figures.change_points = matches!(places, SpecialPlaces::Crossings(_));
    figures.lacking = lacking.to_vec();
    figures.four_bar = grashof::class(mechanism, drive.joint, &request.units);
    let inputs: Vec<f64> = (0..table.count()).map(|index| table.input(index)).collect();
    let MovedVariable { name, unit, .. } = figures.input.clone();
    figures.table.push(MotionColumn { name, unit, values: inputs });
    if let Some(output) = output {
        figures.output(output, table, drive, request.dwell)?;
    }
    if let (Some((joint, _)), Some(loaded)) = (output.and_then(|output| output.joint), loaded) {
        let table = smooth.map_or(table, |(_, table)| table);
        figures.transmission(subject, &mechanism.joints[joint.0], table, loaded);
    }
    figures.profiles(table);
    if let Some(smooth) = smooth.filter(|_| !only_table) {
        figures.friction = DriveFriction::of(moved, drive, table, smooth)?;
    }
    figures.dynamics(subject, table);
    if !only_table {
        figures.contacts(mechanism, table, &request.units);
        (figures.instant_centres, figures.relative_centres) = centres(mechanism, table, drive.rate());
    }
    if let Some(point) = &request.point {
        figures.path = Some(curve::path(table, point).ok_or_else(|| unknown_point(mechanism, point))?);
    }
    figures.thin(drive.fineness);
    Ok(figures)
}

pub(super) fn unknown_point(mechanism: &Mechanism, point: &str) -> MotionError {
    let points: Vec<String> = mechanism.body_places().map(|place| mechanism.place_name(place)).collect();
    let known = cotree::diagnostic::suggest::known(point, points.iter().map(String::as_str).collect::<Vec<_>>());
    MotionError::Request(format!("there is no point `{point}`; {known}"))
}

impl Extent {
    fn of(samples: &Samples, places: &SpecialPlaces) -> Extent {
        let figured = Figured::of(samples, places);
        Extent {
            min: figured.min(),
            max: figured.max(),
            rms: figured.rms(),
            mean: figured.mean(),
            unbounded: figured.unbounded,
        }
    }
}

impl Peak {
    fn of(samples: &Samples, places: &SpecialPlaces) -> Peak {
        let figured = Figured::of(samples, places);
        Peak { max: figured.max(), rms: figured.rms(), unbounded: figured.unbounded }
    }
}

/// Masses and moments of inertia at the default parameters.
struct Masses(Vec<[f64; 2]>);

impl Masses {
    /// None if one is missing that is needed.
    fn of(mechanism: &Mechanism) -> Option<Masses> {
        let parameters = mechanism.parameter_values();
        let body = |body: &cotree::model::Body| {
            let mass = evaluate(body.mass.as_ref()?, &parameters);
            // A body that cannot turn needs no moment of inertia.
            let inertia = body.inertia.as_ref().map_or(0.0, |inertia| evaluate(inertia, &parameters));
            Some([mass, inertia])
        };
        mechanism.bodies.iter().map(body).collect::<Option<_>>().map(Masses)
    }

    /// The sum of a quantity of all bodies, made of variables of each, its mass and its moment of inertia.
    fn sum<const N: usize>(
        &self,
        mechanism: &Mechanism,
        table: &InputTable,
        quantities: [Quantity; N],
        of: impl Fn([f64; N], f64, f64) -> f64,
    ) -> Option<Samples> {
        let mut total: Option<Samples> = None;
        for (body, &[mass, inertia]) in mechanism.bodies.iter().zip(&self.0) {
            let names = quantities.map(|quantity| quantity.of(&body.name));
            let part = table.made(names, |values| of(values, mass, inertia))?;
            total = Some(match total {
                None => part,
                Some(total) => total.plus(&part),
            });
        }
        total
    }
}

/// 1 N.m on the body that the output joint holds, or 1 N along it.
fn unit_load(output: &Part, motion: Derivatives) -> Option<Part> {
    const NAME: &str = "cotree_unit_load";
    let body = moving(output)?;
    match motion {
        ANGULAR => Some(Part::applied_torque(NAME, body, Formula::Number(1.0))),
        _ => {
            let axis = output.vector("axis");
            // The axis is that of the ground if the ground is the first end.
            (output.bodies()[0].is_none()).then(|| Part::applied_force(NAME, body, axis))
        }
    }
}

/// What a unit load makes a joint carry besides.
fn differences(joint: &Part, table: &InputTable, loaded: &InputTable) -> Option<[Samples; 2]> {
    if !joint.component().reactions.starts_with(&[Quantity::Fx, Quantity::Fy]) {
        return None;
    }
    let of = |quantity: Quantity| {
        let name = quantity.of(&joint.name);
        Some(loaded.get(&name)?.minus(&table.get(&name)?))
    };
    Some([of(Quantity::Fx)?, of(Quantity::Fy)?])
}

/// The body that moves at a joint on the ground.
fn moving(joint: &Part) -> Option<BodyId> {
    joint.bodies().into_iter().flatten().next()
}

impl Figures {
    fn empty(mechanism: &Mechanism, drive: &DrivenJoint, table: &InputTable) -> Figures {
        let input = &mechanism.joints[drive.joint.0];
        Figures {
            name: mechanism.name.clone(),
            input: MovedVariable::new(&drive::called(input, drive.motion), &unit_of(drive.motion).si),
            speed: drive.speed,
            full_turn: table.periodic,
            cams: cams(mechanism),
            ..Figures::default()
        }
    }

    /// Of so many samples keeps one for the tables.
    fn thin(&mut self, every: usize) {
        self.table.iter_mut().for_each(|column| thinned(&mut column.values, every));
        self.instant_centres.iter_mut().for_each(|centres| thinned(&mut centres.at, every));
        self.relative_centres.iter_mut().for_each(|centres| thinned(&mut centres.at, every));
        if let Some(path) = &mut self.path {
            thinned(&mut path.radius, every);
            [&mut path.x, &mut path.y].into_iter().for_each(|values| thinned(values, every));
        }
    }

    fn push(&mut self, name: &str, unit: &str, samples: &Samples) {
        let (name, unit) = (name.to_string(), unit.to_string());
        self.table.push(MotionColumn { name, unit, values: samples.values().to_vec() });
    }

    /// Position, influence coefficients, limits, stroke, time ratio and mechanical advantage of the output.
    fn output(
        &mut self,
        output: &Watched,
        table: &InputTable,
        drive: &DrivenJoint,
        dwell: Option<f64>,
    ) -> Result<(), MotionError> {
        let (name, link) = (&output.name, MovedVariable::new(&output.name, &output.unit.si));
        let missing = || MotionError::Request(format!("`{name}` cannot be computed: the scene gives no masses for it"));
        let position = output.variables.first().and_then(|name| table.get(name)).ok_or_else(missing)?;
        // An angle may turn on and on; between neighbours it is smooth.
        let unwound = if link.angular { position.unwound() } else { position.clone() };
        self.output = Some(link.clone());
        self.push(name, &link.unit, &position);
        let Some([first, second]) = self.influence(output, &position, table, drive) else {
            self.stroke = Some(unwound.max().value - unwound.min().value);
            return Ok(());
        };
        let input = self.input.unit.clone();
        self.push(&format!("{name}'"), &ratio(&link.unit, &input, 1), &first);
        self.push(&format!("{name}''"), &ratio(&link.unit, &input, 2), &second);
        if matches!(&*link.unit, "rad" | "m") {
            // 1/q': at a limit infinite.
            self.push("advantage", &ratio(&input, &link.unit, 1), &first.map(|value| 1.0 / value));
        }
        self.limits = first.zeros().iter().map(|&input| ValueAt { input, value: unwound.at_input(input) }).collect();
        if self.limits.len() >= 2 || !table.periodic {
            let mut reached = self.at_dead_points(&unwound);
            reached.extend([unwound.min().value, unwound.max().value]);
            let [least, most] = [f64::min, f64::max].map(|of| reached.iter().copied().reduce(of));
            self.stroke = most.zip(least).map(|(most, least)| most - least);
        }
        if let Some(tolerance) = dwell.filter(|_| !table.periodic || unwound.is_periodic()) {
            let ends = [table.input(0), table.input(if table.periodic { table.count() } else { table.count() - 1 })];
            self.dwell = Dwell::longest(&unwound, &self.limits, tolerance, ends, table.periodic);
        }
        // Where it dwells there is no one input between going and coming back.
        if let [a, b] = self.limits[..]
            && table.periodic
            && first.with(&second, f64::hypot).zeros().is_empty()
        {
            let way = b.input - a.input;
            let rest = std::f64::consts::TAU - way;
            self.time_ratio = Some(way.max(rest) / way.min(rest));
        }
        Ok(())
    }

    /// dq/dphi and d2q/dphi2: by the rates that the scene has of it, else by the slopes between samples. Next to a dead point, where slopes grow without bound, neighbours do not give them: none.
    fn influence(
        &self,
        output: &Watched,
        position: &Samples,
        table: &InputTable,
        drive: &DrivenJoint,
    ) -> Option<[Samples; 2]> {
        let rate = |order: i32| {
            let samples = table.get(output.variables.get(order as usize)?)?;
            Some(samples.map(|value| value / drive.rate().powi(order)))
        };
        let slope = |of: &Samples, turns: bool| (!self.dead_points).then(|| table.slope(of, turns));
        let first = rate(1).or_else(|| slope(position, output.unit.si == "rad"))?;
        let second = rate(2).or_else(|| slope(&first, false))?;
        Some([first, second])
    }

    /// The output where the motion folds, a little beyond the first and the last sample: at the way d from there it is a power series of sqrt(d).
    fn at_dead_points(&self, position: &Samples) -> Vec<f64> {
        let Some(last) = position.values().len().checked_sub(8).map(|rest| rest + 7) else { return Vec::new() };
        let nearest = |end: usize| std::array::from_fn::<usize, 8, _>(|i| if end == 0 { i } else { last - i });
        let at = |(end, fold): (usize, f64)| {
            let samples =
                nearest(end).map(|index| [(fold - position.input(index)).abs().sqrt(), position.values()[index]]);
            lagrange(&samples, 0.0)
        };
        [0, last].into_iter().zip(self.folds).filter_map(|(end, fold)| Some(at((end, fold?)))).collect()
    }

    /// Transmission angles and the joint-force index, by the difference that a unit load makes.
    fn transmission(&mut self, subject: &Subject, output: &Part, table: &InputTable, loaded: &InputTable) {
        let Subject { mechanism, places, only_table, .. } = *subject;
        let Some(body) = moving(output) else { return };
        let carried: Vec<(&Part, [Samples; 2])> =
            mechanism.joints.iter().filter_map(|joint| Some((joint, differences(joint, table, loaded)?))).collect();
        let sizes = carried.iter().map(|(_, [x, y])| x.with(y, f64::hypot));
        let Some(largest) = sizes.reduce(|largest, size| largest.with(&size, f64::max)) else { return };
        let nothing = NOTHING * largest.max().value;
        for (joint, force) in &carried {
            // What carries nothing transmits nothing.
            if force[0].with(&force[1], f64::hypot).max().value <= nothing {
                continue;
            }
            let Some(place) = joint.between.into_iter().find(|place| place.body() == Some(body)) else { continue };
            // At its joint with the ground the body's point does not move.
            if joint.bodies().contains(&None) {
                continue;
            }
            let point = mechanism.place_name(place);
            let velocity = [Quantity::Vx, Quantity::Vy].map(|quantity| table.get(&quantity.of(&point)));
            let direction = directions(table, [&point, &mechanism.bodies[body.0].name]);
            if let ([Some(vx), Some(vy)], Some(direction)) = (velocity, direction) {
                self.transmitted(joint, [force, &[vx, vy], &direction], only_table);
            }
        }
        if only_table {
            return;
        }
        let figured = Figured::of(&largest, places);
        self.joint_force_index = Some(Largest { at: figured.max(), unbounded: figured.unbounded });
    }

    /// The acute angle between force and path is 90 degrees less the transmission angle. The velocity is zero where the path has a direction only.
    fn transmitted(&mut self, joint: &Part, [force, velocity, direction]: [&[Samples; 2]; 3], only_table: bool) {
        let parts = |[dx, dy]: &[Samples; 2]| {
            let [x, y] = force;
            let along = x.with(dx, |f, d| f * d).plus(&y.with(dy, |f, d| f * d));
            [along, x.with(dy, |f, d| f * d).minus(&y.with(dx, |f, d| f * d))]
        };
        let ([along, across], directed) = (parts(velocity), parts(direction));
        let acute = |along: f64, across: f64| along.abs().atan2(across.abs());
        let angle = directed[0].with(&directed[1], acute);
        self.push(&format!("transmission at {}", joint.name), "rad", &angle);
        if only_table {
            return;
        }
        // Its ends, 0 and 90 degrees, are kinks.
        let least = 1e-6 * along.with(&across, f64::hypot).max().value;
        let end = |zero: &Samples, other: &Samples, value: f64| {
            let input = zero.zeros().into_iter().find(|&input| other.at_input(input).abs() > least);
            input.map(|input| ValueAt { input, value })
        };
        // Where the motion folds it goes on smoothly in its double.
        let double = directed[0].with(&directed[1], f64::atan2).map(|angle| 2.0 * angle);
        let parts = [double.map(f64::sin), double.map(f64::cos)].map(|part| self.at_dead_points(&part));
        let folds = self.folds.into_iter().flatten().zip(parts[0].iter().zip(&parts[1]));
        let at_folds: Vec<ValueAt> = folds
            .map(|(input, (sin, cos))| {
                let angle = 0.5 * sin.atan2(*cos);
                ValueAt { input, value: acute(angle.sin(), angle.cos()) }
            })
            .collect();
        let extreme = |kink: Option<ValueAt>, inner: ValueAt, beats: fn(&f64, &f64) -> bool| {
            let all = at_folds
                .iter()
                .copied()
                .fold(inner, |best, piece| if beats(&piece.value, &best.value) { piece } else { best });
            kink.unwrap_or(all)
        };
        self.transmission.push(TransmissionAngle {
            joint: joint.name.clone(),
            min: extreme(end(&along, &across, 0.0), angle.min(), f64::lt),
            max: extreme(end(&across, &along, FRAC_PI_2), angle.max(), f64::gt),
        });
    }

    /// Pressure angle and radius of curvature where each cam touches its follower.
    fn profiles(&mut self, table: &InputTable) {
        let names: Vec<String> = self.cams.iter().map(|cam| cam.name.clone()).collect();
        for name in names {
            let pressure = Quantity::PressureAngle.of(&name);
            if let Some(angle) = table.get(&pressure) {
                self.push(&pressure, "rad", &angle);
            }
            if let Some(curvature) = table.get(&Quantity::Curvature.of(&name)) {
                // Infinite where the profile is straight.
                self.push(&radius_of(&name), "m", &curvature.map(|value| 1.0 / value));
            }
        }
    }

    /// What would lift off or slip.
    fn contacts(&mut self, mechanism: &Mechanism, table: &InputTable, units: &Units) {
        let inputs: Vec<f64> = (0..table.count()).map(|index| table.input(index)).collect();
        let place =
            contact::ContactAxis { named: format!("`{}` =", self.input.name), unit: shown(units, &self.input.unit) };
        let values = |name: &str| Some(table.get(name)?.values().to_vec());
        let found = contact::over(mechanism, units, &inputs, &place, values);
        let faults = found.faults.iter().map(|fault| format!("{}; {}", fault.message, fault.help));
        self.contacts = faults.chain(found.needed).collect();
    }

    /// What acts: drive, joint forces, and what the masses do to the ground.
    fn dynamics(&mut self, subject: &Subject, table: &InputTable) {
        let Subject { mechanism, drive, lacking, places, only_table, .. } = *subject;
        let forces = joint_forces(mechanism, table);
        let effort = table.effort();
        let is_zero = |samples: &Samples| samples.values().iter().all(|value| *value == 0.0);
        // Without masses and loads there is nothing to say of forces.
        self.no_forces = !lacking.is_empty() && effort.iter().chain(forces.iter().map(|(_, force)| force)).all(is_zero);
        if !self.no_forces {
            if let Some(effort) = &effort {
                let unit = if self.input.angular { "N.m" } else { "N" };
                self.push("drive", unit, effort);
                if let Some(without) = self.friction.as_ref().and_then(|friction| friction.without.clone()) {
                    self.push("drive without friction", unit, &without);
                }
                self.drive = (!only_table).then(|| Extent::of(effort, places));
                let rate = drive.direction() * drive.speed;
                let is_told = drive.speed != 0.0 && !only_table;
                self.power = is_told.then(|| Extent::of(&effort.map(|value| value * rate), places));
            }
            for (joint, force) in forces {
                self.push(&format!("|{joint}|"), "N", &force);
                if !only_table {
                    self.joints.push(JointForce { joint, peak: Peak::of(&force, places) });
                }
            }
        }
        if let Some(masses) = Masses::of(mechanism).filter(|_| lacking.is_empty()) {
            self.masses(subject, table, &masses);
        }
    }

    /// Generalised inertia, fluctuation of the speed, and shaking, of which there is none at rest.
    fn masses(&mut self, subject: &Subject, table: &InputTable, masses: &Masses) {
        use Quantity::{Omega, Vx, Vy};
        let Subject { mechanism, drive, places, request, only_table, .. } = *subject;
        let square = drive.rate() * drive.rate();
        let inertia = masses.sum(mechanism, table, [Vx, Vy, Omega], |[x, y, turn], mass, inertia| {
            (mass * (x * x + y * y) + inertia * turn * turn) / square
        });
        let Some(inertia) = inertia else { return };
        let unit = if self.input.angular { "kg.m2" } else { "kg" };
        self.push("inertia", unit, &inertia);
        self.inertia = (!only_table).then(|| Extent::of(&inertia, places));
        let is_bounded = self.drive.as_ref().is_some_and(|drive| drive.unbounded.is_none());
        if let (Some(effort), true) = (table.effort(), self.full_turn && is_bounded) {
            self.fluctuation = Some(Fluctuation::of(&effort, &inertia, drive.speed, request.fluctuation));
        }
        if drive.speed != 0.0 {
            self.shaking(subject, table, masses);
        }
    }

    fn shaking(&mut self, subject: &Subject, table: &InputTable, masses: &Masses) {
        use Quantity::{Alpha, Ax, Ay, X, Y};
        let Subject { mechanism, drive, places, only_table, .. } = *subject;
        let x = masses.sum(mechanism, table, [Ax], |[a], mass, _| -mass * a);
        let y = masses.sum(mechanism, table, [Ay], |[a], mass, _| -mass * a);
        let moment = masses.sum(mechanism, table, [X, Y, Ax, Ay, Alpha], |[x, y, ax, ay, alpha], mass, inertia| {
            -(mass * (x * ay - y * ax) + inertia * alpha)
        });
        let (Some(x), Some(y), Some(moment)) = (x, y, moment) else { return };
        // From the origin to the input joint, if that is on the ground.
        let input = &mechanism.joints[drive.joint.0];
        let place = input.between.into_iter().find(|place| place.body().is_none()).unwrap_or(Place::Origin);
        let name = mechanism.place_name(place);
        let centre = [X, Y].map(|quantity| table.get(&quantity.of(&name)));
        let moment = match &centre {
            [Some(cx), Some(cy)] => moment.minus(&cx.with(&y, |r, f| r * f)).plus(&cy.with(&x, |r, f| r * f)),
            _ => moment,
        };
        let size = x.with(&y, f64::hypot);
        self.push("shaking fx", "N", &x);
        self.push("shaking fy", "N", &y);
        self.push("|shaking force|", "N", &size);
        self.push("shaking moment", "N.m", &moment);
        self.shaking_force = (!only_table).then(|| Peak::of(&size, places));
        self.shaking_moment = (!only_table).then(|| Extent::of(&moment, places));
    }
}

/// The size of the force of each joint that has one.
fn joint_forces(mechanism: &Mechanism, table: &InputTable) -> Vec<(String, Samples)> {
    let force = |joint: &Part| match joint.component().reactions {
        [Quantity::Fx, Quantity::Fy, ..] => {
            table.made([Quantity::Fx, Quantity::Fy].map(|quantity| quantity.of(&joint.name)), |[x, y]| x.hypot(y))
        }
        words => {
            let word = words.iter().find(|word| word.measure().si == "N")?;
            table.made([word.of(&joint.name)], |[force]| force.abs())
        }
    };
    mechanism.joints.iter().filter_map(|joint| Some((joint.name.to_string(), force(joint)?))).collect()
}

fn thinned<T: Copy>(values: &mut Vec<T>, every: usize) {
    if every > 1 {
        *values = values.iter().copied().step_by(every).collect();
    }
}

/// The unit of a derivative: `m/rad`, `rad/m2`; a pure number has none.
fn ratio(above: &str, below: &str, order: u32) -> String {
    match (above, below, order) {
        ("rad", "rad", 1) | ("m", "m", 1) => String::new(),
        ("rad", "rad", _) => "1/rad".to_owned(),
        ("m", "m", _) => "1/m".to_owned(),
        ("", below, 1) => format!("1/{below}"),
        ("", below, _) => format!("1/{below}2"),
        (above, below, 1) => format!("{above}/{below}"),
        (above, below, _) => format!("{above}/{below}2"),
    }
}
