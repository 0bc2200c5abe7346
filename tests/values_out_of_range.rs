//! Parameters that give a key a value that the key must not have: the message names the key, at the start and during the run.

use std::sync::Arc;

use cotree::Scene;
use cotree::compile::compile;
use cotree_fmu::failure::Failure;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;

const SCENE: &str = r#"
name = "ranges"

[parameters]
load = { value = "2 kg", tunable = true }
radius = "0.1 m"
slow = "0.02 rad/s"
rest = "1 m"
rough = 0.2

[bodies.disc]
mass = "load - 1"
inertia = "load*radius^2"

[bodies.disc.points]
rim = [0.1, 0.0]

[joints.pin]
type = "revolute"
between = ["ground.o", "disc"]
friction = { coulomb = "rough", velocity = "slow/2" }

[ground.points]
o = [0.0, 0.0]
far = [2.0, 0.0]

[loads.coil]
type = "spring"
between = ["ground.far", "disc.rim"]
stiffness = "10 N/m"
length = "rest"

[outputs]
variables = ["disc.angle"]

[experiment]
stop = 1.0
"#;

fn instance() -> Instance {
    let scene = Scene::from_toml(SCENE).unwrap_or_else(|faults| panic!("{faults}"));
    let compiled = compile(&scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    let mut instance = Instance::new(Arc::new(Model::new(compiled.program).expect("a sound program")));
    instance.setup(0.0, Some(1.0), None).expect("times");
    instance
}

fn set(instance: &mut Instance, name: &str, value: f64) {
    let variable = instance.variable(name).expect("a parameter");
    instance.set(variable, value).expect("it can be set");
}

#[test]
fn a_start_with_such_values_is_refused_by_name() {
    let cases = [
        (
            "load",
            0.5,
            "with `load` = 0.5 instead of 2 the mechanism cannot start: `mass` of body `disc` must not be negative, but `load-1` is -0.5",
        ),
        ("slow", -0.1, "`velocity` of the friction of joint `pin` must be positive, but `slow/2` is -0.05"),
        ("rough", -0.2, "`coulomb` of the friction of joint `pin` must not be negative, but `rough` is -0.2"),
    ];
    for (name, value, said) in cases {
        let mut instance = instance();
        set(&mut instance, name, value);
        let error = instance.initialise().expect_err(name).to_string();
        assert!(error.contains(said), "{name}: {error}");
        // With good values it goes on.
        set(&mut instance, name, if name == "rough" { 0.0 } else { 1.5 });
        instance.initialise().unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

#[test]
fn a_tuned_parameter_is_refused_during_the_run() {
    let mut instance = instance();
    instance.initialise().expect("a start");
    instance.step_to(0.1).expect("a step");
    set(&mut instance, "load", 0.5);
    let error = instance.step_to(0.2).expect_err("a negative mass");
    assert!(matches!(&error, InstanceError::Solver(Failure::OutOfRange { .. })), "{error:?}");
    set(&mut instance, "load", 3.0);
    instance.step_to(0.2).expect("a mass again");
}

#[test]
fn nothing_is_computed_from_such_values_while_another_integrates() {
    let mut instance = instance();
    instance.initialise_exchange().expect("a start");
    let mut derivatives = vec![0.0; instance.state_count()];
    instance.state_derivatives(&mut derivatives).expect("derivatives");
    set(&mut instance, "load", 0.5);
    let angle = instance.variable("disc.angle").expect("an output");
    let refused = [
        instance.close_loops().err(),
        instance.state_derivatives(&mut derivatives).err(),
        instance.complete_step().err(),
        instance.get(angle).err(),
    ];
    for error in refused {
        let error = error.expect("a negative mass").to_string();
        assert!(error.contains("`mass` of body `disc` must not be negative, but `load-1` is -0.5"), "{error}");
    }
    set(&mut instance, "load", 3.0);
    instance.close_loops().expect("a mass again");
    instance.state_derivatives(&mut derivatives).expect("derivatives");
}
