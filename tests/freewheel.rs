//! Freewheels: closed forms of what they catch and let go, and a simulator in absolute coordinates.

use crate::support::one_sided::{Always, At, OneSided, Shape, World};
use crate::support::run::{model, started, value};

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::program::Engine;

const METHODS: [Engine; 3] = [Engine::Taylor, Engine::Dop853, Engine::Radau];

/// A disc on a freewheel of the ground.
pub fn disc(direction: &str, torque: &str, rate: f64) -> String {
    format!(
        r#"
name = "ratchet"
[bodies.disc]
mass = 1.0
inertia = 0.4
[joints.axle]
type = "revolute"
between = ["ground", "disc"]
[joints.ratchet]
type = "one_way"
between = ["ground", "disc"]
{direction}
[loads.drive]
type = "torque"
on = "disc"
value = "{torque}"
[initial]
"disc.angle" = 0.2
"disc.omega" = {rate:?}
[outputs]
variables = ["disc.angle", "disc.omega", "disc.alpha", "ratchet.stop", "ratchet.mode", "ratchet.impulse"]
[experiment]
stop = "20 s"
tolerance = 1e-10
"#
    )
}

/// The torque is 0.6 sin(2 t) - 0.1: from rest at t0 the disc turns with omega = (0.3 (cos 2 t0 - cos 2 t) - 0.1 (t - t0))/0.4 until that is zero, and begins to turn where the torque passes zero upwards.
#[test]
fn a_ratchet_turns_on_where_its_torque_does() {
    let torque = |time: f64| 0.6 * (2.0 * time).sin() - 0.1;
    let turned = |from: f64, time: f64| {
        let sines =
            (0.5 * (2.0 * from).cos() * (time - from) * 2.0 - 0.5 * ((2.0 * time).sin() - (2.0 * from).sin())) * 0.3;
        (sines - 0.05 * (time - from) * (time - from)) / 0.4
    };
    let rate = |from: f64, time: f64| (0.3 * ((2.0 * from).cos() - (2.0 * time).cos()) - 0.1 * (time - from)) / 0.4;
    let period = std::f64::consts::PI;
    let first = 0.5 * (1.0_f64 / 6.0).asin();
    let [mut from, mut to] = [first + 0.5, first + 2.5];
    for _ in 0..60 {
        let middle = 0.5 * (from + to);
        *(if rate(first, middle) > 0.0 { &mut from } else { &mut to }) = middle;
    }
    let (caught, each) = (to, turned(first, to));
    for (direction, sign) in [("", 1.0), ("direction = \"clockwise\"", -1.0)] {
        let text = if sign > 0.0 { "0.6*sin(2*t) - 0.1" } else { "0.1 - 0.6*sin(2*t)" };
        let model = model(&disc(direction, text, 0.0));
        for engine in METHODS {
            let mut run = started(&model, Some(engine), 20.0, 1e-10);
            for time in [0.05, 0.6, 1.2, 1.9, 2.4, 3.0, 5.1, 9.7, 19.0] {
                run.step_to(time).unwrap();
                let turns = (time / period).floor();
                let within = time - turns * period;
                let (angle, omega, drives) = match within {
                    within if within < first => (turns * each, 0.0, true),
                    within if within < caught => (turns * each + turned(first, within), rate(first, within), false),
                    _ => ((turns + 1.0) * each, 0.0, true),
                };
                let stop = if drives { -torque(time) } else { 0.0 };
                let expected = [0.2 + sign * angle, sign * omega, sign * stop, sign * f64::from(u8::from(drives))];
                let names = ["disc.angle", "disc.omega", "ratchet.stop"];
                for (name, expected) in names.iter().zip(expected) {
                    let found = value(&mut run, name);
                    assert!(
                        (found - expected).abs() < 2e-9,
                        "{sign} {engine:?} {name} at {time} s: {found} {expected}"
                    );
                }
                assert_eq!(value(&mut run, "ratchet.mode"), f64::from(u8::from(drives)), "{engine:?} {time}");
            }
        }
    }
}

