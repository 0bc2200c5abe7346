//! An output that has no value at one instant is missing there, with one warning; the rest of what was asked for is given.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use cotree_study::bench::measure_watched;

use crate::support::run::{compiled, model};

/// It falls from rest: at t = 0 the quotient has no value. x = 0.5 g t^2 and omega = g t with g = 2.
const FALLING: &str = r#"
format = 1
name = "falling"
gravity = [2, 0]
[parameters]
gain = 3.0
[bodies.block]
mass = 1.5
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[initial]
"block.x" = 0
"block.vx" = 0
[inputs]
push = 0
[loads.thrust]
type = "force"
on = "block"
vector = ["push", 0]
[outputs]
variables = ["block.vx"]
share = { value = "gain*block.x/block.vx" }
[experiment]
stop = 1.0
step = 0.25
"#;

fn cotree(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cotree")).current_dir(folder).args(arguments).output().expect("runs")
}

fn texts(output: &Output) -> [String; 2] {
    [&output.stdout, &output.stderr].map(|bytes| String::from_utf8(bytes.clone()).expect("UTF-8"))
}

#[test]
fn derivatives_of_it_are_empty_cells_there() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("falling.toml"), FALLING).expect("written");
    let output = cotree(folder.path(), &["simulate", "falling.toml", "--sensitivity", "gain"]);
    let [table, said] = texts(&output);
    assert!(output.status.success(), "{said}");
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 5, "{table}");
    // time, block.vx, share, their derivatives by gain
    assert_eq!((rows[0][2], rows[0][4]), ("", ""), "{table}");
    for row in &rows[1..] {
        let numbers: Vec<f64> = row.iter().map(|cell| cell.parse().expect("a number")).collect();
        // share = gain t/2
        assert!(
            (numbers[2] - 1.5 * numbers[0]).abs() < 1e-6 && (numbers[4] - 0.5 * numbers[0]).abs() < 1e-6,
            "{table}"
        );
    }
    assert!(said.contains("`share` has no value at t = 0 s (1 of 5 rows)"), "{said}");
}

#[test]
fn a_fit_leaves_such_rows_out_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("falling.toml"), FALLING).expect("written");
    // Of gain = 4; what stands at the start is no measure of anything.
    fs::write(folder.path().join("seen.csv"), "time,share\n0,17\n0.25,0.5\n0.5,1.0\n0.75,1.5\n1.0,2.0\n")
        .expect("written");
    let output = cotree(folder.path(), &["fit", "falling.toml", "--to", "seen.csv", "--vary", "gain"]);
    let [table, said] = texts(&output);
    assert!(output.status.success(), "{table}{said}");
    assert!(table.contains("1 of 5 rows are left out, the first at t = 0 s"), "{table}");
    let line = table.lines().find(|line| line.trim_start().starts_with("gain")).expect("a line of `gain`");
    let value: f64 = line.split_whitespace().nth(1).expect("a value").parse().expect("a number");
    assert!((value - 4.0).abs() < 1e-5, "{table}");
    fs::write(folder.path().join("few.csv"), "time,share\n0,17\n0.25,0.5\n").expect("written");
    let output = cotree(folder.path(), &["fit", "falling.toml", "--to", "few.csv", "--vary", "gain"]);
    let [_, said] = texts(&output);
    assert!(said.contains("1 measured values cannot determine 1 quantities"), "{said}");
    assert!(said.contains("1 of 2 rows are left out"), "{said}");
}

#[test]
fn a_linear_system_is_given_without_it() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("falling.toml"), FALLING).expect("written");
    let output = cotree(folder.path(), &["linearize", "falling.toml", "--json"]);
    let [text, said] = texts(&output);
    assert!(output.status.success(), "{said}");
    let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(found["A"], serde_json::json!([[0.0, 1.0], [0.0, 0.0]]), "{text}");
    assert_eq!(found["outputs"][1]["value"], serde_json::Value::Null, "{text}");
    assert!(said.contains("`share` has no value at t = 0 s"), "{said}");
}

#[test]
fn what_an_output_that_is_not_asked_for_uses_is_used() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("falling.toml"), FALLING).expect("written");
    let arguments = ["simulate", "falling.toml", "--sensitivity", "push", "--variables", "block.vx"];
    let output = cotree(folder.path(), &arguments);
    let [_, said] = texts(&output);
    assert!(output.status.success() && !said.contains("nothing uses"), "{said}");
}

#[test]
fn measuring_is_watched_and_can_be_stopped() {
    let (model, compiled) = (model(FALLING), compiled(FALLING));
    let mut seen = Vec::new();
    let experiment = compiled.description.experiment;
    let variable = compiled.description.reported()[..1].to_vec();
    let bench = measure_watched(&model, &variable, experiment, &mut |next| {
        seen.push((next.done, next.all));
        next.done < 3
    });
    let bench = bench.expect("a reference");
    assert_eq!(bench.runs.len(), 3);
    let all = seen[0].1;
    assert!(all > 10 && seen == [(0, all), (1, all), (2, all), (3, all)], "{seen:?}");
}
