//! The state machine: what may be called when.

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Error, fmi2OK};

use super::super::fmu::*;

pub(super) fn before_initialization(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.step(0.0, 0.1), slave.exit(), slave.terminate()], [fmi2Error; 3]);
    assert_eq!(slave.get(fmu.of_causality("output")[0]), Err(fmi2Error));
}

pub(super) fn no_experiment(fmu: &Fmu) {
    assert_eq!(fmu.slave().enter(), fmi2Error);
}

pub(super) fn during_initialization(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    assert_eq!([slave.enter(), slave.setup(0.0, None, None), slave.step(0.0, 0.1), slave.terminate()], [fmi2Error; 4]);
    assert_eq!(slave.exit(), fmi2OK);
}

pub(super) fn while_stepping(fmu: &Fmu) {
    let slave = fmu.started();
    assert_eq!([slave.enter(), slave.exit(), slave.setup(0.0, None, None)], [fmi2Error; 3]);
    slave.run(0..2);
}

pub(super) fn after_termination(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..2);
    assert_eq!(slave.terminate(), fmi2OK);
    assert_eq!([slave.step(0.02, 0.01), slave.terminate()], [fmi2Error; 2]);
    for settable in fmu.inputs().into_iter().chain(fmu.parameters("tunable")) {
        assert_eq!(slave.put(settable, 1.0), fmi2Error);
    }
}

pub(super) fn final_values(fmu: &Fmu) {
    let slave = fmu.started();
    let last = slave.run(0..5).pop();
    assert_eq!(slave.terminate(), fmi2OK);
    assert_eq!(Some(slave.all()), last);
}

pub(super) fn reset_is_fresh(fmu: &Fmu) {
    let fresh = fmu.started().run(0..30);
    let slave = fmu.slave();
    let check = || {
        assert_eq!(slave.reset(), fmi2OK);
        slave.start();
        assert_eq!(slave.run(0..30), fresh);
    };
    // What is counted at an instant must not be counted over many lives.
    (0..100).for_each(|_| check());
    assert_eq!([slave.reset(), slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 3]);
    check();
    assert_eq!(slave.terminate(), fmi2OK);
    check();
}

pub(super) fn reset_restores(fmu: &Fmu) {
    let slave = fmu.slave();
    let settable = || fmu.inputs().into_iter().chain(fmu.parameters("tunable")).chain(fmu.parameters("fixed"));
    settable().for_each(|reference| assert_eq!(slave.put(reference, fmu.other(reference)), fmi2OK));
    assert_eq!([slave.reset(), slave.enter()], [fmi2OK, fmi2Error]);
    slave.start();
    settable().for_each(|reference| assert_eq!(slave.get(reference), Ok(fmu.default(reference))));
}

pub(super) fn reset_after_error(fmu: &Fmu) {
    let fresh = fmu.started().run(0..10);
    let slave = fmu.started();
    slave.run(0..3);
    assert_eq!(slave.step(77.0, 0.1), fmi2Error);
    assert_eq!(slave.reset(), fmi2OK);
    slave.start();
    assert_eq!(slave.run(0..10), fresh);
}
