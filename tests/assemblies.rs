//! `cotree assemblies`: the ways in which loops close, against circles that are intersected by hand.

use crate::outside::command;

use command::{code, cotree, stderr, stdout};

const FOUR_BAR: &str = r#"
name = "four_bar"
ground.points = { a = [0, 0], d = ["100 mm", 0] }
[bodies]
crank   = { mass = 1, inertia = 1, points = { a = [0, 0], b = ["40 mm", 0] } }
coupler = { mass = 1, inertia = 1, points = { b = [0, 0], c = ["120 mm", 0] } }
rocker  = { mass = 1, inertia = 1, points = { d = [0, 0], c = ["80 mm", 0] } }
[joints]
A = { type = "revolute", between = ["ground.a", "crank.a"] }
B = { type = "revolute", between = ["crank.b", "coupler.b"] }
C = { type = "revolute", between = ["coupler.c", "rocker.c"] }
D = { type = "revolute", between = ["ground.d", "rocker.d"] }
"#;

/// Angle of the rocker for both assemblies [deg].
fn rocker(crank: f64) -> [f64; 2] {
    let (a, b, c, d) = (0.04, 0.12, 0.08, 0.1);
    let [x, y] = [a * crank.cos() - d, a * crank.sin()];
    let r = f64::hypot(x, y);
    let corner = ((r * r + c * c - b * b) / (2.0 * r * c)).acos();
    [-1.0, 1.0].map(|side| (y.atan2(x) + side * corner).to_degrees())
}

