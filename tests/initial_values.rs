//! Initial values of the scene that an importer sets instead, and the description that offers them.

use std::sync::Arc;

use cotree::compile::{Compiled, compile};
use cotree::export::description::StartValue;
use cotree::scene::Scene;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;

const SLIDER_CRANK: &str = include_str!("../models/slider_crank/scene.toml");

fn compiled(text: &str) -> Compiled {
    compile(&Scene::from_toml(text).expect("well-formed")).expect("sound")
}

fn instance(compiled: &Compiled) -> Instance {
    let mut instance = Instance::new(Arc::new(Model::new(compiled.program.clone()).expect("sound")));
    instance.setup(0.0, None, None).expect("possible");
    instance
}

fn index(compiled: &Compiled, name: &str) -> usize {
    compiled.description.variables.iter().position(|variable| variable.name == name).expect("there")
}

#[test]
fn known_values_are_exact_and_guesses_approximate() {
    let compiled = compiled(SLIDER_CRANK);
    let start = |name| compiled.description.variables[index(&compiled, name)].start;
    assert_eq!(start("crank.angle"), Some(StartValue::Exact(0.6)));
    assert_eq!(start("crank.omega"), Some(StartValue::Exact(0.0)));
    assert_eq!(start("rod.angle"), Some(StartValue::Approximate(-0.19)));
    assert_eq!(start("cylinder.s"), None);
}

#[test]
fn setting_an_initial_value_is_like_writing_it_into_the_scene() {
    let (set, written) = (compiled(SLIDER_CRANK), compiled(&SLIDER_CRANK.replace("\"0.6 rad\"", "\"1.1 rad\"")));
    let (mut first, mut second) = (instance(&set), instance(&written));
    first.set(index(&set, "crank.angle"), 1.1).expect("an initial value");
    for instance in [&mut first, &mut second] {
        instance.initialise().expect("closes");
        instance.step_to(0.5).expect("regular");
    }
    let motion = |instance: &Instance| [instance.state().positions(), instance.state().rates()].concat();
    assert_eq!(motion(&first), motion(&second));
}

#[test]
fn another_guess_gives_the_other_assembly() {
    let compiled = compiled(SLIDER_CRANK);
    let mut crossed = instance(&compiled);
    crossed.set(index(&compiled, "rod.angle"), 3.3).expect("a guess");
    crossed.initialise().expect("closes");
    let angle = crossed.get(index(&compiled, "rod.angle")).expect("defined");
    let expected = std::f64::consts::PI + (0.5 * 0.6_f64.sin() / 1.5).asin();
    assert!((angle - expected).abs() < 1e-9, "{angle} for {expected}");
}

#[test]
fn what_cannot_be_assembled_is_named_and_can_be_corrected() {
    // The rod is known too: both angles cannot hold at once.
    let rod = format!("{:?}", -(0.5 * 0.6_f64.sin() / 1.5).asin());
    let text = SLIDER_CRANK.replace("{ guess = \"-0.19 rad\" }", &rod);
    let compiled = compiled(&text);
    let mut instance = instance(&compiled);
    let (crank, rod) = (index(&compiled, "crank.angle"), index(&compiled, "rod.angle"));
    instance.set(crank, 1.2).expect("an initial value");
    let error = instance.initialise().expect_err("contradicts the rod").to_string();
    assert!(error.contains("`crank.angle`") && error.contains("`rod.angle`"), "{error}");
    instance.set(rod, -(0.5 * 1.2_f64.sin() / 1.5).asin()).expect("an initial value");
    instance.initialise().expect("fits now");
    assert!((instance.get(crank).expect("defined") - 1.2).abs() < 1e-9);
    assert!(matches!(instance.set(crank, 1.0), Err(InstanceError::Fixed { .. })));
}

