//! Several libraries in one process, and damaged ones.

use fmi_rs::fmi2::CS;
use fmi_rs::fmi2::types::fmi2Status::Error;

use super::Outcome::{self, Passed};
use super::instantiation::elsewhere;
use crate::fmu::*;

pub(super) fn second_library(fmu: &Fmu) -> Outcome {
    let (_kept, folder) = elsewhere(fmu, "another");
    let expected = fmu.started().run(0..20);
    let other = fmu.make(&Arguments { folder: Some(folder), ..Arguments::default() }).expect("instantiates");
    other.start();
    let first = fmu.started();
    for step in 0..20 {
        let wanted = &expected[step as usize..=step as usize];
        assert!(first.run(step..step + 1) == wanted && other.run(step..step + 1) == wanted);
    }
    Passed
}

pub(super) fn damaged_resources(fmu: &Fmu) -> Outcome {
    let (_kept, folder) = elsewhere(fmu, "copy");
    let file = folder.join("resources/program.bin");
    let whole = std::fs::read(&file).expect("a program");
    let with = Arguments { folder: Some(folder), ..Arguments::default() };
    let refused = |bytes: &[u8]| {
        std::fs::write(&file, bytes).expect("a file");
        assert!(fmu.make(&with).is_err());
    };
    for place in (0..whole.len()).step_by(whole.len() / 60 + 1) {
        let mut changed = whole.clone();
        changed[place] ^= 0x24;
        refused(&changed);
        refused(&whole[..place]);
    }
    refused(&[&whole[..], b"more"].concat());
    std::fs::remove_file(&file).expect("a file");
    assert!(fmu.make(&with).is_err());
    fmu.started();
    Passed
}

/// In turns with an instance of each other model, each from its own library.
pub(super) fn another_model(fmu: &Fmu) -> Outcome {
    let beside = std::fs::read_dir(fmu.folder.parent().expect("models beside it")).expect("a folder");
    let folders = beside.map(|entry| entry.expect("an entry").path());
    let folders = folders.filter(|path| path.join("modelDescription.xml").is_file() && *path != fmu.folder);
    let others: Vec<Fmu> = folders.map(|folder| Fmu::open(&folder)).collect();
    assert!(!others.is_empty());
    let expected = fmu.started().run(0..20);
    let slave = fmu.started();
    let strangers: Vec<Instance<CS>> = others.iter().map(Fmu::started).collect();
    for step in 0..20 {
        strangers.iter().for_each(|stranger| drop(stranger.run(step..step + 1)));
        assert!(slave.run(step..step + 1) == expected[step as usize..=step as usize]);
    }
    let state = strangers[0].save();
    assert_eq!(slave.deserialize(&strangers[0].bytes(state)), Err(Error));
    strangers[0].free(state);
    Passed
}

/// What fmi-rs itself finds wrong with the description.
pub(super) fn description(fmu: &Fmu) -> Outcome {
    let problems: Vec<String> = fmu.description.validate().into_iter().map(|problem| problem.message).collect();
    assert!(problems.is_empty(), "{problems:?}");
    Passed
}
