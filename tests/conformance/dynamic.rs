//! What must happen when the functions are called: one function for each case, run in a process of its own.

use std::ffi::{CStr, CString};
use std::os::fd::AsRawFd;
use std::path::Path;
use std::ptr::{null, null_mut};

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Discard, fmi2Error, fmi2OK, fmi2Warning};
use cotree_fmu::fmi2::types::*;

use crate::fmu::*;
use crate::version;

/// A case: what it is called in the catalogue, what it checks, the check.
pub type Case = (&'static str, &'static str, fn(&Fmu));

pub const CASES: &[Case] = &[
    ("D01", "platform and version before instantiation", platform),
    ("D02", "file:///path", |fmu| located(fmu, &fmu.resources())),
    ("D03", "file:/path", |fmu| located(fmu, &fmu.resources().replacen("file://", "file:", 1))),
    ("D04", "escapes in the resource location", escapes),
    ("D05", "no resource location", no_location),
    ("D06", "wrong GUID", wrong_guid),
    ("D07", "missing GUID or name", missing_strings),
    ("D08", "missing callbacks", missing_callbacks),
    ("D09", "an interface that is not offered", wrong_interface),
    ("D10", "arguments of instantiate may be overwritten", transient_arguments),
    ("D11", "free in every state", free_anywhere),
    ("D12", "calls before initialization", before_initialization),
    ("D13", "initialization without an experiment", no_experiment),
    ("D14", "calls during initialization", during_initialization),
    ("D15", "calls while stepping", while_stepping),
    ("D16", "calls after termination", after_termination),
    ("D17", "final values", final_values),
    ("D18", "reset is a fresh start", reset_is_fresh),
    ("D19", "reset restores defaults", reset_restores),
    ("D20", "reset after an error", reset_after_error),
    ("D21", "unknown value references", unknown_references),
    ("D22", "wrong base type", wrong_type),
    ("D23", "empty arrays", empty_arrays),
    ("D24", "missing arrays", missing_arrays),
    ("D25", "setting what is calculated", set_calculated),
    ("D26", "fixed parameters after initialization", fixed_late),
    ("D27", "initial values after initialization", initial_late),
    ("D28", "tunable parameters", tunable),
    ("D29", "fixed parameters before initialization", fixed_early),
    ("D30", "start values hold", start_values),
    ("D31", "inputs read back", inputs),
    ("D32", "outputs in initialization mode", outputs_early),
    ("D33", "every variable can be read", read_all),
    ("D34", "NaN and infinity as values", nan_values),
    ("D35", "values out of range", out_of_range),
    ("D36", "steps of zero or less", no_steps),
    ("D37", "steps that are no numbers", nan_steps),
    ("D38", "a step from elsewhere", far_steps),
    ("D39", "stop time", stop_time),
    ("D40", "start time", start_time),
    ("D41", "a first step from elsewhere", wrong_first_step),
    ("D42", "steps of different lengths", variable_steps),
    ("D43", "determinism", determinism),
    ("D44", "a thousand accumulated points", accumulated),
    ("D45", "two instances", two_instances),
    ("D46", "eight threads", threads),
    ("D47", "another thread", another_thread),
    ("D48", "no memory is lost", memory),
    ("D49", "unload and load again", reload),
    ("D50", "silent, and nothing of the process changes", silent),
    ("D51", "saved state", saved_state),
    ("D52", "states are reused and freed", reused_state),
    ("D53", "a state holds everything", whole_state),
    ("D54", "serialised state", serialised),
    ("D55", "damaged states", damaged),
    ("D56", "capabilities and functions agree", capabilities),
    ("D57", "directional derivatives", directional),
    ("D58", "derivatives of inputs", input_derivatives),
    ("D59", "derivatives of outputs", output_derivatives),
    ("D60", "status functions", status),
    ("D61", "not terminated", terminated_status),
    ("D62", "log categories", log_categories),
    ("D63", "log messages", log_messages),
    ("D64", "silence when all is well", log_silence),
    ("D65", "printf safety", log_printf),
    ("D66", "strings", strings),
    ("D67", "tolerances", tolerances),
    ("D68", "stop before start", stop_before_start),
    ("M01", "Model Exchange: order of calls", exchange_order),
    ("M02", "Model Exchange: sizes", exchange_sizes),
    ("M03", "Model Exchange: derivatives are those of the states", exchange_derivatives),
    ("M04", "Model Exchange: saved state", exchange_state),
    ("X01", "a second copy of the library in the same process", second_library),
    ("X02", "a state from another process", state_from_file),
    ("X03", "an initial value that does not fit", impossible_initial),
    ("X04", "damaged resources", damaged_resources),
    ("X05", "another model's FMU in the same process", another_model),
    ("X06", "a runtime of another version in the same process", another_version),
];

/// Comes before the reason why a model has nothing that a case is about.
pub const NOTHING: &str = "nothing to check: ";

/// Is there nothing that the case is about? Says so.
fn nothing<T>(found: &[T], what: &str) -> bool {
    if found.is_empty() {
        println!("{NOTHING}it has no {what}");
    }
    found.is_empty()
}

// SAFETY of all calls: the component is alive, and arrays are as long as announced.

fn platform(fmu: &Fmu) {
    let text = |call: unsafe extern "C" fn() -> fmi2String| unsafe { CStr::from_ptr(call()) };
    assert_eq!((text(fmu.library.types_platform), text(fmu.library.version)), (c"default", c"2.0"));
}

fn located(fmu: &Fmu, location: &str) {
    fmu.instantiate(fmi2CoSimulation, location, false).expect("instantiates").start();
}

