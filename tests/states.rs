//! States of a scene, whose rates are given: against closed forms, differences, and themselves by other methods.

use crate::sensitivities::check as check_sensitivities;
use crate::support::exchange::integrate;
use crate::support::motion::Run;
use crate::support::run::{compiled, model, sound, started, value};

use std::sync::Arc;

use cotree::compile::compile;
use cotree::diagnostic::Faults;
use cotree::scene::{Body, Joint, Load, Scene, State};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use cotree_study::analysis::{LinearisedAt, Study};
use nalgebra::{Complex, Matrix2, Matrix3, Vector2};

const METHODS: [Engine; 3] = [Engine::Taylor, Engine::Dop853, Engine::Radau];

/// A motor turns a wheel that a damper brakes: R = 0.8 ohm, L = 4 mH, k = 0.05 N.m/A, J = 2e-3 kg.m2, c = 1e-3 N.m.s.
const MOTOR: &str = r#"
name = "motor"
[parameters]
resistance = "0.8 ohm"
inductance = "4 mH"
constant   = "0.05 N.m/A"
[inputs]
voltage = { start = "6 V" }
[states]
current = { start = "0.5 A", rate = "(voltage - resistance*current - constant*wheel.omega)/inductance" }
[bodies.wheel]
mass    = 1.0
inertia = 2e-3
[joints.axle]
type    = "revolute"
between = ["ground", "wheel"]
damping = 1e-3
[loads.motor]
type  = "torque"
on    = "wheel"
value = "constant*current"
[initial]
"wheel.angle" = 0.0
"wheel.omega" = 10.0
[outputs]
variables = ["wheel.angle", "wheel.omega", "current"]
[experiment]
stop = "1 s"
tolerance = 1e-10
"#;

/// Current and rate of the wheel, in closed form.
fn motor_at(time: f64) -> [f64; 2] {
    let system = Matrix2::new(-0.8 / 4e-3, -0.05 / 4e-3, 0.05 / 2e-3, -1e-3 / 2e-3);
    let rest = -system.try_inverse().unwrap() * Vector2::new(6.0 / 4e-3, 0.0);
    let now = rest + (system * time).exp() * (Vector2::new(0.5, 10.0) - rest);
    [now.x, now.y]
}

#[test]
fn a_motor_on_a_wheel_follows_its_closed_form_by_every_method() {
    for engine in METHODS {
        let mut motor = started(&model(MOTOR), Some(engine), 1.0, 1e-10);
        for time in [0.0, 2e-3, 0.05, 0.3, 1.0] {
            if time > 0.0 {
                motor.step_to(time).unwrap();
            }
            let expected = motor_at(time);
            for (name, expected) in ["current", "wheel.omega"].iter().zip(expected) {
                let found = value(&mut motor, name);
                let close = (found - expected).abs() < 2e-9 * (1.0 + expected.abs());
                assert!(close, "{engine:?}: {name} at {time} s is {found}, not {expected}");
            }
        }
    }
}

/// The component is what its equations say, and a gear turns its rotor faster.
#[test]
fn a_dc_motor_is_a_torque_and_a_state() {
    let values: [cotree::scene::Quantity; 3] = ["0.8 ohm".into(), "4 mH".into(), "0.05 N.m/A".into()];
    let scene = |load: Load| {
        Scene::new("motor")
            .body("wheel", Body::new().mass(1.0).inertia(2e-3))
            .joint("axle", Joint::revolute("ground", "wheel").damping(1e-3))
            .input("voltage", "6 V")
            .load("motor", load)
            .initial("wheel.angle", 0.0)
            .initial("wheel.omega", 10.0)
            .with_every_output()
    };
    let motor = Load::dc_motor("ground", "wheel", "voltage", values.clone()).current("0.5 A");
    let mut run = Run::new(&scene(motor));
    for time in [0.0, 0.05, 1.0] {
        let [current, omega] = motor_at(time);
        run.to(time).check("motor.current", current);
        run.check("wheel.omega", omega);
        run.check("motor.torque", 0.05 * current);
        run.check("energy.total", 0.5 * 2e-3 * omega * omega + 0.5 * 4e-3 * current * current);
    }
    let geared =
        Load::dc_motor("ground", "wheel", "voltage", [values[0].clone(), values[1].clone(), "0.025 N.m/A".into()]);
    let mut run = Run::new(&scene(geared.ratio(2).current("0.5 A")));
    let [current, omega] = motor_at(0.3);
    run.to(0.3).check("motor.current", current);
    run.check("wheel.omega", omega);
}

