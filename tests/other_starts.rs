//! Runs that begin at another time than the scene, and starts far from the guess.

use crate::support::ROOT;
use std::path::Path;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::{Body, Driver, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

fn model_of(scene: &Scene) -> Arc<Model> {
    let compiled = compile(scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    Arc::new(Model::new(compiled.program).expect("a sound program"))
}

fn model(name: &str) -> Arc<Model> {
    let path = Path::new(ROOT).join("models").join(name).join("scene.toml");
    model_of(&Scene::read(&path).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100))))
}

fn started(model: &Arc<Model>, start: f64) -> Instance {
    let mut instance = Instance::new(model.clone());
    instance.setup(start, None, Some(1e-9)).expect("times");
    instance.initialise().unwrap_or_else(|error| panic!("{} at {start} s: {error}", model.program().name));
    instance
}

fn value(instance: &mut Instance, name: &str) -> f64 {
    let variable = instance.variable(name).unwrap_or_else(|| panic!("{name}"));
    instance.get(variable).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The guess belongs to where the scene starts: from there the drivers lead to where the run does, on the same branch as a run that has come there.
#[test]
fn a_run_begins_where_the_drivers_have_led() {
    let klann: &[&str] = &["leg.foot.x", "leg.foot.y", "arm.angle", "leg.angle", "lower_rocker.angle"];
    let gear: &[&str] = &["upper_brace.angle", "lower_brace.angle", "strut.axle.x", "strut.axle.y"];
    for (name, names, starts) in
        [("klann", klann, [0.31, 0.5, 0.77, 3.6]), ("landing_gear", gear, [0.25, 0.5, 0.75, 1.0])]
    {
        let model = model(name);
        let mut through = started(&model, 0.0);
        for start in starts {
            through.step_to(start).expect("the motion goes on");
            let mut begun = started(&model, start);
            for variable in names {
                let [found, expected] = [&mut begun, &mut through].map(|instance| value(instance, variable));
                // Turns of angles count from the start.
                let apart =
                    if variable.ends_with(".angle") { (0.5 * (found - expected)).sin() } else { found - expected };
                assert!(apart.abs() < 1e-7, "{name}, {variable} at {start} s: {found} instead of {expected}");
            }
        }
    }
}

/// Linear loops are closed in one step, however far away.
#[test]
fn gears_that_have_turned_often_close() {
    let model = model("gear_train");
    for start in [3.0, 5.0, 60.0, 1000.0] {
        let mut begun = started(&model, start);
        let first = 15.0 * start * start;
        for (name, expected) in [("first.angle", first), ("second.angle", -first / 3.0), ("third.angle", first / 9.0)] {
            let found = value(&mut begun, name);
            assert!((found - expected).abs() < 1e-12 * first, "{name} at {start} s: {found} instead of {expected}");
        }
    }
    let scene = Scene::new("turned")
        .ground_point("other", [1.0, 0.0])
        .body("driving", Body::new().mass(1.0).inertia(1.0))
        .body("driven", Body::new().mass(1.0).inertia(1.0))
        .revolute("bearing", "ground", "driving")
        .revolute("other_bearing", "ground.other", "driven")
        .joint("mesh", cotree::scene::Joint::gear("driving", "driven", -1.0))
        .driver("motor", Driver::angle("bearing", "101 + t"))
        .stop(1.0);
    let mut begun = started(&model_of(&scene), 0.0);
    assert!((value(&mut begun, "driven.angle") + 101.0).abs() < 1e-10);
}

/// A four-bar on a frame that is turned.
const ON_A_TURNED_FRAME: &str = r#"
name = "turned"
[parameters]
turn = 0.0
[ground.points]
a = [0, 0]
b = ["cos(turn)", "sin(turn)"]
[bodies]
crank   = { mass = 1, inertia = 0.1, points = { a = [0, 0], b = [0.3, 0] } }
coupler = { mass = 1, inertia = 0.1, points = { b = [0, 0], c = [0.9, 0], tip = [0.4, 0.3] } }
rocker  = { mass = 1, inertia = 0.1, points = { d = [0, 0], c = [0.7, 0] } }
[joints]
A = { type = "revolute", between = ["ground.a", "crank.a"] }
B = { type = "revolute", between = ["crank.b", "coupler.b"] }
C = { type = "revolute", between = ["coupler.c", "rocker.c"] }
D = { type = "revolute", between = ["ground.b", "rocker.d"] }
[drivers.motor]
joint = "A"
angle = "turn + 0.6 + t"
[initial]
"crank.angle" = { guess = "turn + 0.6" }
"coupler.angle" = { guess = 0.63 }
"rocker.angle" = { guess = 1.6 }
[outputs]
variables = ["coupler.angle", "rocker.angle", "coupler.tip.x", "coupler.tip.y"]
[experiment]
stop = 6.3
"#;

/// Everything turns with the frame, by more than a guess may be wrong: the guesses belong to the frame of the scene.
#[test]
fn a_pose_follows_what_is_set_far_from_the_guesses() {
    let model = model_of(&Scene::from_toml(ON_A_TURNED_FRAME).expect("a scene"));
    let angles = |turn: f64| {
        let mut instance = Instance::new(model.clone());
        instance.setup(0.0, None, None).expect("times");
        let parameter = instance.variable("turn").expect("turn");
        instance.set(parameter, turn).expect("a value");
        instance.initialise().unwrap_or_else(|error| panic!("turned by {turn}: {error}"));
        ["coupler.angle", "rocker.angle"].map(|name| value(&mut instance, name))
    };
    let own = angles(0.0);
    for turn in [-3.0, -1.7, 0.4, 1.7, 2.5, 3.1] {
        for (angle, own) in angles(turn).into_iter().zip(own) {
            let missed = angle - own - turn;
            let whole = (missed / std::f64::consts::TAU).round() * std::f64::consts::TAU;
            assert!((missed - whole).abs() < 1e-9, "turned by {turn}: {angle} and {own}");
        }
    }
}