fn escapes(fmu: &Fmu) {
    let folder = tempfile::tempdir().expect("a folder");
    let resources = folder.path().join("a b é%");
    copy(&fmu.folder.join("resources"), &resources);
    located(fmu, &format!("file://{}/a%20b%20%C3%A9%25", folder.path().display()));
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        std::fs::copy(entry.path(), to.join(entry.file_name())).expect("a copy");
    }
}

/// Calls `fmi2Instantiate` with these pointers.
fn make(
    fmu: &Fmu,
    [name, guid, location]: [Option<&CStr>; 3],
    callbacks: *const fmi2CallbackFunctions,
) -> fmi2Component {
    let [name, guid, location] = [name, guid, location].map(|text| text.map_or(null(), CStr::as_ptr));
    unsafe { (fmu.library.instantiate)(name, fmi2CoSimulation, guid, location, callbacks, 0, 0) }
}

fn good(fmu: &Fmu) -> [CString; 3] {
    ["a", &fmu.guid, &fmu.resources()].map(|text| CString::new(text).expect("no zero"))
}

fn no_location(fmu: &Fmu) {
    let [name, guid, _] = good(fmu);
    for location in [None, Some(c"")] {
        let messages = Messages::default();
        let c = make(fmu, [Some(&name), Some(&guid), location], &callbacks(&messages));
        assert!(c.is_null() && messages.lock().expect("not poisoned").len() == 1);
    }
}

fn wrong_guid(fmu: &Fmu) {
    let [name, _, location] = good(fmu);
    let messages = Messages::default();
    assert!(make(fmu, [Some(&name), Some(c"{1}"), Some(&location)], &callbacks(&messages)).is_null());
    assert_eq!(messages.lock().expect("not poisoned").len(), 1);
}

fn missing_strings(fmu: &Fmu) {
    let [name, guid, location] = good(fmu);
    let messages = Messages::default();
    for [name, guid] in [[None, Some(&*guid)], [Some(c""), Some(&guid)], [Some(&name), None]] {
        assert!(make(fmu, [name, guid, Some(&location)], &callbacks(&messages)).is_null());
    }
}

fn missing_callbacks(fmu: &Fmu) {
    let [name, guid, location] = good(fmu);
    let strings = [Some(&*name), Some(&guid), Some(&location)];
    assert!(make(fmu, strings, null()).is_null());
    let nothing = fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: null_mut(),
    };
    let c = make(fmu, strings, &nothing);
    assert!(!c.is_null());
    assert_eq!(unsafe { (fmu.library.do_step)(c, 0.0, 1.0, 1) }, fmi2Error);
    unsafe { (fmu.library.free_instance)(c) };
}

fn wrong_interface(fmu: &Fmu) {
    let offered = !fmu.below("fmiModelDescription/ModelExchange").is_empty();
    assert_eq!(fmu.instantiate(fmi2ModelExchange, &fmu.resources(), false).is_some(), offered);
    assert!(fmu.instantiate(7, &fmu.resources(), false).is_none());
}

fn transient_arguments(fmu: &Fmu) {
    let messages = Messages::default();
    let mut strings = good(fmu).map(CString::into_bytes_with_nul);
    let mut functions = callbacks(&messages);
    let texts = [0, 1, 2].map(|index| CStr::from_bytes_with_nul(&strings[index]).ok());
    let c = make(fmu, texts, &functions);
    strings.iter_mut().for_each(|text| text.fill(b'x'));
    functions.logger = None;
    functions.componentEnvironment = null_mut();
    std::hint::black_box((&strings, &functions));
    assert_eq!(unsafe { (fmu.library.terminate)(c) }, fmi2Error);
    assert_eq!(messages.lock().expect("not poisoned")[0].0, "a");
    unsafe { (fmu.library.free_instance)(c) };
}

fn free_anywhere(fmu: &Fmu) {
    unsafe { (fmu.library.free_instance)(null_mut()) };
    drop(fmu.slave());
    let slave = fmu.slave();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    drop(slave);
    drop(fmu.started());
    let slave = fmu.started();
    slave.run(0..3);
    assert_eq!(slave.terminate(), fmi2OK);
}

fn before_initialization(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.step(0.0, 0.1), slave.exit(), slave.terminate()], [fmi2Error; 3]);
    assert_eq!(slave.get(fmu.outputs()[0]), Err(fmi2Error));
}

fn no_experiment(fmu: &Fmu) {
    assert_eq!(fmu.slave().enter(), fmi2Error);
}

fn during_initialization(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    assert_eq!([slave.enter(), slave.setup(0.0, None, None), slave.step(0.0, 0.1), slave.terminate()], [fmi2Error; 4]);
    assert_eq!(slave.exit(), fmi2OK);
}

fn while_stepping(fmu: &Fmu) {
    let slave = fmu.started();
    assert_eq!([slave.enter(), slave.exit(), slave.setup(0.0, None, None)], [fmi2Error; 3]);
    slave.run(0..2);
}

fn after_termination(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..2);
    assert_eq!(slave.terminate(), fmi2OK);
    assert_eq!([slave.step(0.02, 0.01), slave.terminate()], [fmi2Error; 2]);
    for settable in fmu.inputs().into_iter().chain(fmu.tunable()) {
        assert_eq!(slave.put(settable, 1.0), fmi2Error);
    }
}

fn final_values(fmu: &Fmu) {
    let slave = fmu.started();
    let last = slave.run(0..5).pop();
    assert_eq!(slave.terminate(), fmi2OK);
    assert_eq!(Some(slave.all()), last);
}

fn reset_is_fresh(fmu: &Fmu) {
    let fresh = fmu.started().run(0..30);
    let slave = fmu.slave();
    let check = || {
        assert_eq!(slave.reset(), fmi2OK);
        slave.start();
        assert_eq!(slave.run(0..30), fresh);
    };
    check();
    check();
    assert_eq!([slave.reset(), slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 3]);
    check();
    assert_eq!(slave.terminate(), fmi2OK);
    check();
}