/// Seen in a mirror a motor turns the other way, at the same current.
#[test]
fn a_mirrored_motor_has_the_same_current() {
    let folder = tempfile::tempdir().unwrap();
    let start = MOTOR.find("[states]").unwrap();
    let end = MOTOR.find("[bodies.wheel]").unwrap();
    let law = "type  = \"torque\"\non    = \"wheel\"\nvalue = \"constant*current\"";
    let component = "type = \"dc_motor\"\nbetween = [\"ground\", \"wheel\"]\nvoltage = \"voltage\"\nresistance = \"resistance\"\ninductance = \"inductance\"\nconstant = \"constant\"\ncurrent = \"0.5 A\"";
    let text = format!("{}{}", &MOTOR[..start], &MOTOR[end..])
        .replace(law, component)
        .replace("\"current\"]", "\"motor.current\"]");
    std::fs::write(folder.path().join("motor.toml"), text).unwrap();
    let whole = folder.path().join("both.toml");
    std::fs::write(&whole, "name = \"both\"\n[parts]\nleft = { file = \"motor.toml\", mirror = true }\n").unwrap();
    let program = sound(compile(&sound(Scene::read(&whole)))).program;
    let mut run = Instance::new(Arc::new(Model::new(program).unwrap()));
    run.setup(0.0, None, Some(1e-10)).unwrap();
    run.initialise().unwrap();
    run.step_to(0.05).unwrap();
    let [current, omega] = motor_at(0.05);
    assert!((value(&mut run, "left_motor.current") - current).abs() < 1e-8);
    assert!((value(&mut run, "left_wheel.omega") + omega).abs() < 1e-8);
}

/// Communication points and saved states change no bit.
#[test]
fn runs_do_not_depend_on_who_asks_when() {
    let model = model(MOTOR);
    let mut whole = started(&model, None, 1.0, 1e-8);
    whole.step_to(1.0).unwrap();
    let end = whole.state().registers().to_vec();
    for step in [1e-3, 0.013, 0.25] {
        let mut run = started(&model, None, 1.0, 1e-8);
        let mut saved = None;
        let mut time = 0.0;
        while time < 1.0 {
            time = f64::min(time + step, 1.0);
            run.step_to(time).unwrap();
            if saved.is_none() && time > 0.4 {
                saved = Some(run.save());
            }
        }
        let own = |run: &Instance| [run.state().rates(), run.state().states()].concat();
        assert_eq!(own(&run), own(&whole), "steps of {step} s");
        run.restore(saved.as_ref().unwrap()).unwrap();
        run.step_to(1.0).unwrap();
        assert_eq!(own(&run), own(&whole), "restored, steps of {step} s");
    }
    assert_eq!(whole.state().registers(), end);
}

#[test]
fn an_integrator_outside_has_the_states_after_the_pairs() {
    let model = model(MOTOR);
    let mut outside = Instance::new(model.clone());
    outside.setup(0.0, None, None).unwrap();
    integrate(&mut outside, 0.3, 2e-4).unwrap();
    let mut states = [0.0; 3];
    outside.states(&mut states).unwrap();
    let [current, omega] = motor_at(0.3);
    assert!((states[1] - omega).abs() < 1e-7 && (states[2] - current).abs() < 1e-7, "{states:?}");
    let description = compiled(MOTOR).description;
    let derivatives: Vec<&str> =
        description.derivatives().iter().map(|&place| description.variables[place].name.as_str()).collect();
    assert_eq!(derivatives, ["wheel.omega", "wheel.alpha", "der(current)"]);
}

#[test]
fn sensitivities_go_through_states() {
    check_sensitivities(MOTOR, &["resistance", "inductance", "voltage", "current", "wheel.omega"], 0.4, 1e-3, 1e-8);
}

