//! Getting and setting variables.

use fmi_rs::fmi2::types::fmi2Status::{Discard, Error, Ok as OK};
use fmi_rs::model_description::fmi2::{Causality, Initial, ScalarVariable, Variability, VariableType};

use super::Outcome::{self, Nothing, Passed};
use crate::fmu::*;

pub(super) const UNKNOWN: u32 = 1_000_000;

pub(super) fn unknown_references(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    assert_eq!((slave.get(UNKNOWN), slave.put(UNKNOWN, 1.0)), (Err(Error), Error));
    slave.refuses_other_types(UNKNOWN);
    slave.run(0..2);
    Passed
}

pub(super) fn wrong_type(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    fmu.references(|_| true).into_iter().for_each(|reference| slave.refuses_other_types(reference));
    slave.run(0..2);
    Passed
}

pub(super) fn empty_arrays(fmu: &Fmu) -> Outcome {
    let raw = fmu.started().raw;
    let found = [
        raw.getReal(&[], &mut []),
        raw.getInteger(&[], &mut []),
        raw.getBoolean(&[], &mut []),
        raw.getString(&[], &mut []),
        raw.setReal(&[], &[]),
        raw.setInteger(&[], &[]),
        raw.setBoolean(&[], &[]),
        raw.setString(&[], &[]),
        raw.getDirectionalDerivative(&[], &[], &[], &mut []),
    ];
    assert_eq!(found, [OK; 9]);
    Passed
}

fn is_calculated(variable: &ScalarVariable) -> bool {
    use Causality::{CalculatedParameter, Independent, Local, Output};
    matches!(variable.causality, Output | Local | Independent | CalculatedParameter) && start(variable).is_none()
}

pub(super) fn set_calculated(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    let calculated = fmu.references(is_calculated);
    let refused = || calculated.iter().for_each(|&reference| assert_eq!(slave.put(reference, 0.1), Error));
    refused();
    assert_eq!([slave.setup(), slave.raw.enterInitializationMode()], [OK; 2]);
    refused();
    assert_eq!(slave.raw.exitInitializationMode(), OK);
    refused();
    Passed
}

pub(super) fn fixed_late(fmu: &Fmu) -> Outcome {
    if fmu.fixed().is_empty() {
        return Nothing("it has no fixed parameter");
    }
    let slave = fmu.started();
    for fixed in fmu.fixed() {
        assert_eq!(slave.put(fixed, fmu.other(fixed)), Error);
        assert_eq!(slave.get(fixed), Ok(fmu.default(fixed)));
    }
    Passed
}

pub(super) fn initial_late(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    let before = slave.all();
    for known in fmu.references(|one| one.causality != Causality::Input && one.variability == Variability::Continuous) {
        assert_eq!(slave.put(known, 0.1), Error);
    }
    assert_eq!(slave.all(), before);
    Passed
}

pub(super) fn tunable(fmu: &Fmu) -> Outcome {
    if fmu.tunable().is_empty() {
        return Nothing("it has no tunable parameter");
    }
    let slave = fmu.started();
    slave.run(0..2);
    for tunable in fmu.tunable() {
        let value = fmu.other(tunable);
        assert_eq!((slave.put(tunable, value), slave.get(tunable)), (OK, Ok(value)));
    }
    slave.run(2..4);
    Passed
}

pub(super) fn fixed_early(fmu: &Fmu) -> Outcome {
    if fmu.fixed().is_empty() {
        return Nothing("it has no fixed parameter");
    }
    let slave = fmu.slave();
    fmu.fixed().into_iter().for_each(|fixed| assert_eq!(slave.put(fixed, fmu.other(fixed)), OK));
    slave.start();
    fmu.fixed().into_iter().for_each(|fixed| assert_eq!(slave.get(fixed), Ok(fmu.other(fixed))));
    assert_ne!(slave.read(&fmu.outputs()), fmu.started().read(&fmu.outputs()), "parameters count");
    Passed
}