fn reset_restores(fmu: &Fmu) {
    let slave = fmu.slave();
    let settable = || fmu.inputs().into_iter().chain(fmu.tunable()).chain(fmu.fixed());
    settable().for_each(|reference| assert_eq!(slave.put(reference, fmu.other(reference)), fmi2OK));
    assert_eq!([slave.reset(), slave.enter()], [fmi2OK, fmi2Error]);
    slave.start();
    settable().for_each(|reference| assert_eq!(slave.get(reference), Ok(fmu.default(reference))));
}

fn reset_after_error(fmu: &Fmu) {
    let fresh = fmu.started().run(0..10);
    let slave = fmu.started();
    slave.run(0..3);
    assert_eq!(slave.step(77.0, 0.1), fmi2Error);
    assert_eq!(slave.reset(), fmi2OK);
    slave.start();
    assert_eq!(slave.run(0..10), fresh);
}

const UNKNOWN: u32 = 1_000_000;

fn unknown_references(fmu: &Fmu) {
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

fn wrong_type(fmu: &Fmu) {
    let slave = fmu.started();
    fmu.references(|_| true).into_iter().for_each(|reference| other_types(&slave, reference));
    slave.run(0..2);
}

fn empty_arrays(fmu: &Fmu) {
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

fn missing_arrays(fmu: &Fmu) {
    let slave = fmu.started();
    let (fmi, c, reference, mut value) = (slave.fmi(), slave.c, fmu.outputs()[0], 0.0);
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

fn set_calculated(fmu: &Fmu) {
    let slave = fmu.slave();
    let calculated = fmu.references(is_calculated);
    let refused = || calculated.iter().for_each(|&reference| assert_eq!(slave.put(reference, 0.1), fmi2Error));
    refused();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    refused();
    assert_eq!(slave.exit(), fmi2OK);
    refused();
}

fn fixed_late(fmu: &Fmu) {
    if nothing(&fmu.fixed(), "fixed parameter") {
        return;
    }
    let slave = fmu.started();
    for fixed in fmu.fixed() {
        assert_eq!(slave.put(fixed, fmu.other(fixed)), fmi2Error);
        assert_eq!(slave.get(fixed), Ok(fmu.default(fixed)));
    }
}

fn initial_late(fmu: &Fmu) {
    let slave = fmu.started();
    let before = slave.all();
    for known in fmu.references(|variable| variable.causality != "input" && variable.variability == "continuous") {
        assert_eq!(slave.put(known, 0.1), fmi2Error);
    }
    assert_eq!(slave.all(), before);
}

fn tunable(fmu: &Fmu) {
    if nothing(&fmu.tunable(), "tunable parameter") {
        return;
    }
    let slave = fmu.started();
    slave.run(0..2);
    for tunable in fmu.tunable() {
        let value = fmu.other(tunable);
        assert_eq!((slave.put(tunable, value), slave.get(tunable)), (fmi2OK, Ok(value)));
    }
    slave.run(2..4);
}

fn fixed_early(fmu: &Fmu) {
    if nothing(&fmu.fixed(), "fixed parameter") {
        return;
    }
    let slave = fmu.slave();
    for fixed in fmu.fixed() {
        assert_eq!(slave.put(fixed, fmu.other(fixed)), fmi2OK);
    }
    slave.start();
    for fixed in fmu.fixed() {
        assert_eq!(slave.get(fixed), Ok(fmu.other(fixed)));
    }
    assert_ne!(slave.read(&fmu.outputs()), fmu.started().read(&fmu.outputs()), "parameters count");
}

fn start_values(fmu: &Fmu) {
    let slave = fmu.started();
    for variable in &fmu.variables {
        let exact = variable.initial.as_deref() == Some("exact");
        if let Some(start) = variable.start.filter(|_| exact || variable.causality == "input") {
            let found = slave.get(variable.reference).expect("readable");
            assert!((found - start).abs() <= 1e-12 * start.abs().max(1.0), "{}: {found} for {start}", variable.name);
        }
    }
}

fn inputs(fmu: &Fmu) {
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

fn outputs_early(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    let before = slave.read(&fmu.outputs());
    assert_eq!(slave.exit(), fmi2OK);
    assert_eq!(before, slave.read(&fmu.outputs()));
}

fn read_all(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..3);
    let mut references = fmu.references(|_| true);
    let values = slave.read(&references);
    assert_eq!(values, slave.read(&references));
    references.extend(references.clone());
    assert_eq!([values.clone(), values].concat(), slave.read(&references));
}

fn nan_values(fmu: &Fmu) {
    if nothing(&[fmu.inputs(), fmu.tunable()].concat(), "input and no tunable parameter") {
        return;
    }
    let slave = fmu.started();
    for reference in fmu.inputs().into_iter().chain(fmu.tunable()) {
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

fn out_of_range(fmu: &Fmu) {
    if nothing(&fmu.references(|variable| variable.min.or(variable.max).is_some()), "limit of a variable") {
        return;
    }
    let slave = fmu.slave();
    for variable in &fmu.variables {
        let beyond = [variable.min.map(|min| min - 1.0), variable.max.map(|max| max + 1.0)];
        for value in beyond.into_iter().flatten() {
            assert_eq!(slave.put(variable.reference, value), fmi2Error);
        }
    }
    slave.start();
}

fn no_steps(fmu: &Fmu) {
    let slave = fmu.started();
    assert_eq!([slave.step(0.0, 0.0), slave.step(0.0, -0.01)], [fmi2Error; 2]);
    slave.run(0..1);
}

fn nan_steps(fmu: &Fmu) {
    let slave = fmu.started();
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!([slave.step(odd, 0.01), slave.step(0.0, odd)], [fmi2Error; 2]);
    }
    slave.run(0..1);
}

fn far_steps(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..2);
    assert_eq!([slave.step(36_000.0, 0.01), slave.step(-36_000.0, 0.01)], [fmi2Error; 2]);
}

fn stop_time(fmu: &Fmu) {
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

fn last_time(slave: &Slave) -> f64 {
    let mut time = f64::NAN;
    assert_eq!(unsafe { (slave.fmi().get_real_status)(slave.c, fmi2LastSuccessfulTime, &mut time) }, fmi2OK);
    time
}

fn start_time(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.setup(2.5, None, None), slave.enter(), slave.exit()], [fmi2OK; 3]);
    assert_eq!([slave.step(2.5, 0.25), slave.step(2.75, 0.25)], [fmi2OK; 2]);
    assert_eq!(last_time(&slave), 3.0);
}

fn wrong_first_step(fmu: &Fmu) {
    assert_eq!(fmu.started().step(18_000.0, 0.01), fmi2Error);
}

fn variable_steps(fmu: &Fmu) {
    let slave = fmu.started();
    let mut t = 0.0;
    for h in [0.04, 0.02, 0.01, 0.08, 1e-6, 0.3] {
        assert_eq!(slave.step(t, h), fmi2OK);
        t += h;
    }
    let other = fmu.started();
    assert_eq!(other.step(0.0, t), fmi2OK);
    for (a, b) in slave.read(&fmu.outputs()).into_iter().zip(other.read(&fmu.outputs())) {
        assert!((a - b).abs() <= 1e-4 * a.abs().max(1.0), "{a} and {b}");
    }
}

fn determinism(fmu: &Fmu) {
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

fn accumulated(fmu: &Fmu) {
    let slave = fmu.started();
    let mut t = 0.0;
    for _ in 0..1000 {
        assert_eq!(slave.step(t, 0.0007), fmi2OK, "{:?}", slave.log());
        t += 0.0007;
    }
    assert!((last_time(&slave) - t).abs() < 1e-12);
}

fn two_instances(fmu: &Fmu) {
    let expected = fmu.started().run(0..20);
    let (first, second) = (fmu.started(), fmu.started());
    for step in 0..20 {
        let wanted = &expected[step as usize..=step as usize];
        assert!(first.run(step..step + 1) == wanted && second.run(step..step + 1) == wanted);
    }
}

/// A pointer that may go to another thread: one thread at a time uses it.
struct Sent<T>(T);
// SAFETY: see above.
unsafe impl<T> Send for Sent<T> {}

impl<T> Sent<T> {
    fn take(self) -> T {
        self.0
    }
}

fn threads(fmu: &Fmu) {
    let expected = fmu.started().run(0..200);
    std::thread::scope(|scope| {
        let all: Vec<_> = (0..8)
            .map(|_| {
                let slave = Sent(fmu.started());
                scope.spawn(move || slave.take().run(0..200))
            })
            .collect();
        for thread in all {
            assert!(thread.join().expect("no panic") == expected);
        }
    });
}

fn another_thread(fmu: &Fmu) {
    let expected = fmu.started().run(0..5);
    let slave = Sent(fmu.slave());
    std::thread::scope(|scope| {
        let run = scope.spawn(move || {
            let slave = slave.take();
            slave.start();
            slave.run(0..5)
        });
        assert_eq!(run.join().expect("no panic"), expected);
    });
}

/// Resident memory in bytes.
fn resident() -> usize {
    let text = std::fs::read_to_string("/proc/self/statm").expect("Linux");
    4096 * text.split(' ').nth(1).expect("a number").parse::<usize>().expect("a number")
}

fn memory(fmu: &Fmu) {
    let once = || drop(fmu.started().run(0..3));
    (0..20).for_each(|_| once());
    let before = resident();
    (0..300).for_each(|_| once());
    let growth = resident().saturating_sub(before);
    assert!(growth < 3 << 20, "{growth} bytes");
}

fn reload(fmu: &Fmu) {
    let expected = fmu.started().run(0..3);
    for _ in 0..5 {
        let again = Fmu::open(&fmu.folder);
        assert_eq!(again.started().run(0..3), expected);
    }
}

/// What the process is like: folder, locale, rounding, handlers of faults.
fn surroundings() -> (std::path::PathBuf, CString, [bool; 2], [usize; 2]) {
    let folder = std::env::current_dir().expect("a folder");
    let small = std::hint::black_box(f64::EPSILON / 8.0);
    let rounding = [1.0 + small == 1.0, 1.0 - small == 1.0];
    // SAFETY: null asks for the present locale and handlers only.
    unsafe {
        let locale = CStr::from_ptr(libc::setlocale(libc::LC_ALL, null())).to_owned();
        let handlers = [libc::SIGSEGV, libc::SIGFPE].map(|signal| {
            let mut action: libc::sigaction = std::mem::zeroed();
            libc::sigaction(signal, null(), &mut action);
            action.sa_sigaction
        });
        (folder, locale, rounding, handlers)
    }
}

fn silent(fmu: &Fmu) {
    let before = surroundings();
    let file = tempfile::tempfile().expect("a file");
    // SAFETY: the file descriptors are open.
    let kept = unsafe { [1, 2].map(|fd| (fd, libc::dup(fd))) };
    [1, 2].iter().for_each(|&fd| assert_eq!(unsafe { libc::dup2(file.as_raw_fd(), fd) }, fd));
    let slave = fmu.started();
    slave.run(0..5);
    slave.put(UNKNOWN, 1.0);
    slave.terminate();
    drop(slave);
    kept.iter().for_each(|&(fd, copy)| assert_eq!(unsafe { libc::dup2(copy, fd) }, fd));
    assert_eq!(file.metadata().expect("open").len(), 0, "something was printed");
    assert_eq!(surroundings(), before);
}

fn saved_state(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..13);
    let state = slave.save();
    let expected = slave.run(13..40);
    assert_eq!(slave.restore(state), fmi2OK);
    assert_eq!(slave.run(13..40), expected);
    assert_eq!(slave.restore(state), fmi2OK);
    assert_eq!(slave.run(13..40), expected);
    assert_eq!(fmu.started().run(0..40)[13..], expected, "saving changes nothing");
    slave.free(state);
}

fn reused_state(fmu: &Fmu) {
    let slave = fmu.started();
    let (mut first, second) = (slave.save(), slave.save());
    let place = first;
    slave.run(0..3);
    assert_eq!(unsafe { (slave.fmi().get_state)(slave.c, &mut first) }, fmi2OK);
    assert_eq!(first, place);
    slave.free(second);
    let expected = slave.run(3..6);
    assert_eq!(slave.restore(first), fmi2OK);
    assert_eq!(slave.run(3..6), expected);
    slave.free(first);
    let mut nothing = null_mut();
    assert_eq!(unsafe { (slave.fmi().free_state)(slave.c, &mut nothing) }, fmi2OK);
    assert_eq!(unsafe { (slave.fmi().free_state)(slave.c, null_mut()) }, fmi2OK);
}

fn whole_state(fmu: &Fmu) {
    let settable: Vec<u32> = fmu.inputs().into_iter().chain(fmu.tunable()).collect();
    let slave = fmu.slave();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    let early = slave.save();
    assert_eq!(slave.exit(), fmi2OK);
    slave.run(0..3);
    let late = slave.save();
    let (values, time) = (slave.all(), last_time(&slave));
    settable.iter().for_each(|&reference| assert_eq!(slave.put(reference, fmu.other(reference)), fmi2OK));
    assert_eq!(slave.step(0.03, 0.01), fmi2OK);
    assert_eq!(slave.terminate(), fmi2OK);
    assert_eq!(slave.restore(late), fmi2OK);
    assert_eq!((slave.all(), last_time(&slave)), (values, time));
    assert_eq!(slave.restore(early), fmi2OK);
    assert_eq!(slave.step(0.0, 0.01), fmi2Error, "initialization mode is back");
    assert_eq!(slave.exit(), fmi2OK);
    [early, late].into_iter().for_each(|state| slave.free(state));
}

fn serialised(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..13);
    let state = slave.save();
    let bytes = slave.bytes(state);
    let expected = slave.run(13..40);
    let other = fmu.slave();
    let copy = other.deserialize(&bytes).expect("own bytes");
    assert_eq!(other.bytes(copy), bytes);
    assert_eq!(other.restore(copy), fmi2OK);
    assert_eq!(other.run(13..40), expected);
    slave.free(state);
    other.free(copy);
}

fn damaged(fmu: &Fmu) {
    let slave = fmu.started();
    let state = slave.save();
    let mut bytes = slave.bytes(state);
    let room = bytes.len() - 1;
    let mut small = vec![0; room];
    assert_eq!(unsafe { (slave.fmi().serialize)(slave.c, state, small.as_mut_ptr(), room) }, fmi2Error);
    for length in 0..bytes.len() {
        assert_eq!(slave.deserialize(&bytes[..length]), Err(fmi2Error));
    }
    for place in 0..bytes.len() {
        for bit in [1, 0x10] {
            bytes[place] ^= bit;
            assert_eq!(slave.deserialize(&bytes), Err(fmi2Error), "byte {place}");
            bytes[place] ^= bit;
        }
    }
    slave.free(state);
    slave.run(0..2);
}

fn capabilities(fmu: &Fmu) {
    for interface in ["CoSimulation", "ModelExchange"] {
        if fmu.below(&format!("fmiModelDescription/{interface}")).is_empty() {
            continue;
        }
        for flag in ["canGetAndSetFMUstate", "canSerializeFMUstate", "providesDirectionalDerivative"] {
            assert!(fmu.flag(interface, flag), "{flag}");
        }
    }
    assert!(fmu.flag("CoSimulation", "canInterpolateInputs"));
    assert!(!fmu.flag("CoSimulation", "canRunAsynchronuously"));
    assert_eq!(unsafe { (fmu.library.cancel_step)(fmu.started().c) }, fmi2Error);
}

/// Central differences of fourth order.
fn difference(values_at: impl Fn(f64) -> Vec<f64>, h: f64) -> Vec<f64> {
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| values_at(k * h));
    (0..a.len()).map(|i| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * h)).collect()
}

