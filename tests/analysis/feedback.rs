//! Linear systems, vibrations and rests with loads that read accelerations and reactions: closed forms, and differences of the runtime's own accelerations.

use super::slopes::against_differences;
use super::support::close;
use cotree::scene::Scene;
use cotree_study::analysis::Study;

fn pendulum(law: &str, more: &str) -> String {
    format!(
        r#"
name = "pendulum"
gravity = [0, -9.81]
[bodies.bob]
mass = 2.0
inertia = 0.1
points = {{ hinge = [0, 1] }}
[joints.pin]
type = "revolute"
between = ["ground", "bob.hinge"]
[loads.drive]
type = "torque"
on = "bob"
value = {law:?}
[initial]
"pin.angle" = 0.3
"pin.omega" = 0.7
[outputs]
variables = ["bob.alpha", "pin.fx", "pin.fy", "drive.torque"]
{more}"#
    )
}

/// J alpha is an inertia of the vibration; a torque of a share of the weight carried holds the pendulum aside.
#[test]
fn rests_and_vibrations_are_those_of_closed_forms() {
    let study = |text: &str| Study::new(&Scene::from_toml(text).unwrap()).unwrap();
    let found = study(&pendulum("-0.3*bob.alpha", "")).modes(None).unwrap();
    let expected = (2.0 * 9.81 / 2.4_f64).sqrt() / std::f64::consts::TAU;
    close("frequency", found.modes[0].frequency(), expected, 1e-11, 1.0);
    let statics = study(&pendulum("0.2*pin.fy - 0.3*bob.alpha", "")).equilibrium().unwrap();
    let group = statics.groups.iter().find(|group| group.title == "coordinates").unwrap();
    close("angle", group.values[0].1, 0.2_f64.asin(), 1e-11, 1.0);
}

#[test]
fn linear_systems_are_those_of_differences() {
    let laws = ["0.2*pin.fy - 0.3*bob.alpha", "-0.05*hypot(pin.fx, pin.fy)*bob.omega", "u - 0.1*pin.fx"];
    for law in laws {
        against_differences(&pendulum(law, "[inputs]\nu = \"1 N.m\"\n"), &[0.0, 0.4]);
    }
}