/// A pendulum with a freewheel swings to its highest point and stays there.
#[test]
fn a_pendulum_with_a_freewheel_stays_at_its_highest_point() {
    let scene = r#"
name = "held"
gravity = [0, -9.81]
[bodies.rod]
mass = 2.0
inertia = 0.1
points = { top = [-0.4, 0] }
[joints.hinge]
type = "revolute"
between = ["ground", "rod.top"]
[joints.ratchet]
type = "one_way"
between = ["ground", "rod"]
[initial]
"rod.angle" = "-90 deg"
"rod.omega" = 3.0
[outputs]
variables = ["rod.angle", "rod.omega", "hinge.fx", "hinge.fy", "ratchet.stop", "ratchet.mode"]
[experiment]
stop = "3 s"
tolerance = 1e-10
"#;
    // 1/2 J w^2 = m g l (1 - cos(rise)), J = 0.1 + 2*0.4^2.
    let rise = (1.0_f64 - 0.5 * 0.42 * 9.0 / (2.0 * 9.81 * 0.4)).acos();
    let model = model(scene);
    for engine in METHODS {
        let mut run = started(&model, Some(engine), 3.0, 1e-10);
        run.step_to(3.0).unwrap();
        let angle = rise - std::f64::consts::FRAC_PI_2;
        for (name, expected) in [
            ("rod.angle", angle),
            ("rod.omega", 0.0),
            ("ratchet.stop", 2.0 * 9.81 * 0.4 * angle.cos()),
            ("hinge.fx", 0.0),
            ("hinge.fy", 2.0 * 9.81),
            ("ratchet.mode", 1.0),
        ] {
            let found = value(&mut run, name);
            assert!((found - expected).abs() < 1e-8, "{engine:?} {name}: {found} {expected}");
        }
    }
}

/// Turning back at the start it is caught at once, with what its momentum was.
#[test]
fn what_turns_back_is_caught_at_once() {
    let mut run = started(&model(&disc("", "0.3*t - 0.1", -2.0)), None, 20.0, 1e-10);
    assert_eq!(value(&mut run, "disc.omega"), 0.0);
    assert!((value(&mut run, "ratchet.impulse") - 0.8).abs() < 1e-12);
    run.step_to(1.0).unwrap();
    // It turns on at t = 1/3, where the torque passes zero.
    let since = 1.0 - 1.0 / 3.0;
    let expected = 0.2 + (0.05 * (1.0 - 1.0 / 27.0) - 0.15 / 9.0 * since - 0.05 * since * since) / 0.4;
    let found = value(&mut run, "disc.angle");
    assert!((found - expected).abs() < 1e-9, "{found} {expected}");
}

/// Two discs, the outer driven back and forth by an inner one through a freewheel, and held by another on the ground.
#[test]
fn a_rectifier_follows_absolute_coordinates() {
    let scene = r#"
name = "rectifier"
[ground.points]
end = [0.5, 0]
[bodies]
rocker = { mass = 1.0, inertia = 0.05 }
rotor = { mass = 2.0, inertia = 0.3 }
arm = { mass = 1.0, inertia = 0.2 }
[joints.a]
type = "revolute"
between = ["ground", "rocker"]
[joints.b]
type = "revolute"
between = ["ground", "rotor"]
[joints.c]
type = "revolute"
between = ["ground.end", "arm"]
[joints.drives]
type = "one_way"
between = ["rocker", "rotor"]
[joints.holds]
type = "one_way"
between = ["ground", "rotor"]
[joints.mesh]
type = "gear"
between = ["rotor", "arm"]
ratio = -1.5
[loads.motor]
type = "torque"
on = "rocker"
value = "2*sin(5*t + 0.4) - 1.5*rocker.angle - 0.05*rocker.omega"
[loads.brake]
type = "torque"
on = "arm"
value = "-0.3 - 0.1*arm.omega"
[initial]
"rocker.angle" = 0
"rocker.omega" = 0
"rotor.angle" = 0
"rotor.omega" = 0
[outputs]
variables = ["rocker.angle", "rotor.angle", "arm.angle", "rocker.omega", "rotor.omega", "arm.omega", "drives.mode", "holds.mode"]
[experiment]
stop = "4 s"
tolerance = 1e-10
"#;
    let pinned = |body: usize, at: f64, axis: [f64; 2]| Always {
        shape: Shape::Along([At(None, [at, 0.0]), At(Some(body), [0.0, 0.0])], axis),
        bound: 0.0,
    };
    let always = (0..3).flat_map(|body| [[1.0, 0.0], [0.0, 1.0]].map(|axis| pinned(body, [0.0, 0.0, 0.5][body], axis)));
    let freewheel = |terms: Vec<(usize, f64)>| OneSided {
        shape: Shape::Angle(terms),
        sign: 1.0,
        bound: 0.0,
        restitution: 0.0,
        of_rate: true,
    };
    // The arm turns with the rotor.
    let always = always.chain([Always { shape: Shape::Angle(vec![(2, 1.0), (1, 1.5)]), bound: 0.0 }]);
    let world = World {
        bodies: vec![[1.0, 0.05], [2.0, 0.3], [1.0, 0.2]],
        always: always.collect(),
        one_sided: vec![freewheel(vec![(1, 1.0), (0, -1.0)]), freewheel(vec![(1, 1.0)])],
        torques: vec![
            (0, |t, q, v| 2.0 * (5.0 * t + 0.4).sin() - 1.5 * q[2] - 0.05 * v[2]),
            (2, |_, _, v| -0.3 - 0.1 * v[8]),
        ],
        ..World::default()
    };
    let mut own = world.start(vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0], vec![0.0; 9]);
    let mut run = started(&model(scene), None, 4.0, 1e-10);
    for step in 1..=20 {
        let time = 0.2 * f64::from(step);
        world.go_to(&mut own, time);
        run.step_to(time).unwrap();
        for (name, expected) in [
            ("rocker.angle", own.q[2]),
            ("rotor.angle", own.q[5]),
            ("arm.angle", own.q[8]),
            ("rocker.omega", own.v[2]),
            ("rotor.omega", own.v[5]),
            ("arm.omega", own.v[8]),
        ] {
            let found = value(&mut run, name);
            assert!((found - expected).abs() < 1e-7, "{name} at {time} s: {found} {expected}");
        }
    }
}