pub(super) fn start_values(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    for variable in &fmu.description.modelVariables {
        let given = variable.initial == Some(Initial::Exact) || variable.causality == Causality::Input;
        if let Some(start) = start(variable).filter(|_| given) {
            let found = slave.get(variable.valueReference).expect("readable");
            assert!((found - start).abs() <= 1e-12 * start.abs().max(1.0), "{}: {found}, not {start}", variable.name);
        }
    }
    Passed
}

pub(super) fn inputs(fmu: &Fmu) -> Outcome {
    if fmu.inputs().is_empty() {
        return Nothing("it has no input");
    }
    let slave = fmu.slave();
    assert_eq!([slave.setup(), slave.raw.enterInitializationMode()], [OK; 2]);
    let check = |value: f64| {
        for input in fmu.inputs() {
            assert_eq!((slave.put(input, value), slave.get(input)), (OK, Ok(value)));
        }
    };
    check(0.25);
    assert_eq!(slave.raw.exitInitializationMode(), OK);
    check(0.5);
    assert_eq!(slave.step(0.0, 0.01), OK);
    check(-0.5);
    assert_eq!(slave.step(0.01, 0.01), OK);
    Passed
}

pub(super) fn outputs_early(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    assert_eq!([slave.setup(), slave.raw.enterInitializationMode()], [OK; 2]);
    let before = slave.read(&fmu.outputs());
    assert_eq!(slave.raw.exitInitializationMode(), OK);
    assert_eq!(before, slave.read(&fmu.outputs()));
    Passed
}

pub(super) fn read_all(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..3);
    let mut references = fmu.references(|_| true);
    let values = slave.read(&references);
    assert_eq!(values, slave.read(&references));
    references.extend(references.clone());
    assert_eq!([values.clone(), values].concat(), slave.read(&references));
    Passed
}

pub(super) fn nan_values(fmu: &Fmu) -> Outcome {
    let settable = [fmu.inputs(), fmu.tunable()].concat();
    if settable.is_empty() {
        return Nothing("it has no input and no tunable parameter");
    }
    let slave = fmu.started();
    for reference in settable {
        let before = slave.get(reference);
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!((slave.put(reference, value), slave.get(reference)), (Error, before));
        }
        // A number, but an absurd one: any answer, no hang.
        slave.put(reference, 1e300);
    }
    let _ = slave.step(0.0, 0.01);
    assert_eq!(slave.raw.reset(), OK);
    Passed
}

pub(super) fn out_of_range(fmu: &Fmu) -> Outcome {
    let variables = &fmu.description.modelVariables;
    if variables.iter().all(|variable| limits(variable) == [None; 2]) {
        return Nothing("it has no limit of a variable");
    }
    let slave = fmu.slave();
    for variable in variables {
        let [min, max] = limits(variable);
        for value in [min.map(|min| min - 1.0), max.map(|max| max + 1.0)].into_iter().flatten() {
            assert_eq!(slave.put(variable.valueReference, value), Discard);
        }
    }
    slave.start();
    Passed
}

pub(super) fn strings(fmu: &Fmu) -> Outcome {
    let real = |variable: &ScalarVariable| matches!(variable.variableType, VariableType::Real { .. });
    assert!(fmu.description.modelVariables.iter().all(real), "there are none");
    assert_eq!(fmu.started().raw.getString(&[], &mut []), OK);
    Passed
}

pub(super) fn impossible_initial(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    let exact = fmu.references(|one| one.initial == Some(Initial::Exact) && one.causality != Causality::Parameter);
    for known in exact {
        let value = fmu.other(known);
        assert_eq!(slave.put(known, value), OK);
        slave.start();
        let found = slave.get(known).expect("readable");
        assert!((found - value).abs() < 1e-9, "{}: {found}, not {value}", fmu.variable(known).name);
        assert_eq!([slave.put(known, f64::NAN), slave.raw.reset()], [Error, OK]);
    }
    slave.start();
    slave.run(0..2);
    Passed
}
