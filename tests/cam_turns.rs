//! The turn of a cam's turning follower: its angle is that of a direction, so it may be guessed whole turns away, and it stays on that turn in every command. A spring that
//! counts turns is turned with it, and then all that is shown is the same, but for the angles.

use crate::outside::command;

use std::f64::consts::TAU;

use command::{code, cotree, stderr, stdout};

const BASE: f64 = 0.025;
const DISTANCE: f64 = 0.09;
const ARM: f64 = 0.075;
const ROLLER: f64 = 0.006;
const RISE: f64 = 0.4;
const EXPLICIT: &str = "[solver]\nmethod = \"explicit\"\n";

/// A rocker on a cam, `turns` turns away, with a spring that is free there; the cam is driven or held by a spring.
fn scene(turns: f64, [driven, face, right]: [bool; 3]) -> String {
    let touch = if face { "face = [1, 0]".to_owned() } else { format!("roller = {ROLLER}") };
    let side = if right { "right" } else { "left" };
    let guess = match (face, right) {
        (false, false) => 150.0,
        (false, true) => -150.0,
        (true, false) => 150.0,
        (true, true) => -10.0,
    };
    let drive = if driven {
        "[drivers.motor]\njoint = \"shaft\"\nangle = \"0.3 + 12*t\""
    } else {
        "[loads.hold]\ntype = \"torsion_spring\"\nbetween = [\"ground\", \"disc\"]\nstiffness = 6.0\nangle = 1.1\n[initial]\n\"disc.angle\" = 0.8\n\"disc.omega\" = 0.5"
    };
    let initial = if driven { "[initial]\n" } else { "" };
    format!(
        r#"
name = "rocker"
gravity = [0, 0]
[ground.points]
pivot = [{DISTANCE}, 0]
[bodies.disc]
mass = 1.0
inertia = 0.002
[bodies.rocker]
mass = 0.4
inertia = 0.0006
points = {{ tip = [{ARM}, 0] }}
[joints.shaft]
type = "revolute"
between = ["ground", "disc"]
[joints.pivot]
type = "revolute"
between = ["ground.pivot", "rocker"]
[joints.contact]
type = "cam"
between = ["disc", "rocker.tip"]
shaft = "shaft"
guide = "pivot"
base = {BASE}
{touch}
side = "{side}"
law = "{RISE}*(1 - cos(angle))/2"
[loads.spring]
type = "torsion_spring"
between = ["ground", "rocker"]
stiffness = 1.5
angle = "{} deg"
{drive}
{initial}"rocker.angle" = {{ guess = "{} deg" }}
[outputs]
variables = ["rocker.angle", "spring.torque", "contact.fn"]
[experiment]
stop = 0.3
step = 0.1
tolerance = 1e-9
"#,
        guess + 360.0 * turns + 20.0,
        guess + 360.0 * turns,
    )
}

/// All numbers of what a command prints.
fn numbers(text: &str, arguments: &[&str]) -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("rocker.toml"), text).unwrap();
    let arguments = [&[arguments[0], "rocker.toml"], &arguments[1..]].concat();
    let output = cotree(folder.path(), &arguments);
    assert_eq!(code(&output), 0, "{arguments:?}: {}{text}", stderr(&output));
    let is_part = |c: char| !(c.is_ascii_digit() || "+-.e".contains(c));
    stdout(&output).split(is_part).filter_map(|word| word.parse().ok()).collect()
}

/// Is a number the same but for rounding, or so many turns more?
fn is_turned(number: f64, by: f64, from: f64) -> bool {
    let near = |value: f64| (number - value).abs() < 1e-6 * (1.0 + from.abs());
    near(from) || near(from + TAU * by) || near(from + 360.0 * by)
}