fn agree(fmu: &Fmu, unknowns: &[u32], exact: &[f64], found: &[f64], limit: f64) {
    for ((&unknown, exact), found) in unknowns.iter().zip(exact).zip(found) {
        let name = &fmu.variable(unknown).name;
        assert!((exact - found).abs() <= limit * exact.abs().max(1.0), "{name}: {exact}, by differences {found}");
    }
}

fn directional(fmu: &Fmu) {
    if nothing(&[fmu.inputs(), fmu.tunable()].concat(), "input and no tunable parameter") {
        return;
    }
    let unknowns = fmu.references(|variable| matches!(variable.causality.as_str(), "output" | "local"));
    let slave = fmu.started();
    slave.run(0..7);
    for known in fmu.inputs().into_iter().chain(fmu.tunable()) {
        let exact = slave.derivatives(&unknowns, known);
        let before = slave.get(known).expect("readable");
        let at = |change: f64| {
            assert_eq!(slave.put(known, before + change), fmi2OK);
            slave.read(&unknowns)
        };
        let found = difference(at, 1e-2);
        assert_eq!(slave.put(known, before), fmi2OK);
        agree(fmu, &unknowns, &exact, &found, 1e-7);
    }
    let (mut value, unknown) = (0.0, unknowns[0]);
    let wrong = |unknown: u32, known: u32, value: &mut f64| unsafe {
        (slave.fmi().directional_derivative)(slave.c, &unknown, 1, &known, 1, &1.0, value)
    };
    assert_eq!([wrong(unknown, UNKNOWN, &mut value), wrong(UNKNOWN, unknown, &mut value)], [fmi2Error; 2]);
}

