//! `cotree check --drawing` of loops that cannot be closed: the best attempt with the gap, against its closed form.

use crate::outside::command;

use command::{code, cotree, stderr};

const THREE_BARS: &str = r#"
name = "three_bars"
ground.points = { a = [0, 0], d = ["1 m", 0] }
[bodies]
crank   = { mass = 1, inertia = 1, points = { a = [0, 0], b = ["100 mm", 0] } }
coupler = { mass = 1, inertia = 1, points = { b = [0, 0], c = ["250 mm", 0] } }
rocker  = { mass = 1, inertia = 1, points = { d = [0, 0], c = ["150 mm", 0] } }
[joints]
A = { type = "revolute", between = ["ground.a", "crank.a"] }
B = { type = "revolute", between = ["crank.b", "coupler.b"] }
C = { type = "revolute", between = ["coupler.c", "rocker.c"] }
D = { type = "revolute", between = ["ground.d", "rocker.d"] }
[initial]
"crank.angle"   = { guess = "20 deg" }
"coupler.angle" = { guess = "-10 deg" }
"rocker.angle"  = { guess = "170 deg" }
"#;

/// Stretched towards each other, bars of 0.1, 0.25 and 0.15 m leave 0.5 m of 1 m open.
#[test]
fn the_gap_of_the_best_attempt_is_drawn_and_as_long_as_it_must_be() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), THREE_BARS).unwrap();
    for name in ["a.svg", "a.png"] {
        let output = cotree(folder.path(), &["check", "a.toml", "--drawing", name]);
        assert_ne!(code(&output), 0);
        let said = stderr(&output);
        assert!(said.contains("assembly::open_loop") && said.contains("the best attempt"), "{said}");
        assert!(folder.path().join(name).is_file());
    }
    let picture = std::fs::read_to_string(folder.path().join("a.svg")).unwrap();
    assert_eq!(picture.matches("class=\"gap\"").count(), 1, "{picture}");
    assert!(picture.contains("gap of 500 mm"), "{picture}");
}

#[test]
fn what_closes_is_drawn_without_a_gap_and_what_is_no_loop_is_not_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let closes = THREE_BARS.replace("\"1 m\"", "\"0.3 m\"").replace("{ guess = \"20 deg\" }", "\"60 deg\"");
    std::fs::write(folder.path().join("a.toml"), closes.replace("-10 deg", "10 deg").replace("170 deg", "110 deg"))
        .unwrap();
    let output = cotree(folder.path(), &["check", "a.toml", "--drawing", "a.svg"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let picture = std::fs::read_to_string(folder.path().join("a.svg")).unwrap();
    assert!(!picture.contains("class=\"gap\"") && picture.contains("coupler"));
    std::fs::write(folder.path().join("b.toml"), THREE_BARS.replace("mass = 1", "mess = 1")).unwrap();
    let output = cotree(folder.path(), &["check", "b.toml", "--drawing", "b.svg"]);
    assert!(code(&output) != 0 && stderr(&output).contains("`b.svg` is not written"), "{}", stderr(&output));
    assert!(!folder.path().join("b.svg").exists());
}

/// A leaf that slides with its foot in a rail and hangs on an arm: straight up its eye is all but at the end of the arm, and the pose is folded.
const LEAF: &str = r#"
name = "leaf"
ground.points = { rail = [0, 0], arm = ["120 mm", "1.6 m"] }
[bodies]
leaf = { mass = 30, inertia = 9, points = { foot = [0, 0], eye = [0, "1.13 m"] } }
arm  = { mass = 3, inertia = 0.1, points = { pivot = [0, 0], end = [0, "-0.5 m"] } }
[joints]
rail  = { type = "slot", between = ["ground.rail", "leaf.foot"], axis = [0, 1] }
pivot = { type = "revolute", between = ["ground.arm", "arm.pivot"] }
pin   = { type = "revolute", between = ["arm.end", "leaf.eye"] }
[initial]
"rail.s" = "START"
[outputs]
variables = ["leaf.angle", "arm.angle"]
"#;

/// The eye is on the circle of the arm's end at 4.584 and at -13.271 degrees of the leaf, found by bisection.
#[test]
fn a_start_within_reach_of_a_folded_pose_is_found() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), LEAF.replace("START", "20 mm")).unwrap();
    let output = cotree(folder.path(), &["simulate", "a.toml", "--stop", "0", "--units", "deg"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = command::stdout(&output);
    let row: Vec<f64> = text.lines().nth(1).unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    let poses = [[4.584_349_838_447, -24.874_636_109_078], [-13.270_829_741_826, 16.188_156_205_699]];
    let is = |pose: &[f64; 2]| (row[1] - pose[0]).abs() < 1e-6 && (row[2] - pose[1]).abs() < 1e-6;
    assert!(poses.iter().any(is), "{text}");
}

/// Its foot is never 3 m below the arm: the search says that it has found nothing, and what it has found is drawn.
#[test]
fn a_start_out_of_reach_was_not_found_and_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), LEAF.replace("START", "-1.5 m")).unwrap();
    let output = cotree(folder.path(), &["check", "a.toml", "--drawing", "a.svg"]);
    let said = stderr(&output);
    assert!(code(&output) == 1 && said.contains("no configuration was found with `rail.s` = -1500 mm"), "{said}");
    assert!(std::fs::read_to_string(folder.path().join("a.svg")).unwrap().contains("leaf"));
}

#[test]
fn a_pose_that_is_not_the_guessed_one_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let closes = THREE_BARS.replace("\"1 m\"", "\"0.3 m\"").replace("{ guess = \"20 deg\" }", "\"60 deg\"");
    let turned = closes.replace("-10 deg", "100 deg").replace("170 deg", "10 deg");
    std::fs::write(folder.path().join("a.toml"), turned).unwrap();
    let output = cotree(folder.path(), &["check", "a.toml", "--drawing", "a.svg"]);
    let said = stderr(&output);
    assert!(said.contains("assembly::other_branch") && said.contains("the configuration that was found"), "{said}");
    let picture = std::fs::read_to_string(folder.path().join("a.svg")).unwrap();
    assert!(picture.contains("coupler") && !picture.contains("class=\"gap\""));
}