#[test]
fn a_follower_stays_on_the_turn_that_is_guessed_in_every_command() {
    let ways = [[false; 3], [false, false, true], [true, false, false], [true, false, true]];
    for way in ways {
        let commands: &[(&str, &[&str])] = match way[0] {
            true => &[("", &["simulate"]), (EXPLICIT, &["simulate"]), ("", &["motion", "--json"])],
            false => &[
                ("", &["simulate"]),
                (EXPLICIT, &["simulate"]),
                ("", &["equilibrium", "--json"]),
                ("", &["modes", "--json"]),
                ("", &["linearize", "--json"]),
            ],
        };
        for (solver, command) in commands {
            let with = |turns: f64| format!("{}{solver}", scene(turns, way));
            let first = numbers(&with(0.0), command);
            assert!(first.len() > 6, "{first:?}");
            for turns in [-1.0, 1.0, 2.0] {
                let other = numbers(&with(turns), command);
                assert_eq!(first.len(), other.len(), "{way:?} {command:?} {turns}");
                for (from, to) in first.iter().zip(&other) {
                    assert!(is_turned(*to, turns, *from), "{way:?} {command:?} {turns}: {from} {to}");
                }
            }
        }
    }
}

/// The angle of a driven rocker is where the roller touches the base circle, less the law; the spring has the difference from its rest.
#[test]
fn a_driven_follower_follows_its_law_on_every_turn() {
    let reach = BASE + ROLLER;
    let inner = ((DISTANCE * DISTANCE + ARM * ARM - reach * reach) / (2.0 * DISTANCE * ARM)).acos();
    for (right, turns) in [(false, 0.0), (false, -1.0), (true, 1.0), (false, 2.0)] {
        let text = scene(turns, [true, false, right]);
        let rows = numbers(&text, &["simulate"]);
        // Names have no numbers in them: rows of time, angle, torque and force.
        let rows: Vec<&[f64]> = rows.chunks(4).collect();
        assert_eq!(rows.len(), 4);
        for row in rows {
            let [time, angle, torque, _] = row[..] else { unreachable!() };
            let law = 0.5 * RISE * (1.0 - (0.3 + 12.0 * time).cos());
            let (middle, sense) = if right { (-150.0, 1.0) } else { (150.0, -1.0) };
            // On the left the arm is below half a turn by the angle of the triangle, on the right above it.
            let direction = std::f64::consts::PI + sense * (inner + law);
            let guess = f64::to_radians(middle + 360.0 * turns);
            let expected = direction - TAU * ((direction - guess) / TAU).round();
            assert!((angle - expected).abs() < 1e-7, "{right} {turns} {time}: {angle} {expected}");
            let rest = guess + f64::to_radians(20.0);
            assert!((torque + 1.5 * (angle - rest)).abs() < 1e-6, "{torque}");
        }
    }
}

/// What lifts off is apart by its gap along its way: the angle from the law's times the arm.
#[test]
fn the_gap_of_a_lifted_follower_is_measured_along_its_way() {
    let variables = ["spring.torque\", \"contact.fn\"]", "contact.gap\", \"contact.mode\"]"];
    let text = scene(0.0, [true, false, true])
        .replace("side = \"right\"", "side = \"right\"\nunilateral = {}")
        .replace(variables[0], variables[1])
        .replace("stiffness = 1.5", "stiffness = 0.05")
        .replace(
            "\"rocker.angle\" = { guess = \"-150 deg\" }",
            "\"rocker.angle\" = \"-146.2 deg\"\n\"rocker.omega\" = 0",
        );
    let reach = BASE + ROLLER;
    let inner = ((DISTANCE * DISTANCE + ARM * ARM - reach * reach) / (2.0 * DISTANCE * ARM)).acos();
    let rows = numbers(&text, &["simulate"]);
    assert!(rows.chunks(4).any(|row| row[2] > 0.005), "{rows:?}");
    for row in rows.chunks(4) {
        let law = 0.5 * RISE * (1.0 - (0.3 + 12.0 * row[0]).cos());
        let apart = ARM * (row[1] - (inner + law - std::f64::consts::PI));
        assert!((row[2] - apart).abs() < 1e-9, "{row:?} {apart}");
    }
}
