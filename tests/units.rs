//! Numbers, units and names as newcomers write them: what is right counts, all else is told what to write.

use cotree::Scene;
use cotree::compile::compile;
use cotree::scene::{Fault, Severity};

const FAN: &str = r#"
name = "fan"
gravity = [0, -9.81]

[bodies.blade]
mass = 0.4
inertia = "3 g.m2"
points = { hub = [0, 0], tip = ["140 mm", 0] }
com = ["70 mm", 0]

[joints.shaft]
type = "revolute"
between = ["ground", "blade.hub"]

[drivers.motor]
joint = "shaft"
angle = "2*pi*t"

[outputs]
variables = ["shaft.angle", "motor.torque"]

[experiment]
stop = "0.2 s"
step = "0.1 s"
"#;

fn with(old: &str, new: &str) -> String {
    assert!(FAN.contains(old), "{old}");
    FAN.replacen(old, new, 1)
}

/// All that is wrong or odd.
fn faults(text: &str) -> Vec<Fault> {
    match Scene::from_toml(text).and_then(|scene| compile(&scene)) {
        Err(faults) => faults.list,
        Ok(compiled) => compiled.warnings.map_or_else(Vec::new, |warnings| warnings.list),
    }
}

/// A turn is 2 pi, whichever unit says it, and a number of degrees is a coefficient like any other.
#[test]
fn an_angle_may_be_so_many_degrees_times_the_time() {
    for law in ["360[deg]*t", "t*1[rev]", "2*pi*t", "360[deg/s]*t", "60[rpm]*t"] {
        let results = Scene::from_toml(&with("2*pi*t", law)).unwrap().simulate().unwrap();
        let angle = results.column("shaft.angle").unwrap().values[1];
        assert!((angle - 0.2 * std::f64::consts::PI).abs() < 1e-12, "{law}: {angle}");
    }
}

/// The radian counts as a pure number in roots and powers, too: the metres and seconds beside it are known.
#[test]
fn roots_of_angles_keep_the_other_units() {
    let with_signal =
        |value: &str| format!("{}\n[signals]\nown = \"{value}\"\n", with("variables = [", "variables = [\"own\", "));
    for wrong in
        ["sqrt(4[rev]*1[m2]) + 2[s]", "(4[rev]*1[m2])^0.5 + 2[s]", "2[s] + sqrt(2[rad])*3[m]", "2[rad]^1.5*1[m] + 2[s]"]
    {
        let faults = faults(&with_signal(wrong));
        assert!(faults.iter().any(|fault| fault.code == "scene::wrong_unit"), "{wrong}: {faults:?}");
    }
    assert!(faults(&with_signal("sqrt(4[rev]*1[m2]) + 2[m]")).is_empty());
}

/// A weight beyond all numbers is not left out; below that it is what it is.
#[test]
fn what_is_too_large_for_a_number_is_refused() {
    for mass in ["1e308", "5e307"] {
        let found = faults(&with("mass = 0.4", &format!("mass = {mass}")));
        assert_eq!((found[0].code, found[0].severity), ("scene::out_of_range", Severity::Error), "{mass}: {found:?}");
    }
    let results = Scene::from_toml(&with("mass = 0.4", "mass = 1e306")).unwrap().simulate().unwrap();
    let torque = results.column("motor.torque").unwrap().values[0];
    assert!((torque / (1e306 * 9.81 * 0.07) - 1.0).abs() < 1e-12, "{torque}");
}

#[test]
fn what_newcomers_write_is_told_what_to_write() {
    for (old, new, code, help) in [
        ("\"140 mm\"", "\"140 milimeter\"", "scene::unknown_unit", "`mm`"),
        ("\"140 mm\"", "'5.5\"'", "scene::unknown_unit", "`in`"),
        ("2*pi*t", "2 pi t", "scene::bad_expression", "`2*pi*t`"),
        ("2*pi*t", "2pi t", "scene::bad_expression", "`2*pi*t`"),
        ("2*pi*t", "t 2*pi", "scene::bad_expression", "`t*2*pi`"),
        ("2*pi*t", "360*t", "scene::degrees", "`360[deg]*t`"),
        ("\"shaft.angle\"", "\"shaft.angle [deg]\"", "scene::unknown_output", "write `shaft.angle`"),
        ("\"shaft.angle\"", "\"shaft.angle (deg)\"", "scene::unknown_output", "write `shaft.angle`"),
        ("mass = 0.4", "mass = 0．4", "scene::syntax", "mass = 0.4`"),
        ("mass = 0.4", "mass = ０.４", "scene::syntax", "mass = 0.4`"),
        ("\"revolute\"", "“revolute”", "scene::syntax", "\"revolute\"`"),
        ("\"revolute\"", "„revolute“", "scene::syntax", "\"revolute\"`"),
        (
            "{ hub = [0, 0], tip = [\"140 mm\", 0] }",
            "[[0, 0], [0.14, 0]]",
            "scene::wrong_type",
            "each point has a name",
        ),
        ("angle = \"2*pi*t\"", "omega = \"2*pi\"", "scene::driver_motion", "`angle = \"2*pi*t\"`"),
        ("angle = \"2*pi*t\"", "speed = 3", "scene::driver_motion", "`angle = \"2*pi*t\"`"),
    ] {
        let found = faults(&with(old, new));
        let is_said = |fault: &Fault| fault.code == code && fault.help.contains(help);
        assert!(found.iter().any(is_said), "{new}: {found:#?}");
    }
    assert!(faults(&with("2*pi*t", "360[rad]*t")).is_empty() && faults(&with("2*pi*t", "10*t")).is_empty());
}

/// Where the loops do not close as guessed, a guess that was odd is said beside it.
#[test]
fn warnings_stand_beside_a_later_error() {
    let loop_ = r#"
[bodies.rod]
mass = 0.2
inertia = 0.001
points = { a = [0, 0], b = ["300 mm", 0] }
[joints.pin]
type = "revolute"
between = ["blade.tip", "rod.a"]
[joints.rail]
type = "slot"
between = ["ground", "rod.b"]
axis = [1, 0]
[initial]
"rod.angle" = { guess = 100 }
"rail.s" = "5 m"
"#;
    let found = faults(&format!("{FAN}{loop_}"));
    let errors = found.iter().filter(|fault| fault.severity == Severity::Error).count();
    assert!(errors > 0 && found.iter().any(|fault| fault.code == "scene::degrees"), "{found:#?}");
}
