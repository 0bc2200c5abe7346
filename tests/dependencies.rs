//! The dependencies that the model description declares, against what changes when a state or an input changes.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cotree::export::description::{Causality, Description, Start};
use cotree::pipeline::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Source;

/// Two pendulums that have nothing to do with each other.
const APART: &str = r#"
format = 1
name = "apart"
gravity = [0, -9.81]
[inputs]
torque = "0 N.m"
[bodies.left]
mass = 1.0
inertia = 0.1
points = { pin = [0, 1] }
[bodies.right]
mass = 1.0
inertia = 0.2
points = { pin = [0, 1] }
[joints.left_pin]
type = "revolute"
between = ["ground", "left.pin"]
[joints.right_pin]
type = "revolute"
between = ["ground", "right.pin"]
[loads.motor]
type = "torque"
on = "left"
value = "torque"
[initial]
"left.angle" = 0.3
"right.angle" = 0.5
[outputs]
variables = ["left.alpha", "right.alpha", "left_pin.fx", "right_pin.fy", "left.x", "energy.total"]
"#;

/// Scene, variable, and a state that is in its expression but has no effect: terms that cancel.
const CANCELLED: &[(&str, &str, &str)] =
    &[("scotch_yoke", "energy.total", "crank.angle"), ("vibration", "m2.ax", "m3.vx")];

fn scenes() -> Vec<(String, String)> {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let folders = fs::read_dir(models).expect("the models").map(|entry| entry.expect("an entry").path());
    let mut folders: Vec<PathBuf> = folders.filter(|path| path.join("scene.toml").is_file()).collect();
    folders.sort();
    let read = |path: &Path| fs::read_to_string(path).expect("a scene");
    let name = |path: &Path| path.file_name().expect("a folder").to_string_lossy().into_owned();
    let mut scenes: Vec<_> = folders.iter().map(|path| (name(path), read(&path.join("scene.toml")))).collect();
    scenes.push(("apart".to_owned(), APART.to_owned()));
    let stiff = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/stiff.toml");
    scenes.push(("stiff".to_owned(), read(&stiff)));
    scenes
}

/// What a calculated variable changes with, of all states and inputs, at some states of the model.
fn found(instance: &mut Instance, description: &Description) -> Vec<BTreeSet<usize>> {
    let calculated: Vec<usize> = (0..description.variables.len()).filter(|&v| is_calculated(description, v)).collect();
    let mut found = vec![BTreeSet::new(); description.variables.len()];
    let mut states = vec![0.0; instance.state_count()];
    instance.states(&mut states).expect("consistent");
    for sample in 0..4 {
        // Off the loops too: each state counts by itself.
        let moved: Vec<f64> =
            (0..states.len()).map(|k| states[k] + 0.3 * f64::sin(f64::from(7 * k as u32 + sample))).collect();
        for known in 0..description.variables.len() {
            let source = instance.model().program().variables[known].source;
            let place = match source {
                Source::Coordinate(index) if !moved.is_empty() => Some(2 * index as usize),
                Source::Rate(index) if !moved.is_empty() => Some(2 * index as usize + 1),
                Source::Input(_) => None,
                _ => continue,
            };
            let mut at = |change: f64| -> Vec<Option<f64>> {
                let mut states = moved.clone();
                match place {
                    Some(place) => states[place] += change,
                    None => instance.set(known, 0.4 + change).expect("an input"),
                }
                if !states.is_empty() {
                    instance.set_states(&states).expect("finite");
                }
                calculated.iter().map(|&unknown| instance.get(unknown).ok()).collect()
            };
            let (before, after) = (at(0.0), at(1e-2));
            at(0.0);
            for ((&unknown, before), after) in calculated.iter().zip(before).zip(after) {
                // What does not depend on it has the same bits.
                if before.map(f64::to_bits) != after.map(f64::to_bits) {
                    found[unknown].insert(known);
                }
            }
        }
    }
    found
}

fn is_calculated(description: &Description, variable: usize) -> bool {
    matches!(description.variables[variable].causality, Causality::Output | Causality::Local)
}

