//! Communication steps, times and tolerances.

use fmi_rs::fmi2::types::fmi2Status::{Error, Ok as OK};
use fmi_rs::fmi2::types::{fmi2Boolean, fmi2False, fmi2True};

use super::Outcome::{self, Passed};
use crate::fmu::*;

pub(super) fn no_steps(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    assert_eq!([slave.step(0.0, 0.0), slave.step(0.0, -0.01)], [Error; 2]);
    slave.run(0..1);
    Passed
}

pub(super) fn nan_steps(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!([slave.step(odd, 0.01), slave.step(0.0, odd)], [Error; 2]);
    }
    slave.run(0..1);
    Passed
}

pub(super) fn far_steps(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..2);
    assert_eq!([slave.step(36_000.0, 0.01), slave.step(-36_000.0, 0.01)], [Error; 2]);
    Passed
}

pub(super) fn stop_time(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    slave.start_with(None, 0.0, Some(1.0));
    let mut time = 0.0;
    for _ in 0..10 {
        assert_eq!(slave.step(time, 0.1), OK);
        time += 0.1;
    }
    assert_eq!(slave.step(time, 0.1), Error);
    let open = fmu.started();
    assert_eq!([open.step(0.0, 0.5), open.step(0.5, 5.0)], [OK; 2], "no stop time, no limit");
    Passed
}

pub(super) fn start_time(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    slave.start_with(None, 2.5, None);
    assert_eq!([slave.step(2.5, 0.25), slave.step(2.75, 0.25)], [OK; 2]);
    assert_eq!(slave.last_time(), 3.0);
    Passed
}

pub(super) fn wrong_first_step(fmu: &Fmu) -> Outcome {
    assert_eq!(fmu.started().step(18_000.0, 0.01), Error);
    Passed
}

pub(super) fn variable_steps(fmu: &Fmu) -> Outcome {
    let (slave, mut time) = (fmu.started(), 0.0);
    for step in [0.04, 0.02, 0.01, 0.08, 1e-6, 0.3] {
        assert_eq!(slave.step(time, step), OK);
        time += step;
    }
    let (other, outputs) = (fmu.started(), fmu.outputs());
    assert_eq!(other.step(0.0, time), OK);
    agree(fmu, &outputs, &slave.read(&outputs), &other.read(&outputs), 1e-4);
    Passed
}

pub(super) fn determinism(fmu: &Fmu) -> Outcome {
    let run = |fixed: fmi2Boolean| {
        let slave = fmu.started();
        (0..50).for_each(|step| assert_eq!(slave.raw.doStep(f64::from(step) * 0.01, 0.01, fixed), OK));
        slave.all()
    };
    assert!(run(fmi2False) == run(fmi2False) && run(fmi2False) == run(fmi2True));
    Passed
}

pub(super) fn accumulated(fmu: &Fmu) -> Outcome {
    let (slave, mut time) = (fmu.started(), 0.0);
    for _ in 0..1000 {
        assert_eq!(slave.step(time, 0.0007), OK, "{:?}", slave.messages());
        time += 0.0007;
    }
    assert!((slave.last_time() - time).abs() < 1e-12);
    Passed
}

pub(super) fn tolerances(fmu: &Fmu) -> Outcome {
    for tolerance in [1e-3, 1e-10, 1e-16, 10.0] {
        let slave = fmu.slave();
        slave.start_with(Some(tolerance), 0.0, None);
        slave.run(0..10);
    }
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(fmu.slave().raw.setupExperiment(Some(tolerance), 0.0, None), Error);
    }
    Passed
}

pub(super) fn stop_before_start(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    let setup = |start, stop| slave.raw.setupExperiment(None, start, stop);
    assert_eq!([setup(1.0, Some(0.5)), setup(f64::NAN, None)], [Error; 2]);
    slave.start();
    Passed
}
