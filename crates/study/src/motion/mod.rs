//! Design quantities of a mechanism that is driven at one joint: range of motion, limits, transmission, drive, reactions, shaking, inertia,
//! for one turn or stroke. The quantities are those of Norton, *Design of Machinery*, and Uicker, Pennock, Shigley, *Theory of Machines and
//! Mechanisms*.

mod cams;
mod centres;
mod clearance;
mod curve;
mod differentiated;
mod direction;
mod drive;
mod dwell;
mod figures;
mod flywheel;
mod friction;
mod grashof;
mod growth;
mod input;
pub mod report;
mod rows;
mod samples;
mod stops;
mod tolerance;

use std::f64::consts::TAU;

use cotree::diagnostic::FaultKind;
use cotree::model::{Discrete, DiscreteKind, JointId, Mechanism, Output, Unit, Units};
use cotree::run::{RunError, SimulateError};
use cotree::scene::{Faults, Scene};
use cotree::typeset::rounded;

pub use cams::Cam;
pub use clearance::{Clearances, InputTime, PairClearance};
pub(crate) use differentiated::DifferentiatedTurn;
use drive::{COUNT, InputTable, Moved};
pub use figures::{Figures, MotionColumn, MovedVariable, Speed};
use input::{InputStart, Watched};
pub use report::usual;
pub use samples::ValueAt;
use samples::{ANGULAR, Derivatives};
use stops::ContactGaps;
pub use stops::Stops;
pub use tolerance::{Deviation, TurnTolerances, tolerances};

/// What is asked for.
#[derive(Clone, Debug, Default)]
pub struct MotionRequest {
    /// The joint that is driven, or its motion, such as `pin.s`; the one with a driver if absent.
    pub input: Option<String>,
    /// The joint, the variable or the output of the scene that is of interest; another joint on the ground if absent.
    pub output: Option<String>,
    /// The speed of the input [rad/s] or [m/s], above zero, or zero for forces at rest; the size of that at the scene's start if absent.
    pub speed: Option<f64>,
    /// From where to where, SI, in the order of the motion; one turn, or as far as it goes, if absent.
    pub range: Option<[f64; 2]>,
    /// A row of the printed table every so much of the input, SI; a twelfth of the turn or range if absent.
    pub every: Option<f64>,
    /// A point whose path is of interest.
    pub point: Option<String>,
    /// How near an end of its stroke the output is to stay, for a dwell, SI.
    pub dwell: Option<f64>,
    /// The permitted coefficient of fluctuation of the speed, for a flywheel.
    pub fluctuation: Option<f64>,
    /// The units of what is said in sentences.
    pub units: Units,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    #[error(transparent)]
    Scene(#[from] Faults),
    /// What is asked for does not fit the scene.
    #[error("{0}")]
    Request(String),
    /// The motion cannot be found or continued.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl From<SimulateError> for MotionError {
    fn from(error: SimulateError) -> Self {
        match error {
            SimulateError::Scene(faults) => MotionError::Scene(faults),
            SimulateError::Run(error) => MotionError::Run(error),
            error @ SimulateError::Settings(_) => MotionError::Request(error.to_string()),
        }
    }
}

/// The SI units of the input and of what is of interest.
///
/// # Errors
/// As [`study`].
pub fn units(scene: &Scene, request: &MotionRequest) -> Result<[Unit; 2], MotionError> {
    let mechanism = scene.resolve()?.mechanism;
    let input = input::driven(&mechanism, request.input.as_deref())?;
    let output = input::output(scene, &mechanism, input, request.output.as_deref())?;
    Ok([unit_of(input.1), output.map_or_else(Unit::length, |output| output.unit)])
}

fn unit_of(motion: Derivatives) -> Unit {
    if motion == ANGULAR { Unit::angle() } else { Unit::length() }
}

/// Which joint is driven, how fast, and how far.
#[derive(Clone, Debug)]
struct DrivenJoint {
    joint: JointId,
    motion: Derivatives,
    /// Its size [rad/s] or [m/s]; zero: forces are those at rest.
    speed: f64,
    /// Where it is at the start of the scene.
    start: f64,
    /// From where to where; none: one turn.
    range: Option<[f64; 2]>,
    /// Are the samples of the turn half a step beside round angles? In a pose where branches cross there are no reactions.
    between: bool,
    /// Steps of a range that are shown, and samples for each.
    shown: usize,
    fineness: usize,
}

impl DrivenJoint {
    /// Forwards, or backwards.
    fn direction(&self) -> f64 {
        if self.range.is_some_and(|[from, to]| to < from) { -1.0 } else { 1.0 }
    }

