//! What an importer may do around the calls, and what the FMU may do to the process: one function for each case, run in a process of its own.

use std::cell::{Cell, RefCell};
use std::ffi::CString;
use std::ptr::{null, null_mut};

use cotree_fmu::fmi3::types::fmi3Status::{fmi3Error, fmi3OK};
use cotree_fmu::fmi3::types::*;

use super::Case;
use super::cases::{logged, refused};
use super::fmu::*;
use super::process::{keeps_its_memory, leaves_no_trace, on_a_small_stack, under_traps};
use super::xml::attribute;

// SAFETY of all calls: the instance is alive, and arrays are as long as announced.

pub const CASES: &[Case] = &[
    ("3D03", "the resource path is not a URI", |fmu| {
        let folder = tempfile::tempdir().expect("a folder");
        let odd = folder.path().join("50%20 off é");
        std::fs::create_dir(&odd).expect("a folder");
        for file in std::fs::read_dir(fmu.resources()).expect("a folder") {
            let file = file.expect("an entry");
            std::fs::copy(file.path(), odd.join(file.file_name())).expect("a copy");
        }
        let at = |path: String| fmu.make(&Making { resources: Some(path), ..logged() });
        let instance = at(format!("{}/", odd.display())).expect("as it is");
        instance.start();
        assert_eq!(instance.run(0..5), fmu.started().run(0..5));
        // An importer that leaves the separator out is understood.
        assert!(at(odd.display().to_string()).is_some());
        assert!(at(format!("file://{}/", odd.display()).replace(' ', "%20")).is_none());
    }),
    ("3D08", "an interface that is not offered", |fmu| {
        let texts = ["name", &fmu.token, &fmu.resources()].map(|text| CString::new(text).expect("no zero"));
        let [name, token, path] = texts.each_ref().map(|text| text.as_ptr());
        let scheduled = fmu.library.instantiate_scheduled;
        assert!(unsafe { scheduled(name, token, path, 0, 0, null_mut(), None, None, None, None) }.is_null());
        let offered = !fmu.below("fmiModelDescription/ModelExchange").is_empty();
        assert_eq!(fmu.make(&Making { exchange: true, ..logged() }).is_some(), offered);
    }),
    ("3D09", "event mode is for those who declare it", |fmu| {
        let made = fmu.make(&Making { events: true, ..logged() });
        assert_eq!(made.is_some(), fmu.flag("CoSimulation", "hasEventMode"));
    }),
    ("3D11", "arguments of the instantiation may be overwritten", |fmu| {
        // They are, in every case.
        let instance = fmu.made();
        instance.start();
        let fresh = instance.run(0..5);
        assert_eq!(instance.reset(), fmi3OK);
        instance.start();
        assert_eq!(instance.run(0..5), fresh);
    }),
    ("3D38", "arguments are copied, and left as they are", |fmu| {
        let instance = fmu.make(&logged()).expect("instantiates");
        let mut category = *b"logStatusError\0";
        let names = [category.as_ptr().cast()];
        assert_eq!(unsafe { (instance.fmi().set_debug_logging)(instance.c, 1, 1, names.as_ptr()) }, fmi3OK);
        assert_eq!(&category, b"logStatusError\0");
        category.fill(b'?');
        instance.start();
        let expected = instance.run(0..4);
        let state = instance.save();
        let bytes = instance.bytes(state);
        let mut given = bytes.clone();
        let copy = instance.deserialize(&given).expect("sound");
        assert_eq!(given, bytes);
        given.fill(0);
        let after = instance.run(4..8);
        assert_eq!((instance.restore(copy), instance.all()), (fmi3OK, expected[3].clone()));
        assert_eq!(instance.run(4..8), after);
        [state, copy].into_iter().for_each(|state| instance.free_state(state));
        assert_eq!(instance.step(99.0, 0.1).status, fmi3Error);
        assert_eq!(instance.log().pop().expect("a message").1, "logStatusError");
    }),
    ("3D52", "no memory is lost", |fmu| keeps_its_memory(|| drop(fmu.started().run(0..3)))),
    ("3D53", "unload and load again", |fmu| {
        let expected = fmu.started().run(0..3);
        for _ in 0..5 {
            let again = Fmu::open(&fmu.folder);
            assert_eq!(again.started().run(0..3), expected);
        }
    }),
    ("3D54", "silent, and nothing of the process changes", |fmu| {
        leaves_no_trace(|| {
            let instance = fmu.started();
            instance.run(0..5);
            assert_eq!(instance.put(u32::MAX, 1.0), fmi3Error);
            assert_eq!(instance.reset(), fmi3OK);
            drop(instance);
            assert!(fmu.make(&Making { token: Some("{other}".to_owned()), ..Making::default() }).is_none());
        });
    }),
    ("3D63", "dependencies by a call, where they are offered", |fmu| {
        assert!(!fmu.flag("CoSimulation", "providesPerElementDependencies"), "then this case is to compare them");
        type Call = fn(&Instance) -> fmi3Status;
        let calls: [(&str, Call); 2] = [
            ("count", |i| unsafe { (i.fmi().dependency_count)(i.c, 0, null_mut()) }),
            ("list", |i| unsafe { (i.fmi().dependencies)(i.c, 0, null_mut(), null(), null_mut(), null_mut(), 0) }),
        ];
        refused(fmu, |i: &Instance| i.start(), &calls);
    }),
    ("3D67", "no early return unless it is allowed, whatever is asked for", |fmu| {
        let instance = fmu.make(&Making { update: Some(interrupt), ..logged() }).expect("instantiates");
        instance.start();
        let plain = fmu.started();
        for step in 0..5 {
            let t = 0.1 * f64::from(step);
            assert_eq!(instance.step(t, 0.1), Step { status: fmi3OK, event: false, early: false, time: t + 0.1 });
            plain.go(t, 0.1);
        }
        assert_eq!(instance.all(), plain.all());
        let updates = instance.updates();
        assert!(updates.len() >= 5 && updates.iter().all(|update| !update.can_return), "{updates:?}");
    }),
    ("3D68", "updates and early returns are declared", |fmu| {
        let how = Making { update: Some(interrupt), early_return: true, ..logged() };
        let instance = fmu.make(&how).expect("instantiates");
        instance.start();
        let (mut now, mut early) = (0.0, false);
        while now < 0.5 {
            let step = instance.step(now, 0.5 - now);
            assert_eq!(step.status, fmi3OK);
            early |= step.early;
            now = step.time;
        }
        let updates = instance.updates();
        assert!(fmu.flag("CoSimulation", "providesIntermediateUpdate") || updates.is_empty());
        assert!(fmu.flag("CoSimulation", "mightReturnEarlyFromDoStep") || !early);
        let offered = updates.iter().any(|update| update.can_return);
        assert!(fmu.flag("CoSimulation", "canReturnEarlyAfterIntermediateUpdate") || !offered);
    }),
    ("3D73", "messages in declared categories", |fmu| {
        let instance = fmu.make(&logged()).expect("instantiates");
        instance.start();
        instance.run(0..3);
        instance.step(99.0, 0.1);
        assert_eq!(instance.reset(), fmi3OK);
        instance.start();
        instance.terminate();
        let log = instance.log();
        assert!(log.len() >= 5, "{log:?}");
        let categories = fmu.below("LogCategories/Category");
        let declared: Vec<_> = categories.into_iter().map(|tag| attribute(tag, "name").expect("required")).collect();
        for (status, category, text) in log {
            assert!(declared.contains(&&*category) && !text.is_empty() && !text.ends_with('\n'), "{category}: {text}");
            assert_eq!(status == fmi3Error, category == "logStatusError", "{text}");
        }
    }),
    ("3D76", "signs that mean something in messages", |fmu| {
        // The instance is called `it's 100% # mine`.
        let instance = fmu.make(&logged()).expect("instantiates");
        assert_eq!(instance.category(&[c"100% #1 %s %n"], true), fmi3Error);
        let (_, _, text) = instance.log().pop().expect("a message");
        assert!(text.contains("100% ##1 %s %n"), "{text}");
    }),
    ("3X03", "a call while another one is under way", busy),
    ("3X04", "an importer that traps and rounds otherwise", traps),
    ("3X05", "a thread with a small stack", |fmu| {
        let expected = fmu.started().run(0..20);
        let found = on_a_small_stack(|| {
            let instance = fmu.started();
            let values = instance.run(0..20);
            let state = instance.save();
            instance.bytes(state);
            instance.free_state(state);
            values
        });
        assert!(found == expected);
    }),
];

