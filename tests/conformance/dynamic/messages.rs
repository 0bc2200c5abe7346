//! Status and log.

use std::ffi::CString;
use std::ptr::null;

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Discard, fmi2Error, fmi2OK, fmi2Warning};
use cotree_fmu::fmi2::types::*;

use super::super::fmu::*;
use super::stepping::last_time;
use super::values::UNKNOWN;

// SAFETY of all calls: the component is alive, and arrays are as long as announced.

pub(super) fn status(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..4);
    assert!((last_time(&slave) - 0.04).abs() < 1e-12);
    let (fmi, c) = (slave.fmi(), slave.c);
    let (mut real, mut integer, mut state, mut text) = (0.0, 0, fmi2OK, null());
    let found = unsafe {
        [
            (fmi.get_status)(c, fmi2DoStepStatus, &mut state),
            (fmi.get_real_status)(c, fmi2PendingStatus, &mut real),
            (fmi.get_integer_status)(c, fmi2DoStepStatus, &mut integer),
            (fmi.get_boolean_status)(c, fmi2DoStepStatus, &mut integer),
            (fmi.get_string_status)(c, fmi2PendingStatus, &mut text),
        ]
    };
    assert_eq!(found, [fmi2Discard; 5]);
    assert_eq!(unsafe { (fmi.cancel_step)(c) }, fmi2Error);
}

pub(super) fn terminated_status(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..1);
    let mut terminated = 7;
    assert_eq!(unsafe { (slave.fmi().get_boolean_status)(slave.c, fmi2Terminated, &mut terminated) }, fmi2OK);
    assert_eq!(terminated, fmi2False);
}

fn categories(fmu: &Fmu) -> Vec<String> {
    let tags = fmu.below("/LogCategories/Category");
    tags.into_iter().map(|tag| attribute(tag, "name").expect("required").to_owned()).collect()
}

pub(super) fn log_categories(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.debug(true, &[]), slave.debug(false, &[])], [fmi2OK; 2]);
    for category in categories(fmu) {
        let name = CString::new(category).expect("no zero");
        assert_eq!([slave.debug(true, &[&name]), slave.debug(false, &[&name])], [fmi2OK; 2]);
    }
    assert!([fmi2Error, fmi2Warning].contains(&slave.debug(true, &[c"no such category"])));
}

pub(super) fn log_messages(fmu: &Fmu) {
    let slave = fmu.instantiate(fmi2CoSimulation, &fmu.resources(), true).expect("instantiates");
    slave.start();
    slave.run(0..3);
    slave.put(UNKNOWN, 1.0);
    slave.step(9.0, 1.0);
    slave.terminate();
    let log = slave.log();
    assert!(log.len() >= 5, "{log:?}");
    for (instance, status, category, message) in log {
        assert_eq!(instance, "it's 100% # mine");
        assert!(categories(fmu).contains(&category) && !message.is_empty() && !message.ends_with('\n'));
        assert_eq!(status == fmi2Error, category == "errors");
    }
}

pub(super) fn log_silence(fmu: &Fmu) {
    let slave = fmu.started();
    // Before the input jumps: of one that a driver follows that is a warning.
    slave.run(0..5);
    slave.terminate();
    assert_eq!(slave.log(), []);
}

pub(super) fn log_printf(fmu: &Fmu) {
    let slave = fmu.started();
    slave.put(UNKNOWN, 1.0);
    slave.step(f64::NAN, 1.0);
    for (_, _, _, message) in slave.log() {
        assert!(!message.replace("%%", "").contains('%'), "{message}");
    }
}