    /// The drive that goes the way of a table back.
    fn backwards(&self, table: &InputTable) -> DrivenJoint {
        let last = if table.periodic { table.count() } else { table.count() - 1 };
        DrivenJoint { range: Some([table.input(last), table.input(0)]), ..self.clone() }
    }

    /// The speed of the runs. Rates by the input do not depend on it.
    fn pace(&self) -> f64 {
        if self.speed == 0.0 { 1.0 } else { self.speed }
    }

    /// The rate of the input in the samples.
    fn rate(&self) -> f64 {
        self.direction() * self.pace()
    }
}

/// What states and sampled values are in a pose, and which events have happened, depends on the way there: figures of a turn or stroke cannot say what acts.
fn without_history(mechanism: &Mechanism) -> Result<(), MotionError> {
    if let Some(part) = mechanism.parts_over_pulleys().next() {
        return Err(MotionError::Request(format!(
            "how far `{}` is wound on its pulleys depends on the motion before a configuration, and the study looks at configurations one by one: use `simulate`",
            part.name
        )));
    }
    if let Some(part) = mechanism.first_at_profile() {
        return Err(MotionError::Request(format!(
            "which line or arc of its profile `{}` touches depends on the motion before a configuration, and the study looks at configurations one by one: use `simulate`",
            part.name
        )));
    }
    let sampled = mechanism.discrete.iter().find(|discrete| discrete.kind == DiscreteKind::Sampled);
    let (what, section) = if let Some(Discrete { name, .. }) = sampled {
        (format!("the sampled value `{name}` in a configuration"), "sampled")
    } else if let Some(event) = mechanism.events.first() {
        (format!("whether the event `{}` has happened before a configuration", event.name), "events")
    } else if let Some(state) = mechanism.states.first() {
        (format!("the state `{}` in a configuration", state.name), "states")
    } else {
        return Ok(());
    };
    Err(MotionError::Request(format!(
        "{what} depends on the motion before it, so the forces of a turn or stroke are not determined: use `simulate`, or a scene without `[{section}]`"
    )))
}

/// Moves a scene through one turn or stroke of its input, and says what there is to say.
///
/// # Errors
/// Faults of the scene, a request that does not fit it, a motion that cannot be found.
pub fn study(scene: &Scene, request: &MotionRequest) -> Result<Figures, MotionError> {
    study_of(scene, &scene.resolve()?.mechanism, request)
}

/// As [`study`], of the mechanism of a scene with other values of its parameters and inputs.
///
/// # Errors
/// As there.
pub fn study_of(scene: &Scene, mechanism: &Mechanism, request: &MotionRequest) -> Result<Figures, MotionError> {
    worked_out(scene, mechanism, request, false)
}

/// As [`study_of`], with the table, the stroke and the time ratio only: what a search looks at thousands of times.
///
/// # Errors
/// As there.
pub(crate) fn table_of(scene: &Scene, mechanism: &Mechanism, request: &MotionRequest) -> Result<Figures, MotionError> {
    worked_out(scene, mechanism, request, true)
}

fn worked_out(
    scene: &Scene,
    mechanism: &Mechanism,
    request: &MotionRequest,
    only_table: bool,
) -> Result<Figures, MotionError> {
    let InputRun { mechanism, moved, drive, output, lacking, stops, table, places, origin, speed } =
        InputRun::of(scene, mechanism, request)?;
    let subject = figures::Subject {
        moved: &moved,
        mechanism: &mechanism,
        drive: &drive,
        output: output.as_ref(),
        request,
        lacking: &lacking,
        places: &places,
        stops: stops.as_ref(),
        only_table,
    };
    let figures = figures::of(&subject, &table)?;
    let rows = if only_table { Vec::new() } else { rows::rows(&subject, &figures)? };
    let mut clearances = if only_table { Clearances::default() } else { clearance::of(&subject, &table)? };
    let mut whole = figures.table;
    whole.append(&mut clearances.columns);
    let reversed = origin == Speed::OfScene && speed < 0.0 && drive.direction() > 0.0;
    let Clearances { pairs, permitted, .. } = clearances;
    let clearance = (!pairs.is_empty()).then_some(pairs);
    Ok(Figures { reversed, origin, rows, clearance, least_clearance: permitted, table: whole, ..figures })
}

/// A turn or stroke that has been moved through.
struct InputRun {
    mechanism: Mechanism,
    moved: Moved,
    drive: DrivenJoint,
    output: Option<Watched>,
    /// Bodies without a mass that forces need.
    lacking: Vec<String>,
    stops: Option<Stops>,
    table: InputTable,
    places: SpecialPlaces,
    /// Where the speed is from, and that of the scene's start [rad/s] or [m/s].
    origin: Speed,
    speed: f64,
}

impl InputRun {
    fn of(scene: &Scene, mechanism: &Mechanism, request: &MotionRequest) -> Result<InputRun, MotionError> {
        without_history(mechanism)?;
        let gaps = ContactGaps::of(mechanism)?;
        let mechanism = mechanism.without_stops();
        let input @ (joint, motion) = input::driven(&mechanism, request.input.as_deref())?;
        let output = input::output(scene, &mechanism, input, request.output.as_deref())?;
        let requested: Vec<Output> = output.iter().map(|output| output.requested.clone()).collect();
        let InputStart { position: start, speed, moved } = input::start(scene, &mechanism, &requested, input)?;
        let still = speed.abs() <= 1e-9;
        let origin = match request.speed {
            Some(_) => Speed::Requested,
            None if still => Speed::Assumed,
            None => Speed::OfScene,
        };
        let rate = if still { 1.0 } else { speed.abs() };
        let mut drive = DrivenJoint {
            joint,
            motion,
            speed: request.speed.unwrap_or(rate),
            start,
            range: request.range,
            between: false,
            shown: COUNT,
            fineness: 1,
        };
        permitted(&mechanism, &drive, request, output.as_ref())?;
        input::is_there(&mechanism, &requested, &moved, &drive)?;
        let lacking = drive::lacking(&moved, &drive)?;
        let moved = input::without_masses(moved, &drive, &lacking);
        let stops = gaps.met(&moved, &drive, &request.units)?;
        let (mut table, places) = match (request.range, &stops) {
            (Some(range), stops) => {
                drive.range = Some(
                    stops
                        .as_ref()
                        .map_or(Ok(range), |stops| stops.clipped(range, &mechanism, &drive, &request.units))?,
                );
                (drive::sample(&moved, &drive, None)?, SpecialPlaces::Ordinary)
            }
            (None, Some(stops)) if stops.ends.iter().any(Option::is_some) => between_stops(&moved, &mut drive, stops)?,
            (None, _) => whole_way(&moved, &mut drive)?,
        };
        drive.fineness = drive::fineness(&mechanism, &table)?;
        if drive.fineness > 1 {
            table = drive::sample(&moved, &drive, None)?;
        }
        Ok(InputRun { mechanism, moved, drive, output, lacking, stops, table, places, origin, speed })
    }
}

/// Whether what is asked for can be.
fn permitted(
    mechanism: &Mechanism,
    drive: &DrivenJoint,
    request: &MotionRequest,
    output: Option<&Watched>,
) -> Result<(), MotionError> {
    let refused = |message: String| Err(MotionError::Request(message));
    if !(drive.speed >= 0.0 && drive.speed.is_finite()) {
        return refused(format!(
            "the speed of the input is {}, but must be positive, or 0 for static forces; for a backward motion give a range such as \"60 deg..0 deg\"",
            drive.speed
        ));
    }
    if drive.speed == 0.0 {
        if let Some(slips) = mechanism.first_slip() {
            return refused(format!("{slips} is not determined at rest: give a positive speed"));
        }
        if let Some(output) = output.filter(|output| output.is_rate) {
            return refused(format!("`{}` is 0 at rest: give a positive speed", output.name));
        }
        if request.fluctuation.is_some() {
            return refused("the speed is 0 and cannot fluctuate: give a positive speed".to_owned());
        }
    }
    match request.range {
        Some([from, to]) if !(from.is_finite() && to.is_finite() && from != to) => {
            let unit = request.units.of(&unit_of(drive.motion));
            let [from, to] = [from, to].map(|at| rounded(at / unit.factor, 4));
            refused(format!("the range from {from} to {to} {} is empty", unit.name))
        }
        _ => Ok(()),
    }
}

/// Where the motion is special.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SpecialPlaces {
    /// Nowhere.
    Ordinary,
    /// At an end, or at both, the motion folds: the input there.
    Folds([Option<f64>; 2]),
    /// Branches of the motion cross: the inputs.
    Crossings(Vec<f64>),
}