/// What the importer's logger needs to call back.
struct Caller<'a> {
    library: &'a Library,
    instance: Cell<fmi3Instance>,
    answers: RefCell<Vec<fmi3Status>>,
}

unsafe extern "C" fn call_back(environment: fmi3InstanceEnvironment, _: fmi3Status, _: fmi3String, _: fmi3String) {
    // SAFETY: the environment is the `Caller` below, which outlives its instance.
    let caller = unsafe { &*environment.cast::<Caller>() };
    let (c, library, mut value) = (caller.instance.get(), caller.library, 0.0);
    if !c.is_null() {
        let answers = unsafe { [(library.get)(c, &0, 1, &mut value, 1), (library.terminate)(c)] };
        caller.answers.borrow_mut().extend(answers);
    }
}

/// A call while another one is under way is refused, whoever makes it.
fn busy(fmu: &Fmu) {
    let library = &fmu.library;
    let caller = Caller { library, instance: Cell::new(null_mut()), answers: RefCell::default() };
    let environment = std::ptr::from_ref(&caller).cast_mut().cast();
    let texts = ["name", &fmu.token, &fmu.resources()].map(|text| CString::new(text).expect("no zero"));
    let [name, token, path] = texts.each_ref().map(|text| text.as_ptr());
    unsafe {
        let make = library.instantiate_cosimulation;
        let c = make(name, token, path, 0, 1, 0, 0, null(), 0, environment, Some(call_back), None);
        caller.instance.set(c);
        assert_eq!((library.set)(c, &u32::MAX, 1, &0.0, 1), fmi3Error);
        assert_eq!(*caller.answers.borrow(), [fmi3Error; 2]);
        caller.instance.set(null_mut());
        assert_eq!((library.reset)(c), fmi3OK, "idle again");
        (library.free)(c);
    }
}

/// Nothing traps, and results have the same bits.
fn traps(fmu: &Fmu) {
    let expected = fmu.started().run(0..20);
    let instance = under_traps(|| fmu.made());
    assert_eq!([under_traps(|| instance.enter()), under_traps(|| instance.exit())], [fmi3OK; 2]);
    let references = fmu.references(|_| true);
    for (step, expected) in (0..20_u32).zip(&expected) {
        let (time, value) = (f64::from(step) * 0.01, 0.1 * f64::from(step % 7));
        for input in fmu.inputs().into_iter().filter(|_| step % 5 == 0) {
            assert_eq!(under_traps(|| instance.put(input, value)), fmi3OK);
        }
        assert_eq!(under_traps(|| instance.step(time, 0.01)).status, fmi3OK);
        let values = under_traps(|| instance.read(&references));
        assert!(values.iter().map(|value| value.to_bits()).eq(expected.iter().copied()), "step {step}");
    }
}