fn input_derivatives(fmu: &Fmu) {
    if nothing(&fmu.inputs(), "input") {
        return;
    }
    let slave = fmu.started();
    let set = |reference: u32, order: i32| unsafe {
        (slave.fmi().set_input_derivatives)(slave.c, &reference, 1, &order, &1.0)
    };
    assert_eq!([set(UNKNOWN, 1), set(fmu.outputs()[0], 1)], [fmi2Error; 2]);
    for input in fmu.inputs() {
        assert_eq!([set(input, 1), set(input, 0), set(input, 3)], [fmi2OK, fmi2Error, fmi2Error]);
        let before = slave.get(input).expect("readable");
        assert_eq!(slave.step(0.0, 0.5), fmi2OK);
        assert_eq!(slave.get(input), Ok(before + 0.5), "the derivative acts");
    }
}

/// Outputs of a run that ends at a time, or their derivatives by time; the status if they are refused.
fn outputs_at(slave: &Slave, start: fmi2FMUstate, time: f64, order: i32) -> Result<Vec<f64>, fmi2Status> {
    let outputs = slave.fmu.outputs();
    assert_eq!([slave.restore(start), slave.step(0.0, time)], [fmi2OK; 2]);
    let (orders, mut values) = (vec![order; outputs.len()], vec![f64::NAN; outputs.len()]);
    let (references, count) = (outputs.as_ptr(), outputs.len());
    let status = unsafe {
        match order {
            0 => (slave.fmi().get_real)(slave.c, references, count, values.as_mut_ptr()),
            _ => {
                let call = slave.fmi().get_output_derivatives;
                call(slave.c, references, count, orders.as_ptr(), values.as_mut_ptr())
            }
        }
    };
    if status == fmi2OK { Ok(values) } else { Err(status) }
}

