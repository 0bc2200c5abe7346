//! What has no damper and no driver keeps its energy.

use std::sync::Arc;

use cotree::formulate::formulate;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use super::{cases, choices, resolved};
use crate::support::absolute::Load;
use crate::support::random::{Case, Family};
use crate::support::scene_text::scene_text;
use crate::support::variables::variables;
use cotree::scene::Resolved;

/// Of the solver's tolerance, 1e-10 for each step; thousands of steps add up.
const DRIFT: f64 = 1e-7;

#[test]
fn conservative_mechanisms_keep_their_energy() {
    for family in [Family::Chain, Family::Tree, Family::Loops] {
        for (seed, case) in cases(family, 16) {
            let mut resolved = resolved(&conservative(case));
            // Every fourth tree pair: the presets and a random one take turns.
            let choice = choices(&resolved.mechanism, seed, 1).swap_remove(seed as usize % 4);
            resolved.mechanism.coordinates = choice;
            let drift = drift(&resolved).unwrap_or_else(|error| panic!("{family:?} {seed}: {error}"));
            assert!(drift <= DRIFT, "{family:?} {seed}: the energy drifts by {drift:e}");
        }
    }
}

/// The scene without dampers and without forces and torques that take no part in the energy.
fn conservative(mut case: Case) -> String {
    case.system.joints.iter_mut().for_each(|joint| joint.damping = 0.0);
    case.system.loads.retain(|load| matches!(load, Load::Spring { .. } | Load::TorsionSpring { .. }));
    for load in &mut case.system.loads {
        if let Load::Spring { damping, .. } | Load::TorsionSpring { damping, .. } = load {
            *damping = 0.0;
        }
    }
    let expected = variables(&case.system, &case.state, 0.0);
    scene_text("conservative", &case.system, &case.state, &expected)
}

/// Largest change of the energy in one second, relative to the largest kinetic or potential energy.
fn drift(resolved: &Resolved) -> Result<f64, String> {
    let formulated = formulate(&resolved.mechanism, &resolved.outputs).map_err(|faults| faults[0].message.clone())?;
    let model = Model::new(formulated.lowered.program).map_err(|fault| fault.to_string())?;
    let mut instance = Instance::new(Arc::new(model));
    let names = ["energy.total", "energy.kinetic", "energy.potential"];
    let places = names.map(|name| instance.variable(name).unwrap());
    instance.setup(0.0, Some(1.0), Some(1e-10)).map_err(|error| error.to_string())?;
    instance.initialise().map_err(|error| error.to_string())?;
    let start = instance.get(places[0]).map_err(|error| error.to_string())?;
    let (mut change, mut scale) = (0.0_f64, 1.0_f64);
    for step in 1..=20 {
        instance.step_to(f64::from(step) / 20.0).map_err(|error| error.to_string())?;
        let mut values = [0.0; 3];
        for (value, place) in values.iter_mut().zip(places) {
            *value = instance.get(place).map_err(|error| error.to_string())?;
        }
        change = change.max((values[0] - start).abs());
        scale = scale.max(values[1].abs()).max(values[2].abs());
    }
    Ok(change / scale)
}
