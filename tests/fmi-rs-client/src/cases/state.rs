//! Saved and serialised states.

use std::process::Command;
use std::ptr::null_mut;

use fmi_rs::fmi2::types::fmi2Status::{Error, Ok as OK};

use super::Outcome::{self, Passed};
use crate::fmu::*;

pub(super) fn saved_state(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..13);
    let state = slave.save();
    let expected = slave.run(13..40);
    for _ in 0..2 {
        assert_eq!(slave.raw.setFMUstate(state), OK);
        assert_eq!(slave.run(13..40), expected);
    }
    assert_eq!(fmu.started().run(0..40)[13..], expected, "saving changes nothing");
    slave.free(state);
    Passed
}

pub(super) fn reused_state(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    let (mut first, second) = (slave.save(), slave.save());
    let place = first;
    slave.run(0..3);
    assert_eq!((slave.raw.getFMUstate(&mut first), first), (OK, place));
    slave.free(second);
    let expected = slave.run(3..6);
    assert_eq!(slave.raw.setFMUstate(first), OK);
    assert_eq!(slave.run(3..6), expected);
    slave.free(first);
    assert_eq!([slave.raw.freeFMUstate(&mut null_mut()), slave.raw.freeFMUstate(null_mut())], [OK; 2]);
    Passed
}

pub(super) fn whole_state(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    assert_eq!([slave.setup(), slave.raw.enterInitializationMode()], [OK; 2]);
    let early = slave.save();
    assert_eq!(slave.raw.exitInitializationMode(), OK);
    slave.run(0..3);
    let late = slave.save();
    let (values, time) = (slave.all(), slave.last_time());
    for reference in fmu.inputs().into_iter().chain(fmu.tunable()) {
        assert_eq!(slave.put(reference, fmu.other(reference)), OK);
    }
    assert_eq!([slave.step(0.03, 0.01), slave.raw.terminate(), slave.raw.setFMUstate(late)], [OK; 3]);
    assert_eq!((slave.all(), slave.last_time()), (values, time));
    assert_eq!([slave.raw.setFMUstate(early), slave.step(0.0, 0.01)], [OK, Error], "initialization mode is back");
    assert_eq!(slave.raw.exitInitializationMode(), OK);
    [early, late].into_iter().for_each(|state| slave.free(state));
    Passed
}

pub(super) fn serialised(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..13);
    let state = slave.save();
    let bytes = slave.bytes(state);
    let expected = slave.run(13..40);
    let other = fmu.slave();
    let copy = other.deserialize(&bytes).expect("own bytes");
    assert_eq!(other.bytes(copy), bytes);
    assert_eq!(other.raw.setFMUstate(copy), OK);
    assert_eq!(other.run(13..40), expected);
    slave.free(state);
    other.free(copy);
    Passed
}

pub(super) fn damaged(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    let state = slave.save();
    let mut bytes = slave.bytes(state);
    let mut small = vec![0; bytes.len() - 1];
    assert_eq!([slave.raw.serializeFMUstate(state, &mut small), slave.raw.setFMUstate(null_mut())], [Error; 2]);
    for place in 0..bytes.len() {
        assert_eq!(slave.deserialize(&bytes[..place]), Err(Error));
        for bit in [1, 0x10] {
            bytes[place] ^= bit;
            assert_eq!(slave.deserialize(&bytes), Err(Error), "byte {place}");
            bytes[place] ^= bit;
        }
    }
    slave.free(state);
    slave.run(0..2);
    Passed
}

/// Names the file with a state, in the process that writes it.
const STATE: &str = "FMI_RS_CLIENT_STATE";

pub(super) fn state_from_file(fmu: &Fmu) -> Outcome {
    if let Some(file) = std::env::var_os(STATE) {
        let slave = fmu.started();
        slave.run(0..13);
        std::fs::write(file, slave.bytes(slave.save())).expect("a file");
        return Passed;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("state.bin");
    let mut other = Command::new(std::env::current_exe().expect("a program"));
    let written = other.arg("case").arg(&fmu.folder).arg("X02").env(STATE, &file).output().expect("a process");
    assert!(written.status.success());
    let slave = fmu.slave();
    let state = slave.deserialize(&std::fs::read(&file).expect("a file")).expect("own bytes");
    assert_eq!(slave.raw.setFMUstate(state), OK);
    assert_eq!(slave.run(13..40), fmu.started().run(0..40)[13..]);
    slave.free(state);
    Passed
}
