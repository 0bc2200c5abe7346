//! Getting and setting variables.

use std::ptr::{null, null_mut};

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Discard, fmi2Error, fmi2OK};

use super::super::fmu::*;
use super::nothing;

// SAFETY of all calls: the component is alive, and arrays are as long as announced.

pub(super) const UNKNOWN: u32 = 1_000_000;

pub(super) fn unknown_references(fmu: &Fmu) {
    let slave = fmu.started();
    assert_eq!((slave.get(UNKNOWN), slave.put(UNKNOWN, 1.0)), (Err(fmi2Error), fmi2Error));
    other_types(&slave, UNKNOWN);
    slave.run(0..2);
}

/// Get and set of every other type are refused.
fn other_types(slave: &Slave, reference: u32) {
    let (fmi, c) = (slave.fmi(), slave.c);
    let (mut integer, mut text) = (0, null());
    let known = c"text".as_ptr();
    let found = unsafe {
        [
            (fmi.get_integer)(c, &reference, 1, &mut integer),
            (fmi.get_boolean)(c, &reference, 1, &mut integer),
            (fmi.get_string)(c, &reference, 1, &mut text),
            (fmi.set_integer)(c, &reference, 1, &integer),
            (fmi.set_boolean)(c, &reference, 1, &integer),
            (fmi.set_string)(c, &reference, 1, &known),
        ]
    };
    assert_eq!(found, [fmi2Error; 6]);
}

pub(super) fn wrong_type(fmu: &Fmu) {
    let slave = fmu.started();
    fmu.references(|_| true).into_iter().for_each(|reference| other_types(&slave, reference));
    slave.run(0..2);
}

pub(super) fn empty_arrays(fmu: &Fmu) {
    let slave = fmu.started();
    let (fmi, c) = (slave.fmi(), slave.c);
    let found = unsafe {
        [
            (fmi.get_real)(c, null(), 0, null_mut()),
            (fmi.get_integer)(c, null(), 0, null_mut()),
            (fmi.get_boolean)(c, null(), 0, null_mut()),
            (fmi.get_string)(c, null(), 0, null_mut()),
            (fmi.set_real)(c, null(), 0, null()),
            (fmi.set_integer)(c, null(), 0, null()),
            (fmi.set_boolean)(c, null(), 0, null()),
            (fmi.set_string)(c, null(), 0, null()),
            (fmi.set_input_derivatives)(c, null(), 0, null(), null()),
            (fmi.get_output_derivatives)(c, null(), 0, null(), null_mut()),
            (fmi.directional_derivative)(c, null(), 0, null(), 0, null(), null_mut()),
        ]
    };
    assert_eq!(found, [fmi2OK; 11]);
}

pub(super) fn missing_arrays(fmu: &Fmu) {
    let slave = fmu.started();
    let (fmi, c, reference, mut value) = (slave.fmi(), slave.c, fmu.of_causality("output")[0], 0.0);
    let found = unsafe {
        [
            (fmi.get_real)(c, null(), 1, &mut value),
            (fmi.get_real)(c, &reference, 1, null_mut()),
            (fmi.set_real)(c, null(), 1, &value),
            (fmi.set_real)(c, &reference, 1, null()),
            (fmi.get_integer)(c, null(), 1, null_mut()),
            (fmi.set_string)(c, &reference, 1, null()),
            (fmi.set_input_derivatives)(c, &reference, 1, null(), null()),
            (fmi.get_output_derivatives)(c, &reference, 1, null(), &mut value),
            (fmi.directional_derivative)(c, &reference, 1, null(), 1, &value, &mut value),
            (fmi.get_state)(c, null_mut()),
            (fmi.set_state)(c, null_mut()),
            (fmi.serialize)(c, null_mut(), null_mut(), 0),
            (fmi.deserialize)(c, null(), 10, null_mut()),
        ]
    };
    assert_eq!(found, [fmi2Error; 13]);
    slave.run(0..2);
}

fn is_calculated(variable: &Variable) -> bool {
    matches!(variable.causality.as_str(), "output" | "local" | "independent" | "calculatedParameter")
        && variable.start.is_none()
}

pub(super) fn set_calculated(fmu: &Fmu) {
    let slave = fmu.slave();
    let calculated = fmu.references(is_calculated);
    let refused = || calculated.iter().for_each(|&reference| assert_eq!(slave.put(reference, 0.1), fmi2Error));
    refused();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    refused();
    assert_eq!(slave.exit(), fmi2OK);
    refused();
}

pub(super) fn fixed_late(fmu: &Fmu) {
    if nothing(&fmu.parameters("fixed"), "fixed parameter") {
        return;
    }
    let slave = fmu.started();
    for fixed in fmu.parameters("fixed") {
        assert_eq!(slave.put(fixed, fmu.other(fixed)), fmi2Error);
        assert_eq!(slave.get(fixed), Ok(fmu.default(fixed)));
    }
}

pub(super) fn initial_late(fmu: &Fmu) {
    let slave = fmu.started();
    let before = slave.all();
    for known in fmu.references(|variable| variable.causality != "input" && variable.variability == "continuous") {
        assert_eq!(slave.put(known, 0.1), fmi2Error);
    }
    assert_eq!(slave.all(), before);
}

pub(super) fn tunable(fmu: &Fmu) {
    if nothing(&fmu.parameters("tunable"), "tunable parameter") {
        return;
    }
    let slave = fmu.started();
    slave.run(0..2);
    for tunable in fmu.parameters("tunable") {
        let value = fmu.other(tunable);
        assert_eq!((slave.put(tunable, value), slave.get(tunable)), (fmi2OK, Ok(value)));
    }
    slave.run(2..4);
}