#[test]
fn the_linear_system_has_the_states() {
    let system =
        Study::new(&Scene::from_toml(MOTOR).unwrap()).unwrap().linearize(&LinearisedAt::Times(vec![0.0])).unwrap();
    let system = &system.points[0];
    let names: Vec<&str> = system.states.iter().map(|state| state.name.as_str()).collect();
    assert_eq!(names, ["wheel.angle", "wheel.omega", "current"]);
    let expected = Matrix3::new(0.0, 1.0, 0.0, 0.0, -0.5, 25.0, 0.0, -12.5, -200.0);
    assert!((system.a.clone() - expected).amax() < 1e-9, "{}", system.a);
    assert!((system.b[(2, 0)] - 250.0).abs() < 1e-9);
}

/// Against a torsion spring the motor rests where the torque of the current U/R is that of the spring; its modes are the eigenvalues of the linear system.
#[test]
fn a_motor_rests_against_a_spring_and_swings_about_it() {
    let spring =
        "[loads.spring]\ntype = \"torsion_spring\"\nbetween = [\"ground\", \"wheel\"]\nstiffness = 0.5\n[initial]";
    let scene = Scene::from_toml(&MOTOR.replacen("[initial]", spring, 1)).unwrap();
    let rest = Study::new(&scene).unwrap().equilibrium().unwrap();
    for (name, expected) in [("current", 6.0 / 0.8), ("wheel.angle", 0.05 * 6.0 / 0.8 / 0.5)] {
        let found = rest.value(name).unwrap();
        assert!((found - expected).abs() < 1e-9, "{name} rests at {found}, not {expected}");
    }
    let found = Study::new(&scene).unwrap().modes(None).unwrap().modes;
    let system = Matrix3::new(0.0, 1.0, 0.0, -250.0, -0.5, 25.0, 0.0, -12.5, -200.0);
    let mut expected: Vec<Complex<f64>> =
        system.complex_eigenvalues().iter().copied().filter(|value| value.im >= 0.0).collect();
    expected.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    assert_eq!(found.len(), expected.len());
    for (mode, expected) in found.iter().zip(expected) {
        assert!((mode.eigenvalue - expected).norm() < 1e-8 * expected.norm(), "{} {expected}", mode.eigenvalue);
    }
}

/// What drivers prescribe has states beside it.
#[test]
fn a_driven_mechanism_has_states() {
    let scene = Scene::new("driven")
        .body("crank", Body::new().point("tip", [0.3, 0.0]))
        .revolute("axle", "ground", "crank")
        .driver("motor", cotree::scene::Driver::angle("axle", "3*t"))
        .state("lag", State::new(0.0, "crank.omega - 2*lag"))
        .state("swing", State::new(1.0, "cos(crank.angle)"))
        .output("lag")
        .output("swing");
    let mut run = Run::new(&scene);
    for time in [0.0, 0.4, 2.0, 9.0] {
        run.to(time).check("lag", 1.5 * (1.0 - (-2.0 * time).exp()));
        run.check("swing", 1.0 + (3.0 * time).sin() / 3.0);
    }
}

#[test]
fn a_state_does_not_drift() {
    let scene = Scene::new("long")
        .body("wheel", Body::new().mass(1.0).inertia(1.0))
        .revolute("axle", "ground", "wheel")
        .initial("wheel.angle", 0.0)
        .initial("wheel.omega", 1.0)
        .state("wave", State::new(0.0, "cos(wheel.angle)"))
        .state("count", State::new(0.0, "1").nominal(100))
        .output("wave")
        .output("count");
    let mut run = Run::new(&scene);
    run.to(1000.0).check("wave", 1000_f64.sin());
    run.check("count", 1000.0);
}

