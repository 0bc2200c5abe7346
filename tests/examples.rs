//! The examples do what their pages say.

use crate::outside::python;
use crate::support::ROOT;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

const REQUIREMENTS: &str = include_str!("../examples/requirements.txt");

/// One environment for all examples, made once.
static ENVIRONMENT: LazyLock<Option<(PathBuf, PathBuf)>> = LazyLock::new(|| {
    // Neither Ray, which is large, nor cotree's package, which takes long to build, is needed by what is run here.
    let needed = REQUIREMENTS.lines().filter(|line| !line.starts_with(['#', '.']) && !line.starts_with("ray="));
    python::python("examples", &needed.collect::<Vec<_>>().join("\n"))
});

fn root() -> &'static Path {
    Path::new(ROOT)
}

/// Exports a scene into a folder of its own for one test.
fn export(scene: &str, folder: &Path) -> PathBuf {
    let scene = root().join(scene);
    std::fs::create_dir_all(folder).unwrap();
    let stem = match scene.file_stem().unwrap().to_str().unwrap() {
        "scene" => scene.parent().unwrap().file_name().unwrap().to_str().unwrap().to_owned(),
        stem => stem.to_owned(),
    };
    let fmu = folder.join(format!("{stem}.fmu"));
    python::run(Command::new(env!("CARGO_BIN_EXE_cotree")).arg("export").arg(scene).arg("-o").arg(&fmu)).unwrap();
    fmu
}

/// Runs a script with these arguments: what it prints.
fn script(python: &Path, script: &str, arguments: &[&Path]) -> String {
    python::run(Command::new(python).arg(root().join(script)).args(arguments))
        .unwrap_or_else(|report| panic!("{report}"))
}

/// Each line of a table is on a page, its numbers to two digits.
fn says(page: &str, table: &str) {
    let page = std::fs::read_to_string(root().join(page)).unwrap();
    let same = |left: &str, right: &str| match (left.parse::<f64>(), right.parse::<f64>()) {
        (Ok(left), Ok(right)) => (left - right).abs() <= 0.05 * left.abs(),
        _ => left == right,
    };
    for line in table.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let found = page.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
        let mut found = found.filter(|other| other.len() == words.len());
        assert!(
            found.any(|other| words.iter().zip(other).all(|(left, right)| same(left, right))),
            "no page has\n{line}"
        );
    }
}

/// The numbers of a line.
fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().map(|word| word.parse().unwrap()).collect()
}

/// Who installs the packages that the page names can run all examples.
#[test]
fn all_packages_that_examples_import_are_named() {
    let named: Vec<&str> = REQUIREMENTS.lines().map(|line| line.split(['=', '[']).next().unwrap_or_default()).collect();
    let mut scripts = Vec::new();
    for folder in ["examples", "examples/coupled", "examples/many"] {
        let files = std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        scripts.extend(files.filter(|path| path.extension().is_some_and(|extension| extension == "py")));
    }
    for package in ["fmpy", "numpy", "dask", "ezdxf", "ray", "cotree"] {
        let imports = [format!("import {package}\n"), format!("from {package}"), format!("import {package} as")];
        let used = scripts.iter().any(|path| {
            let text = std::fs::read_to_string(path).unwrap();
            imports.iter().any(|line| text.contains(line))
        });
        let line = if package == "cotree" { "." } else { package };
        assert!(used && named.contains(&line), "{package}");
    }
}

#[test]
fn run_prints_a_table() {
    let Some((work, python)) = &*ENVIRONMENT else { return };
    let fmu = export("models/slider_crank/scene.toml", &work.join("run"));
    let table = script(python, "examples/run.py", &[&fmu, Path::new("crank_length=0.4")]);
    let rows: Vec<Vec<f64>> = table.lines().skip(1).take(11).map(numbers).collect();
    assert_eq!((rows[0][0], rows[10][0]), (0.0, 10.0), "{table}");
    let stroke = 0.4 * 0.6f64.cos() + (1.5f64.powi(2) - (0.4 * 0.6f64.sin()).powi(2)).sqrt();
    assert!((rows[0][3] - stroke).abs() < 1e-5, "{table}");
    assert!(table.lines().last().unwrap().contains("plot: "), "{table}");
}

#[test]
fn run_names_what_can_be_set() {
    let Some((work, python)) = &*ENVIRONMENT else { return };
    let fmu = export("models/slider_crank/scene.toml", &work.join("names"));
    let error =
        python::run(Command::new(python).arg(root().join("examples/run.py")).arg(fmu).arg("rod=1")).unwrap_err();
    assert!(error.contains("cannot set rod; there are crank_length, "), "{error}");
}

