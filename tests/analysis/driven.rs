//! Fully driven mechanisms: the order of solution, inverse dynamics, large steps.

use super::run::{self, scene_of, sound, value};
use cotree::report::summary::Summary;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;

fn instance(text: &str) -> Instance {
    let mut instance = Instance::new(run::model(text));
    instance.setup(0.0, None, Some(1e-11)).unwrap();
    instance.initialise().unwrap();
    instance
}

fn summary(text: &str) -> Summary {
    sound(Scene::from_toml(text).and_then(|scene| scene.summary()))
}

fn blocks(text: &str) -> Vec<Vec<String>> {
    summary(text).blocks
}

#[test]
fn eq38_is_solved_before_eq39() {
    assert_eq!(blocks(&scene_of("quick_return")), [["rocker.angle"], ["rod.angle"]]);
    let summary = summary(&scene_of("quick_return"));
    assert!(summary.to_string().contains("blocks         2  rocker.angle, rod.angle"), "{summary}");
    assert_eq!(serde_json::to_value(&summary).unwrap()["blocks"][0][0], "rocker.angle");
}

#[test]
fn what_moves_freely_has_no_order_of_solution() {
    assert!(blocks(&scene_of("slider_crank")).is_empty());
}

/// In other coordinates there are other blocks; the motion and the torque are the same.
#[test]
fn blocks_of_all_trees_give_the_same_motion() {
    let names = ["rocker.angle", "tool_slide.s", "tool_slide.a", "motor.torque", "rod_pin.fx", "tool_slide.fn"];
    let of = |preset: &str| {
        let text = format!("{}\n[coordinates]\npreset = \"{preset}\"\n", heavy_quick_return());
        let mut instance = instance(&text);
        instance.step_to(0.317).unwrap();
        (blocks(&text), names.map(|name| value(&mut instance, name)))
    };
    let (_, expected) = of("recommended");
    for preset in ["absolute", "joint"] {
        let (blocks, found) = of(preset);
        assert!(blocks.len() > 1, "{preset}: {blocks:?}");
        for ((name, value), expected) in names.iter().zip(found).zip(expected) {
            assert!((value - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{preset} {name}: {value} {expected}");
        }
    }
}

/// The quick-return mechanism with masses, in gravity.
fn heavy_quick_return() -> String {
    scene_of("quick_return")
        .replace("[parameters]", "gravity = [0, -9.81]\n[parameters]")
        .replace("[bodies.crank]", "[bodies.crank]\nmass = 2.0\ninertia = 0.02")
        .replace("[bodies.rocker]", "[bodies.rocker]\nmass = 3.0\ninertia = 0.15")
        .replace("[bodies.block]", "[bodies.block]\nmass = 0.5\ninertia = 0.001")
        .replace("[bodies.rod]", "[bodies.rod]\nmass = 1.5\ninertia = 0.05")
        .replace("[bodies.tool]", "[bodies.tool]\nmass = 4.0\ninertia = 0.1")
        .replace(
            "\"constraint.position\",",
            "\"constraint.position\", \"motor.torque\", \"motor.power\", \"energy.total\", \"rod_pin.fx\", \"tool_slide.fn\", \"crank.omega\",",
        )
}

#[test]
fn the_power_of_the_driver_is_the_rate_of_the_energy() {
    let mut instance = instance(&heavy_quick_return());
    let h = 1e-3;
    for index in 1..=20 {
        let time = 0.045 * f64::from(index);
        let mut at = |time: f64, name: &str| {
            instance.step_to(time).unwrap();
            value(&mut instance, name)
        };
        let before = [-2.0, -1.0].map(|k| at(time + k * h, "energy.total"));
        let power = at(time, "motor.power");
        let after = [1.0, 2.0].map(|k| at(time + k * h, "energy.total"));
        let rate = (8.0 * (after[0] - before[1]) - (after[1] - before[0])) / (12.0 * h);
        assert!((power - rate).abs() < 1e-5 * (1.0 + power.abs()), "{power} W, energy changes by {rate} W at {time} s");
    }
}

/// The torque found for the prescribed motion, applied to the free mechanism, brings that motion about.
#[test]
fn the_torque_of_the_driver_drives_the_free_mechanism() {
    let mut driven = instance(&heavy_quick_return());
    let free = heavy_quick_return()
        .replace(
            "[drivers.motor]\njoint = \"crank_pivot\"\nangle = \"0.4356 + 4*pi*t\"",
            "[inputs]\ntau = \"0 N.m\"\n[loads.motor]\ntype = \"torque\"\non = \"crank\"\nvalue = \"tau\"",
        )
        .replace("[initial]", "[initial]\n\"crank.angle\" = 0.4356\n\"crank.omega\" = \"4*pi rad/s\"")
        .replace("\"motor.torque\", \"motor.power\", ", "");
    let free = free.replace("\"4*pi rad/s\"", &format!("{:?}", 4.0 * std::f64::consts::PI));
    let mut free = Instance::new(run::model(&free));
    free.setup(0.0, None, Some(1e-11)).unwrap();
    let tau = free.variable("tau").unwrap();
    // The torque as a parabola through three points of every interval.
    let h = 1e-3;
    for step in 0..300 {
        let start = f64::from(step) * h;
        let mut torque = |time: f64| {
            if time > driven.time() {
                driven.step_to(time).unwrap();
            }
            value(&mut driven, "motor.torque")
        };
        let [a, b, c] = [0.0, 0.5, 1.0].map(|share| torque(start + share * h));
        free.set(tau, a).unwrap();
        if step == 0 {
            free.initialise().unwrap();
        }
        free.set_derivative(tau, 1, (4.0 * b - 3.0 * a - c) / h).unwrap();
        free.set_derivative(tau, 2, 4.0 * (a - 2.0 * b + c) / (h * h)).unwrap();
        free.step_to(start + h).unwrap();
    }
    for name in ["crank.angle", "rocker.angle", "tool_slide.s", "rod_pin.fx", "tool_slide.fn"] {
        let (found, expected) = (value(&mut free, name), value(&mut driven, name));
        assert!((found - expected).abs() < 1e-6 * (1.0 + expected.abs()), "{name}: {found} instead of {expected}");
    }
}

#[test]
fn two_turns_in_one_step_are_followed_through() {
    let mut large = instance(&scene_of("quick_return"));
    let mut small = instance(&scene_of("quick_return"));
    large.step_to(1.0).unwrap();
    (1..=1000).for_each(|step| small.step_to(f64::from(step) * 1e-3).unwrap());
    for name in ["crank.angle", "rocker.angle", "rod.angle", "tool_slide.s", "rocker.omega", "tool_slide.a"] {
        let (large, small) = (value(&mut large, name), value(&mut small, name));
        assert!((large - small).abs() < 1e-9 * (1.0 + small.abs()), "{name}: {large} instead of {small}");
    }
}

/// A drag link turns fully with its crank. Its driver begins and ends at rest: without a look at the way between, the pose after two turns is
/// the pose before.
#[test]
fn a_soft_start_does_not_lose_turns() {
    let text = r#"
        format = 1
        name = "drag_link"
        [ground.points]
        left = [0, 0]
        right = [0.2, 0]
        [bodies.crank]
        points = { pivot = [0, 0], pin = [0.5, 0] }
        [bodies.coupler]
        points = { first = [0, 0], second = [0.45, 0] }
        [bodies.follower]
        points = { pivot = [0, 0], pin = [0.5, 0] }
        [joints.left]
        type = "revolute"
        between = ["ground.left", "crank.pivot"]
        [joints.first]
        type = "revolute"
        between = ["crank.pin", "coupler.first"]
        [joints.second]
        type = "revolute"
        between = ["coupler.second", "follower.pin"]
        [joints.right]
        type = "revolute"
        between = ["ground.right", "follower.pivot"]
        [drivers.motor]
        joint = "left"
        angle = "4*pi*(10*t^3 - 15*t^4 + 6*t^5)"
        [initial]
        "coupler.angle" = { guess = "60 deg" }
        "follower.angle" = { guess = "60 deg" }
        [outputs]
        variables = ["crank.angle", "coupler.angle", "follower.angle"]
        [experiment]
        stop = "1 s"
        step = "10 ms"
    "#;
    let mut instance = instance(text);
    let names = ["crank.angle", "coupler.angle", "follower.angle"];
    let before = names.map(|name| value(&mut instance, name));
    instance.step_to(1.0).unwrap();
    for (name, before) in names.into_iter().zip(before) {
        let turns = (value(&mut instance, name) - before) / std::f64::consts::TAU;
        assert!((turns - 2.0).abs() < 1e-9, "{name}: {turns} turns");
    }
}
