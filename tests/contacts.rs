//! Contacts that would not hold, against closed forms: a follower that its spring cannot keep on the cam, a disc on a slope.

use crate::outside::command;

use std::f64::consts::{FRAC_PI_2, TAU};

use command::{code, cotree, stderr, stdout};
use cotree::scene::Scene;
use cotree_study::contact::of_experiment;

const CAM: &str = r#"
name = "flying"
gravity = [0, -9.81]
ground.points = { top = [0, "78 mm"] }
[bodies]
cam      = { mass = 1, inertia = 5e-4 }
follower = { mass = 0.3, inertia = 1e-4 }
[joints]
shaft   = { type = "revolute", between = ["ground", "cam"] }
guide   = { type = "prismatic", between = ["ground", "follower"], axis = [0, 1] }
contact = { type = "cam", between = ["cam", "follower"], shaft = "shaft", guide = "guide", base = "20 mm", roller = "8 mm", law = "8[mm]*if(angle < pi/2, cycloidal(angle/(pi/2)), if(angle < pi, 1 - cycloidal((angle - pi/2)/(pi/2)), 0))" }
[loads]
spring = { type = "spring", between = ["follower", "ground.top"], stiffness = 5000, length = "60 mm" }
[drivers]
motor = { joint = "shaft", angle = "SPEED*t" }
[outputs]
variables = ["guide.s"]
[experiment]
stop = "1/SPIN"
step = "1e-4/SPIN"
"#;

/// Turns a second.
fn cam(spin: f64) -> String {
    CAM.replace("SPEED", &format!("{:?}", spin * TAU)).replace("SPIN", &format!("{spin:?}"))
}

/// What the cam carries along the guide, by the law's own derivatives: rise and return are cycloids over a quarter of a turn each.
fn carried(spin: f64, angle: f64) -> f64 {
    let (lift, way) = (8e-3, FRAC_PI_2);
    let x = (angle / way).fract();
    let rise = lift * (x - (TAU * x).sin() / TAU);
    let growth = lift * TAU * (TAU * x).sin() / (way * way) * (spin * TAU).powi(2);
    let (s, a) = match angle {
        angle if angle < way => (rise, growth),
        angle if angle < 2.0 * way => (lift - rise, -growth),
        _ => (0.0, 0.0),
    };
    0.3 * (a + 9.81) + 5000.0 * (0.01 + s)
}

/// The number behind a word of a message.
fn number(message: &str, word: &str) -> f64 {
    let (_, rest) = message.split_once(word).unwrap_or_else(|| panic!("no `{word}` in {message}"));
    rest.split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn a_follower_that_would_fly_is_told_of() {
    let spin = 30.0;
    let found = of_experiment(&Scene::from_toml(&cam(spin)).unwrap());
    let [fault] = &found.faults[..] else { panic!("{found:?}") };
    assert!(found.needed.is_empty() && fault.message.starts_with("`contact` would have to pull"), "{fault:?}");
    let angles: Vec<f64> = (0..100_000).map(|k| TAU * f64::from(k) / 1e5).collect();
    let least = angles.iter().map(|angle| carried(spin, *angle)).fold(f64::MAX, f64::min);
    let more = number(&fault.help, "at least ");
    assert!((more + least).abs() < 2e-3 * more, "{more} N, not {}", -least);
    let first = angles.iter().find(|angle| carried(spin, **angle) < 0.0).unwrap() / (spin * TAU);
    assert!((number(&fault.message, "t = ") - first).abs() < 2e-3 * first, "{}, not {first}", fault.message);
    // Slow enough the spring holds it.
    let slow = of_experiment(&Scene::from_toml(&cam(0.5 * spin)).unwrap());
    assert!(slow.faults.is_empty() == angles.iter().all(|angle| carried(0.5 * spin, *angle) > 0.0), "{slow:?}");
    assert!(slow.faults.is_empty(), "{slow:?}");
}

#[test]
fn every_command_that_shows_forces_says_so() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("fast.toml"), cam(30.0)).unwrap();
    std::fs::write(folder.path().join("slow.toml"), cam(15.0)).unwrap();
    for (arguments, told) in [(&["check"][..], true), (&["simulate", "--summary"], true), (&["motion"], false)] {
        for (scene, flies) in [("fast.toml", true), ("slow.toml", false)] {
            let output = cotree(folder.path(), &[&arguments[..1], &[scene], &arguments[1..]].concat());
            assert_eq!(code(&output), 0, "{}", stderr(&output));
            let said = if told { stderr(&output) } else { stdout(&output) };
            assert_eq!(said.contains("`contact` would have to pull"), flies, "{arguments:?} {scene}: {said}");
        }
    }
}

/// Reports on contacts are in the units that are asked for.
#[test]
fn forces_and_places_are_in_the_units_that_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("fast.toml"), cam(30.0)).unwrap();
    for (command, at) in [(&["simulate", "fast.toml", "--summary"][..], "t ="), (&["motion", "fast.toml"], "`shaft` =")]
    {
        let told = |units: &str| {
            let output = cotree(folder.path(), &[command, &["--units", units]].concat());
            let said = stdout(&output) + &stderr(&output);
            let said = said.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
            let (_, told) = said.split_once("`contact` would have to pull").unwrap_or_else(|| panic!("{said}"));
            told.to_owned()
        };
        let (si, shown) = (told("si"), told("kN,ms,rad"));
        for (word, factor) in
            [("is down to ", 1e-3), ("with at least ", 1e-3), (at, if at == "t =" { 1e3 } else { 1.0 })]
        {
            let (found, wanted) = (number(&shown, word), factor * number(&si, word));
            assert!((found - wanted).abs() < 1e-3 * wanted.abs(), "{word}: {found}, not {wanted}\n{si}\n{shown}");
        }
        assert!(shown.contains(" kN at ") && si.contains(" N at "), "{si}\n{shown}");
        assert!(shown.contains(if at == "t =" { " ms" } else { " rad" }), "{shown}");
    }
}