#[test]
fn what_goes_wrong_is_told_in_a_line() {
    let Some((work, python)) = &*ENVIRONMENT else { return };
    let fmu = export("models/slider_crank/scene.toml", &work.join("wrong"));
    let fmu = fmu.to_str().unwrap();
    let cases: [(&[&str], &str); 11] = [
        (&["from_dxf.py"], "usage: from_dxf.py"),
        (&["from_dxf.py", "missing.dxf", "never.toml"], "missing.dxf"),
        (&["run.py", fmu, "crank_length=5"], "crank.angle"),
        (&["run.py", fmu, "crank_length=long"], "NAME=NUMBER"),
        (&["run.py", "missing.fmu"], "missing.fmu"),
        (&["run.py", "Cargo.toml"], "not a zip file"),
        (&["run.py"], "usage: run.py"),
        (&["sweep.py", "missing.fmu"], "missing.fmu"),
        (&["coupled/couple.py", "missing"], "missing"),
        (&["coupled/loop.py", "missing"], "missing"),
        (&["coupled/ssp.py", "missing"], "usage: ssp.py"),
    ];
    for (arguments, message) in cases {
        let mut command = Command::new(python);
        command.current_dir(root()).arg(root().join("examples").join(arguments[0])).args(&arguments[1..]);
        let output = command.output().unwrap();
        let told = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {told}");
        assert!(told.contains(message) && !told.contains("Traceback"), "{arguments:?}: {told}");
    }
}

#[test]
fn coupled_fmus_converge_to_the_undivided_mechanism() {
    let Some((work, python)) = &*ENVIRONMENT else { return };
    let work = work.join("coupled");
    for name in ["crank", "load", "whole"] {
        export(&format!("examples/coupled/{name}.toml"), &work);
    }
    let table = script(python, "examples/coupled/couple.py", &[&work]);
    let rows: Vec<Vec<f64>> = table.lines().skip(1).map(numbers).collect();
    assert_eq!(rows.len(), 3, "{table}");
    for pair in rows.windows(2) {
        let order = |column: usize| (pair[0][column] / pair[1][column]).ln() / (pair[0][0] / pair[1][0]).ln();
        for column in [1, 2] {
            assert!((0.9..1.2).contains(&order(column)), "at once and Gauss-Seidel are of first order:\n{table}");
        }
        for column in [3, 4] {
            assert!((1.9..2.1).contains(&order(column)), "extrapolated and iterated are of second order:\n{table}");
        }
    }
    says("docs/coupling.md", &table);
    let ssp = work.join("both.ssp");
    script(python, "examples/coupled/ssp.py", &[&work, &ssp]);
    script(python, "tests/fmpy/ssp.py", &[&work.join("whole.fmu"), &ssp]);
}

#[test]
fn a_loop_is_closed_by_newton_whatever_the_masses() {
    let Some((work, python)) = &*ENVIRONMENT else { return };
    let work = work.join("loop");
    for name in ["cart", "rider"] {
        export(&format!("examples/coupled/{name}.toml"), &work);
    }
    let table = script(python, "examples/coupled/loop.py", &[&work]);
    says("docs/coupling.md", &table);
}

#[test]
fn a_sweep_gives_the_stroke_of_every_crank() {
    let Some((work, python)) = &*ENVIRONMENT else { return };
    let fmu = export("models/slider_crank/scene.toml", &work.join("sweep"));
    let table = script(python, "examples/sweep.py", &[&fmu, Path::new("2"), Path::new("2")]);
    assert!(table.contains("4/4 runs"), "{table}");
    let rows: Vec<Vec<f64>> = table.lines().skip(2).take(2).map(numbers).collect();
    assert_eq!((rows[0][0], rows[1][0]), (0.3, 0.6), "{table}");
    for row in rows {
        // The crank turns around: the stroke is its diameter, up to the distance between communication points.
        assert!(row[1..].iter().all(|stroke| (stroke - 2.0 * row[0]).abs() < 2e-3), "{table}");
    }
}

/// The pose of a linkage, drawn and read again: as many bodies and joints, and its loops close in that pose.
#[test]
fn a_drawing_becomes_a_scene_that_closes_in_its_pose() {
    let Some((work, python)) = &*ENVIRONMENT else { return };
    let work = work.join("dxf");
    std::fs::create_dir_all(&work).unwrap();
    let cotree = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cotree"));
        python::run(command.current_dir(&work).args(arguments)).unwrap_or_else(|report| panic!("{report}"))
    };
    for name in ["four_bar", "jansen"] {
        let scene = root().join("models").join(name).join("scene.toml");
        cotree(&["show", scene.to_str().unwrap(), "--drawing", "pose.dxf"]);
        script(python, "examples/from_dxf.py", &[&work.join("pose.dxf"), &work.join("again.toml")]);
        let json =
            |scene: &str| -> serde_json::Value { serde_json::from_str(&cotree(&["show", scene, "--json"])).unwrap() };
        let (drawn, again) = (json(scene.to_str().unwrap()), json("again.toml"));
        for part in ["bodies", "joints"] {
            let count = |scene: &serde_json::Value| scene[part].as_array().map(Vec::len);
            assert!(count(&drawn) > Some(2) && count(&drawn) == count(&again), "{name}: {part}");
        }
        // It starts in the pose of the drawing: no body has turned.
        let table = cotree(&["simulate", "again.toml", "--stop", "0"]);
        let angles: Vec<f64> = table.lines().nth(1).unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
        assert!(angles.len() > 3 && angles.iter().all(|angle| angle.abs() < 1e-6), "{name}: {table}");
    }
}
