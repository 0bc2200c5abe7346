//! Linkages driven by the program itself: the last word on whether they do their task.

use std::sync::Arc;

use cotree::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;
use cotree_synthesis::{Point, Pose, way};

/// A pose that a scene is to have at a time \[s\].
pub struct Station {
    pub time: f64,
    pub pose: Pose,
}

/// How far a scene is from the poses at their times, at most: places as shares of the size, angles in radians.
///
/// # Errors
/// Why the scene cannot be moved there.
pub fn largest_miss(text: &str, stations: &[Station], size: f64) -> Result<f64, String> {
    let scene = Scene::from_toml(text).map_err(|faults| faults.to_string())?;
    let program = compile(&scene).map_err(|faults| faults.to_string())?.program;
    let model = Arc::new(Model::new(program).map_err(|fault| fault.to_string())?);
    let mut instance = Instance::new(model);
    let name = |name: &str| instance.variable(name).ok_or_else(|| format!("there is no {name}"));
    let variables = [name("coupler.origin.x")?, name("coupler.origin.y")?, name("coupler.angle")?];
    walk(&mut instance, variables, stations, size).map_err(|error| error.to_string())
}

fn walk(instance: &mut Instance, variables: [usize; 3], stations: &[Station], size: f64) -> Result<f64, InstanceError> {
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
