//! Model Exchange.

use fmi_rs::fmi2::ME;
use fmi_rs::fmi2::types::fmi2Status::{self, Discard, Error, Ok as OK};
use fmi_rs::fmi2::types::fmi2True;
use fmi_rs::model_description::fmi2::ScalarVariable;

use super::Outcome::{self, Nothing, Passed};
use crate::fmu::*;

const NO_EXCHANGE: Outcome = Nothing("it has no Model Exchange");

/// An instance for Model Exchange in event mode.
fn exchange(fmu: &Fmu) -> Option<Instance<'_, ME>> {
    fmu.description.modelExchange.as_ref()?;
    let instance = fmu.exchange().expect("instantiates");
    instance.start();
    Some(instance)
}

fn event(instance: &Instance<ME>) -> fmi2Status {
    let (mut needed, mut terminate, mut nominals, mut values, mut next) = (true, true, true, true, Some(7.0));
    let status = instance.raw.newDiscreteStates(&mut needed, &mut terminate, &mut nominals, &mut values, &mut next);
    assert!(status != OK || (needed, terminate, next) == (false, false, None));
    status
}

pub(super) fn exchange_order(fmu: &Fmu) -> Outcome {
    let Some(instance) = exchange(fmu) else { return NO_EXCHANGE };
    let raw = &instance.raw;
    let completed = || raw.completedIntegratorStep(fmi2True, &mut 7, &mut 7);
    let continuous = || raw.enterContinuousTimeMode();
    assert_eq!(completed(), Error);
    assert_eq!([event(&instance), continuous(), continuous(), event(&instance)], [OK, OK, Error, Error]);
    assert_eq!([completed(), raw.setTime(0.01), raw.setTime(f64::NAN)], [OK, OK, Error]);
    instance.all();
    for tunable in fmu.tunable() {
        assert_eq!(instance.put(tunable, fmu.other(tunable)), Error, "in event mode only");
    }
    assert_eq!(raw.enterEventMode(), OK);
    for tunable in fmu.tunable() {
        assert_eq!(instance.put(tunable, fmu.other(tunable)), OK);
    }
    assert_eq!([event(&instance), continuous(), raw.terminate(), continuous()], [OK, OK, OK, Error]);
    instance.all();
    assert_eq!(raw.reset(), OK);
    instance.start();
    Passed
}

pub(super) fn exchange_sizes(fmu: &Fmu) -> Outcome {
    let Some(instance) = exchange(fmu) else { return NO_EXCHANGE };
    let (raw, count) = (&instance.raw, fmu.description.derivatives.len());
    let indicators = fmu.description.numberOfEventIndicators as usize;
    assert_eq!([event(&instance), raw.enterContinuousTimeMode()], [OK; 2]);
    let calls = |more: usize| {
        let mut values = vec![0.0; count + more];
        let mut found = vec![raw.getContinuousStates(&mut values), raw.setContinuousStates(&values)];
        found.extend([raw.getDerivatives(&mut values), raw.getNominalsOfContinuousStates(&mut values)]);
        found.push(raw.getEventIndicators(&mut vec![0.0; indicators + more]));
        found
    };
    assert_eq!((calls(0), calls(1)), (vec![OK; 5], vec![Error; 5]));
    if count > 0 {
        assert_eq!(raw.setContinuousStates(&[f64::NAN].repeat(count)), Discard);
    }
    Passed
}

pub(super) fn exchange_derivatives(fmu: &Fmu) -> Outcome {
    let Some(instance) = exchange(fmu) else { return NO_EXCHANGE };
    let (raw, variables) = (&instance.raw, &fmu.description.modelVariables);
    let listed = fmu.description.derivatives.iter();
    let derivatives: Vec<&ScalarVariable> = listed.map(|unknown| &variables[unknown.index as usize - 1]).collect();
    let state = |one: &&ScalarVariable| {
        variables[one.variableType.derivative().expect("a derivative") as usize - 1].valueReference
    };
    let states: Vec<u32> = derivatives.iter().map(state).collect();
    let unknowns: Vec<u32> = derivatives.iter().map(|one| one.valueReference).collect();
    let (mut values, mut rates) = (vec![0.0; states.len()], vec![0.0; states.len()]);
    assert_eq!([raw.getContinuousStates(&mut values), raw.getDerivatives(&mut rates)], [OK; 2]);
    assert_eq!((instance.read(&states), instance.read(&unknowns)), (values.clone(), rates));
    assert_eq!([event(&instance), raw.enterContinuousTimeMode()], [OK; 2]);
    for (place, &state) in states.iter().enumerate() {
        let exact = instance.derivatives(&unknowns, state);
        let at = |change: f64| {
            let mut moved = values.clone();
            moved[place] += change;
            assert_eq!(raw.setContinuousStates(&moved), OK);
            instance.read(&unknowns)
        };
        let found = difference(at, 1e-3);
        at(0.0);
        agree(fmu, &unknowns, &exact, &found, 1e-7);
    }
    Passed
}

pub(super) fn exchange_state(fmu: &Fmu) -> Outcome {
    let Some(instance) = exchange(fmu) else { return NO_EXCHANGE };
    let (saved, before) = (instance.save(), instance.all());
    let raw = &instance.raw;
    assert_eq!([event(&instance), raw.enterContinuousTimeMode(), raw.setTime(0.02)], [OK; 3]);
    let (moved, later) = (instance.save(), instance.all());
    assert_eq!((raw.setFMUstate(saved), instance.all()), (OK, before));
    let other = fmu.exchange().expect("instantiates");
    let copy = other.deserialize(&instance.bytes(moved)).expect("own bytes");
    assert_eq!((other.raw.setFMUstate(copy), other.all()), (OK, later));
    assert_eq!(fmu.slave().raw.setFMUstate(copy), Error, "not in Co-Simulation");
    [saved, moved, copy].into_iter().for_each(|state| instance.free(state));
    Passed
}
