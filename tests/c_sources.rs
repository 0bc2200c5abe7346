//! The C sources for real-time targets: they compile without a warning, keep to their rules, and move as the runtime does.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::ROOT;

const WARNINGS: [&str; 7] =
    ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-Wdouble-promotion"];

fn cotree(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cotree")).args(arguments).output().unwrap()
}

fn scene(model: &str) -> PathBuf {
    Path::new(ROOT).join("models").join(model).join("scene.toml")
}

/// The sources of a scene, in a folder; or why there are none.
fn sources(scene: &Path, folder: &Path, step: &str) -> Result<PathBuf, String> {
    let file = folder.join("model.c");
    let output = cotree(&["export", scene.to_str().unwrap(), "--c", file.to_str().unwrap(), "--step", step]);
    if output.status.success() { Ok(file) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}

/// Compiles with all warnings, as C and as C++.
fn compile(file: &Path) {
    let folder = file.parent().unwrap();
    let object = folder.join("model.o");
    let mut gcc = Command::new("gcc");
    gcc.args(WARNINGS).args(["-O1", "-c", "-o"]).arg(&object).arg(file);
    let mut gpp = Command::new("g++");
    gpp.args(["-x", "c++", "-std=c++11", "-pedantic", "-Wall", "-Wextra", "-Werror", "-c", "-o"])
        .arg(&object)
        .arg(file);
    for command in [&mut gcc, &mut gpp] {
        let output = match command.output() {
            // A machine with gcc alone; .ci/run installs it.
            Err(error) if error.kind() == ErrorKind::NotFound && command.get_program() == "g++" => {
                println!("skipped: g++ is not installed");
                continue;
            }
            output => output.unwrap(),
        };
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

/// The values at the end of so many steps, or the message of the step that failed.
fn run(file: &Path, coordinates: usize, steps: u32) -> Result<Vec<f64>, String> {
    let program = file.with_extension("run");
    let own = Path::new(ROOT).join("tests/c_sources/run.c");
    let name = format!("-DMODEL_FILE=\"{}\"", file.display());
    let output = Command::new("gcc")
        .args(["-std=c99", "-O1", &name, &format!("-DCOORDINATES={coordinates}"), "-o"])
        .arg(&program)
        .arg(own)
        .arg("-lm")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = Command::new(program).arg(steps.to_string()).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if !output.status.success() {
        return Err(text);
    }
    Ok(text.split_whitespace().map(|value| value.parse().unwrap()).collect())
}

/// Coordinates after two seconds by the runtime, in their order: each value, then its rate.
fn reference(scene: &Path, variables: &str) -> Vec<f64> {
    let scene = scene.to_str().unwrap();
    let limits = ["--stop", "2 s", "--step", "2 s", "--tolerance", "1e-11"];
    let output = cotree(&[&["simulate", scene, "--variables", variables][..], &limits].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.lines().last().unwrap().split(',').skip(1).map(|value| value.parse().unwrap()).collect()
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()))
}

fn error(model: &str, variables: &str, step: &str, steps: u32) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let file = sources(&scene(model), folder.path(), step).unwrap();
    let end = run(&file, variables.split(',').count() / 2, steps).unwrap();
    largest(&end, &reference(&scene(model), variables))
}

#[test]
fn the_error_at_a_millisecond_is_small_and_of_fourth_order() {
    let cases = [
        ("bench_slider_crank", "crank.angle,crank.omega,rod.angle,rod.omega", 1e-6),
        ("cart_pole", "rail.s,rail.v,pole.angle,pole.omega", 1e-9),
    ];
    for (model, variables, most) in cases {
        let found = error(model, variables, "1 ms", 2000);
        assert!(found <= most, "{model}: {found:e}");
        let halved = error(model, variables, "0.5 ms", 4000);
        assert!((10.0..=30.0).contains(&(found / halved)), "{model}: {found:e} {halved:e}");
    }
}

#[test]
fn sources_keep_to_their_rules_and_compile_without_warnings() {
    for model in ["four_bar", "motor_four_bar", "vibration", "klann", "metronome"] {
        let folder = tempfile::tempdir().unwrap();
        let Ok(file) = sources(&scene(model), folder.path(), "1 ms") else { panic!("{model} is refused") };
        check_text(&fs::read_to_string(&file).unwrap());
        compile(&file);
    }
}

fn check_text(text: &str) {
    for word in ["malloc", "calloc", "goto", "setjmp", "while (", "<stdlib", "<stdio", "alloca("] {
        assert!(!text.contains(word), "`{word}`");
    }
    assert!(text.lines().filter(|line| line.starts_with("#include")).eq(["#include <math.h>"]));
}

#[test]
fn what_presses_and_steps_that_are_too_long_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let refused = sources(&scene("end_stop"), folder.path(), "1 ms").unwrap_err();
    assert!(refused.contains("unilateral constraint") && refused.contains("scene.toml:"), "{refused}");
    // Another inductance: a pole a hundred times faster.
    let text = fs::read_to_string(scene("motor_four_bar")).unwrap();
    let line = text.lines().find(|line| line.trim_start().starts_with("inductance")).unwrap();
    let stiff = folder.path().join("stiff.toml");
    fs::write(&stiff, text.replace(line, "inductance = \"0.02 mH\"")).unwrap();
    let refused = sources(&stiff, folder.path(), "1 ms").unwrap_err();
    assert!(refused.contains("too long for `motor.current`") && refused.contains("--substeps"), "{refused}");
}

