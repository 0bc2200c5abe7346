//! Model Exchange: one function for each case, run in a process of its own.

use cotree_fmu::fmi3::types::fmi3Status::{fmi3Error, fmi3OK};

use super::fmu::*;
use super::{Case, nothing};

// SAFETY of all calls: the instance is alive, and arrays are as long as announced.

pub const CASES: &[Case] = &[
    ("3M01", "order of calls", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        instance.settle();
        (0..5).for_each(|step| euler(&instance, 1e-4 * f64::from(step), 1e-4));
        assert_eq!(instance.call(instance.fmi().enter_event), fmi3OK);
        instance.settle();
        assert_eq!(instance.terminate(), fmi3OK);
    }),
    ("3M02", "numbers of states and indicators", |fmu| {
        let making = Making { exchange: true, ..Making::default() };
        let Some(_) = fmu.exchanged() else { return };
        let instance = fmu.make(&making).expect("instantiates");
        assert_eq!(instance.count(instance.fmi().state_count), fmu.structure("ContinuousStateDerivative").len());
        assert_eq!(instance.count(instance.fmi().indicator_count), fmu.structure("EventIndicator").len());
    }),
    ("3M03", "vectors and value references", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        let derivatives = fmu.structure("ContinuousStateDerivative");
        let states: Vec<u32> =
            derivatives.iter().map(|&reference| fmu.variable(reference).derivative.expect("of a state")).collect();
        assert_eq!(instance.vector(instance.fmi().get_derivatives), instance.read(&derivatives));
        assert_eq!(instance.vector(instance.fmi().get_states), instance.read(&states));
        assert!(instance.vector(instance.fmi().get_nominals).iter().all(|nominal| *nominal > 0.0));
        let indicators = fmu.structure("EventIndicator");
        let mut values = vec![f64::NAN; indicators.len()];
        let status = unsafe { (instance.fmi().get_indicators)(instance.c, values.as_mut_ptr(), values.len()) };
        assert_eq!((status, values), (fmi3OK, instance.read(&indicators)));
    }),
    ("3M04", "wrong numbers", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        instance.settle();
        let count = instance.count(instance.fmi().state_count);
        assert_eq!(instance.set_states(&vec![0.0; count + 1]), fmi3Error);
        let Some(instance) = fmu.exchanged() else { return };
        let mut values = vec![0.0; count + 1];
        assert_eq!(unsafe { (instance.fmi().get_derivatives)(instance.c, values.as_mut_ptr(), count + 1) }, fmi3Error);
    }),
    ("3M05", "calls of other modes", |fmu| {
        let in_event: [fn(&Instance) -> bool; 5] = [
            |i| i.step(0.0, 0.01).status == fmi3Error,
            |i| i.call(i.fmi().enter_step) == fmi3Error,
            |i| i.completed() == Err(fmi3Error),
            |i| i.set_states(&vec![0.0; i.count(i.fmi().state_count)]) == fmi3Error,
            |i| i.enter() == fmi3Error,
        ];
        for refused in in_event {
            let Some(instance) = fmu.exchanged() else { return };
            assert!(refused(&instance) && instance.update() == Err(fmi3Error), "an error terminates");
        }
        let in_continuous: [fn(&Instance) -> bool; 3] = [
            |i| i.update() == Err(fmi3Error),
            |i| i.call(i.fmi().enter_continuous) == fmi3Error,
            |i| i.step(0.0, 0.01).status == fmi3Error,
        ];
        for refused in in_continuous {
            let Some(instance) = fmu.exchanged() else { return };
            instance.settle();
            assert!(refused(&instance));
        }
    }),
    ("3M06", "time", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        instance.settle();
        assert_eq!([instance.set_time(0.1), instance.set_time(0.05)], [fmi3OK; 2]);
        assert_eq!(instance.set_time(-0.1), fmi3Error);
    }),
    ("3M07", "parameters in continuous-time mode", |fmu| {
        let parameters = fmu.of_causality("parameter");
        for &reference in &parameters {
            let Some(instance) = fmu.exchanged() else { return };
            instance.settle();
            assert_eq!(instance.put(reference, fmu.other(reference)), fmi3Error);
        }
        for reference in fmu.parameters("tunable") {
            let Some(instance) = fmu.exchanged() else { return };
            assert_eq!(instance.put(reference, fmu.other(reference)), fmi3OK);
        }
        nothing(&parameters, "parameters");
    }),
    ("3M08", "inputs act at once", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        if nothing(&fmu.inputs(), "inputs") {
            return;
        }
        instance.settle();
        let watched = fmu.references(|variable| variable.intermediate);
        for input in fmu.inputs() {
            let listed = watched.iter().filter(|&&reference| depends(fmu, reference, input)).count();
            let before = instance.read(&watched);
            assert_eq!(instance.put(input, fmu.default(input) + 0.3), fmi3OK);
            let moved = instance.read(&watched).iter().zip(before).filter(|(now, before)| *now != before).count();
            assert!(moved > 0 || listed == 0, "{}", fmu.variable(input).name);
        }
    }),
    ("3M09", "what is not listed has no effect", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        let unknowns = [
            ("Output", fmu.structure("Output")),
            ("ContinuousStateDerivative", fmu.structure("ContinuousStateDerivative")),
        ];
        let states = fmu
            .structure("ContinuousStateDerivative")
            .into_iter()
            .map(|one| fmu.variable(one).derivative.expect("one"));
        let knowns: Vec<u32> = states
            .chain(["input", "parameter", "independent"].into_iter().flat_map(|causality| fmu.of_causality(causality)))
            .collect();
        instance.settle();
        for (element, references) in unknowns {
            for (&known, &unknown) in
                knowns.iter().flat_map(|known| references.iter().map(move |unknown| (known, unknown)))
            {
                let listed = fmu.dependencies(element, unknown).is_none_or(|list| list.contains(&known));
                let found = instance.directional(&[unknown], &[known], &[1.0]);
                assert!(
                    listed || found == Ok(vec![0.0]),
                    "{} by {}: {found:?}",
                    fmu.variable(unknown).name,
                    fmu.variable(known).name
                );
            }
        }
    }),
    ("3M10", "derivatives agree with differences, and the adjoint with them", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        let unknowns = fmu.structure("ContinuousStateDerivative");
        if nothing(&unknowns, "states") {
            return;
        }
        let states: Vec<u32> = unknowns.iter().map(|&one| fmu.variable(one).derivative.expect("one")).collect();
        instance.settle();
        let at = instance.vector(instance.fmi().get_states);
        let seed: Vec<f64> = (0..states.len()).map(|place| 1.0 - 0.3 * place as f64).collect();
        let exact = instance.directional(&unknowns, &states, &seed).expect("regular");
        let beside = |share: f64| {
            let moved: Vec<f64> = at.iter().zip(&seed).map(|(state, change)| state + share * change).collect();
            assert_eq!(instance.set_states(&moved), fmi3OK);
            instance.vector(instance.fmi().get_derivatives)
        };
        let (after, before) = (beside(1e-6), beside(-1e-6));
        let size = exact.iter().chain(&after).fold(1.0, |size: f64, value| size.max(value.abs()));
        for ((exact, after), before) in exact.iter().zip(after).zip(before) {
            assert!((exact - (after - before) / 2e-6).abs() < 1e-5 * size, "{exact} {after} {before}");
        }
        assert_eq!(instance.set_states(&at), fmi3OK);
        // w^T (J s) = (J^T w)^T s
        let weights: Vec<f64> = (0..unknowns.len()).map(|place| 0.5 + 0.1 * place as f64).collect();
        let back = instance.adjoint(&unknowns, &states, &weights).expect("regular");
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((sum(&exact, &weights) - sum(&back, &seed)).abs() < 1e-9 * size);
        assert_eq!(instance.directional(&unknowns, &states, &seed[1..]), Err(fmi3Error), "3D62: a seed for each known");
    }),
    ("3M11", "saved state", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        instance.settle();
        euler(&instance, 0.0, 1e-3);
        let (state, values) = (instance.save(), instance.all());
        euler(&instance, 1e-3, 1e-3);
        assert_eq!((instance.restore(state), instance.all()), (fmi3OK, values));
        euler(&instance, 1e-3, 1e-3);
        instance.free_state(state);
    }),
    ("3M12", "reset", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        instance.settle();
        euler(&instance, 0.0, 1e-3);
        let fresh = instance.all();
        assert_eq!((instance.completed().is_ok(), instance.set_time(f64::NAN)), (true, fmi3Error));
        assert_eq!(instance.reset(), fmi3OK);
        instance.start();
        instance.settle();
        euler(&instance, 0.0, 1e-3);
        assert_eq!(instance.all(), fresh);
    }),
    ("3M13", "NaN states", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        instance.settle();
        let count = instance.count(instance.fmi().state_count);
        if nothing(&vec![(); count], "states") {
            return;
        }
        assert_ne!(instance.set_states(&vec![f64::NAN; count]), fmi3OK);
    }),
    ("3M14", "Model Exchange and Co-Simulation give the same motion", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        instance.settle();
        const STEPS: u32 = 2000;
        let (end, h) = (0.05, 0.05 / f64::from(STEPS));
        (0..STEPS).for_each(|step| midpoint(&instance, h * f64::from(step), h));
        let slave = fmu.started();
        slave.go(0.0, end);
        let outputs = fmu.of_causality("output");
        for ((exchanged, simulated), reference) in
            instance.read(&outputs).into_iter().zip(slave.read(&outputs)).zip(&outputs)
        {
            let error = (exchanged - simulated).abs() / simulated.abs().max(1.0);
            assert!(error < 2e-4, "{}: {exchanged} {simulated}", fmu.variable(*reference).name);
        }
    }),
    ("3M15", "a tunable parameter that is not listed moves nothing", |fmu| {
        let Some(instance) = fmu.exchanged() else { return };
        let tunable = fmu.parameters("tunable");
        if nothing(&tunable, "tunable parameters") {
            return;
        }
        let unknowns: Vec<u32> =
            ["Output", "ContinuousStateDerivative"].into_iter().flat_map(|element| fmu.structure(element)).collect();
        for parameter in tunable {
            let before = instance.read(&unknowns);
            assert_eq!(instance.put(parameter, fmu.other(parameter)), fmi3OK);
            let after = instance.read(&unknowns);
            let moved = (0..unknowns.len()).filter(|&place| after[place].to_bits() != before[place].to_bits());
            let moved: Vec<u32> = moved.map(|place| unknowns[place]).collect();
            assert!(moved.iter().all(|&unknown| depends(fmu, unknown, parameter)), "{moved:?}");
            assert!(!moved.is_empty(), "{} has no effect", fmu.variable(parameter).name);
        }
    }),
];