#[test]
fn dependencies_are_those_that_differences_show() {
    for (name, text) in scenes() {
        let compiled = compile(&Scene::from_toml(&text).expect("a scene")).expect("a model");
        let description = &compiled.description;
        let model = Arc::new(Model::new(compiled.program.clone()).expect("a program"));
        let mut instance = Instance::new(model);
        instance.initialise_exchange().expect("offered");
        let found = found(&mut instance, description);
        for (variable, found) in description.variables.iter().zip(found) {
            let declared: BTreeSet<usize> = variable.dependencies.iter().copied().collect();
            let words = |set: BTreeSet<usize>| -> Vec<&str> {
                set.into_iter().map(|index| description.variables[index].name.as_str()).collect()
            };
            let missing = words(&found - &declared);
            assert!(missing.is_empty(), "{name}: `{}` also depends on {missing:?}", variable.name);
            for idle in words(&declared - &found) {
                let known = CANCELLED.contains(&(name.as_str(), variable.name.as_str(), idle));
                assert!(known, "{name}: `{}` does not depend on `{idle}`", variable.name);
            }
        }
    }
}

/// Everything that is calculated, at the start, with a parameter, an input or a known initial value changed a little.
fn at_the_start(model: &Arc<Model>, known: Option<(usize, f64)>, calculated: &[usize]) -> Option<Vec<Option<u64>>> {
    let mut instance = Instance::new(model.clone());
    if let Some((known, value)) = known {
        instance.set(known, value).ok()?;
    }
    instance.initialise().ok()?;
    Some(calculated.iter().map(|&unknown| instance.get(unknown).ok().map(f64::to_bits)).collect())
}

#[test]
fn dependencies_at_the_start_hold_all_that_differences_show() {
    for (name, text) in scenes() {
        let compiled = compile(&Scene::from_toml(&text).expect("a scene")).expect("a model");
        let description = &compiled.description;
        let model = Arc::new(Model::new(compiled.program.clone()).expect("a program"));
        let variables = &description.variables;
        let unknowns: Vec<usize> = (0..variables.len())
            .filter(|&place| {
                is_calculated(description, place) && !matches!(variables[place].start, Some(Start::Exact(_)))
            })
            .collect();
        let before = at_the_start(&model, None, &unknowns).expect("consistent");
        for (known, variable) in variables.iter().enumerate() {
            let start = match (variable.causality, variable.start) {
                (Causality::Parameter { start, .. } | Causality::Input { start, .. }, _) => start,
                (_, Some(Start::Exact(start))) => start,
                _ => continue,
            };
            // Large enough to show above the tolerance of the loops, small enough for them to close.
            let value = start * 1.001 + if start == 0.0 { 1e-3 } else { 0.0 };
            let Some(after) = at_the_start(&model, Some((known, value)), &unknowns) else { continue };
            for ((&unknown, before), after) in unknowns.iter().zip(&before).zip(after) {
                let listed = variables[unknown].initial_dependencies.contains(&known);
                let names = (&variables[unknown].name, &variable.name);
                assert!(*before == after || listed, "{name}: {} also depends on {} at the start", names.0, names.1);
            }
        }
    }
}

#[test]
fn what_is_apart_depends_on_its_own_values_at_the_start() {
    let description = compile(&Scene::from_toml(APART).expect("a scene")).expect("a model").description;
    let place = |name: &str| description.variables.iter().position(|variable| variable.name == name).expect("known");
    let depends = |name: &str| -> Vec<&str> {
        let places = description.variables[place(name)].initial_dependencies.iter();
        places.map(|&place| description.variables[place].name.as_str()).collect()
    };
    assert_eq!(depends("left.alpha"), ["torque", "left.angle"]);
    assert_eq!(depends("right.alpha"), ["right.angle"]);
    assert_eq!(depends("left.x"), ["left.angle"]);
    assert_eq!(depends("left.omega"), [""; 0]);
    assert_eq!(depends("energy.total"), ["left.angle", "right.angle"]);
}