/// A slider-crank with crank and rod of one length goes through its dead point, where branches cross, beside a state as without one.
#[test]
fn singular_poses_are_passed_beside_states() {
    let bar = |mass: f64| Body::new().mass(mass).inertia(mass / 12.0).point("a", [-0.5, 0.0]).point("b", [0.5, 0.0]);
    let scene = |torque: &str| {
        let scene = Scene::new("dead_points")
            .body("crank", bar(1.0))
            .body("rod", bar(0.6))
            .body("slider", Body::new().mass(0.7))
            .revolute("bearing", "ground", "crank.a")
            .revolute("pin", "crank.b", "rod.a")
            .revolute("wrist", "rod.b", "slider")
            .prismatic("guide", "ground", "slider", [1.0, 0.0])
            .load("motor", Load::torque("ground", "crank", torque))
            .initial("crank.angle", 0.5)
            .initial("crank.omega", 3.0)
            .guess("rod.angle", -0.5)
            .output("crank.angle")
            .output("slider.x");
        if torque == "z" { scene.state("z", State::new(1.5, "0")).state("far", State::new(7.0, "40*z")) } else { scene }
    };
    let end = |torque: &str| {
        let program = sound(compile(&scene(torque))).program;
        let mut run = Instance::new(Arc::new(Model::new(program).unwrap()));
        run.setup(0.0, None, Some(1e-10)).unwrap();
        run.initialise().unwrap();
        run.step_to(2.0).unwrap();
        let passed = run.take_passages().len();
        (passed, value(&mut run, "crank.angle"), value(&mut run, "slider.x"))
    };
    let (with, without) = (end("z"), end("1.5"));
    assert!(with.0 > 0 && with.0 == without.0, "{with:?} {without:?}");
    assert!((with.1 - without.1).abs() < 1e-7 && (with.2 - without.2).abs() < 1e-7, "{with:?} {without:?}");
}

/// States of a part have the name of the part in front.
#[test]
fn a_part_brings_its_states() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("motor.toml"), MOTOR).unwrap();
    let whole = folder.path().join("both.toml");
    std::fs::write(
        &whole,
        "name = \"both\"\n[parts]\nleft = { file = \"motor.toml\" }\nright = { file = \"motor.toml\" }\n",
    )
    .unwrap();
    let scene = sound(Scene::read(&whole));
    let program = sound(compile(&scene)).program;
    let mut run = Instance::new(Arc::new(Model::new(program).unwrap()));
    run.setup(0.0, None, Some(1e-10)).unwrap();
    run.initialise().unwrap();
    run.step_to(0.05).unwrap();
    let [current, omega] = motor_at(0.05);
    for part in ["left", "right"] {
        assert!((value(&mut run, &format!("{part}_current")) - current).abs() < 1e-8);
        assert!((value(&mut run, &format!("{part}_wheel.omega")) - omega).abs() < 1e-8);
    }
}

fn fault(text: &str) -> String {
    let faults: Faults = Scene::from_toml(text).and_then(|scene| compile(&scene)).expect_err("a fault");
    faults.render(false, 400)
}

#[test]
fn what_a_rate_and_a_driver_may_not_use_is_said() {
    let rate = "(voltage - resistance*current - constant*wheel.omega)/inductance";
    let with = |other: &str| fault(&MOTOR.replace(rate, other));
    assert!(with("voltage/inductance + 1[A/s]*energy.kinetic/1[J]").contains("`energy.kinetic`, a sum"));
    let other = with("voltage");
    assert!(other.contains("must be in `A/s`") && other.contains("`V`"), "{other}");
    let driven = MOTOR.replace("[initial]", "[drivers.turn]\nangle = \"current\"\njoint = \"axle\"\n[initial]");
    assert!(fault(&driven).contains("cannot depend on a state"), "{}", fault(&driven));
    let twice = MOTOR.replace("[inputs]", "[inputs]\ncurrent = 0");
    assert!(fault(&twice).contains("as input and as state"), "{}", fault(&twice));
}

/// Pressures are large numbers in SI: what they do to an angle is printed all the same.
#[test]
fn printed_linear_systems_show_small_numbers_beside_pressures() {
    let scene = Scene::from_toml(&crate::support::run::scene_of("hydraulic_lever")).unwrap();
    let system = Study::new(&scene).unwrap().linearize(&LinearisedAt::Times(vec![0.0])).unwrap();
    let exact = system.points[0].a[(1, 2)];
    assert!(exact.abs() < 1e-4 && exact != 0.0, "{exact}");
    let text = system.report().text(&cotree::model::Units::default());
    let is_wanted = |line: &&str| line.contains("d(lever.omega)/dt") && line.split_whitespace().count() == 5;
    let row = text.lines().find(is_wanted).expect("a row of A");
    let printed: f64 = row.split_whitespace().nth(3).unwrap().parse().unwrap();
    assert!((printed - exact).abs() < 1e-5 * exact.abs(), "{row}");
}
