//! What designers ask of a mechanism that is driven at one joint: range of motion, limits, transmission, drive, reactions, shaking, inertia,
//! for one turn or stroke. The quantities are those of Norton, *Design of Machinery*, and Uicker, Pennock, Shigley, *Theory of Machines and
//! Mechanisms*.

mod cams;
mod centres;
mod curve;
mod drive;
mod dwell;
mod figures;
mod flywheel;
mod grashof;
mod input;
pub mod report;
mod samples;

use std::f64::consts::TAU;

use cotree::columns::rounded;
use cotree::mechanism::{JointId, Mechanism, Unit, Units};
use cotree::scene::{Faults, Scene};
use cotree::simulate::{RunError, SimulateError};

pub use cams::Cam;
use drive::Table;
pub use figures::{Column, Figures, Link};
use input::Start;
pub use report::{step, usual};
pub use samples::At;
use samples::{ANGULAR, Derivatives};

/// What is asked for.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// The joint that is driven, or its motion, such as `pin.s`; the one with a driver if absent.
    pub input: Option<String>,
    /// The joint, the variable or the output of the scene that is of interest; another joint on the ground if absent.
    pub output: Option<String>,
    /// The speed of the input [rad/s] or [m/s], above zero; the size of that at the scene's start if absent.
    pub speed: Option<f64>,
    /// From where to where, SI, the lower end first; one turn, or as far as it goes, if absent.
    pub range: Option<[f64; 2]>,
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
pub fn units(scene: &Scene, request: &Request) -> Result<[Unit; 2], MotionError> {
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
struct Drive {
    joint: JointId,
    motion: Derivatives,
    /// [rad/s] or [m/s]
    speed: f64,
    /// Where it is at the start of the scene.
    start: f64,
    /// From where to where; none: one turn.
    range: Option<[f64; 2]>,
    /// Are the samples of the turn half a step beside round angles? In a pose where branches cross there are no reactions.
    between: bool,
    /// Samples for each that is shown.
    fineness: usize,
}

/// Moves a scene through one turn or stroke of its input, and says what there is to say.
///
/// # Errors
/// Faults of the scene, a request that does not fit it, a motion that cannot be found.
pub fn study(scene: &Scene, request: &Request) -> Result<Figures, MotionError> {
    let mechanism = scene.resolve()?.mechanism;
    let input @ (joint, motion) = input::driven(&mechanism, request.input.as_deref())?;
    let output = input::output(scene, &mechanism, input, request.output.as_deref())?;
    let Start { position: start, speed, scene } = input::start(scene, &mechanism, input)?;
    let scene = &input::reporting(scene, output.as_ref());
    let reversed = request.speed.is_none() && speed < -1e-9;
    let speed = request.speed.unwrap_or(if speed.abs() > 1e-9 { speed.abs() } else { 1.0 });
    if !(speed > 0.0 && speed.is_finite()) {
        return Err(MotionError::Request(format!("the speed of the input must be above zero, not {speed}")));
    }
    let mut drive = Drive { joint, motion, speed, start, range: request.range, between: false, fineness: 1 };
    input::is_there(scene, &mechanism, &drive)?;
    if let Some([low, high]) = request.range
        && !(low <= start && start <= high && low < high)
    {
        let unit = request.units.of(&unit_of(motion));
        let [low, high, start] = [low, high, start].map(|at| rounded(at / unit.factor, 4));
        let message = format!(
            "the range from {low} to {high} {0} does not have the start of the scene, {start} {0}, in it",
            unit.name
        );
        return Err(MotionError::Request(message));
    }
    let (mut table, folds) = match request.range {
        Some(_) => (drive::sample(scene, &mechanism, &drive, None)?, None),
        None => whole_way(scene, &mechanism, &mut drive)?,
    };
    drive.fineness = drive::fineness(&mechanism, &table)?;
    if drive.fineness > 1 {
        table = drive::sample(scene, &mechanism, &drive, None)?;
    }
    let subject = figures::Subject { scene, mechanism: &mechanism, drive: &drive, output: output.as_ref(), request };
    Ok(Figures { reversed, ..figures::of(&subject, &table, folds)? })
}

/// The motion of a full turn; else as far as the input goes from its start both ways, and the input at the folds there.
fn whole_way(
    scene: &Scene,
    mechanism: &Mechanism,
    drive: &mut Drive,
) -> Result<(Table, Option<[f64; 2]>), MotionError> {
    let is_angular = drive.motion == ANGULAR;
    if is_angular {
        match drive::sample(scene, mechanism, drive, None) {
            Err(SimulateError::Run(_)) => {}
            // The turn begins a little ahead of the scene: out of reach already.
            Err(SimulateError::Scene(faults)) if faults.list.iter().all(|own| own.code.starts_with("assembly::")) => {}
            sampled => {
                let table = sampled?;
                drive.between = drive::passes_change_points(scene, mechanism, drive)?;
                // In a singular pose nothing but the motion itself is determined.
                let between = drive.between.then(|| drive::sample(scene, mechanism, drive, None));
                return Ok((between.unwrap_or(Ok(table))?, None));
            }
        }
    }
    let most = if is_angular { TAU } else { drive::size(mechanism) };
    let [back, forth] = [-1.0, 1.0].map(|direction| drive::reach(scene, mechanism, drive, direction, most));
    let is_whole = |way: f64| way >= most * (1.0 - 1e-9);
    if is_angular && is_whole(back) && is_whole(forth) {
        drive.between = true;
        return Ok((drive::sample(scene, mechanism, drive, None)?, None));
    }
    if is_whole(back) || is_whole(forth) {
        let name = &mechanism.joints[drive.joint.0].name;
        let message = format!("`{name}` moves without an end: give its range, such as \"0 mm..120 mm\"");
        return Err(MotionError::Request(message));
    }
    if back + forth <= 1e-9 * most {
        let name = &mechanism.joints[drive.joint.0].name;
        let message =
            format!("`{name}` cannot move from where the scene starts: a dead point of the mechanism for this input");
        return Err(MotionError::Request(message));
    }
    // The folds themselves have no rates.
    let margin = 1e-3 * (back + forth);
    drive.range = Some([drive.start - (back - margin).max(0.0), drive.start + (forth - margin).max(0.0)]);
    Ok((drive::sample(scene, mechanism, drive, None)?, Some([drive.start - back, drive.start + forth])))
}
