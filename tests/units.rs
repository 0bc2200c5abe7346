//! Numbers, units and names as newcomers write them: what is right counts, all else is told what to write.

use cotree::Scene;
use cotree::compile::compile;
use cotree::export::xml::{fmi2, fmi3};
use cotree::model::Exponents;
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
        ("angle = \"2*pi*t\"", "omega = \"2*pi\"", "scene::driver_motion", "`angle = \"(2*pi)*t\"`"),
        ("angle = \"2*pi*t\"", "speed = 3", "scene::driver_motion", "`angle = \"3*t\"`"),
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

/// A motor of direct current without inductance that turns a disc: J dw/dt = k (u - k w)/R.
const MOTOR: &str = r#"
name = "motor"
gravity = [0, 0]

[parameters]
k = "80 mN.m/A"
back = "0.08 V.s/rad"
resistance = "500 mohm"

[inputs]
supply = "12 V"

[bodies.disc]
mass = "2 kg"
inertia = "4 g.m2"
points = { hub = [0, 0] }

[joints.shaft]
type = "revolute"
between = ["ground", "disc.hub"]

[signals]
current = { value = "(supply - back*shaft.omega)/resistance", unit = "mA" }

[loads.armature]
type = "torque"
between = ["ground", "disc"]
value = "k*current"

[outputs]
variables = ["shaft.omega", "current"]

[experiment]
stop = "0.2 s"
step = "0.05 s"
tolerance = 1e-9
"#;

#[test]
fn a_motor_of_direct_current_has_its_closed_form() {
    let results = Scene::from_toml(MOTOR).unwrap().simulate().unwrap();
    let column = |name: &str| results.column(name).unwrap().values.clone();
    for ((time, omega), current) in results.times().iter().zip(column("shaft.omega")).zip(column("current")) {
        let share = (-0.08 * 0.08 / (0.5 * 0.004) * time).exp();
        assert!((omega - 150.0 * (1.0 - share)).abs() < 1e-5, "{time}: {omega}");
        assert!((current - 24.0 * share).abs() < 1e-6, "{time}: {current}");
    }
}

/// In both versions of FMI a volt is kg m2/(s3 A).
#[test]
fn electrical_units_are_in_the_description() {
    let compiled = compile(&Scene::from_toml(MOTOR).unwrap()).unwrap();
    let unit = |name: &str| {
        let variable = compiled.description.variables.iter().find(|variable| variable.name == name).unwrap();
        let display = variable.unit.display.as_ref().map(|display| (display.name.as_str(), display.factor));
        (variable.unit.si.as_str(), variable.unit.exponents, display)
    };
    assert_eq!(unit("supply"), ("V", Exponents::VOLT, None));
    assert_eq!(unit("current"), ("A", Exponents::AMPERE, Some(("mA", 1e-3))));
    assert_eq!(unit("k"), ("N.m/A", Exponents::WEBER, Some(("mN.m/A", 1e-3))));
    assert_eq!(unit("back"), ("V.s/rad", Exponents::WEBER.over(Exponents::RADIAN), None));
    assert_eq!(unit("resistance"), ("ohm", Exponents::OHM, Some(("mohm", 1e-3))));
    for written in [fmi2::model_description, fmi3::model_description].map(|written| written(&compiled.description)) {
        let description = String::from_utf8(written.unwrap()).unwrap();
        assert!(description.contains(r#"<Unit name="V">"#), "{description}");
        assert!(description.contains(r#"<BaseUnit kg="1" m="2" s="-3" A="-1"/>"#), "{description}");
        assert!(description.contains(r#"<BaseUnit A="1"/>"#), "{description}");
    }
}

#[test]
fn electrical_units_agree_with_what_they_are_made_of() {
    let with_signal = |value: &str| {
        MOTOR
            .replace("[signals]", &format!("[signals]\nown = \"{value}\""))
            .replace(r#""current"]"#, r#""current", "own"]"#)
    };
    for right in [
        "1[V] + 2[W/A]",
        "1[V] + 2[A.ohm]",
        "1[ohm] + 2[V/A] + 3[kohm] + 4[Ω] + 5[\u{2126}]",
        "1[H] + 2[ohm.s]",
        "1[F] + 2[C/V] + 3[uF]",
        "1[C] + 2[A.s]",
        "1[Wb] + 2[V.s] + 3[N.m/A]",
        "1[T] + 2[Wb/m2]",
        "1[W] + 2[V.mA]",
        "1[J] + 2[H.A2]",
        "1[V.s/rad] + 2[N.m/A]",
        "1[kPa] + 2[bar] + 3[N/mm2]",
    ] {
        let found = faults(&with_signal(right));
        assert!(found.is_empty(), "{right}: {found:?}");
    }
    for (wrong, named) in [
        ("1[V] + 2[A]", ["`V`", "`A`"]),
        ("1[ohm] + 2[H]", ["`ohm`", "`H`"]),
        ("1[F] + 2[C]", ["`F`", "`C`"]),
        ("1[N.m/A] + 2[T]", ["`N.m/A`", "`T`"]),
        ("resistance + supply", ["`ohm`", "`V`"]),
    ] {
        let found = faults(&with_signal(wrong));
        let is_said =
            |fault: &Fault| fault.code == "scene::wrong_unit" && named.iter().all(|unit| fault.message.contains(unit));
        assert!(found.iter().any(is_said), "{wrong}: {found:?}");
    }
    for (old, new, named) in [
        ("value = \"k*current\"", "value = \"k*supply\"", "a torque"),
        ("mass = \"2 kg\"", "mass = \"2 V\"", "`V`"),
        ("unit = \"mA\"", "unit = \"mV\"", "`mV`"),
    ] {
        let found = faults(&MOTOR.replace(old, new));
        assert!(
            found.iter().any(|fault| fault.code == "scene::wrong_unit" && fault.message.contains(named)),
            "{new}: {found:?}"
        );
    }
    for (word, meant) in
        [("volts", "`V`"), ("Ohm", "`ohm`"), ("mAh", "`mA.h`"), ("degC", "coulomb"), ("Nm/A", "`N.m/A`"), ("cV", "")]
    {
        let found = faults(&MOTOR.replace("12 V", &format!("12 {word}")));
        assert!(
            found.iter().any(|fault| fault.code == "scene::unknown_unit" && fault.help.contains(meant)),
            "{word}: {found:?}"
        );
    }
}