/// The guess is more than a quarter of a turn from both assemblies.
#[test]
fn guesses_that_lead_nowhere_hide_no_assembly() {
    let folder = tempfile::tempdir().unwrap();
    let [one, other] = rocker(60f64.to_radians());
    let guess = 0.5 * (one + other);
    assert!(guess - one > 90.0 && other - guess > 90.0);
    let scene = format!(
        "{FOUR_BAR}[initial]\n\"crank.angle\" = \"60 deg\"\n\"rocker.angle\" = {{ guess = \"{guess} deg\" }}\n"
    );
    std::fs::write(folder.path().join("a.toml"), &scene).unwrap();
    assert_ne!(code(&cotree(folder.path(), &["check", "a.toml"])), 0);
    let output = cotree(folder.path(), &["assemblies", "a.toml"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    assert!(
        text.starts_with("four_bar: the loops close in 2 assembly modes") && text.contains("lead to none of them"),
        "{text}"
    );
    assert!(!text.contains("that of the scene"), "{text}");
}

#[test]
fn both_assemblies_of_a_four_bar_are_found_and_can_be_pasted() {
    let folder = tempfile::tempdir().unwrap();
    let scene =
        format!("{FOUR_BAR}[initial]\n\"crank.angle\" = \"60 deg\"\n\"rocker.angle\" = {{ guess = \"60 deg\" }}\n");
    std::fs::write(folder.path().join("a.toml"), &scene).unwrap();
    let output = cotree(folder.path(), &["assemblies", "a.toml", "--drawings", "poses"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    assert!(text.starts_with("four_bar: the loops close in 2 assembly modes (from 200 starts)"), "{text}");
    let mut found = Vec::new();
    for (index, part) in text.split("\n# ").skip(1).enumerate() {
        let lines: String = part.lines().skip(2).map(|line| format!("{line}\n")).collect();
        let pasted = format!(
            "{FOUR_BAR}[initial]\n\"crank.angle\" = \"60 deg\"\n{lines}[outputs]\nvariables = [\"rocker.angle\"]\n"
        );
        std::fs::write(folder.path().join("b.toml"), pasted).unwrap();
        let run = cotree(folder.path(), &["simulate", "b.toml", "--stop", "0", "--units", "deg"]);
        assert_eq!(code(&run), 0, "{}", stderr(&run));
        found.push(stdout(&run).lines().nth(1).unwrap().split(',').nth(1).unwrap().parse::<f64>().unwrap());
        let picture = std::fs::read(folder.path().join(format!("poses/{}.png", index + 1))).unwrap();
        assert!(picture.starts_with(b"\x89PNG"));
    }
    found.sort_by(f64::total_cmp);
    let mut wanted = rocker(60f64.to_radians()).map(|angle| (angle + 180.0).rem_euclid(360.0) - 180.0);
    wanted.sort_by(f64::total_cmp);
    let same = |a: f64, b: f64| ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs() < 1e-6;
    assert!(found.len() == 2 && same(found[0], wanted[0]) && same(found[1], wanted[1]), "{found:?} {wanted:?}");
}

/// Two equal bars on two equal bars, like scissors: `a` is driven, so the upper pair has two upright ways; or it is folded, with its ends together, and turns freely.
const SCISSORS: &str = r#"
name = "scissors"
[bodies.a]
mass = 1
inertia = 1
points = { l = [-0.5, 0], r = [0.5, 0], m = [0, 0] }
[bodies.b]
mass = 1
inertia = 1
points = { l = [-0.5, 0], r = [0.5, 0], m = [0, 0] }
[joints]
pin = { type = "revolute", between = ["ground", "a.l"] }
middle = { type = "revolute", between = ["a.m", "b.m"] }
roller = { type = "slot", between = ["ground", "b.r"], axis = [1, 0] }
[bodies.c]
mass = 1
inertia = 1
points = { l = [-0.5, 0], r = [0.5, 0], m = [0, 0] }
[bodies.d]
mass = 1
inertia = 1
points = { l = [-0.5, 0], r = [0.5, 0], m = [0, 0] }
[joints.left]
type = "revolute"
between = ["b.l", "c.l"]
[joints.right]
type = "revolute"
between = ["a.r", "d.r"]
[joints.upper]
type = "revolute"
between = ["c.m", "d.m"]
[drivers.tilt]
joint = "pin"
angle = "30 deg"
[initial]
"a.angle" = { guess = "30 deg" }
"b.angle" = { guess = "-30 deg" }
"c.angle" = { guess = "30 deg" }
"d.angle" = { guess = "-30 deg" }
"#;

/// `b` is at -30 deg, with `c` and `d` upright on it or hanging from it, or folded onto `a` at -150 deg, where `b.l` is `a.r` and the upper pair is folded, too.
#[test]
fn folded_poses_that_turn_freely_hide_no_single_ones() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), SCISSORS).unwrap();
    let output = cotree(folder.path(), &["assemblies", "a.toml"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    assert!(
        text.contains("the loops close in 2 assembly modes")
            && text.contains("can move although all degrees of freedom are fixed"),
        "{text}"
    );
    for angle in ["30.000000", "-30.000000"] {
        assert!(text.contains(&format!("\"c.angle\" = {{ guess = \"{angle} deg\" }}")), "{text}");
    }
}

#[test]
fn what_is_open_is_held_where_the_scene_begins() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("a.toml"),
        format!("{FOUR_BAR}[initial]\n\"crank.angle\" = {{ guess = \"50 deg\" }}\n"),
    )
    .unwrap();
    let text = stdout(&cotree(folder.path(), &["assemblies", "a.toml"]));
    assert!(text.contains("the loops close in 2 assembly modes with `"), "{text}");
    let check = stdout(&cotree(folder.path(), &["check", "a.toml"]));
    assert!(!check.contains("one of"), "a guess has picked one\n{check}");
    std::fs::write(
        folder.path().join("a.toml"),
        format!("{FOUR_BAR}[drivers.motor]\njoint = \"A\"\nangle = \"1 + t\"\n"),
    )
    .unwrap();
    let check = cotree(folder.path(), &["check", "a.toml"]);
    assert!(stdout(&check).contains("this is one of 2"), "{}{}", stdout(&check), stderr(&check));
}

/// A wheel turns a rack, a rod ties both: where the rack is counts whole turns of the wheel.
#[test]
fn whole_turns_that_a_rack_counts_are_kept() {
    let scene = r#"
name = "rack"
[bodies]
wheel  = { mass = 1, inertia = 1, points = { pin = [0.1, 0] } }
slider = { mass = 1, inertia = 1 }
[joints]
bearing = { type = "revolute", between = ["ground", "wheel"] }
guide   = { type = "prismatic", between = ["ground", "slider"], axis = [1, 0] }
rack    = { type = "rack", between = ["wheel", "slider"], axis = [1, 0], radius = "20 mm", displacement = "80 mm" }
rod     = { type = "distance", between = ["wheel.pin", "slider"], length = "150 mm" }
"#;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("rack.toml"), scene).unwrap();
    let output = cotree(folder.path(), &["assemblies", "rack.toml", "--starts", "400"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    let value = |line: &str| -> f64 {
        let inner = line.split("guess = \"").nth(1).unwrap();
        inner.split_whitespace().next().unwrap().parse().unwrap()
    };
    let of = |name: &str| text.lines().filter(|line| line.starts_with(name)).map(value).collect::<Vec<f64>>();
    let (places, angles) = (of("\"guide.s\""), of("\"wheel.angle\""));
    assert!(places.len() >= 3 && places.len() == angles.len(), "{text}");
    for (place, angle) in places.iter().zip(&angles) {
        // The rack, and the rod from the pin.
        assert!((place - (80.0 + 20.0 * angle)).abs() < 1e-4, "{place} {angle}");
        assert!(((place - 100.0 * angle.cos()).hypot(100.0 * angle.sin()) - 150.0).abs() < 1e-3, "{place} {angle}");
    }
    assert!(angles.iter().any(|angle| angle.abs() > std::f64::consts::PI), "{angles:?}");
}
