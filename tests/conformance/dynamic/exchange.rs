//! Model Exchange.

use std::ptr::null_mut;

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Discard, fmi2Error, fmi2OK};
use cotree_fmu::fmi2::types::*;

use super::super::fmu::*;
use super::derivatives::{agree, difference};
use super::nothing;

// SAFETY of all calls: the component is alive, and arrays are as long as announced.

/// An instance for Model Exchange in event mode, unless there is none.
fn exchange(fmu: &Fmu) -> Option<Slave<'_>> {
    let slave = fmu.instantiate(fmi2ModelExchange, &fmu.resources(), false);
    nothing(slave.as_slice(), "Model Exchange");
    slave.as_ref().inspect(|slave| slave.start());
    slave
}

fn states(fmu: &Fmu) -> usize {
    fmu.below("/ModelStructure/Derivatives/Unknown").len()
}

fn event(slave: &Slave) -> fmi2Status {
    let mut info = fmi2EventInfo {
        newDiscreteStatesNeeded: 7,
        terminateSimulation: 7,
        nominalsOfContinuousStatesChanged: 7,
        valuesOfContinuousStatesChanged: 7,
        nextEventTimeDefined: 7,
        nextEventTime: f64::NAN,
    };
    let status = unsafe { (slave.fmi().new_discrete_states)(slave.c, &mut info) };
    // An importer that looks at the answer alone must not ask again for ever.
    assert_eq!((info.newDiscreteStatesNeeded, info.terminateSimulation), (0, i32::from(status != fmi2OK)));
    status
}

/// States that an event moves are declared: an integrator that has gone astray is brought back to the loops.
pub(super) fn reinitialised(fmu: &Fmu) {
    let Some(slave) = exchange(fmu) else { return };
    let (fmi, c, count) = (slave.fmi(), slave.c, states(fmu));
    let declared = fmu.tags.iter().filter(|tag| attribute(tag, "reinit") == Some("true")).count();
    let mut values = vec![0.0; count];
    let mut info = fmi2EventInfo {
        newDiscreteStatesNeeded: 7,
        terminateSimulation: 7,
        nominalsOfContinuousStatesChanged: 7,
        valuesOfContinuousStatesChanged: 7,
        nextEventTimeDefined: 7,
        nextEventTime: 0.0,
    };
    assert_eq!([event(&slave), unsafe { (fmi.enter_continuous_time_mode)(c) }], [fmi2OK; 2]);
    unsafe {
        assert_eq!((fmi.get_continuous_states)(c, values.as_mut_ptr(), count), fmi2OK);
        values.iter_mut().enumerate().for_each(|(place, value)| *value += 1e-5 * (1.0 + place as f64));
        assert_eq!((fmi.set_continuous_states)(c, values.as_ptr(), count), fmi2OK);
        assert_eq!([(fmi.enter_event_mode)(c), (fmi.new_discrete_states)(c, &mut info)], [fmi2OK; 2]);
    }
    let expected = if info.valuesOfContinuousStatesChanged == fmi2True { count } else { 0 };
    assert_eq!(declared, expected, "of {count} states");
}

/// An integrator outside may try what the model has no accelerations for; with other states it goes on. Friction that holds a model keeps its accelerations at zero.
pub(super) fn beyond(fmu: &Fmu) {
    let Some(slave) = exchange(fmu) else { return };
    let (fmi, c, count) = (slave.fmi(), slave.c, states(fmu));
    if nothing(&vec![(); count], "continuous state") {
        return;
    }
    let (mut good, mut rates, mut again) = (vec![0.0; count], vec![0.0; count], vec![f64::NAN; count]);
    assert_eq!([event(&slave), unsafe { (fmi.enter_continuous_time_mode)(c) }], [fmi2OK; 2]);
    unsafe {
        assert_eq!((fmi.get_continuous_states)(c, good.as_mut_ptr(), count), fmi2OK);
        assert_eq!((fmi.get_derivatives)(c, rates.as_mut_ptr(), count), fmi2OK);
        let beyond = [1e300].repeat(count);
        assert_eq!((fmi.set_continuous_states)(c, beyond.as_ptr(), count), fmi2OK);
        let status = (fmi.get_derivatives)(c, again.as_mut_ptr(), count);
        let is_known = again.iter().all(|rate| rate.is_finite());
        assert_eq!(status, if is_known { fmi2OK } else { fmi2Discard });
        assert_eq!((fmi.set_continuous_states)(c, good.as_ptr(), count), fmi2OK);
        assert_eq!((fmi.get_derivatives)(c, again.as_mut_ptr(), count), fmi2OK);
    }
    assert_eq!(again, rates);
}

pub(super) fn exchange_order(fmu: &Fmu) {
    let Some(slave) = exchange(fmu) else { return };
    let (fmi, c) = (slave.fmi(), slave.c);
    let (mut enter, mut terminate) = (7, 7);
    let mut completed = || unsafe { (fmi.completed_integrator_step)(c, 1, &mut enter, &mut terminate) };
    let continuous = || unsafe { (fmi.enter_continuous_time_mode)(c) };
    assert_eq!([slave.step(0.0, 0.1), completed()], [fmi2Error; 2]);
    assert_eq!([event(&slave), continuous(), continuous(), event(&slave)], [fmi2OK, fmi2OK, fmi2Error, fmi2Error]);
    assert_eq!(
        [completed(), unsafe { (fmi.set_time)(c, 0.01) }, unsafe { (fmi.set_time)(c, f64::NAN) }],
        [fmi2OK, fmi2OK, fmi2Error]
    );
    slave.all();
    for tunable in fmu.parameters("tunable") {
        assert_eq!(slave.put(tunable, fmu.other(tunable)), fmi2Error, "in event mode only");
    }
    assert_eq!(unsafe { (fmi.enter_event_mode)(c) }, fmi2OK);
    for tunable in fmu.parameters("tunable") {
        assert_eq!(slave.put(tunable, fmu.other(tunable)), fmi2OK);
    }
    assert_eq!([event(&slave), continuous(), slave.terminate(), continuous()], [fmi2OK, fmi2OK, fmi2OK, fmi2Error]);
    slave.all();
    let alone = fmu.started();
    assert_eq!([unsafe { (fmi.set_time)(alone.c, 0.0) }, event(&alone)], [fmi2Error; 2], "not in Co-Simulation");
    assert_eq!(slave.reset(), fmi2OK);
    slave.start();
}

