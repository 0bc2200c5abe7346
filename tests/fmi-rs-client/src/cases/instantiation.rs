//! Loading and freeing.

use std::path::{Path, PathBuf};

use fmi_rs::fmi2::types::fmi2Status::{Error, Ok as OK};

use super::Outcome::{self, Passed};
use crate::fmu::*;

pub(super) fn platform(fmu: &Fmu) -> Outcome {
    let raw = fmu.slave().raw;
    assert_eq!((raw.getTypesPlatform(), raw.getVersion()), ("default".to_owned(), "2.0".to_owned()));
    Passed
}

pub(super) fn located(fmu: &Fmu) -> Outcome {
    fmu.started();
    Passed
}

/// An FMU in a folder with that name.
pub(super) fn elsewhere(fmu: &Fmu, name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let copy = folder.path().join(name);
    copy_all(&fmu.folder, &copy);
    (folder, copy)
}

fn copy_all(from: &Path, to: &Path) {
    std::fs::create_dir(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let (from, to) = entry.map(|entry| (entry.path(), to.join(entry.file_name()))).expect("an entry");
        if from.is_dir() { copy_all(&from, &to) } else { assert!(std::fs::copy(from, to).is_ok()) }
    }
}

pub(super) fn escapes(fmu: &Fmu) -> Outcome {
    let (_kept, folder) = elsewhere(fmu, "a b é%");
    fmu.make(&Arguments { folder: Some(folder), ..Arguments::default() }).expect("instantiates").start();
    Passed
}

/// Without a folder of resources fmi-rs passes a null pointer.
pub(super) fn no_location(fmu: &Fmu) -> Outcome {
    let (_kept, folder) = elsewhere(fmu, "copy");
    std::fs::remove_dir_all(folder.join("resources")).expect("a folder");
    assert!(fmu.make(&Arguments { folder: Some(folder), ..Arguments::default() }).is_err());
    Passed
}

pub(super) fn wrong_guid(fmu: &Fmu) -> Outcome {
    assert!(fmu.make(&Arguments { guid: Some("{1}"), ..Arguments::default() }).is_err());
    Passed
}

pub(super) fn missing_strings(fmu: &Fmu) -> Outcome {
    assert!(fmu.make(&Arguments { name: "", ..Arguments::default() }).is_err());
    assert!(fmu.make(&Arguments { guid: Some(""), ..Arguments::default() }).is_err());
    Passed
}

pub(super) fn wrong_interface(fmu: &Fmu) -> Outcome {
    assert_eq!(fmu.exchange().is_ok(), fmu.description.modelExchange.is_some());
    Passed
}

/// fmi-rs frees the strings and the structure as soon as the instance is there.
pub(super) fn transient_arguments(fmu: &Fmu) -> Outcome {
    let slave = fmu.make(&Arguments { memory: false, ..Arguments::default() }).expect("instantiates");
    assert_eq!(slave.raw.terminate(), Error);
    assert_eq!(slave.messages().len(), 1);
    slave.start();
    Passed
}

pub(super) fn free_anywhere(fmu: &Fmu) -> Outcome {
    drop(fmu.slave());
    let slave = fmu.slave();
    assert_eq!([slave.setup(), slave.raw.enterInitializationMode()], [OK; 2]);
    drop(slave);
    drop(fmu.started());
    let slave = fmu.started();
    slave.run(0..3);
    assert_eq!(slave.raw.terminate(), OK);
    Passed
}
