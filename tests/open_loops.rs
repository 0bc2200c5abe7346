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
    assert_ne!(code(&cotree(folder.path(), &["check", "b.toml", "--drawing", "b.svg"])), 0);
    assert!(!folder.path().join("b.svg").exists());
}