pub(super) fn exchange_sizes(fmu: &Fmu) {
    let Some(slave) = exchange(fmu) else { return };
    let (fmi, c, count) = (slave.fmi(), slave.c, states(fmu));
    let indicators = attribute(&fmu.tags[0], "numberOfEventIndicators").expect("declared").parse().expect("a number");
    let mut values = vec![0.0; count + indicators + 1];
    let pointer = values.as_mut_ptr();
    unsafe {
        assert_eq!(event(&slave), fmi2OK);
        assert_eq!((fmi.enter_continuous_time_mode)(c), fmi2OK);
        let right = [
            (fmi.get_continuous_states)(c, pointer, count),
            (fmi.set_continuous_states)(c, pointer, count),
            (fmi.get_derivatives)(c, pointer, count),
            (fmi.get_nominals)(c, pointer, count),
            (fmi.get_event_indicators)(c, pointer, indicators),
        ];
        assert_eq!(right, [fmi2OK; 5]);
        let wrong = [
            (fmi.get_continuous_states)(c, pointer, count + 1),
            (fmi.set_continuous_states)(c, pointer, count + 1),
            (fmi.get_derivatives)(c, pointer, count + 1),
            (fmi.get_nominals)(c, pointer, count + 1),
            (fmi.get_event_indicators)(c, pointer, indicators + 1),
        ];
        assert_eq!(wrong, [fmi2Error; 5]);
        if count > 0 {
            assert_eq!((fmi.set_continuous_states)(c, [f64::NAN].repeat(count).as_ptr(), count), fmi2Discard);
            assert_eq!((fmi.get_derivatives)(c, null_mut(), count), fmi2Error);
        }
    }
}

pub(super) fn exchange_derivatives(fmu: &Fmu) {
    let Some(slave) = exchange(fmu) else { return };
    let (fmi, c, count) = (slave.fmi(), slave.c, states(fmu));
    let listed = fmu.below("/ModelStructure/Derivatives/Unknown");
    let indices =
        listed.iter().map(|tag| attribute(tag, "index").expect("required").parse::<usize>().expect("a number"));
    let derivatives: Vec<&Variable> = indices.map(|index| &fmu.variables[index - 1]).collect();
    let (mut values, mut rates) = (vec![0.0; count], vec![0.0; count]);
    unsafe {
        assert_eq!((fmi.get_continuous_states)(c, values.as_mut_ptr(), count), fmi2OK);
        assert_eq!((fmi.get_derivatives)(c, rates.as_mut_ptr(), count), fmi2OK);
    }
    for (place, derivative) in derivatives.iter().enumerate() {
        let state = &fmu.variables[derivative.derivative.expect("a derivative") as usize - 1];
        assert_eq!(
            (slave.get(state.reference), slave.get(derivative.reference)),
            (Ok(values[place]), Ok(rates[place]))
        );
    }
    // By the states: along each of them.
    let unknowns: Vec<u32> = derivatives.iter().map(|variable| variable.reference).collect();
    assert_eq!([event(&slave), unsafe { (fmi.enter_continuous_time_mode)(c) }], [fmi2OK; 2]);
    for (place, derivative) in derivatives.iter().enumerate() {
        let state = &fmu.variables[derivative.derivative.expect("a derivative") as usize - 1];
        let exact = slave.derivatives(&unknowns, state.reference);
        let at = |change: f64| {
            let mut moved = values.clone();
            moved[place] += change;
            assert_eq!(unsafe { (fmi.set_continuous_states)(c, moved.as_ptr(), count) }, fmi2OK);
            slave.read(&unknowns)
        };
        let found = difference(at, 1e-3);
        at(0.0);
        agree(fmu, &unknowns, &exact, &found, 1e-7);
    }
}

pub(super) fn exchange_state(fmu: &Fmu) {
    let Some(slave) = exchange(fmu) else { return };
    let saved = slave.save();
    let before = slave.all();
    assert_eq!([event(&slave), unsafe { (slave.fmi().enter_continuous_time_mode)(slave.c) }], [fmi2OK; 2]);
    assert_eq!(unsafe { (slave.fmi().set_time)(slave.c, 0.02) }, fmi2OK);
    let moved = slave.save();
    let later = slave.all();
    assert_eq!(slave.restore(saved), fmi2OK);
    assert_eq!((slave.all(), unsafe { (slave.fmi().set_time)(slave.c, 0.0) }), (before, fmi2OK));
    let bytes = slave.bytes(moved);
    let other = fmu.instantiate(fmi2ModelExchange, &fmu.resources(), false).expect("instantiates");
    let copy = other.deserialize(&bytes).expect("own bytes");
    assert_eq!(other.restore(copy), fmi2OK);
    assert_eq!(other.all(), later);
    assert_eq!(fmu.slave().restore(copy), fmi2Error, "not in Co-Simulation");
    [saved, moved, copy].into_iter().for_each(|state| slave.free(state));
}
