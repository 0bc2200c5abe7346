//! Parameters that are expressions of others follow these: in runs, in the FMU, in derivatives; and they cannot be set themselves.

use std::sync::Arc;

use cotree::compile::compile;
use cotree::run::Results;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_study::analysis::Study;

/// A crank whose mass, moment of inertia, mass centre and spring follow its length and thickness, through each other.
const SCENE: &str = r#"
name = "calculated"
gravity = [0, -9.81]

[parameters]
reach = "half + margin"
half = { value = "length/2", max = "2 m", description = "half the length" }
length = { value = "1 m", tunable = true }
thickness = "20 mm"
margin = "50 mm"
density = 7850
grade = 40
spin = 0.4
pause = 0.05
mass = "density*length*thickness^2"
inertia = "mass*length^2/12"
alias = "length"
rate = { value = "2*pi/60*90", unit = "rad/s" }

[ground.points]
o = [0, 0]
far = ["2*reach", "alias"]

[bodies.crank]
mass = "mass"
inertia = "inertia"
com = ["half", 0]
points = { a = [0, 0], e = ["alias", 0] }

[joints.pin]
type = "revolute"
between = ["ground.o", "crank.a"]

[loads.coil]
type = "spring"
between = ["ground.far", "crank.e"]
stiffness = "grade*mass"
length = "reach"

[loads.push]
type = "torque"
on = "crank"
value = "if(t < pause*alias, mass*sin(rate*t), 0)"

[initial]
"crank.omega" = "spin*half"

[outputs]
variables = ["crank.angle", "crank.omega", "crank.e.x", "pin.fx", "energy.total"]

[experiment]
stop = 0.4
step = 0.1
"#;

/// The same with numbers in the place of what is calculated.
fn with_numbers(length: f64, thickness: f64) -> Scene {
    let (half, mass) = (length / 2.0, 7850.0 * length * thickness * thickness);
    let text = SCENE.replace("\"half + margin\"", &(half + 0.05).to_string());
    let text = text.replace("value = \"length/2\", ", &format!("value = {half}, "));
    let text = text.replace("\"1 m\"", &length.to_string()).replace("\"20 mm\"", &thickness.to_string());
    let text = text.replace("\"density*length*thickness^2\"", &mass.to_string());
    let text = text.replace("\"mass*length^2/12\"", &(mass * length * length / 12.0).to_string());
    scene(&text.replace("alias = \"length\"", &format!("alias = {length}")))
}

fn scene(text: &str) -> Scene {
    Scene::from_toml(text).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)))
}

fn assert_alike(found: &Results, expected: &Results) {
    for (own, other) in found.columns().iter().zip(expected.columns()) {
        for (a, b) in own.values.iter().zip(&other.values) {
            assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{}: {a} instead of {b}", own.name);
        }
    }
}

#[test]
fn they_follow_what_is_set() {
    let members = [vec![], vec![("length", 1.7)], vec![("thickness", 0.05), ("length", 0.6)]];
    let found = scene(SCENE).simulate_many(&members).expect("names and values");
    for (own, (length, thickness)) in found.into_iter().zip([(1.0, 0.02), (1.7, 0.02), (0.6, 0.05)]) {
        let expected = with_numbers(length, thickness).simulate().expect("a run");
        assert_alike(&own.expect("a run"), &expected);
    }
}

#[test]
fn studies_follow_too() {
    let angles = |scene: &Scene, setting: Option<f64>| {
        let mut study = Study::new(scene).expect("a scene");
        if let Some(length) = setting {
            study.set("length", |_| Ok(length)).expect("it can be set");
        }
        study.modes(None).expect("modes").modes.iter().map(|mode| mode.eigenvalue.im).collect::<Vec<f64>>()
    };
    let (set, written) = (angles(&scene(SCENE), Some(1.3)), angles(&with_numbers(1.3, 0.02), None));
    assert!(set.iter().zip(&written).all(|(a, b)| (a - b).abs() < 1e-6), "{set:?} {written:?}");
    assert_eq!(set.len(), written.len());
}

#[test]
fn derivatives_go_through_them() {
    let mut study = Study::new(&scene(SCENE)).expect("a scene");
    let found = study.sensitivities(&["length".to_owned()], &[0.4]).expect("derivatives");
    let step = 1e-4;
    let runs = scene(SCENE).simulate_many(&[vec![("length", 1.0 + step)], vec![("length", 1.0 - step)]]);
    let [above, below] = <[_; 2]>::try_from(runs.expect("names")).expect("two").map(|run| run.expect("a run"));
    for (index, (up, down)) in above.columns().iter().zip(below.columns()).enumerate() {
        let (up, down) = (up.values.last().expect("values"), down.values.last().expect("values"));
        let (difference, derivative) = ((up - down) / (2.0 * step), found.derivatives[0][(index, 0)]);
        assert!((difference - derivative).abs() < 1e-5 * (1.0 + difference.abs()), "{difference} {derivative}");
    }
}