fn output_derivatives(fmu: &Fmu) {
    const H: f64 = 1e-3;
    let [fine, coarse] = [1e-12, 1e-11].map(|tolerance| {
        let slave = fmu.slave();
        assert_eq!([slave.setup(0.0, None, Some(tolerance)), slave.enter(), slave.exit()], [fmi2OK; 3]);
        (slave.save(), slave)
    });
    let at =
        |(start, slave): &(fmi2FMUstate, Slave), time, order| outputs_at(slave, *start, time, order).expect("provided");
    let declared = fmu.below("fmiModelDescription/CoSimulation")[0];
    let highest: i32 = attribute(declared, "maxOutputDerivativeOrder").expect("declared").parse().expect("a number");
    for order in 1..=highest {
        let [exact, exact_again] = [&fine, &coarse].map(|run| at(run, 0.1, order));
        let [lower, lower_again] = [&fine, &coarse].map(|run| at(run, 0.1, order - 1));
        let found = difference(|change| at(&fine, 0.1 + change, order - 1), H);
        for (index, &output) in fmu.outputs().iter().enumerate() {
            // What another tolerance changes is not known any better: stiff motion multiplies every error of the state.
            let unknown = (exact[index] - exact_again[index]).abs() + (lower[index] - lower_again[index]).abs() / H;
            let limit = 1e-5 * exact[index].abs().max(lower[index].abs()).max(1.0) + 10.0 * unknown;
            let name = &fmu.variable(output).name;
            let (exact, found) = (exact[index], found[index]);
            assert!((exact - found).abs() <= limit, "{name}, order {order}: {exact}, by differences {found}");
        }
    }
    for order in [-1, highest + 1] {
        assert_eq!(outputs_at(&fine.1, fine.0, 0.1, order), Err(fmi2Error));
    }
    let (output, mut value) = (fmu.outputs()[0], 0.0);
    let zero = unsafe { (fmu.library.get_output_derivatives)(fine.1.c, &output, 1, &0, &mut value) };
    assert_eq!(zero, fmi2Error);
    [fine, coarse].into_iter().for_each(|(state, slave)| slave.free(state));
}

fn status(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..4);
    assert!((last_time(&slave) - 0.04).abs() < 1e-12);
    let (fmi, c) = (slave.fmi(), slave.c);
    let (mut real, mut integer, mut state, mut text) = (0.0, 0, fmi2OK, null());
    let found = unsafe {
        [
            (fmi.get_status)(c, fmi2DoStepStatus, &mut state),
            (fmi.get_real_status)(c, fmi2PendingStatus, &mut real),
            (fmi.get_integer_status)(c, fmi2DoStepStatus, &mut integer),
            (fmi.get_boolean_status)(c, fmi2DoStepStatus, &mut integer),
            (fmi.get_string_status)(c, fmi2PendingStatus, &mut text),
        ]
    };
    assert_eq!(found, [fmi2Discard; 5]);
    assert_eq!(unsafe { (fmi.cancel_step)(c) }, fmi2Error);
}

fn terminated_status(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..1);
    let mut terminated = 7;
    assert_eq!(unsafe { (slave.fmi().get_boolean_status)(slave.c, fmi2Terminated, &mut terminated) }, fmi2OK);
    assert_eq!(terminated, fmi2False);
}