pub(super) fn fixed_early(fmu: &Fmu) {
    if nothing(&fmu.parameters("fixed"), "fixed parameter") {
        return;
    }
    let slave = fmu.slave();
    for fixed in fmu.parameters("fixed") {
        assert_eq!(slave.put(fixed, fmu.other(fixed)), fmi2OK);
    }
    slave.start();
    for fixed in fmu.parameters("fixed") {
        assert_eq!(slave.get(fixed), Ok(fmu.other(fixed)));
    }
    assert_ne!(
        slave.read(&fmu.of_causality("output")),
        fmu.started().read(&fmu.of_causality("output")),
        "parameters count"
    );
}

pub(super) fn start_values(fmu: &Fmu) {
    let slave = fmu.started();
    for variable in &fmu.variables {
        let exact = variable.initial.as_deref() == Some("exact");
        if let Some(start) = variable.start.filter(|_| exact || variable.causality == "input") {
            let found = slave.get(variable.reference).expect("readable");
            assert_eq!(found.to_bits(), start.to_bits(), "{}: {found} for {start}", variable.name);
        }
    }
    other_starts(fmu);
}

/// What is set before initialization holds to the last bit, wherever the mechanism can be assembled with it.
fn other_starts(fmu: &Fmu) {
    let known =
        |variable: &&Variable| variable.initial.as_deref() == Some("exact") && variable.causality != "parameter";
    for variable in fmu.variables.iter().filter(known) {
        for change in [1e-3, 1.0 / 3.0, 80.0] {
            let slave = fmu.slave();
            let value = variable.start.expect("required") + change;
            assert_eq!([slave.setup(0.0, None, None), slave.put(variable.reference, value)], [fmi2OK; 2]);
            assert_eq!(slave.enter(), fmi2OK);
            if slave.exit() == fmi2OK {
                let found = slave.get(variable.reference).expect("readable");
                assert_eq!(found.to_bits(), value.to_bits(), "{}: {found} for {value}", variable.name);
            }
        }
    }
}

pub(super) fn inputs(fmu: &Fmu) {
    if nothing(&fmu.inputs(), "input") {
        return;
    }
    let slave = fmu.slave();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    let check = |value: f64| {
        for input in fmu.inputs() {
            assert_eq!((slave.put(input, value), slave.get(input)), (fmi2OK, Ok(value)));
        }
    };
    check(0.25);
    assert_eq!(slave.exit(), fmi2OK);
    check(0.5);
    assert_eq!(slave.step(0.0, 0.01), fmi2OK);
    check(-0.5);
    assert_eq!(slave.step(0.01, 0.01), fmi2OK);
}

pub(super) fn outputs_early(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    let before = slave.read(&fmu.of_causality("output"));
    assert_eq!(slave.exit(), fmi2OK);
    assert_eq!(before, slave.read(&fmu.of_causality("output")));
}

pub(super) fn read_all(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..3);
    let mut references = fmu.references(|_| true);
    let values = slave.read(&references);
    assert_eq!(values, slave.read(&references));
    references.extend(references.clone());
    assert_eq!([values.clone(), values].concat(), slave.read(&references));
}

pub(super) fn nan_values(fmu: &Fmu) {
    if nothing(&[fmu.inputs(), fmu.parameters("tunable")].concat(), "input and no tunable parameter") {
        return;
    }
    let slave = fmu.started();
    for reference in fmu.inputs().into_iter().chain(fmu.parameters("tunable")) {
        let before = slave.get(reference);
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!((slave.put(reference, value), slave.get(reference)), (fmi2Error, before));
        }
        // A number, but an absurd one: any answer, no hang.
        slave.put(reference, 1e300);
    }
    let _ = slave.step(0.0, 0.01);
    assert_eq!(slave.reset(), fmi2OK);
}

pub(super) fn out_of_range(fmu: &Fmu) {
    if nothing(&fmu.references(|variable| variable.min.or(variable.max).is_some()), "limit of a variable") {
        return;
    }
    let slave = fmu.slave();
    for variable in &fmu.variables {
        let beyond = [variable.min.map(|min| min - 1.0), variable.max.map(|max| max + 1.0)];
        for value in beyond.into_iter().flatten() {
            assert_eq!(slave.put(variable.reference, value), fmi2Discard);
        }
    }
    slave.start();
}

pub(super) fn strings(fmu: &Fmu) {
    assert!(fmu.below("/ScalarVariable/String").is_empty(), "there are none");
    assert_eq!(unsafe { (fmu.library.get_string)(fmu.started().c, null(), 0, null_mut()) }, fmi2OK);
}

pub(super) fn impossible_initial(fmu: &Fmu) {
    let slave = fmu.slave();
    let knowns = fmu.references(|variable| variable.start.is_some() && variable.initial.as_deref() == Some("exact"));
    let knowns = knowns.into_iter().filter(|&known| fmu.variable(known).causality != "parameter");
    for known in knowns {
        let value = fmu.other(known);
        assert_eq!(slave.put(known, value), fmi2OK);
        slave.start();
        let found = slave.get(known).expect("readable");
        assert!((found - value).abs() < 1e-9, "{}: {found} for {value}", fmu.variable(known).name);
        assert_eq!(slave.put(known, f64::NAN), fmi2Error);
        assert_eq!(slave.reset(), fmi2OK);
    }
    slave.start();
    slave.run(0..2);
}