fn instance() -> Instance {
    let compiled = compile(&scene(SCENE)).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    let mut instance = Instance::new(Arc::new(Model::new(compiled.program).expect("a sound program")));
    instance.setup(0.0, Some(1.0), None).expect("times");
    instance
}

#[test]
fn an_instance_computes_them_and_does_not_let_them_be_set() {
    let mut instance = instance();
    let variable = |instance: &Instance, name: &str| instance.variable(name).expect("a variable");
    let (length, half, reach) =
        (variable(&instance, "length"), variable(&instance, "half"), variable(&instance, "reach"));
    assert!(instance.set(half, 0.3).expect_err("it is calculated").to_string().contains("`half` is calculated"));
    instance.set(length, 3.0).expect("a parameter");
    assert_eq!([half, reach].map(|of| instance.get(of).expect("a value")), [1.5, 1.55]);
    instance.initialise().expect("a start");
    instance.step_to(0.1).expect("a step");
    instance.set(length, 2.0).expect("a tunable parameter");
    assert_eq!([half, reach].map(|of| instance.get(of).expect("a value")), [1.0, 1.05]);
    // Their limits hold, too.
    instance.set(length, 4.5).expect("it has no limits of its own");
    let error = instance.step_to(0.2).expect_err("half is more than 2 m").to_string();
    assert!(error.contains("parameter `half` must be at most 2, but `length/2` is 2.25"), "{error}");
}

#[test]
fn the_description_says_so() {
    let compiled = compile(&scene(SCENE)).expect("a scene");
    let kind = |name: &str| {
        let variable = compiled.description.variables.iter().find(|own| own.name == name).expect("a variable");
        (variable.causality.name(), variable.variability.name(), variable.description.as_str())
    };
    assert_eq!(kind("half"), ("calculatedParameter", "tunable", "half the length; calculated: `length/2`"));
    assert_eq!(kind("length").0, "parameter");
    // Calculated from numbers only: a number.
    assert_eq!(kind("rate"), ("parameter", "fixed", "parameter `rate` of the scene"));
    let half = compiled.description.variables.iter().position(|own| own.name == "half").expect("a variable");
    assert!(compiled.description.initial_unknowns().contains(&half));
}

#[test]
fn who_sets_one_is_told_what_to_set() {
    let error = scene(SCENE).simulate_many(&[vec![("half", 0.3)]]).expect_err("it is calculated").to_string();
    assert!(
        error.contains(
            "`half` cannot be set: it is calculated from other parameters (half the length; calculated: `length/2`)"
        ),
        "{error}"
    );
    let error = Study::new(&scene(SCENE)).expect("a scene").set("inertia", |_| Ok(1.0)).expect_err("it is calculated");
    let error = error.to_string();
    assert!(
        error.contains("`inertia` cannot be set: it is calculated")
            && error.contains("; set `density`, `length`, `thickness`, or"),
        "{error}"
    );
}

#[test]
fn chains_of_them_that_double_are_refused() {
    let chain: String = (1..60).map(|place| format!("a{place} = \"a{0} + a{0}\"\n", place - 1)).collect();
    let text = SCENE.replace("[parameters]\n", &format!("[parameters]\na0 = 1\n{chain}"));
    let faults = Scene::from_toml(&text).and_then(|scene| scene.resolve().map(|_| ())).expect_err("2^59 operations");
    assert!(faults.render(false, 100).contains("takes more than 10000 operations"), "{}", faults.render(false, 100));
}

#[test]
fn a_unit_that_an_expression_of_mere_numbers_does_not_get_is_warned_of() {
    let warned = |value: &str, unit: &str| {
        let more = format!("[parameters]\nratio = 0.4\nmore = {{ value = \"{value}\", unit = \"{unit}\" }}\n");
        let resolved = scene(&SCENE.replace("[parameters]\n", &more)).resolve().expect("no errors");
        resolved.warnings.iter().any(|fault| fault.code == "scene::unit_in_expression")
    };
    for (value, unit) in [("30 + 2", "mm"), ("10*3", "deg"), ("ratio*30", "deg")] {
        assert!(warned(value, unit), "{value} {unit}");
    }
    for (value, unit) in [("30", "mm"), ("2*length", "mm"), ("atan(ratio)", "deg"), ("2*pi*ratio", "rad/s")] {
        assert!(!warned(value, unit), "{value} {unit}");
    }
}