/// An importer that sets a length sees which one, not only what does not fit then.
#[test]
fn what_was_set_is_named_if_there_is_no_start() {
    let compiled = compiled(&SLIDER_CRANK.replace("min = \"0.6 m\"", "min = \"0.1 m\""));
    let rod = index(&compiled, "rod_length");
    let mut instance = instance(&compiled);
    instance.set(rod, 0.2).expect("in range");
    let error = instance.initialise().expect_err("the rod does not reach the rail").to_string();
    assert!(error.contains("with `rod_length` = 0.2 instead of 1.5 the mechanism cannot start: "), "{error}");
    assert!(error.contains("`crank.angle`"), "{error}");
    instance.set(rod, 1.4).expect("in range");
    instance.initialise().expect("long enough");
}

#[test]
fn an_initial_value_of_something_else_becomes_a_variable() {
    let text = SLIDER_CRANK.replace("\"crank.omega\" = 0.0", "\"cylinder.v\" = \"0.3 m/s\"");
    let text = text.replace("\"cylinder.s\", ", "");
    let compiled = compiled(&text);
    let speed = index(&compiled, "cylinder.v");
    assert_eq!(compiled.description.variables[speed].start, Some(StartValue::Exact(0.3)));
    assert_eq!(compiled.description.variables[speed].unit.si, "m/s");
    let mut instance = instance(&compiled);
    instance.set(speed, -0.2).expect("an initial value");
    instance.initialise().expect("closes");
    assert!((instance.get(speed).expect("defined") + 0.2).abs() < 1e-12);
}

#[test]
fn values_that_are_formulas_follow_their_parameters_and_cannot_be_set() {
    let text = SLIDER_CRANK.replace("\"crank.angle\" = \"0.6 rad\"", "\"crank.angle\" = \"0.6*crank_length/0.5\"");
    let text = text.replace("crank_length = \"0.5 m\"", "crank_length = 0.5");
    let compiled = compiled(&text);
    let angle = index(&compiled, "crank.angle");
    assert_eq!(compiled.description.variables[angle].start, None);
    let mut instance = instance(&compiled);
    assert!(matches!(instance.set(angle, 1.0), Err(InstanceError::Calculated { .. })));
    instance.set(index(&compiled, "crank_length"), 0.55).expect("a parameter");
    instance.initialise().expect("closes");
    assert!((instance.get(angle).expect("defined") - 0.66).abs() < 1e-9);
}

/// A cart against a one-sided spring, with dry friction.
const STOP: &str = r#"
format = 1
name = "stop"
gravity = [0, 0]
[inputs]
push = { start = "1 N" }
[bodies.cart]
mass = 1.0
[joints.rail]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
[loads.wall]
type = "actuator"
between = ["ground", "cart"]
force = "if(length > 1, -1000*(length - 1), 0) + max(push, -3)"
[initial]
"rail.s" = 0.5
"rail.v" = 0.0
[outputs]
variables = ["rail.s"]
"#;

#[test]
fn laws_with_corners_have_event_indicators() {
    let compiled = compiled(STOP);
    assert_eq!(compiled.description.exchange, Some(2));
    let mut instance = instance(&compiled);
    instance.initialise_exchange().expect("offered");
    let mut signs = |position: f64, push: f64| {
        instance.set(index(&compiled, "push"), push).expect("an input");
        instance.set_states(&[position, 0.0]).expect("finite");
        let mut indicators = [f64::NAN; 2];
        instance.indicators(&mut indicators).expect("two");
        indicators.map(|indicator| indicator > 0.0)
    };
    let (free, hit, pulled) = (signs(0.5, 1.0), signs(1.5, 1.0), signs(0.5, -4.0));
    assert_eq!((0..2).filter(|&i| free[i] != hit[i]).count(), 1);
    assert_eq!((0..2).filter(|&i| free[i] != pulled[i]).count(), 1);
    assert_ne!(hit, pulled);
    let smooth = compile(&Scene::from_toml(SLIDER_CRANK).expect("well-formed")).expect("sound");
    assert_eq!(smooth.description.exchange, Some(0));
}

