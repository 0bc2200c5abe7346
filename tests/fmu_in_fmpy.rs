//! Every model's FMU, in an independent importer: fmpy, in a private Python environment under `target/`.

use crate::outside::python;
use crate::support::ROOT;

use std::path::Path;
use std::process::Command;

const REQUIREMENTS: &str = include_str!("fmpy/requirements.txt");

#[test]
fn every_model_runs_in_fmpy() {
    let Some((work, python)) = python::python("fmpy", REQUIREMENTS) else { return };
    let root = Path::new(ROOT);
    let mut check = Command::new(python);
    check.arg(root.join("tests/fmpy/check.py")).arg(env!("CARGO_BIN_EXE_cotree"));
    check.arg(root.join("models")).arg(&work);
    match python::run(&mut check) {
        Ok(report) => println!("{report}"),
        Err(report) => panic!("{report}"),
    }
}

#[test]
fn odd_scenes_behave_in_fmpy_as_worked_out_by_hand() {
    let Some((work, python)) = python::python("fmpy", REQUIREMENTS) else { return };
    let root = Path::new(ROOT);
    let mut check = Command::new(python);
    check.arg(root.join("tests/fmpy/odd.py")).arg(env!("CARGO_BIN_EXE_cotree")).arg(work);
    match python::run(&mut check) {
        Ok(report) => println!("{report}"),
        Err(report) => panic!("{report}"),
    }
}

#[test]
fn events_in_model_exchange_are_those_of_the_log() {
    let Some((work, python)) = python::python("fmpy", REQUIREMENTS) else { return };
    let root = Path::new(ROOT);
    let mut check = Command::new(python);
    check.arg(root.join("tests/fmpy/events.py")).arg(env!("CARGO_BIN_EXE_cotree"));
    check.arg(root.join("models")).arg(work);
    match python::run(&mut check) {
        Ok(report) => println!("{report}"),
        Err(report) => panic!("{report}"),
    }
}

#[test]
fn loops_are_closed_at_few_events_in_model_exchange() {
    let Some((work, python)) = python::python("fmpy", REQUIREMENTS) else { return };
    let root = Path::new(ROOT);
    let mut check = Command::new(python);
    check.arg(root.join("tests/fmpy/drift.py")).arg(env!("CARGO_BIN_EXE_cotree"));
    check.arg(root.join("models")).arg(work);
    match python::run(&mut check) {
        Ok(report) => println!("{report}"),
        Err(report) => panic!("{report}"),
    }
}

#[test]
fn sources_that_are_compiled_move_as_the_full_solver_does() {
    let Some((work, python)) = python::python("fmpy", REQUIREMENTS) else { return };
    let root = Path::new(ROOT);
    let mut check = Command::new(python);
    check.arg(root.join("tests/fmpy/sources.py")).arg(env!("CARGO_BIN_EXE_cotree"));
    check.arg(root.join("models")).arg(work);
    match python::run(&mut check) {
        Ok(report) => println!("{report}"),
        Err(report) => panic!("{report}"),
    }
}