/// Does the description say so?
fn depends(fmu: &Fmu, unknown: u32, known: u32) -> bool {
    ["Output", "ContinuousStateDerivative"].into_iter().any(|element| {
        fmu.structure(element).contains(&unknown)
            && fmu.dependencies(element, unknown).is_none_or(|list| list.contains(&known))
    })
}

/// x + h f
fn moved(instance: &Instance, states: &[f64], h: f64) -> Vec<f64> {
    let rates = instance.vector(instance.fmi().get_derivatives);
    states.iter().zip(rates).map(|(state, rate)| state + h * rate).collect()
}

/// A step of the explicit midpoint rule, with the events that it leads to.
fn midpoint(instance: &Instance, t: f64, h: f64) {
    let states = instance.vector(instance.fmi().get_states);
    let middle = moved(instance, &states, 0.5 * h);
    assert_eq!([instance.set_time(t + 0.5 * h), instance.set_states(&middle)], [fmi3OK; 2]);
    let end = moved(instance, &states, h);
    finish(instance, t + h, &end);
}

/// A step of Euler's rule, with the event that it may lead to.
fn euler(instance: &Instance, t: f64, h: f64) {
    let states = instance.vector(instance.fmi().get_states);
    let end = moved(instance, &states, h);
    finish(instance, t + h, &end);
}

fn finish(instance: &Instance, time: f64, states: &[f64]) {
    assert_eq!([instance.set_time(time), instance.set_states(states)], [fmi3OK; 2]);
    if instance.completed().expect("regular") {
        assert_eq!(instance.call(instance.fmi().enter_event), fmi3OK);
        instance.settle();
    }
}