/// The motion of a full turn; else as far as the input goes from its start both ways.
fn whole_way(moved: &Moved, drive: &mut DrivenJoint) -> Result<(InputTable, SpecialPlaces), MotionError> {
    let mechanism = &moved.mechanism;
    let is_angular = drive.motion == ANGULAR;
    if is_angular {
        match drive::sample(moved, drive, None) {
            Err(MotionError::Run(_)) => {}
            // The turn begins a little ahead of the scene: out of reach already.
            Err(MotionError::Scene(faults)) if faults.list.iter().all(|list| list.kind() == FaultKind::Assembly) => {}
            sampled => {
                let table = sampled?;
                let crossings = drive::change_points(moved, drive)?;
                if crossings.is_empty() {
                    return Ok((table, SpecialPlaces::Ordinary));
                }
                // In a singular pose nothing but the motion itself is determined.
                drive.between = true;
                return Ok((drive::sample(moved, drive, None)?, SpecialPlaces::Crossings(crossings)));
            }
        }
    }
    let most = if is_angular { TAU } else { drive::size(mechanism) };
    let reach = |direction: f64| drive::reach(moved, drive, direction, most);
    let (back, forth) = (reach(-1.0)?, reach(1.0)?);
    let is_whole = |way: f64| way >= most * (1.0 - 1e-9);
    if is_angular && is_whole(back) && is_whole(forth) {
        drive.between = true;
        let crossings = drive::change_points(moved, drive)?;
        return Ok((drive::sample(moved, drive, None)?, SpecialPlaces::Crossings(crossings)));
    }
    if is_whole(back) || is_whole(forth) {
        return Err(endless(mechanism, drive));
    }
    if back + forth <= 1e-9 * most {
        let name = &mechanism.joints[drive.joint.0].name;
        let message = format!("`{name}` cannot move from the start of the scene: it is a dead point for this input");
        return Err(MotionError::Request(message));
    }
    let folds = [drive.start - back, drive.start + forth];
    drive.range = Some(between_folds(folds.map(Some), folds));
    Ok((drive::sample(moved, drive, None)?, SpecialPlaces::Folds(folds.map(Some))))
}