/// A chain of three bodies from ground to ground of which only one angle is known, and a double pendulum of which only one body is.
const INCOMPLETE: [&str; 2] = [
    r#"
    name = "loop"
    [ground]
    points = { g = [0.9, 0.1] }
    [bodies.a]
    mass = 1.0
    inertia = 0.01
    points = { p = [-0.25, 0], q = [0.25, 0] }
    [bodies.b]
    mass = 1.0
    inertia = 0.02
    points = { p = [-0.4, 0], q = [0.4, 0] }
    [bodies.c]
    mass = 0.5
    inertia = 0.01
    points = { p = [-0.3, 0], q = [0.3, 0] }
    [joints.j1]
    type = "revolute"
    between = ["ground", "a.p"]
    [joints.j2]
    type = "revolute"
    between = ["a.q", "b.p"]
    [joints.j3]
    type = "revolute"
    between = ["b.q", "c.p"]
    [joints.j4]
    type = "revolute"
    between = ["c.q", "ground.g"]
    [initial]
    "a.angle" = "70 deg"
    "c.angle" = { guess = "-1 rad" }
    [outputs]
    variables = ["a.angle", "b.x", "b.y", "b.angle", "c.omega"]
    "#,
    r#"
    name = "pendulum"
    [bodies.a]
    mass = 1.0
    inertia = 0.01
    points = { q = [0.25, 0] }
    [bodies.b]
    mass = 1.0
    inertia = 0.02
    points = { p = [-0.4, 0] }
    [joints.j1]
    type = "revolute"
    between = ["ground", "a"]
    [joints.j2]
    type = "revolute"
    between = ["a.q", "b.p"]
    [initial]
    "a.angle" = "70 deg"
    "a.omega" = 2.0
    [outputs]
    variables = ["a.angle", "b.x", "b.y", "b.angle", "b.omega", "b.vx"]
    "#,
];

#[test]
fn what_is_left_open_does_not_depend_on_the_trees() {
    for text in INCOMPLETE {
        let outputs = |coordinates: &str| {
            let compiled = compiled(&format!("{text}\n[coordinates]\n{coordinates}\n"));
            let mut instance = instance(&compiled);
            instance.initialise().expect("closes");
            let mut named = |name: &str| instance.get(instance.variable(name).expect("an output")).expect("a value");
            let names = ["a.angle", "b.x", "b.y", "b.angle"];
            let more: &[&str] = if text.contains("c.omega") { &["c.omega"] } else { &["b.omega", "b.vx"] };
            names.iter().chain(more).map(|name| named(name)).collect::<Vec<f64>>()
        };
        let recommended = outputs("preset = \"recommended\"");
        let trees = ["preset = \"absolute\"", "preset = \"joint\"", "rotation = ["];
        for coordinates in trees {
            let loops = if text.contains("joints.j3") { "\"j1\", \"b\", \"j4\"]" } else { "\"j2\", \"j1\"]" };
            let coordinates =
                if coordinates.ends_with('[') { format!("{coordinates}{loops}") } else { coordinates.into() };
            for (found, expected) in outputs(&coordinates).iter().zip(&recommended) {
                assert!((found - expected).abs() < 1e-9, "{coordinates}: {found} instead of {expected}");
            }
        }
    }
}

/// A number between 0 and 1 for each step of a simple generator.
fn share(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

#[test]
fn a_known_start_keeps_its_bits_however_far_the_search_goes() {
    let text = include_str!("../models/four_bar/scene.toml");
    let text: String = text.lines().filter(|line| !line.contains("guess =")).map(|line| format!("{line}\n")).collect();
    let mut seed = 3;
    let mut assembled = 0;
    for _ in 0..300 {
        let known = std::f64::consts::TAU * (share(&mut seed) - 0.5);
        let Ok(compiled) =
            compile(&Scene::from_toml(&text.replace("\"60 deg\"", &format!("{known:?}"))).expect("well-formed"))
        else {
            continue;
        };
        let crank = index(&compiled, "crank.angle");
        let mut instance = instance(&compiled);
        if instance.initialise().is_ok() {
            assembled += 1;
            assert_eq!(instance.get(crank).expect("computed").to_bits(), known.to_bits(), "{known}");
        }
    }
    assert!(assembled > 200, "{assembled}");
}
