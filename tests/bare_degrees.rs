//! Angles without a unit that look like degrees, and lengths that are too large for metres, are warned of wherever they are read: in tasks, in columns of CSV files, in laws that read tables.

use crate::outside::command;

use command::{code, cotree, stderr};

const ARM: &str = r#"
name = "arm"
gravity = [0, 0]
[inputs]
wanted = { unit = "rad", start = 0 }
[bodies.arm]
mass = 1.0
inertia = 0.1
[joints.hinge]
type = "revolute"
between = ["ground", "arm"]
[experiment]
stop = 0.1
"#;

/// What a command says about files, on standard error.
fn said(files: &[(&str, &str)], arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
    let output = cotree(folder.path(), arguments);
    assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
    stderr(&output)
}

/// The text with degrees is warned of once, the same with units is not.
fn is_warned_of(bare: &[(&str, &str)], units: &[(&str, &str)], arguments: &[&str]) {
    let found = said(bare, arguments);
    assert_eq!(found.matches("scene::degrees").count(), 1, "{found}");
    let other = said(units, arguments);
    assert!(!other.contains("scene::degrees"), "{other}");
}

#[test]
fn poses_of_a_task_are_warned_of() {
    let task = |angles: [&str; 3]| {
        let [a, b, c] = angles;
        format!("[poses]\nat = [[0, 0, {a}], [0.12, 0.05, {b}], [0.2, 0.15, {c}]]\n")
    };
    let (bare, units) = (task(["0", "25", "50"]), task(["0", "\"25 deg\"", "\"50 deg\""]));
    is_warned_of(&[("task.toml", &bare)], &[("task.toml", &units)], &["synthesize", "task.toml"]);
    let task = "[poses]\nat = \"poses.csv\"\n";
    let rows = "0,0,0\n0.12,0.05,21\n0.2,0.15,43\n";
    let (bare, units) = (format!("x,y,angle\n{rows}"), format!("x,y,angle [deg]\n{rows}"));
    let files = |rows| [("task.toml", task), ("poses.csv", rows)];
    is_warned_of(&files(&bare), &files(&units), &["synthesize", "task.toml"]);
}

#[test]
fn columns_of_inputs_and_tables_are_warned_of() {
    let files = |heading: &str| format!("time,{heading}\n0,0\n0.05,45\n0.1,90\n");
    let (bare, units) = (files("wanted"), files("wanted [deg]"));
    let with = |rows| [("arm.toml", ARM), ("in.csv", rows)];
    is_warned_of(&with(&bare), &with(&units), &["simulate", "arm.toml", "--input", "in.csv"]);
    let (bare, units) = (files("angle"), files("angle [deg]"));
    let driven = format!("{ARM}[drivers.motor]\njoint = \"hinge\"\nangle = 'spline(\"turn.csv\", t)'\n");
    let with = |rows| [("arm.toml", &driven[..]), ("turn.csv", rows)];
    is_warned_of(&with(&bare), &with(&units), &["check", "arm.toml"]);
}

/// Lengths of more than 10 without a unit, once for all of a scene, and for each key of a task.
#[test]
fn lengths_that_are_too_large_for_metres_are_warned_of() {
    let warned = |bare: &[(&str, &str)], units: &[(&str, &str)], arguments: &[&str]| {
        let found = said(bare, arguments);
        assert_eq!(found.matches("scene::metres").count(), 1, "{found}");
        assert!(found.contains("mm\"` for millimetres") || found.contains("[mm]` in the first line"), "{found}");
        let other = said(units, arguments);
        assert!(!other.contains("scene::metres"), "{other}");
    };
    let scene = |a: &str, b: &str| {
        ARM.replace("inertia = 0.1", &format!("inertia = 0.1\npoints = {{ a = [{a}, 0], b = [{b}, 0] }}"))
    };
    let (bare, units) = (scene("120", "-80"), scene("\"120 m\"", "\"-80 mm\""));
    warned(&[("arm.toml", &bare)], &[("arm.toml", &units)], &["check", "arm.toml"]);
    let task = |x: [&str; 2]| format!("[poses]\nat = [[0, 0, 0], [{}, 0.05, 0.3], [{}, 0.15, 0.9]]\n", x[0], x[1]);
    let (bare, units) = (task(["120", "200"]), task(["\"120 mm\"", "\"200 mm\""]));
    warned(&[("task.toml", &bare)], &[("task.toml", &units)], &["synthesize", "task.toml"]);
    let rows = "0,0,0\n120,0.05,0.3\n200,0.15,0.9\n";
    let (bare, units) = (format!("x,y,angle\n{rows}"), format!("x [mm],y,angle\n{rows}"));
    let files = |rows| [("task.toml", "[poses]\nat = \"poses.csv\"\n"), ("poses.csv", rows)];
    warned(&files(&bare), &files(&units), &["synthesize", "task.toml"]);
}