/// The motion from one stop to the other; where there is none on one side, to where the motion folds or one turn on.
fn between_stops(
    moved: &Moved,
    drive: &mut DrivenJoint,
    stops: &Stops,
) -> Result<(InputTable, SpecialPlaces), MotionError> {
    let is_angular = drive.motion == ANGULAR;
    let most = if is_angular { TAU } else { drive::size(&moved.mechanism) };
    let mut ends = [drive.start; 2];
    let mut folds = [None; 2];
    for (index, (direction, stop)) in [-1.0, 1.0].into_iter().zip(&stops.ends).enumerate() {
        if let Some(stop) = stop {
            ends[index] = stop.input;
            continue;
        }
        let way = drive::reach(moved, drive, direction, most)?;
        ends[index] += direction * way;
        if way < most * (1.0 - 1e-9) {
            folds[index] = Some(ends[index]);
        } else if !is_angular {
            return Err(endless(&moved.mechanism, drive));
        }
    }
    drive.range = Some(between_folds(folds, ends));
    Ok((drive::sample(moved, drive, None)?, SpecialPlaces::Folds(folds)))
}

/// A range that ends a little before where the motion folds: there are no rates.
fn between_folds(folds: [Option<f64>; 2], [low, high]: [f64; 2]) -> [f64; 2] {
    let margin = 1e-3 * (high - low);
    let [before, behind] = folds.map(|fold| if fold.is_some() { margin } else { 0.0 });
    [low + before, high - behind]
}

fn endless(mechanism: &Mechanism, drive: &DrivenJoint) -> MotionError {
    let name = &mechanism.joints[drive.joint.0].name;
    MotionError::Request(format!("`{name}` has an unlimited range: give one, such as \"0 mm..120 mm\""))
}
