//! Nothing is modelled that the scene does not need, and `show` says so.

use cotree::pipeline::Compiled;
use cotree_fmu::program::Motion;

#[path = "support/run.rs"]
mod run;
use run::{compiled, scene_of};

fn model(name: &str) -> Compiled {
    compiled(&scene_of(name))
}

fn left_out(compiled: &Compiled) -> Vec<&str> {
    compiled.summary.economy.left_out.iter().map(|left| left.part).collect()
}

#[test]
fn an_open_chain_has_no_loop_equations_and_nothing_that_serves_them() {
    let pendulum = model("double_pendulum");
    assert!(left_out(&pendulum).contains(&"loop equations"));
    let tapes = &pendulum.program.tapes;
    for tape in
        [&tapes.constraint, &tapes.gamma, &tapes.project_position, &tapes.project_velocity, &tapes.jacobian.tape]
    {
        assert!(tape.instructions.is_empty() && tape.results.is_empty());
    }
    assert_eq!(tapes.acceleration.results.len(), pendulum.program.coordinates.len());
    assert!(!left_out(&model("bench_slider_crank")).contains(&"loop equations"));
}

#[test]
fn masses_on_a_line_have_no_rotation() {
    let line = model("vibration");
    assert!(left_out(&line).contains(&"rotation"));
    assert!(line.summary.trees.rotation.is_empty());
    assert!(!left_out(&model("pendulum")).contains(&"rotation"));
}

#[test]
fn a_driven_scene_has_no_integrator_and_no_forces_unless_one_is_asked_for() {
    let scene = |output: &str| {
        compiled(&format!(
            "format = 1\nname = \"driven\"\n[bodies.arm]\nmass = 1\ninertia = 1\npoints = {{ end = [-1, 0] }}\n[joints.pin]\ntype = \
             \"revolute\"\nbetween = [\"ground\", \"arm.end\"]\n[drivers.motor]\njoint = \"pin\"\nangle = \"0.3*t\"\n[outputs]\nvariables = \
             [\"{output}\"]\n"
        ))
    };
    let (position, torque) = (scene("arm.x"), scene("motor.torque"));
    for driven in [&position, &torque] {
        assert_eq!(driven.program.motion, Motion::Kinematic);
        assert!(left_out(driven).contains(&"integrator"));
        assert!(driven.program.tapes.acceleration.instructions.is_empty());
    }
    assert!(left_out(&position).contains(&"masses and forces") && position.program.tapes.inverse.is_none());
    assert!(!left_out(&torque).contains(&"masses and forces"));
}

#[test]
fn only_what_is_asked_for_is_computed_and_its_cost_is_told() {
    let with = |outputs: &str| {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models/bench_slider_crank/scene.toml");
        let text = std::fs::read_to_string(path).expect("a scene");
        let (before, rest) = text.split_once("variables = [").expect("outputs");
        let (_, after) = rest.split_once(']').expect("a list");
        compiled(&format!("{before}variables = [{outputs}]{after}"))
    };
    let angle = with("\"crank.angle\"");
    assert!(angle.program.tapes.outputs.results.is_empty());
    assert!(
        left_out(&angle).contains(&"output kernel")
            && left_out(&angle).contains(&"accelerations at communication points")
    );
    let [few, more] = ["\"slider.x\"", "\"slider.x\", \"main_bearing.fx\""].map(with);
    assert_eq!(few.program.tapes.outputs.results.len(), 1);
    assert!(few.program.tapes.outputs.instructions.len() < more.program.tapes.outputs.instructions.len());
    let economy = &more.summary.economy;
    let cost = |name: &str| economy.outputs.iter().find(|output| output.name == name).expect("told");
    assert!(!cost("slider.x").accelerated && cost("main_bearing.fx").accelerated);
    assert!(cost("slider.x").operations > 0);
    // What is told is what the kernel has, and shared parts count once.
    assert_eq!(economy.together, more.program.tapes.outputs.instructions.len());
    assert!(economy.together <= economy.outputs.iter().map(|output| output.operations).sum());
    let text = more.summary.to_string();
    assert!(
        text.contains("left out") && text.contains("main_bearing.fx: ") && text.contains("and the accelerations there"),
        "{text}"
    );
}