fn categories(fmu: &Fmu) -> Vec<String> {
    let tags = fmu.below("/LogCategories/Category");
    tags.into_iter().map(|tag| attribute(tag, "name").expect("required").to_owned()).collect()
}

fn log_categories(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.debug(true, &[]), slave.debug(false, &[])], [fmi2OK; 2]);
    for category in categories(fmu) {
        let name = CString::new(category).expect("no zero");
        assert_eq!([slave.debug(true, &[&name]), slave.debug(false, &[&name])], [fmi2OK; 2]);
    }
    assert!([fmi2Error, fmi2Warning].contains(&slave.debug(true, &[c"no such category"])));
}

fn log_messages(fmu: &Fmu) {
    let slave = fmu.instantiate(fmi2CoSimulation, &fmu.resources(), true).expect("instantiates");
    slave.start();
    slave.run(0..3);
    slave.put(UNKNOWN, 1.0);
    slave.step(9.0, 1.0);
    slave.terminate();
    let log = slave.log();
    assert!(log.len() >= 5, "{log:?}");
    for (instance, status, category, message) in log {
        assert_eq!(instance, "it's 100% # mine");
        assert!(categories(fmu).contains(&category) && !message.is_empty() && !message.ends_with('\n'));
        assert_eq!(status == fmi2Error, category == "errors");
    }
}

fn log_silence(fmu: &Fmu) {
    let slave = fmu.started();
    slave.run(0..10);
    slave.terminate();
    assert_eq!(slave.log(), []);
}

fn log_printf(fmu: &Fmu) {
    let slave = fmu.started();
    slave.put(UNKNOWN, 1.0);
    slave.step(f64::NAN, 1.0);
    for (_, _, _, message) in slave.log() {
        assert!(!message.replace("%%", "").contains('%'), "{message}");
    }
}

fn strings(fmu: &Fmu) {
    assert!(fmu.below("/ScalarVariable/String").is_empty(), "there are none");
    assert_eq!(unsafe { (fmu.library.get_string)(fmu.started().c, null(), 0, null_mut()) }, fmi2OK);
}

fn tolerances(fmu: &Fmu) {
    for tolerance in [1e-3, 1e-10, 1e-16, 10.0] {
        let slave = fmu.slave();
        assert_eq!([slave.setup(0.0, None, Some(tolerance)), slave.enter(), slave.exit()], [fmi2OK; 3]);
        slave.run(0..10);
    }
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(fmu.slave().setup(0.0, None, Some(tolerance)), fmi2Error);
    }
}

fn stop_before_start(fmu: &Fmu) {
    let slave = fmu.slave();
    assert_eq!([slave.setup(1.0, Some(0.5), None), slave.setup(f64::NAN, None, None)], [fmi2Error; 2]);
    slave.start();
}

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
    assert!(status != fmi2OK || (info.newDiscreteStatesNeeded, info.terminateSimulation) == (0, 0));
    status
}

fn exchange_order(fmu: &Fmu) {
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
    for tunable in fmu.tunable() {
        assert_eq!(slave.put(tunable, fmu.other(tunable)), fmi2Error, "in event mode only");
    }
    assert_eq!(unsafe { (fmi.enter_event_mode)(c) }, fmi2OK);
    for tunable in fmu.tunable() {
        assert_eq!(slave.put(tunable, fmu.other(tunable)), fmi2OK);
    }
    assert_eq!([event(&slave), continuous(), slave.terminate(), continuous()], [fmi2OK, fmi2OK, fmi2OK, fmi2Error]);
    slave.all();
    let alone = fmu.started();
    assert_eq!([unsafe { (fmi.set_time)(alone.c, 0.0) }, event(&alone)], [fmi2Error; 2], "not in Co-Simulation");
    assert_eq!(slave.reset(), fmi2OK);
    slave.start();
}

fn exchange_sizes(fmu: &Fmu) {
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
            assert_eq!((fmi.set_continuous_states)(c, [f64::NAN].repeat(count).as_ptr(), count), fmi2Error);
            assert_eq!((fmi.get_derivatives)(c, null_mut(), count), fmi2Error);
        }
    }
}

