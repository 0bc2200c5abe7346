//! Communication steps, times and tolerances.

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Error, fmi2OK};
use cotree_fmu::fmi2::types::*;

use super::super::fmu::*;

// SAFETY of all calls: the component is alive, and arrays are as long as announced.

pub(super) fn no_steps(fmu: &Fmu) {
    let slave = fmu.started();
    assert_eq!([slave.step(0.0, 0.0), slave.step(0.0, -0.01)], [fmi2Error; 2]);
    slave.run(0..1);
}

pub(super) fn nan_steps(fmu: &Fmu) {
    let slave = fmu.started();
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!([slave.step(odd, 0.01), slave.step(0.0, odd)], [fmi2Error; 2]);
    }
    slave.run(0..1);
}

pub(super) fn far_steps(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..2);
    assert_eq!([slave.step(36_000.0, 0.01), slave.step(-36_000.0, 0.01)], [fmi2Error; 2]);
}

pub(super) fn stop_time(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.setup(0.0, Some(1.0), None), slave.enter(), slave.exit()], [fmi2OK; 3]);
    let mut t = 0.0;
    for _ in 0..10 {
        assert_eq!(slave.step(t, 0.1), fmi2OK);
        t += 0.1;
    }
    assert_eq!(slave.step(t, 0.1), fmi2Error);
    let open = fmu.started();
    assert_eq!([open.step(0.0, 0.5), open.step(0.5, 5.0)], [fmi2OK; 2], "no stop time, no limit");
}

pub(super) fn last_time(slave: &Slave) -> f64 {
    let mut time = f64::NAN;
    assert_eq!(unsafe { (slave.fmi().get_real_status)(slave.c, fmi2LastSuccessfulTime, &mut time) }, fmi2OK);
    time
}

pub(super) fn start_time(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.setup(2.5, None, None), slave.enter(), slave.exit()], [fmi2OK; 3]);
    assert_eq!([slave.step(2.5, 0.25), slave.step(2.75, 0.25)], [fmi2OK; 2]);
    assert_eq!(last_time(&slave), 3.0);
}

pub(super) fn wrong_first_step(fmu: &Fmu) {
    assert_eq!(fmu.started().step(18_000.0, 0.01), fmi2Error);
}

pub(super) fn variable_steps(fmu: &Fmu) {
    let slave = fmu.started();
    let mut t = 0.0;
    for h in [0.04, 0.02, 0.01, 0.08, 1e-6, 0.3] {
        assert_eq!(slave.step(t, h), fmi2OK);
        t += h;
    }
    let other = fmu.started();
    assert_eq!(other.step(0.0, t), fmi2OK);
    for (a, b) in slave.read(&fmu.of_causality("output")).into_iter().zip(other.read(&fmu.of_causality("output"))) {
        assert!((a - b).abs() <= 1e-4 * a.abs().max(1.0), "{a} and {b}");
    }
}

pub(super) fn determinism(fmu: &Fmu) {
    let run = |fixed: fmi2Boolean| {
        let slave = fmu.started();
        for step in 0..50 {
            let t = f64::from(step) * 0.01;
            assert_eq!(unsafe { (slave.fmi().do_step)(slave.c, t, 0.01, fixed) }, fmi2OK);
        }
        slave.all()
    };
    assert!(run(0) == run(0) && run(0) == run(1));
}

pub(super) fn accumulated(fmu: &Fmu) {
    let slave = fmu.started();
    let mut t = 0.0;
    for _ in 0..1000 {
        assert_eq!(slave.step(t, 0.0007), fmi2OK, "{:?}", slave.log());
        t += 0.0007;
    }
    assert!((last_time(&slave) - t).abs() < 1e-12);
}

pub(super) fn tolerances(fmu: &Fmu) {
    for tolerance in [1e-3, 1e-10, 1e-16, 10.0] {
        let slave = fmu.slave();
        assert_eq!([slave.setup(0.0, None, Some(tolerance)), slave.enter(), slave.exit()], [fmi2OK; 3]);
        slave.run(0..10);
    }
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(fmu.slave().setup(0.0, None, Some(tolerance)), fmi2Error);
    }
}

pub(super) fn stop_before_start(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.setup(1.0, Some(0.5), None), slave.setup(f64::NAN, None, None)], [fmi2Error; 2]);
    slave.start();
}