/// An integrator outside finds where a freewheel catches and lets go.
#[test]
fn an_integrator_outside_sees_freewheels() {
    let model = model(&disc("", "0.6*sin(2*t) - 0.1", 0.0));
    let mut inside = started(&model, None, 20.0, 1e-10);
    let mut outside = cotree_fmu::instance::Instance::new(model);
    outside.setup(0.0, None, None).unwrap();
    inside.step_to(6.0).unwrap();
    crate::one_sided::integrate_to_events(&mut outside, 6.0, 1e-3);
    for name in ["disc.angle", "disc.omega"] {
        let (found, expected) = (value(&mut outside, name), value(&mut inside, name));
        assert!((found - expected).abs() < 1e-7, "{name}: {found} {expected}");
    }
}

/// In a mirror it turns the other way.
#[test]
fn a_mirrored_freewheel_turns_the_other_way() {
    let folder = tempfile::tempdir().unwrap();
    let text = disc("", "0.6*sin(2*t) - 0.1", 0.0);
    std::fs::write(folder.path().join("disc.toml"), &text).unwrap();
    let whole = "name = \"whole\"\n[parts.own]\nfile = \"disc.toml\"\nmirror = true\nangle = 0.7\n[outputs]\nvariables = [\"own_disc.omega\", \"own_ratchet.stop\", \"own_ratchet.mode\"]\n[experiment]\nstop = 20\ntolerance = 1e-10\n";
    std::fs::write(folder.path().join("whole.toml"), whole).unwrap();
    let scene = Scene::read(folder.path().join("whole.toml")).map_err(|faults| faults.render(false, 100)).unwrap();
    let compiled = compile(&scene).map_err(|faults| faults.render(false, 100)).unwrap();
    let placed = std::sync::Arc::new(cotree_fmu::model::Model::new(compiled.program).unwrap());
    let [mut one, mut other] = [started(&placed, None, 20.0, 1e-10), started(&model(&text), None, 20.0, 1e-10)];
    for time in [0.05, 1.0, 2.3, 3.0, 4.0, 9.0] {
        one.step_to(time).unwrap();
        other.step_to(time).unwrap();
        for (name, sign) in [("disc.omega", -1.0), ("ratchet.stop", -1.0), ("ratchet.mode", 1.0)] {
            let (found, expected) = (value(&mut one, &format!("own_{name}")), sign * value(&mut other, name));
            assert!((found - expected).abs() < 1e-8, "{name} at {time} s: {found} {expected}");
        }
    }
}

#[test]
fn a_freewheel_that_drivers_turn_is_refused() {
    let text = disc("", "0", 0.0).replace(
        "[initial]\n\"disc.angle\" = 0.2\n\"disc.omega\" = 0.0\n",
        "[drivers.motor]\njoint = \"axle\"\nangle = \"t\"\n",
    );
    let found = Scene::from_toml(&text).and_then(|scene| compile(&scene)).expect_err("a fault").to_string();
    assert!(found.contains("a prescribed motion cannot stop"), "{found}");
    let wrong = disc("direction = \"left\"", "0", 0.0);
    let found = Scene::from_toml(&wrong).and_then(|scene| compile(&scene)).expect_err("a fault").to_string();
    assert!(found.contains("direction"), "{found}");
}
