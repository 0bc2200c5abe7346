//! Simulates each linkage through its task. This decides whether the linkage is accepted.

use std::sync::Arc;

use cotree::compile;
use cotree::scene::{Faults, Scene};
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;
use cotree_fmu::program::check::ProgramError;
use cotree_synthesis::{Point, Pose, way};
use thiserror::Error;

/// A pose that a scene is to have at a time \[s\].
pub struct PoseStation {
    pub time: f64,
    pub pose: Pose,
}

/// Why a scene cannot be moved through poses.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct DriveError(pub String);

cotree::diagnostic::from_messages!(DriveError as DriveError: Faults, ProgramError, InstanceError);

/// How far a scene is from the poses at their times, at most: places as shares of the size, angles in radians.
///
/// # Errors
/// Why the scene cannot be moved there.
pub fn largest_miss(text: &str, stations: &[PoseStation], size: f64) -> Result<f64, DriveError> {
    let program = compile(&Scene::from_toml(text)?)?.program;
    let model = Arc::new(Model::new(program)?);
    let mut instance = Instance::new(model);
    let name = |name: &'static str| instance.variable(name).ok_or_else(|| DriveError(format!("there is no {name}")));
    let variables = [name("coupler.origin.x")?, name("coupler.origin.y")?, name("coupler.angle")?];
    Ok(walk(&mut instance, variables, stations, size)?)
}

/// The largest of what `off` says of two outputs of a scene at times \[s\].
///
/// # Errors
/// Why the scene cannot be moved there.
pub fn largest_output_miss<T>(
    text: &str,
    outputs: [&'static str; 2],
    stations: &[(f64, T)],
    mut off: impl FnMut(usize, [f64; 2]) -> f64,
) -> Result<f64, DriveError> {
    let program = compile(&Scene::from_toml(text)?)?.program;
    let mut instance = Instance::new(Arc::new(Model::new(program)?));
    let name = |name: &'static str| instance.variable(name).ok_or_else(|| DriveError(format!("there is no {name}")));
    let variables = [name(outputs[0])?, name(outputs[1])?];
    instance.setup(0.0, None, Some(1e-12))?;
    instance.initialise()?;
    let mut most: f64 = 0.0;
    for (index, (time, _)) in stations.iter().enumerate() {
        if *time > instance.time() {
            instance.step_to(*time)?;
        }
        let [a, b] = variables.map(|variable| instance.get(variable));
        most = most.max(off(index, [a?, b?]));
    }
    Ok(most)
}

fn walk(
    instance: &mut Instance,
    variables: [usize; 3],
    stations: &[PoseStation],
    size: f64,
) -> Result<f64, InstanceError> {
    instance.setup(0.0, None, Some(1e-12))?;
    instance.initialise()?;
    let mut most: f64 = 0.0;
    for station in stations {
        if station.time > instance.time() {
            instance.step_to(station.time)?;
        }
        let [x, y, angle] = variables.map(|variable| instance.get(variable));
        let off = (Point::new(x?, y?) - station.pose.at).norm() / size;
        most = most.max(off).max(way(station.pose.angle, angle?).abs());
    }
    Ok(most)
}