fn exchange_derivatives(fmu: &Fmu) {
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
        let state = &fmu.variables[derivative.derivative.expect("a derivative") - 1];
        assert_eq!(
            (slave.get(state.reference), slave.get(derivative.reference)),
            (Ok(values[place]), Ok(rates[place]))
        );
    }
    // By the states: along each of them.
    let unknowns: Vec<u32> = derivatives.iter().map(|variable| variable.reference).collect();
    assert_eq!([event(&slave), unsafe { (fmi.enter_continuous_time_mode)(c) }], [fmi2OK; 2]);
    for (place, derivative) in derivatives.iter().enumerate() {
        let state = &fmu.variables[derivative.derivative.expect("a derivative") - 1];
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

fn exchange_state(fmu: &Fmu) {
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

fn second_library(fmu: &Fmu) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = Fmu::library_path(&fmu.folder, &fmu.identifier);
    let copy = folder.path().join("another.so");
    std::fs::copy(path, &copy).expect("a copy");
    let mut second = Fmu::open(&fmu.folder);
    second.library = Library::load(&copy);
    let expected = fmu.started().run(0..20);
    let (first, other) = (fmu.started(), second.started());
    for step in 0..20 {
        let wanted = &expected[step as usize..=step as usize];
        assert!(first.run(step..step + 1) == wanted && other.run(step..step + 1) == wanted);
    }
}

/// The first process writes a state and where it leads; the one that finds them goes on from there.
fn state_from_file(fmu: &Fmu) {
    let file = fmu.folder.join("state.bin");
    let slave = fmu.slave();
    if let Ok(bytes) = std::fs::read(&file) {
        let bytes: Vec<i8> = bytes.into_iter().map(|byte| byte as i8).collect();
        let (expected, bytes) = bytes.split_at(8 * fmu.variables.len());
        let state = slave.deserialize(bytes).expect("own bytes");
        assert_eq!(slave.restore(state), fmi2OK);
        let found = slave.run(13..40).pop().expect("steps");
        assert!(found.iter().flat_map(|bits| bits.to_le_bytes()).eq(expected.iter().map(|&byte| byte as u8)));
        return slave.free(state);
    }
    slave.start();
    slave.run(0..13);
    let state = slave.save();
    let bytes = slave.bytes(state);
    let last = slave.run(13..40).pop().expect("steps");
    let all: Vec<u8> =
        last.iter().flat_map(|bits| bits.to_le_bytes()).chain(bytes.into_iter().map(|byte| byte as u8)).collect();
    std::fs::write(&file, all).expect("a file");
    slave.free(state);
    crate::respawn();
}

fn impossible_initial(fmu: &Fmu) {
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

/// Whatever has happened to the program: no instance, one message, no crash.
fn damaged_resources(fmu: &Fmu) {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = std::fs::read(fmu.folder.join("resources/program.bin")).expect("a program");
    let refused = |bytes: Option<&[u8]>| {
        let file = folder.path().join("program.bin");
        match bytes {
            Some(bytes) => std::fs::write(&file, bytes).expect("a file"),
            None => std::fs::remove_file(&file).expect("a file"),
        }
        let [name, guid, _] = good(fmu);
        let location = CString::new(format!("file://{}", folder.path().display())).expect("no zero");
        let messages = Messages::default();
        let c = make(fmu, [Some(&name), Some(&guid), Some(&location)], &callbacks(&messages));
        assert!(c.is_null() && messages.lock().expect("not poisoned").len() == 1);
    };
    let places = (0..whole.len()).step_by(whole.len() / 200 + 1);
    for place in places {
        let mut changed = whole.clone();
        changed[place] ^= 0x24;
        refused(Some(&changed));
        refused(Some(&whole[..place]));
    }
    refused(Some(&[&whole[..], b"more"].concat()));
    refused(None);
    located(fmu, &fmu.resources());
}

/// In turns with an instance of each other model, each from its own library.
fn another_model(fmu: &Fmu) {
    let models = fmu.folder.parent().expect("models beside it");
    let folders = std::fs::read_dir(models).expect("a folder").map(|entry| entry.expect("an entry").path());
    let folders = folders.filter(|path| path.join("modelDescription.xml").is_file() && *path != fmu.folder);
    let others: Vec<Fmu> = folders.map(|folder| Fmu::open(&folder)).collect();
    assert!(!others.is_empty());
    let expected = fmu.started().run(0..20);
    let slave = fmu.started();
    let strangers: Vec<Slave> = others.iter().map(Fmu::started).collect();
    for step in 0..20 {
        strangers.iter().for_each(|stranger| drop(stranger.run(step..step + 1)));
        assert!(slave.run(step..step + 1) == expected[step as usize..=step as usize]);
    }
    // A state of another model is refused.
    let state = strangers[0].save();
    assert_eq!(slave.deserialize(&strangers[0].bytes(state)), Err(fmi2Error));
    strangers[0].free(state);
}

/// An FMU of another version: its own runtime, and a program in that runtime's format.
fn of_another_version(fmu: &Fmu, folder: &Path) -> Fmu {
    let path = std::env::var(crate::OTHER).expect("set by the first process");
    let format = version::format(Path::new(&path));
    assert_ne!(format, version::format(&Fmu::library_path(&fmu.folder, &fmu.identifier)));
    copy(&fmu.folder.join("resources"), &folder.join("resources"));
    let program = folder.join("resources/program.bin");
    let mut bytes = std::fs::read(&program).expect("a program");
    // After the mark.
    bytes[4..8].copy_from_slice(&format.to_le_bytes());
    std::fs::write(&program, bytes).expect("a file");
    let mut other = Fmu::open(&fmu.folder);
    (other.folder, other.library) = (folder.to_owned(), Library::load(Path::new(&path)));
    other
}

/// In turns with an instance of a runtime of another version; neither reads what the other has written.
fn another_version(fmu: &Fmu) {
    let folder = tempfile::tempdir().expect("a folder");
    let other = of_another_version(fmu, folder.path());
    let expected = fmu.started().run(0..20);
    let (slave, stranger) = (fmu.started(), other.started());
    for step in 0..20 {
        let wanted = &expected[step as usize..=step as usize];
        assert!(slave.run(step..step + 1) == wanted && stranger.run(step..step + 1) == wanted);
    }
    for [reader, writer] in [[&slave, &stranger], [&stranger, &slave]] {
        let [name, guid, _] = good(reader.fmu);
        let location = CString::new(writer.fmu.resources()).expect("no zero");
        let messages = Messages::default();
        assert!(make(reader.fmu, [Some(&name), Some(&guid), Some(&location)], &callbacks(&messages)).is_null());
        let said = messages.lock().expect("not poisoned").pop().expect("a message").3;
        assert!(said.contains("format") && said.contains("export again"), "{said}");
        let state = writer.save();
        assert_eq!(reader.deserialize(&writer.bytes(state)), Err(fmi2Error));
        writer.free(state);
        let said = reader.log().pop().expect("a message").3;
        assert!(said.contains("the saved state cannot be read: format"), "{said}");
    }
    assert_eq!(slave.run(20..30), stranger.run(20..30));
}