/// A parallelogram that turns evenly and ends a step on its dead point: there its loop does not determine the rates.
const PARALLELOGRAM: &str = r#"
name = "parallelogram"
gravity = [0, 0]
[ground.points]
left = [0, 0]
right = [0.7, 0]
[bodies.front]
mass = 2
inertia = 0.05
points = { foot = [0, 0], head = [0.3, 0] }
[bodies.rear]
mass = 2
inertia = 0.05
points = { foot = [0, 0], head = [0.3, 0] }
[bodies.bridge]
mass = 1
inertia = 0.02
points = { one = [0, 0], two = [0.7, 0] }
[joints.first]
type = "revolute"
between = ["ground.left", "front.foot"]
[joints.second]
type = "revolute"
between = ["front.head", "bridge.one"]
[joints.third]
type = "revolute"
between = ["bridge.two", "rear.head"]
[joints.fourth]
type = "revolute"
between = ["ground.right", "rear.foot"]
[initial]
"front.angle" = -0.4
"front.omega" = 2
"rear.angle" = { guess = -0.4 }
"bridge.angle" = { guess = 0 }
[experiment]
stop = "1 s"
step = "1 ms"
"#;

/// How far from evenly it has turned 0.21 s later, or what failed.
fn turned(begin: f64) -> Result<f64, String> {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("parallelogram.toml");
    fs::write(&scene, PARALLELOGRAM.replace("-0.4", &format!("{begin:?}"))).unwrap();
    let file = sources(&scene, folder.path(), "1 ms").unwrap();
    let end = run(&file, 3, 210)?;
    Ok(largest(&end, &[begin + 0.42, 2.0, begin + 0.42, 2.0, 0.0, 0.0]))
}

#[test]
fn a_step_that_ends_on_a_dead_point_is_right_or_an_error() {
    let ends = [-0.1, -0.2, -0.3, -0.4, -0.36, -1.0].map(turned);
    for end in &ends {
        match end {
            Ok(apart) => assert!(*apart < 1e-9, "{ends:?}"),
            Err(failed) => assert!(failed.contains("dead point"), "{ends:?}"),
        }
    }
    assert!(ends[5].is_ok(), "nothing is singular there: {ends:?}");
}

#[test]
#[ignore = "all models: .ci/nightly"]
fn every_model_has_sources_or_is_refused_by_name() {
    let mut accepted = 0;
    let mut models: Vec<PathBuf> =
        fs::read_dir(Path::new(ROOT).join("models")).unwrap().map(|own| own.unwrap().path()).collect();
    models.sort();
    for model in models.iter().filter(|model| model.join("scene.toml").is_file()) {
        let folder = tempfile::tempdir().unwrap();
        match sources(&model.join("scene.toml"), folder.path(), "0.1 ms") {
            Ok(file) => {
                check_text(&fs::read_to_string(&file).unwrap());
                compile(&file);
                accepted += 1;
            }
            Err(refused) => assert!(refused.contains("export::sources") && refused.contains('`'), "{refused}"),
        }
    }
    println!("{accepted} of {} accepted", models.len());
}
