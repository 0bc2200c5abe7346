//! Status and log.

use fmi_rs::fmi2::types::fmi2Status::{Discard, Error, Ok as OK};
use fmi_rs::fmi2::types::{fmi2False, fmi2StatusKind};

use super::Outcome::{self, Passed};
use super::values::UNKNOWN;
use crate::fmu::*;

/// All but `fmi2GetStatus`, for which fmi-rs has no method.
pub(super) fn status(fmu: &Fmu) -> Outcome {
    use fmi2StatusKind::{DoStepStatus, PendingStatus};
    let slave = fmu.started();
    slave.run(0..4);
    assert!((slave.last_time() - 0.04).abs() < 1e-12);
    let (raw, mut integer) = (&slave.raw, 0);
    let found = [
        raw.getRealStatus(&PendingStatus, &mut 0.0),
        raw.getIntegerStatus(&DoStepStatus, &mut integer),
        raw.getBooleanStatus(&DoStepStatus, &mut integer),
        raw.getStringStatus(&PendingStatus, &mut String::new()),
    ];
    assert_eq!(found, [Discard; 4]);
    assert_eq!(raw.cancelStep(), Error);
    Passed
}

pub(super) fn terminated_status(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..1);
    let mut terminated = 7;
    assert_eq!(slave.raw.getBooleanStatus(&fmi2StatusKind::Terminated, &mut terminated), OK);
    assert_eq!(terminated, fmi2False);
    Passed
}

pub(super) fn log_messages(fmu: &Fmu) -> Outcome {
    let slave = fmu.make(&Arguments { logging: true, ..Arguments::default() }).expect("instantiates");
    slave.start();
    slave.run(0..3);
    slave.put(UNKNOWN, 1.0);
    slave.step(9.0, 1.0);
    slave.raw.terminate();
    let log = slave.messages();
    assert!(log.len() >= 5, "{log:?}");
    let categories = &fmu.description.logCategories;
    for (status, category, message) in log {
        assert!(categories.iter().any(|known| known.name == category), "{category}");
        assert!(!message.is_empty() && !message.ends_with('\n'));
        assert_eq!(status == Error, category == "errors");
    }
    Passed
}

pub(super) fn log_silence(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    // Before the input jumps: of one that a driver follows that is a warning.
    slave.run(0..5);
    slave.raw.terminate();
    assert!(slave.messages().is_empty());
    Passed
}

/// fmi-rs formats messages as C does: a percent sign in a message must have been doubled.
pub(super) fn log_printf(fmu: &Fmu) -> Outcome {
    let slave = fmu.make(&Arguments { name: "%s%n%d #r1#", ..Arguments::default() }).expect("instantiates");
    slave.put(UNKNOWN, 1.0);
    slave.step(f64::NAN, 1.0);
    assert_eq!(slave.messages().len(), 2);
    Passed
}
