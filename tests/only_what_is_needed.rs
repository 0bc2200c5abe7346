//! Nothing is modelled that the scene does not need.

use crate::support::{ROOT, run};

use cotree::compile::Compiled;
use cotree::report::summary::Summary;
use cotree::scene::Scene;
use cotree_fmu::program::Engine;

use run::{compiled, motion, scene_of, sound, started};

fn summary(name: &str) -> Summary {
    sound(Scene::from_toml(&scene_of(name)).and_then(|scene| scene.summary()))
}

fn model(name: &str) -> Compiled {
    compiled(&scene_of(name))
}

#[test]
fn an_open_chain_has_no_loop_equations_and_nothing_that_serves_them() {
    let pendulum = model("double_pendulum");
    let tapes = &pendulum.program.tapes;
    for tape in
        [&tapes.constraint, &tapes.gamma, &tapes.project_position, &tapes.project_velocity, &tapes.jacobian.tape]
    {
        assert!(tape.instructions().is_empty() && tape.results.is_empty());
    }
    assert_eq!(tapes.acceleration.results.len(), pendulum.program.coordinates.len());
    assert!(!model("bench_slider_crank").program.tapes.constraint.results.is_empty());
}

#[test]
fn masses_on_a_line_have_no_rotation() {
    let line = summary("vibration");
    assert!(line.trees.rotation.is_empty());
    assert!(!summary("pendulum").trees.rotation.is_empty());
}

#[test]
fn a_driven_scene_has_no_integrator_and_no_forces_unless_one_is_asked_for() {
    let scene = |output: &str, gravity: f64| {
        compiled(&format!(
            "format = 1\nname = \"driven\"\ngravity = [0, {gravity:?}]\n[bodies.arm]\nmass = 1\ninertia = 1\npoints = {{ end = [-1, 0] \
             }}\n[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm.end\"]\n[drivers.motor]\njoint = \"pin\"\nangle = \
             \"0.3*t\"\n[outputs]\nvariables = [\"{output}\"]\n"
        ))
    };
    for output in ["arm.x", "motor.torque"] {
        let driven = scene(output, -9.81);
        assert!(driven.program.is_driven());
        assert!(driven.program.tapes.acceleration.instructions().is_empty());
    }
    let work = |output: &str, gravity: f64| scene(output, gravity).program.tapes.outputs.instructions().len();
    // At a constant rate the motor carries nothing but the weight.
    assert_eq!(work("arm.x", 0.0), work("arm.x", -9.81));
    assert!(work("motor.torque", 0.0) < work("motor.torque", -9.81));
}

#[test]
fn only_what_is_asked_for_is_computed() {
    let with = |outputs: &str| {
        let path = std::path::Path::new(ROOT).join("models/bench_slider_crank/scene.toml");
        let text = std::fs::read_to_string(path).expect("a scene");
        let (before, rest) = text.split_once("variables = [").expect("outputs");
        let (_, after) = rest.split_once(']').expect("a list");
        compiled(&format!("{before}variables = [{outputs}]{after}"))
    };
    let angle = with("\"crank.angle\"");
    assert!(angle.program.tapes.outputs.results.is_empty());
    let [few, more] = ["\"slider.x\"", "\"slider.x\", \"main_bearing.fx\""].map(with);
    assert_eq!(few.program.tapes.outputs.results.len(), 1);
    assert!(few.program.tapes.outputs.instructions().len() < more.program.tapes.outputs.instructions().len());
}

#[test]
fn limits_that_are_never_reached_change_no_bit_of_a_series() {
    let of = |text: &str| {
        let mut instance = started(&run::model(text), Some(Engine::Taylor), 3.0, 1e-8);
        (1..=60)
            .map(|step| {
                instance.step_to(0.05 * f64::from(step)).expect("a motion");
                motion(&instance).iter().map(|value| value.to_bits()).collect::<Vec<u64>>()
            })
            .collect::<Vec<_>>()
    };
    for (name, joints) in [
        ("double_pendulum", &["shoulder", "elbow"][..]),
        ("four_bar", &["crank_pivot"]),
        ("bench_slider_crank", &["main_bearing", "wrist_pin"]),
    ] {
        let free = scene_of(name);
        let limited = joints.iter().fold(free.clone(), |text, joint| {
            let head = format!("[joints.{joint}]\n");
            assert!(text.contains(&head), "{name} has no {joint}");
            text.replace(&head, &format!("{head}limits = {{ min = -1e4, max = 1e4, restitution = 0.5 }}\n"))
        });
        assert!(of(&free) == of(&limited), "{name}");
    }
}