/// Down a slope a disc with moment of inertia c m r^2 rolls with a friction of c/(1 + c) of the slope.
#[test]
fn a_disc_that_rolls_needs_friction() {
    let slope = |inertia: f64, pull: f64| {
        format!(
            "name = \"slope\"\ngravity = [4.905, -8.495709211125343]\n[bodies.disc]\nmass = 2\ninertia = {inertia}\n\
             [joints.wheel]\ntype = \"rolling\"\nbetween = [\"ground\", \"disc\"]\naxis = [1, 0]\nradius = 0.1\n\
             [loads.rope]\ntype = \"force\"\non = \"disc\"\nvector = [0, {pull:?}]\n[experiment]\nstop = 1\n"
        )
    };
    let found = of_experiment(&Scene::from_toml(&slope(0.01, 0.0)).unwrap());
    let [needed] = &found.needed[..] else { panic!("{found:?}") };
    let wanted = (1.0 / 3.0) * (30_f64).to_radians().tan();
    assert!((number(needed, "at least ") - wanted).abs() < 1e-4, "{needed}, not {wanted}");
    assert!(found.faults.is_empty());
    let lifted = of_experiment(&Scene::from_toml(&slope(0.01, 20.0)).unwrap());
    assert!(lifted.faults.len() == 1 && lifted.faults[0].message.contains("the disc would lift off"), "{lifted:?}");
}

/// A groove or a conjugate cam also pulls.
#[test]
fn a_cam_that_is_closed_by_its_form_does_not_let_go() {
    let closed = cam(30.0).replace("roller = \"8 mm\"", "roller = \"8 mm\", closure = \"form\"");
    let told = |text: &str| of_experiment(&Scene::from_toml(text).unwrap()).faults.len();
    assert_eq!([told(&cam(30.0)), told(&closed), told(&closed.replace("\"form\"", "\"force\""))], [1, 0, 1]);
    let wrong = Scene::from_toml(&closed.replace("\"form\"", "\"groove\"")).unwrap();
    assert!(wrong.resolve().is_err());
}

/// Of a long experiment the beginning is looked at, and what comes after it is said to be taken for granted.
#[test]
fn long_experiments_are_looked_at_for_a_while() {
    let long = |stop: &str| {
        format!(
            "name = \"long\"\ngravity = [0, -9.81]\n[bodies.disc]\nmass = 2\ninertia = 0.01\n\
             [joints.wheel]\ntype = \"rolling\"\nbetween = [\"ground\", \"disc\"]\naxis = [1, 0]\nradius = 0.1\n\
             [ground.points]\nwall = [0, 0.1]\n[loads.spring]\ntype = \"spring\"\nbetween = [\"ground.wall\", \"disc\"]\n\
             stiffness = 50\nlength = \"0.5 m\"\n[initial]\n\"wheel.s\" = 0.7\n[experiment]\nstop = {stop}\nstep = 0.01\n"
        )
    };
    let found = |stop: &str| of_experiment(&Scene::from_toml(&long(stop)).unwrap());
    assert_eq!(found("2").unseen, None);
    let cut = found("1e5");
    let until = number(&cut.unseen.unwrap(), "stay closed from t = ");
    assert!(until > 2.0 && until < 1e3, "{until}");
    assert_eq!(cut.needed.len(), 1);
}

/// A rope has the force of a bar of its length, and a freewheel the torque that it keeps up.
#[test]
fn ropes_and_freewheels_have_a_force_and_a_torque_as_other_joints() {
    let text = r#"
name = "hung_beside"
gravity = [0, -10]
[bodies.a]
mass = 3.0
[bodies.b]
mass = 3.0
[bodies.wheel]
mass = 1.0
inertia = 0.2
[ground.points]
beside = [1, 0]
apart = [3, 0]
[joints]
guide = { type = "prismatic", between = ["ground", "a"], axis = [0, 1] }
other = { type = "prismatic", between = ["ground.beside", "b"], axis = [0, 1] }
line = { type = "rope", between = ["ground", "a"], length = 1 }
bar = { type = "distance", between = ["ground.beside", "b"], length = 1 }
pin = { type = "revolute", between = ["ground.apart", "wheel"] }
ratchet = { type = "one_way", between = ["ground", "wheel"] }
[loads.push]
type = "torque"
on = "wheel"
value = -4
[initial]
"guide.s" = -1
"other.s" = { guess = -1 }
[outputs]
variables = ["line.force", "line.stop", "bar.force", "ratchet.torque", "ratchet.stop"]
[experiment]
stop = 0.2
step = 0.1
"#;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("hung.toml"), text).unwrap();
    let output = cotree(folder.path(), &["simulate", "hung.toml"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let told = stdout(&output);
    for line in told.lines().skip(1) {
        let row: Vec<f64> = line.split(',').skip(1).map(|number| number.parse().unwrap()).collect();
        let expected = [-30.0, -30.0, -30.0, 4.0, 4.0];
        assert!(row.iter().zip(expected).all(|(own, right)| (own - right).abs() < 1e-9), "{row:?}");
    }
}
