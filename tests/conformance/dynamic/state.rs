//! Saved and serialised states.

use std::ptr::null_mut;

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Error, fmi2OK};

use super::super::fmu::*;
use super::stepping::last_time;

// SAFETY of all calls: the component is alive, and arrays are as long as announced.

pub(super) fn saved_state(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..13);
    let state = slave.save();
    let expected = slave.run(13..40);
    for _ in 0..100 {
        assert_eq!(slave.restore(state), fmi2OK);
        assert_eq!(slave.run(13..40), expected);
    }
    assert_eq!(fmu.started().run(0..40)[13..], expected, "saving changes nothing");
    slave.free(state);
}

pub(super) fn reused_state(fmu: &Fmu) {
    let slave = fmu.started();
    let (mut first, second) = (slave.save(), slave.save());
    let place = first;
    slave.run(0..3);
    assert_eq!(unsafe { (slave.fmi().get_state)(slave.c, &mut first) }, fmi2OK);
    assert_eq!(first, place);
    slave.free(second);
    let expected = slave.run(3..6);
    assert_eq!(slave.restore(first), fmi2OK);
    assert_eq!(slave.run(3..6), expected);
    slave.free(first);
    let mut nothing = null_mut();
    assert_eq!(unsafe { (slave.fmi().free_state)(slave.c, &mut nothing) }, fmi2OK);
    assert_eq!(unsafe { (slave.fmi().free_state)(slave.c, null_mut()) }, fmi2OK);
}

pub(super) fn whole_state(fmu: &Fmu) {
    let settable: Vec<u32> = fmu.inputs().into_iter().chain(fmu.parameters("tunable")).collect();
    let slave = fmu.slave();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    let early = slave.save();
    assert_eq!(slave.exit(), fmi2OK);
    slave.run(0..3);
    let late = slave.save();
    let (values, time) = (slave.all(), last_time(&slave));
    settable.iter().for_each(|&reference| assert_eq!(slave.put(reference, fmu.other(reference)), fmi2OK));
    assert_eq!(slave.step(0.03, 0.01), fmi2OK);
    assert_eq!(slave.terminate(), fmi2OK);
    assert_eq!(slave.restore(late), fmi2OK);
    assert_eq!((slave.all(), last_time(&slave)), (values, time));
    assert_eq!(slave.restore(early), fmi2OK);
    assert_eq!(slave.step(0.0, 0.01), fmi2Error, "initialization mode is back");
    assert_eq!(slave.exit(), fmi2OK);
    [early, late].into_iter().for_each(|state| slave.free(state));
}

pub(super) fn serialised(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..13);
    let state = slave.save();
    let bytes = slave.bytes(state);
    let expected = slave.run(13..40);
    let other = fmu.slave();
    let copy = other.deserialize(&bytes).expect("own bytes");
    assert_eq!(other.bytes(copy), bytes);
    assert_eq!(other.restore(copy), fmi2OK);
    assert_eq!(other.run(13..40), expected);
    slave.free(state);
    other.free(copy);
}

pub(super) fn damaged(fmu: &Fmu) {
    let slave = fmu.started();
    let state = slave.save();
    let mut bytes = slave.bytes(state);
    let room = bytes.len() - 1;
    let mut small = vec![0; room];
    assert_eq!(unsafe { (slave.fmi().serialize)(slave.c, state, small.as_mut_ptr(), room) }, fmi2Error);
    for length in 0..bytes.len() {
        assert_eq!(slave.deserialize(&bytes[..length]), Err(fmi2Error));
    }
    for place in 0..bytes.len() {
        for bit in [1, 0x10] {
            bytes[place] ^= bit;
            assert_eq!(slave.deserialize(&bytes), Err(fmi2Error), "byte {place}");
            bytes[place] ^= bit;
        }
    }
    slave.free(state);
    slave.run(0..2);
}

/// The first process writes a state and where it leads; the one that finds them goes on from there.
pub(super) fn state_from_file(fmu: &Fmu) {
    let file = fmu.folder.join("state.bin");
    let slave = fmu.slave();
    if let Ok(bytes) = std::fs::read(&file) {
        let bytes: Vec<i8> = bytes.into_iter().map(|byte| byte as i8).collect();
        let (expected, bytes) = bytes.split_at(8 * fmu.variables.len());
        let state = slave.deserialize(bytes).expect("own bytes");
        assert_eq!(slave.restore(state), fmi2OK);
        let found = slave.run(13..40).pop().expect("steps");
        assert!(found.iter().flat_map(|bits| bits.to_le_bytes()).eq(expected.iter().map(|&byte| byte as u8)));
        return slave.free(state);
    }
    slave.start();
    slave.run(0..13);
    let state = slave.save();
    let bytes = slave.bytes(state);
    let last = slave.run(13..40).pop().expect("steps");
    let all: Vec<u8> =
        last.iter().flat_map(|bits| bits.to_le_bytes()).chain(bytes.into_iter().map(|byte| byte as u8)).collect();
    std::fs::write(&file, all).expect("a file");
    slave.free(state);
    super::super::respawn();
}
