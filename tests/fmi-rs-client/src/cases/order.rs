//! The state machine: what may be called when.

use fmi_rs::fmi2::types::fmi2Status::{Error, Ok as OK};

use super::Outcome::{self, Passed};
use crate::fmu::*;

pub(super) fn before_initialization(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    assert_eq!([slave.step(0.0, 0.1), slave.raw.exitInitializationMode(), slave.raw.terminate()], [Error; 3]);
    assert_eq!(slave.get(fmu.outputs()[0]), Err(Error));
    Passed
}

pub(super) fn no_experiment(fmu: &Fmu) -> Outcome {
    assert_eq!(fmu.slave().raw.enterInitializationMode(), Error);
    Passed
}

pub(super) fn during_initialization(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    assert_eq!([slave.setup(), slave.raw.enterInitializationMode()], [OK; 2]);
    let refused = [slave.raw.enterInitializationMode(), slave.setup(), slave.step(0.0, 0.1), slave.raw.terminate()];
    assert_eq!(refused, [Error; 4]);
    assert_eq!(slave.raw.exitInitializationMode(), OK);
    Passed
}

pub(super) fn while_stepping(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    let refused = [slave.raw.enterInitializationMode(), slave.raw.exitInitializationMode(), slave.setup()];
    assert_eq!(refused, [Error; 3]);
    slave.run(0..2);
    Passed
}

pub(super) fn after_termination(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..2);
    assert_eq!([slave.raw.terminate(), slave.step(0.02, 0.01), slave.raw.terminate()], [OK, Error, Error]);
    for settable in fmu.inputs().into_iter().chain(fmu.tunable()) {
        assert_eq!(slave.put(settable, 1.0), Error);
    }
    Passed
}

pub(super) fn final_values(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    let last = slave.run(0..5).pop();
    assert_eq!(slave.raw.terminate(), OK);
    assert_eq!(Some(slave.all()), last);
    Passed
}

pub(super) fn reset_is_fresh(fmu: &Fmu) -> Outcome {
    let fresh = fmu.started().run(0..30);
    let slave = fmu.slave();
    let check = || {
        assert_eq!(slave.raw.reset(), OK);
        slave.start();
        assert_eq!(slave.run(0..30), fresh);
    };
    check();
    check();
    assert_eq!([slave.raw.reset(), slave.setup(), slave.raw.enterInitializationMode()], [OK; 3]);
    check();
    assert_eq!(slave.raw.terminate(), OK);
    check();
    Passed
}

pub(super) fn reset_restores(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    let settable = || fmu.inputs().into_iter().chain(fmu.tunable()).chain(fmu.fixed());
    settable().for_each(|reference| assert_eq!(slave.put(reference, fmu.other(reference)), OK));
    assert_eq!([slave.raw.reset(), slave.raw.enterInitializationMode()], [OK, Error]);
    slave.start();
    settable().for_each(|reference| assert_eq!(slave.get(reference), Ok(fmu.default(reference))));
    Passed
}

pub(super) fn reset_after_error(fmu: &Fmu) -> Outcome {
    let fresh = fmu.started().run(0..10);
    let slave = fmu.started();
    slave.run(0..3);
    assert_eq!([slave.step(77.0, 0.1), slave.raw.reset()], [Error, OK]);
    slave.start();
    assert_eq!(slave.run(0..10), fresh);
    Passed
}
