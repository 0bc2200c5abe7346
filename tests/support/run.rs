//! Scenes read, compiled and run, where none of it may fail.
#![allow(dead_code, reason = "each test file uses its own part")]

use crate::support::ROOT;
use std::path::Path;
use std::sync::Arc;

use cotree::compile::{Compiled, compile};
use cotree::formulate::{Formulated, formulate};
use cotree::model::Mechanism;
use cotree::scene::{Faults, Resolved, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;

/// What there is, or a panic with the faults as a user sees them.
pub fn sound<T>(result: Result<T, Faults>) -> T {
    result.unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)))
}

/// The text of a file of the repository.
pub fn file(path: &str) -> String {
    let path = Path::new(ROOT).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A block of 1 kg on a guide, between whose wall, 1 m away, and itself are a spring of 100 N/m, relaxed in the middle, and the load `rub` of this law; and what else the scene says.
pub fn block_with_law(law: &str, more: &str) -> String {
    format!(
        r#"
name = "pieces"
[ground.points]
wall = [-1, 0]
[bodies.block]
mass = 1
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[loads.spring]
type = "spring"
between = ["ground.wall", "block"]
stiffness = 100
length = 1
[loads.rub]
type = "actuator"
between = ["ground.wall", "block"]
force = "{law}"
{more}
"#
    )
}

/// The scene of a model in `models`; what it says of other files of its folder is changed so that it holds from here.
pub fn scene_of(model: &str) -> String {
    from_here(model, file(&format!("models/{model}/scene.toml")))
}

/// A text of a model in which the names of the other files of its folder are paths from here.
pub fn from_here(model: &str, mut text: String) -> String {
    let folder = Path::new(ROOT).join("models").join(model);
    for entry in std::fs::read_dir(&folder).into_iter().flatten() {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        text = text.replace(&format!("\"{name}\""), &format!("\"{}\"", folder.join(&name).display()));
    }
    text
}

/// Names of the models in `models`.
pub fn models() -> Vec<String> {
    let folders = std::fs::read_dir(Path::new(ROOT).join("models")).expect("the models");
    let folders =
        folders.map(|entry| entry.expect("an entry")).filter(|entry| entry.path().join("scene.toml").is_file());
    let mut names: Vec<String> = folders.map(|entry| entry.file_name().into_string().expect("a name")).collect();
    names.sort();
    assert!(names.len() >= 15, "models are missing: {names:?}");
    names
}

/// A scene with its names resolved.
pub fn mechanism(text: &str) -> Mechanism {
    resolved(text).mechanism
}

/// As [`mechanism`], with the outputs of the scene.
pub fn resolved(text: &str) -> Resolved {
    sound(Scene::from_toml(text).and_then(|scene| scene.resolve()))
}

/// The equations and the program of a scene with its names resolved.
pub fn formulated(resolved: &Resolved) -> Formulated {
    let found = formulate(&resolved.mechanism, &resolved.outputs);
    found.unwrap_or_else(|faults| panic!("{}: {}", resolved.mechanism.name, faults[0].message))
}

/// A compiled scene.
pub fn compiled(text: &str) -> Compiled {
    sound(Scene::from_toml(text).and_then(|scene| compile(&scene)))
}

/// A scene as the runtime sees it.
pub fn model(text: &str) -> Arc<Model> {
    Arc::new(Model::new(compiled(text).program).expect("a sound program"))
}

/// A run that has begun, with an engine of its own or the one that the program chooses.
pub fn started(model: &Arc<Model>, engine: Option<Engine>, stop: f64, tolerance: f64) -> Instance {
    let mut instance = Instance::new(model.clone());
    instance.setup(model.program().experiment.start, Some(stop), Some(tolerance)).expect("times");
    if let Some(engine) = engine {
        instance.set_engine(engine).expect("not begun");
    }
    instance.initialise().expect("consistent");
    instance
}

/// The models with dry friction that sticks: no code is printed of them.
pub const RUBBING: [&str; 5] = ["barrier", "clutch_start", RUBBING_IN_DRIVEN, "stick_slip", "worm_hoist"];
/// That of a mechanism that drivers move: no equations are printed of it.
pub const RUBBING_IN_DRIVEN: &str = "friction_press";

/// The present value of a variable.
pub fn value(instance: &mut Instance, name: &str) -> f64 {
    let variable = instance.variable(name).unwrap_or_else(|| panic!("no variable {name}"));
    instance.get(variable).expect("defined")
}

/// A message of a run, which holds words for what has no value, and names.
pub fn message(error: &dyn std::fmt::Display) -> String {
    let message = error.to_string();
    let is_value =
        |word: &str| ["NaN", "inf", "-inf"].contains(&word.trim_matches(|letter| "()`,;:.".contains(letter)));
    assert!(!message.split_whitespace().any(is_value) && !message.contains("``"), "{message}");
    message
}

/// Coordinates and their rates.
pub fn motion(instance: &Instance) -> Vec<f64> {
    let state = instance.state();
    state.positions().iter().chain(state.rates()).copied().collect()
}

/// The largest difference of two motions, relative to what is larger than 1.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs() / b.abs().max(1.0)).fold(0.0, f64::max)
}
