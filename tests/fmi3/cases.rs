//! Calls of both interfaces and of Co-Simulation: one function for each case, run in a process of its own.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use cotree_fmu::fmi3::types::fmi3Status::{fmi3Error, fmi3OK};

use super::fmu::*;
use super::{Case, nothing};

// SAFETY of all calls: the instance is alive, and arrays are as long as announced.

pub const CASES: &[Case] = &[
    ("3D01", "version before instantiation", |fmu| {
        let version = unsafe { CStr::from_ptr((fmu.library.version)()) };
        assert_eq!(version, c"3.0");
    }),
    ("3D02", "a whole run", |fmu| {
        let instance = fmu.started();
        instance.run(0..20);
        assert_eq!(instance.terminate(), fmi3OK);
    }),
    ("3D04", "no resource path", |fmu| {
        assert!(fmu.make(&Making { resources: Some(String::new()), ..logged() }).is_none())
    }),
    ("3D05", "wrong instantiation token", |fmu| {
        assert!(fmu.make(&Making { token: Some("{other}".to_owned()), ..logged() }).is_none());
    }),
    ("3D06", "missing strings", |fmu| unsafe {
        let make = fmu.library.instantiate_exchange;
        assert!(make(null(), null(), null(), 0, 0, null_mut(), None).is_null());
        assert!(make(c" ".as_ptr(), c"x".as_ptr(), c"/".as_ptr(), 0, 0, null_mut(), None).is_null());
    }),
    ("3D07", "no logger", |fmu| {
        let instance = fmu.started();
        instance.run(0..2);
        assert_eq!(instance.step(99.0, 0.1).status, fmi3Error);
    }),
    ("3D10", "unknown intermediate variables", |fmu| {
        for reference in fmu.of_causality("parameter").into_iter().chain([u32::MAX]) {
            assert!(fmu.make(&Making { intermediate: vec![reference], ..logged() }).is_none());
        }
        let outputs = fmu.references(|variable| variable.intermediate);
        assert!(fmu.make(&Making { intermediate: outputs, ..logged() }).is_some());
    }),
    ("3D12", "free in every state", |fmu| {
        unsafe { (fmu.library.free)(null_mut()) };
        drop(fmu.made());
        drop(fmu.started());
    }),
    ("3D13", "calls before initialization mode", |fmu| {
        refused(
            fmu,
            |_| (),
            &[
                ("step", |i| i.step(0.0, 0.01).status),
                ("exit", |i: &Instance| i.exit()),
                ("terminate", |i: &Instance| i.terminate()),
            ],
        );
        refused(fmu, |_| (), &[("step mode", step_mode), ("event mode", event_mode)]);
    }),
    ("3D14", "calls in initialization mode", |fmu| {
        let enter = |i: &Instance| assert_eq!(i.enter(), fmi3OK);
        refused(
            fmu,
            enter,
            &[("enter", |i: &Instance| i.enter()), ("step", |i| i.step(0.0, 0.01).status), ("event mode", event_mode)],
        );
    }),
    ("3D15", "calls in step mode", |fmu| {
        refused(
            fmu,
            |i: &Instance| i.start(),
            &[("enter", |i: &Instance| i.enter()), ("exit", |i: &Instance| i.exit()), ("event mode", event_mode)],
        );
    }),
    ("3D16", "calls after termination", |fmu| {
        let end = |i: &Instance| {
            i.start();
            assert_eq!(i.terminate(), fmi3OK);
        };
        refused(
            fmu,
            end,
            &[
                ("step", |i| i.step(0.0, 0.01).status),
                ("enter", |i: &Instance| i.enter()),
                ("end", |i: &Instance| i.terminate()),
            ],
        );
    }),
    ("3D17", "final values", |fmu| {
        let instance = fmu.started();
        let last = instance.run(0..3).pop().expect("three steps");
        assert_eq!((instance.terminate(), instance.all()), (fmi3OK, last));
    }),
    ("3D18", "an error terminates", |fmu| {
        let instance = fmu.started();
        assert_eq!(instance.step(99.0, 0.1).status, fmi3Error);
        assert_eq!(instance.step(0.0, 0.01).status, fmi3Error);
        assert_eq!(instance.reset(), fmi3OK);
        instance.start();
        instance.run(0..2);
    }),
    ("3D19", "reset is a fresh start", |fmu| {
        let fresh = fmu.started().run(0..10);
        for stop in 0..3 {
            let instance = fmu.made();
            if stop > 0 {
                instance.start();
            }
            if stop > 1 {
                instance.run(0..4);
                assert_eq!(instance.step(99.0, 0.1).status, fmi3Error);
            }
            assert_eq!(instance.reset(), fmi3OK);
            instance.start();
            assert_eq!(instance.run(0..10), fresh);
        }
        let (instance, longer) = (fmu.started(), fmu.started().run(0..30));
        for _ in 0..100 {
            assert_eq!(instance.reset(), fmi3OK);
            instance.start();
            assert_eq!(instance.run(0..30), longer);
        }
    }),
    ("3D20", "reset restores defaults", |fmu| {
        let settable = [fmu.parameters("fixed"), fmu.parameters("tunable"), fmu.of_causality("input")].concat();
        if nothing(&settable, "parameters and inputs") {
            return;
        }
        let instance = fmu.made();
        settable.iter().for_each(|&reference| assert_eq!(instance.put(reference, fmu.other(reference)), fmi3OK));
        assert_eq!(instance.reset(), fmi3OK);
        settable.iter().for_each(|&reference| assert_eq!(instance.get(reference), Ok(fmu.default(reference))));
    }),
    ("3D21", "no configuration mode", |fmu| {
        refused(fmu, |_| (), &[("configuration", |i| i.call(i.fmi().enter_configuration))]);
    }),
    ("3D22", "unknown value references", |fmu| {
        refused(
            fmu,
            |i: &Instance| i.start(),
            &[("get", |i| i.get(u32::MAX).expect_err("unknown")), ("set", |i| i.put(u32::MAX, 1.0))],
        );
    }),
    ("3D23", "other types", |fmu| unsafe {
        let first = fmu.variables[0].reference;
        let (mut number, mut text) = (0, null());
        let instance = fmu.started();
        assert_eq!((instance.fmi().get_int32)(instance.c, &first, 1, &mut number, 1), fmi3Error);
        let instance = fmu.started();
        assert_eq!((instance.fmi().get_string)(instance.c, &first, 1, &mut text, 1), fmi3Error);
        let instance = fmu.started();
        assert_eq!((instance.fmi().set_int64)(instance.c, &first, 1, &1, 1), fmi3Error);
        let (instance, mut flag) = (fmu.started(), 0);
        assert_eq!((instance.fmi().get_clock)(instance.c, &first, 1, &mut flag), fmi3Error);
    }),
    ("3D24", "empty arrays", |fmu| unsafe {
        let instance = fmu.started();
        assert_eq!((instance.fmi().get)(instance.c, null(), 0, null_mut(), 0), fmi3OK);
        assert_eq!((instance.fmi().set)(instance.c, null(), 0, null(), 0), fmi3OK);
        assert_eq!((instance.fmi().get_boolean)(instance.c, null(), 0, null_mut(), 0), fmi3OK);
    }),
    ("3D25", "missing arrays", |fmu| unsafe {
        let first = fmu.variables[0].reference;
        let instance = fmu.started();
        assert_eq!((instance.fmi().get)(instance.c, &first, 1, null_mut(), 1), fmi3Error);
        let instance = fmu.started();
        assert_eq!((instance.fmi().set)(instance.c, null(), 1, &1.0, 1), fmi3Error);
    }),
    ("3D26", "numbers of values", |fmu| unsafe {
        let all = fmu.references(|_| true);
        for count in [all.len() - 1, all.len() + 1] {
            let (instance, mut values) = (fmu.started(), vec![-7.5; all.len() + 1]);
            let status = (instance.fmi().get)(instance.c, all.as_ptr(), all.len(), values.as_mut_ptr(), count);
            assert_eq!((status, values), (fmi3Error, vec![-7.5; all.len() + 1]), "nothing is written");
        }
    }),
    ("3D27", "setting what cannot be set", |fmu| {
        let stages: [fn(&Instance); 3] = [|_| (), |i| assert_eq!(i.enter(), fmi3OK), |i: &Instance| i.start()];
        let calculated = |v: &Variable| v.causality == "independent" || v.initial.as_deref() == Some("calculated");
        for reference in fmu.references(calculated) {
            for stage in stages {
                let instance = fmu.made();
                stage(&instance);
                assert_eq!(instance.put(reference, 0.1), fmi3Error, "{:?}", fmu.variable(reference));
            }
        }
    }),
    ("3D28", "fixed parameters in step mode", |fmu| {
        let fixed = fmu.parameters("fixed");
        nothing(&fixed, "fixed parameters");
        for reference in fixed {
            let instance = fmu.started();
            let before = instance.get(reference);
            assert_eq!(instance.put(reference, fmu.other(reference)), fmi3Error);
            assert_eq!(instance.get(reference), before);
        }
    }),
    ("3D29", "calculated variables in step mode", |fmu| {
        for reference in fmu.references(|variable| ["output", "local"].contains(&&*variable.causality)) {
            assert_eq!(fmu.started().put(reference, 0.1), fmi3Error);
        }
    }),
    ("3D30", "tunable parameters", |fmu| {
        let tunable = fmu.parameters("tunable");
        nothing(&tunable, "tunable parameters");
        for reference in tunable {
            let instance = fmu.started();
            instance.run(0..3);
            assert_eq!(instance.put(reference, fmu.other(reference)), fmi3OK);
            instance.go(0.03, 0.01);
            assert_eq!(instance.get(reference), Ok(fmu.other(reference)));
        }
    }),
    ("3D31", "parameters before the start", |fmu| {
        let parameters = fmu.of_causality("parameter");
        nothing(&parameters, "parameters");
        for reference in parameters {
            let instance = fmu.made();
            assert_eq!(instance.put(reference, fmu.other(reference)), fmi3OK);
            assert_eq!(instance.enter(), fmi3OK);
            assert_eq!(instance.get(reference), Ok(fmu.other(reference)));
            assert_eq!(instance.put(reference, fmu.default(reference)), fmi3OK);
            assert_eq!((instance.exit(), instance.get(reference)), (fmi3OK, Ok(fmu.default(reference))));
        }
    }),
    ("3D32", "start values when instantiated", |fmu| {
        let instance = fmu.made();
        for variable in fmu.variables.iter().filter(|variable| variable.start.is_some()) {
            assert_eq!(instance.get(variable.reference).ok(), variable.start, "{}", variable.name);
        }
    }),
    ("3D33", "start values after initialization", |fmu| {
        let instance = fmu.started();
        for variable in fmu.variables.iter().filter(|variable| variable.initial.as_deref() == Some("exact")) {
            assert_eq!(instance.get(variable.reference).ok(), variable.start, "{}", variable.name);
        }
    }),
    ("3D34", "inputs", |fmu| {
        let inputs = fmu.inputs();
        nothing(&inputs, "inputs");
        for reference in inputs {
            let instance = fmu.made();
            assert_eq!([instance.put(reference, 0.2), instance.enter(), instance.put(reference, 0.3)], [fmi3OK; 3]);
            assert_eq!((instance.exit(), instance.get(reference)), (fmi3OK, Ok(0.3)));
            assert_eq!(instance.put(reference, 0.4), fmi3OK);
            instance.go(0.0, 0.01);
            assert_eq!(instance.get(reference), Ok(0.4));
        }
    }),
    ("3D35", "every variable can be read", |fmu| {
        let instance = fmu.made();
        assert_eq!(instance.enter(), fmi3OK);
        assert_eq!(instance.all(), instance.all());
        assert_eq!(instance.exit(), fmi3OK);
        instance.go(0.0, 0.01);
        assert_eq!(instance.all(), instance.all());
    }),
    ("3D36", "many values in one call", |fmu| {
        let instance = fmu.started();
        let twice = [fmu.references(|_| true), fmu.references(|_| true)].concat();
        let single: Vec<f64> = twice.iter().map(|&reference| instance.get(reference).expect("known")).collect();
        assert_eq!(instance.read(&twice), single);
    }),
    ("3D37", "the independent variable", |fmu| {
        let [time] = fmu.of_causality("independent")[..] else { panic!("there is one") };
        let instance = fmu.made();
        assert_eq!((instance.enter_from(2.5, None, None), instance.get(time)), (fmi3OK, Ok(2.5)));
        assert_eq!(instance.exit(), fmi3OK);
        instance.go(2.5, 0.25);
        assert_eq!(instance.get(time), Ok(2.75));
    }),
    ("3D39", "NaN and infinity as values", |fmu| {
        let settable = [fmu.of_causality("parameter"), fmu.of_causality("input")].concat();
        nothing(&settable, "parameters and inputs");
        for reference in settable {
            for odd in [f64::NAN, f64::INFINITY] {
                assert_ne!(fmu.made().put(reference, odd), fmi3OK);
            }
        }
    }),
    ("3D40", "steps of zero or less", |fmu| {
        refused(fmu, |i| i.start(), &[("zero", |i| i.step(0.0, 0.0).status), ("back", |i| i.step(0.0, -0.1).status)]);
    }),
    ("3D41", "steps that are no numbers", |fmu| {
        for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!([fmu.started().step(odd, 0.01).status, fmu.started().step(0.0, odd).status], [fmi3Error; 2]);
        }
    }),
    ("3D42", "a first step from elsewhere", |fmu| {
        refused(fmu, |i| i.start(), &[("far", |i| i.step(5.0, 0.01).status)]);
    }),
    ("3D43", "later steps from elsewhere, and no place for results", |fmu| {
        let go = |i: &Instance| drop(i.run(0..2));
        let begin = |i: &Instance| {
            i.start();
            go(i);
        };
        refused(
            fmu,
            begin,
            &[("later", |i| i.step(36_000.0, 0.01).status), ("earlier", |i| i.step(-36_000.0, 0.01).status)],
        );
        refused(
            fmu,
            begin,
            &[("nowhere", |i| unsafe {
                (i.fmi().do_step)(i.c, 0.02, 0.01, 1, null_mut(), null_mut(), null_mut(), null_mut())
            })],
        );
    }),
    ("3D44", "stop time", |fmu| {
        let instance = fmu.made();
        assert_eq!([instance.enter_from(0.0, Some(0.3), None), instance.exit()], [fmi3OK; 2]);
        (0..3).for_each(|step| instance.go(0.1 * f64::from(step), 0.1));
        assert_eq!(instance.step(0.3, 0.1).status, fmi3Error);
    }),
    ("3D45", "impossible experiments", |fmu| {
        assert_eq!(fmu.made().enter_from(1.0, Some(0.5), None), fmi3Error);
        for odd in [0.0, -1.0, f64::NAN] {
            assert_eq!(fmu.made().enter_from(0.0, None, Some(odd)), fmi3Error);
        }
    }),
    ("3D46", "no early return unless it is allowed", |fmu| {
        let instance = fmu.started();
        for step in 0..20 {
            let t = 0.01 * f64::from(step);
            assert_eq!(instance.step(t, 0.01), Step { status: fmi3OK, event: false, early: false, time: t + 0.01 });
        }
    }),
    ("3D47", "steps of different lengths", |fmu| {
        let (instance, mut t) = (fmu.started(), 0.0);
        for h in [0.01, 0.005, 0.0025, 0.02, 0.03] {
            instance.go(t, h);
            t += h;
        }
    }),
    ("3D48", "determinism", |fmu| assert_eq!(fmu.started().run(0..30), fmu.started().run(0..30))),
    ("3D49", "a thousand accumulated points", |fmu| {
        let (instance, mut t) = (fmu.started(), 0.0);
        for _ in 0..1000 {
            instance.go(t, 1e-3);
            t += 1e-3;
        }
    }),
    ("3D50", "two instances", |fmu| {
        let alone = fmu.started().run(0..10);
        let (first, second) = (fmu.started(), fmu.started());
        assert_eq!(second.step(99.0, 0.1).status, fmi3Error);
        assert_eq!(first.run(0..10), alone);
    }),
    ("3D51", "eight threads", |fmu| {
        let alone = fmu.started().run(0..50);
        let instances: Vec<_> = (0..8).map(|_| fmu.started()).collect();
        let found: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> = instances
                .into_iter()
                .map(|instance| {
                    scope.spawn(move || {
                        let instance = instance;
                        instance.run(0..50)
                    })
                })
                .collect();
            threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        });
        assert!(found.iter().all(|run| *run == alone));
    }),
    ("3D55", "saved states", |fmu| {
        let instance = fmu.started();
        instance.run(0..7);
        let state = instance.save();
        let after = instance.run(7..30);
        for _ in 0..100 {
            assert_eq!(instance.restore(state), fmi3OK);
            assert_eq!(instance.run(7..30), after);
        }
        instance.free_state(state);
    }),
    ("3D56", "states are overwritten and freed", |fmu| {
        let instance = fmu.started();
        let mut state = instance.save();
        let later = instance.run(0..5);
        assert_eq!(unsafe { (instance.fmi().get_state)(instance.c, &mut state) }, fmi3OK);
        instance.run(5..8);
        assert_eq!((instance.restore(state), Some(&instance.all())), (fmi3OK, later.last()));
        instance.free_state(state);
        instance.free_state(null_mut());
    }),
    ("3D57", "a state holds the mode", |fmu| {
        let instance = fmu.made();
        assert_eq!(instance.enter(), fmi3OK);
        let state = instance.save();
        assert_eq!([instance.exit(), instance.terminate(), instance.restore(state), instance.exit()], [fmi3OK; 4]);
        assert_eq!(instance.step(9.0, 0.1).status, fmi3Error);
        assert_eq!([instance.restore(state), instance.exit()], [fmi3OK; 2]);
        instance.run(0..2);
        instance.free_state(state);
    }),
    ("3D58", "serialised states", |fmu| {
        let (instance, other) = (fmu.started(), fmu.made());
        instance.run(0..6);
        let state = instance.save();
        let copy = other.deserialize(&instance.bytes(state)).expect("sound");
        assert_eq!(other.restore(copy), fmi3OK);
        assert_eq!(other.run(6..12), instance.run(6..12));
        instance.free_state(state);
        other.free_state(copy);
    }),
    ("3D59", "damaged states", |fmu| {
        let instance = fmu.started();
        let state = instance.save();
        let bytes = instance.bytes(state);
        for place in (0..bytes.len()).step_by(1 + bytes.len() / 20) {
            let mut damaged = bytes.clone();
            damaged[place] ^= 0x10;
            assert_eq!(fmu.made().deserialize(&damaged), Err(fmi3Error));
            assert_eq!(fmu.made().deserialize(&bytes[..place]), Err(fmi3Error));
        }
        let mut small = vec![0; bytes.len() - 1];
        assert_eq!(
            unsafe { (instance.fmi().serialize)(instance.c, state, small.as_mut_ptr(), small.len()) },
            fmi3Error
        );
        instance.free_state(state);
    }),
    ("3D60", "what is not supported", |fmu| {
        refused(
            fmu,
            |i: &Instance| i.start(),
            &[
                ("evaluate", |i| i.call(i.fmi().evaluate)),
                ("dependencies", |i| unsafe { (i.fmi().dependency_count)(i.c, 0, &mut 0) }),
                ("partitions", |i| unsafe { (i.fmi().activate)(i.c, 0, 0.0) }),
            ],
        );
    }),
    ("3D65", "intermediate updates", |fmu| {
        let instance = fmu.make(&Making { update: Some(watch), ..logged() }).expect("instantiates");
        instance.start();
        assert_eq!(instance.step(0.0, 0.5), Step { status: fmi3OK, event: false, early: false, time: 0.5 });
        let updates = instance.updates();
        assert!(updates.is_sorted_by(|a, b| a.time <= b.time) && updates.iter().all(|update| !update.can_return));
        assert_eq!(updates.last().map(|update| update.time), Some(0.5));
    }),
    ("3D66", "early return on request", |fmu| {
        let how = Making { update: Some(interrupt), early_return: true, ..logged() };
        let instance = fmu.make(&how).expect("instantiates");
        instance.start();
        instance.go(0.0, 0.5);
        let early = instance.updates().iter().filter(|update| update.can_return).count();
        let dynamic = !fmu.structure("ContinuousStateDerivative").is_empty();
        assert_eq!(early > 0, dynamic, "a driven mechanism has no steps of its own");
        for flag in ["mightReturnEarlyFromDoStep", "canReturnEarlyAfterIntermediateUpdate"] {
            assert_eq!(fmu.flag("CoSimulation", flag), dynamic, "{flag}");
        }
    }),
    ("3D69", "event mode", |fmu| {
        let instance = fmu.make(&Making { events: true, ..logged() }).expect("instantiates");
        instance.start();
        assert_eq!(instance.update(), Ok((false, false)));
        assert_eq!(step_mode(&instance), fmi3OK);
        instance.go(0.0, 0.01);
        assert_eq!([event_mode(&instance), step_mode(&instance)], [fmi3OK; 2]);
        assert_eq!(event_mode(&instance), fmi3OK);
        assert_eq!(instance.step(0.01, 0.01).status, fmi3Error, "not in event mode");
    }),
    ("3D70", "however steps are made, the results are the same", |fmu| {
        let plain = fmu.started().run(0..40);
        let events = fmu.make(&Making { events: true, ..logged() }).expect("instantiates");
        events.start();
        assert_eq!(step_mode(&events), fmi3OK);
        assert_eq!(events.run(0..40), plain);
        for how in [
            Making { update: Some(watch), ..logged() },
            Making { early_return: true, ..logged() },
            Making { update: Some(interrupt), early_return: true, ..logged() },
        ] {
            let instance = fmu.make(&how).expect("instantiates");
            instance.start();
            assert_eq!(instance.run(0..40), plain);
        }
    }),
    ("3D71", "errors, and nothing else, without debug logging", |fmu| {
        let instance = fmu.make(&Making { logging: Some(false), ..Making::default() }).expect("instantiates");
        instance.start();
        assert_eq!(instance.log(), []);
        assert_eq!(instance.step(99.0, 0.1).status, fmi3Error);
        let log = instance.log();
        assert_eq!(log.len(), 1, "{log:?}");
        assert_eq!((log[0].0, log[0].1.as_str()), (fmi3Error, "logStatusError"));
    }),
    ("3D72", "an error is logged in a declared category", |fmu| {
        let instance = fmu.make(&logged()).expect("instantiates");
        instance.start();
        assert_eq!(instance.step(99.0, 0.1).status, fmi3Error);
        let log = instance.log();
        let declared: Vec<&str> = fmu.below("LogCategories/Category").iter().map(|tag| tag.1[0].1.as_str()).collect();
        assert!(
            log.iter().all(|(_, category, text)| declared.contains(&&**category) && !text.ends_with('\n')),
            "{log:?}"
        );
        let (status, category, text) = log.last().expect("a message");
        assert_eq!((*status, category.as_str()), (fmi3Error, "logStatusError"));
        assert!(text.contains("t = 99 s"), "{text}");
    }),
    ("3D74", "log categories", |fmu| {
        let instance = fmu.make(&logged()).expect("instantiates");
        assert_eq!(instance.category(&[c"logStatusError"], true), fmi3OK);
        instance.start();
        assert_eq!(instance.log(), [], "events are off");
        assert_eq!(instance.category(&[], false), fmi3OK);
        assert_eq!(instance.step(99.0, 0.1).status, fmi3Error);
        assert_eq!(instance.log(), []);
    }),
    ("3D75", "undeclared log categories", |fmu| {
        refused(fmu, |_| (), &[("category", |i| i.category(&[c"nonsense"], true))]);
    }),
];

pub fn logged() -> Making {
    Making { logging: Some(true), ..Making::default() }
}

fn step_mode(instance: &Instance) -> cotree_fmu::fmi3::types::fmi3Status {
    instance.call(instance.fmi().enter_step)
}

fn event_mode(instance: &Instance) -> cotree_fmu::fmi3::types::fmi3Status {
    instance.call(instance.fmi().enter_event)
}

/// A call that is to be refused, and its name.
pub type Call = (&'static str, fn(&Instance) -> cotree_fmu::fmi3::types::fmi3Status);

/// Each call is an error in this state, and only a reset helps then.
pub fn refused(fmu: &Fmu, prepare: impl Fn(&Instance), calls: &[Call]) {
    for (name, call) in calls {
        let instance = fmu.make(&logged()).expect("instantiates");
        prepare(&instance);
        instance.log();
        assert_eq!(call(&instance), fmi3Error, "{name}");
        assert!(!instance.log().is_empty(), "{name}: no message");
        assert_eq!(instance.step(0.0, 0.01).status, fmi3Error, "{name}: terminated");
        assert_eq!(instance.reset(), fmi3OK, "{name}");
        instance.start();
    }
}
