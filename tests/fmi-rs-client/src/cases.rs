//! What must happen when the functions are called, as far as fmi-rs can call them: one function for each case.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::ptr::null_mut;

use fmi_rs::fmi2::types::fmi2Status::{self, Discard, Error, Ok as OK};
use fmi_rs::fmi2::types::{fmi2Boolean, fmi2False, fmi2StatusKind, fmi2True};
use fmi_rs::fmi2::{CS, ME};
use fmi_rs::model_description::fmi2::{Causality, Initial, ScalarVariable, Variability, VariableType};

use crate::fmu::*;

/// What a case ends with, unless it panics.
pub enum Outcome {
    Passed,
    /// The model has nothing that the case is about.
    Nothing(&'static str),
}
use Outcome::{Nothing, Passed};

/// How a case is run.
pub enum Check {
    Run(fn(&Fmu) -> Outcome),
    /// The interface of fmi-rs cannot express it; with the reason.
    Beyond(&'static str),
}
use Check::{Beyond, Run};

pub const CASES: &[(&str, Check)] = &[
    ("D01", Run(platform)),
    ("D02", Run(located)),
    ("D03", Beyond("FMU2::new makes the resource location itself, always of the form file:///path")),
    ("D04", Run(escapes)),
    ("D05", Run(no_location)),
    ("D06", Run(wrong_guid)),
    ("D07", Run(missing_strings)),
    (
        "D08",
        Beyond(
            "FMU2::new always passes its callbacks and a logger; leaving out the functions for memory is tried in D10",
        ),
    ),
    ("D09", Run(wrong_interface)),
    ("D10", Run(transient_arguments)),
    ("D11", Run(free_anywhere)),
    ("D12", Run(before_initialization)),
    ("D13", Run(no_experiment)),
    ("D14", Run(during_initialization)),
    ("D15", Run(while_stepping)),
    ("D16", Run(after_termination)),
    ("D17", Run(final_values)),
    ("D18", Run(reset_is_fresh)),
    ("D19", Run(reset_restores)),
    ("D20", Run(reset_after_error)),
    ("D21", Run(unknown_references)),
    ("D22", Run(wrong_type)),
    ("D23", Run(empty_arrays)),
    ("D24", Beyond("its arrays are slices, which are never null pointers")),
    ("D25", Run(set_calculated)),
    ("D26", Run(fixed_late)),
    ("D27", Run(initial_late)),
    ("D28", Run(tunable)),
    ("D29", Run(fixed_early)),
    ("D30", Run(start_values)),
    ("D31", Run(inputs)),
    ("D32", Run(outputs_early)),
    ("D33", Run(read_all)),
    ("D34", Run(nan_values)),
    ("D35", Run(out_of_range)),
    ("D36", Run(no_steps)),
    ("D37", Run(nan_steps)),
    ("D38", Run(far_steps)),
    ("D39", Run(stop_time)),
    ("D40", Run(start_time)),
    ("D41", Run(wrong_first_step)),
    ("D42", Run(variable_steps)),
    ("D43", Run(determinism)),
    ("D44", Run(accumulated)),
    ("D45", Run(two_instances)),
    ("D46", Run(threads)),
    ("D47", Run(another_thread)),
    ("D48", Run(memory)),
    ("D49", Run(reload)),
    ("D50", Run(silent)),
    ("D51", Run(saved_state)),
    ("D52", Run(reused_state)),
    ("D53", Run(whole_state)),
    ("D54", Run(serialised)),
    ("D55", Run(damaged)),
    ("D56", Run(capabilities)),
    ("D57", Run(directional)),
    ("D58", Beyond("FMU2 loads fmi2SetRealInputDerivatives, but has no method that calls it")),
    ("D59", Beyond("FMU2 loads fmi2GetRealOutputDerivatives, but has no method that calls it")),
    ("D60", Run(status)),
    ("D61", Run(terminated_status)),
    ("D62", Beyond("FMU2 loads fmi2SetDebugLogging, but has no method that calls it")),
    ("D63", Run(log_messages)),
    ("D64", Run(log_silence)),
    ("D65", Run(log_printf)),
    ("D66", Run(strings)),
    ("D67", Run(tolerances)),
    ("D68", Run(stop_before_start)),
    ("M01", Run(exchange_order)),
    ("M02", Run(exchange_sizes)),
    ("M03", Run(exchange_derivatives)),
    ("M04", Run(exchange_state)),
    ("X01", Run(second_library)),
    ("X02", Run(state_from_file)),
    ("X03", Run(impossible_initial)),
    ("X04", Run(damaged_resources)),
    ("X05", Run(another_model)),
    ("X07", Run(description)),
];

fn platform(fmu: &Fmu) -> Outcome {
    let raw = fmu.slave().raw;
    assert_eq!((raw.getTypesPlatform(), raw.getVersion()), ("default".to_owned(), "2.0".to_owned()));
    Passed
}

fn located(fmu: &Fmu) -> Outcome {
    fmu.started();
    Passed
}

/// An FMU in a folder with that name.
fn elsewhere(fmu: &Fmu, name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let copy = folder.path().join(name);
    copy_all(&fmu.folder, &copy);
    (folder, copy)
}

fn copy_all(from: &Path, to: &Path) {
    std::fs::create_dir(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let (from, to) = entry.map(|entry| (entry.path(), to.join(entry.file_name()))).expect("an entry");
        if from.is_dir() { copy_all(&from, &to) } else { assert!(std::fs::copy(from, to).is_ok()) }
    }
}

fn escapes(fmu: &Fmu) -> Outcome {
    let (_kept, folder) = elsewhere(fmu, "a b é%");
    fmu.make(&Arguments { folder: Some(folder), ..Arguments::default() }).expect("instantiates").start();
    Passed
}

/// Without a folder of resources fmi-rs passes a null pointer.
fn no_location(fmu: &Fmu) -> Outcome {
    let (_kept, folder) = elsewhere(fmu, "copy");
    std::fs::remove_dir_all(folder.join("resources")).expect("a folder");
    assert!(fmu.make(&Arguments { folder: Some(folder), ..Arguments::default() }).is_err());
    Passed
}

fn wrong_guid(fmu: &Fmu) -> Outcome {
    assert!(fmu.make(&Arguments { guid: Some("{1}"), ..Arguments::default() }).is_err());
    Passed
}

fn missing_strings(fmu: &Fmu) -> Outcome {
    assert!(fmu.make(&Arguments { name: "", ..Arguments::default() }).is_err());
    assert!(fmu.make(&Arguments { guid: Some(""), ..Arguments::default() }).is_err());
    Passed
}

fn wrong_interface(fmu: &Fmu) -> Outcome {
    assert_eq!(fmu.exchange().is_ok(), fmu.description.modelExchange.is_some());
    Passed
}

/// fmi-rs frees the strings and the structure as soon as the instance is there.
fn transient_arguments(fmu: &Fmu) -> Outcome {
    let slave = fmu.make(&Arguments { memory: false, ..Arguments::default() }).expect("instantiates");
    assert_eq!(slave.raw.terminate(), Error);
    assert_eq!(slave.messages().len(), 1);
    slave.start();
    Passed
}

fn free_anywhere(fmu: &Fmu) -> Outcome {
    drop(fmu.slave());
    let slave = fmu.slave();
    assert_eq!([slave.setup(), slave.raw.enterInitializationMode()], [OK; 2]);
    drop(slave);
    drop(fmu.started());
    let slave = fmu.started();
    slave.run(0..3);
    assert_eq!(slave.raw.terminate(), OK);
    Passed
}

fn before_initialization(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    assert_eq!([slave.step(0.0, 0.1), slave.raw.exitInitializationMode(), slave.raw.terminate()], [Error; 3]);
    assert_eq!(slave.get(fmu.outputs()[0]), Err(Error));
    Passed
}

fn no_experiment(fmu: &Fmu) -> Outcome {
    assert_eq!(fmu.slave().raw.enterInitializationMode(), Error);
    Passed
}

fn during_initialization(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    assert_eq!([slave.setup(), slave.raw.enterInitializationMode()], [OK; 2]);
    let refused = [slave.raw.enterInitializationMode(), slave.setup(), slave.step(0.0, 0.1), slave.raw.terminate()];
    assert_eq!(refused, [Error; 4]);
    assert_eq!(slave.raw.exitInitializationMode(), OK);
    Passed
}

fn while_stepping(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    let refused = [slave.raw.enterInitializationMode(), slave.raw.exitInitializationMode(), slave.setup()];
    assert_eq!(refused, [Error; 3]);
    slave.run(0..2);
    Passed
}

fn after_termination(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..2);
    assert_eq!([slave.raw.terminate(), slave.step(0.02, 0.01), slave.raw.terminate()], [OK, Error, Error]);
    for settable in fmu.inputs().into_iter().chain(fmu.tunable()) {
        assert_eq!(slave.put(settable, 1.0), Error);
    }
    Passed
}

fn final_values(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    let last = slave.run(0..5).pop();
    assert_eq!(slave.raw.terminate(), OK);
    assert_eq!(Some(slave.all()), last);
    Passed
}

fn reset_is_fresh(fmu: &Fmu) -> Outcome {
    let fresh = fmu.started().run(0..30);
    let slave = fmu.slave();
    let check = || {
        assert_eq!(slave.raw.reset(), OK);
        slave.start();
        assert_eq!(slave.run(0..30), fresh);
    };
    check();
    check();
    assert_eq!([slave.raw.reset(), slave.setup(), slave.raw.enterInitializationMode()], [OK; 3]);
    check();
    assert_eq!(slave.raw.terminate(), OK);
    check();
    Passed
}

fn reset_restores(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    let settable = || fmu.inputs().into_iter().chain(fmu.tunable()).chain(fmu.fixed());
    settable().for_each(|reference| assert_eq!(slave.put(reference, fmu.other(reference)), OK));
    assert_eq!([slave.raw.reset(), slave.raw.enterInitializationMode()], [OK, Error]);
    slave.start();
    settable().for_each(|reference| assert_eq!(slave.get(reference), Ok(fmu.default(reference))));
    Passed
}

fn reset_after_error(fmu: &Fmu) -> Outcome {
    let fresh = fmu.started().run(0..10);
    let slave = fmu.started();
    slave.run(0..3);
    assert_eq!([slave.step(77.0, 0.1), slave.raw.reset()], [Error, OK]);
    slave.start();
    assert_eq!(slave.run(0..10), fresh);
    Passed
}

const UNKNOWN: u32 = 1_000_000;

fn unknown_references(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    assert_eq!((slave.get(UNKNOWN), slave.put(UNKNOWN, 1.0)), (Err(Error), Error));
    slave.refuses_other_types(UNKNOWN);
    slave.run(0..2);
    Passed
}

fn wrong_type(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    fmu.references(|_| true).into_iter().for_each(|reference| slave.refuses_other_types(reference));
    slave.run(0..2);
    Passed
}

fn empty_arrays(fmu: &Fmu) -> Outcome {
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

fn set_calculated(fmu: &Fmu) -> Outcome {
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

fn fixed_late(fmu: &Fmu) -> Outcome {
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

fn initial_late(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    let before = slave.all();
    for known in fmu.references(|one| one.causality != Causality::Input && one.variability == Variability::Continuous) {
        assert_eq!(slave.put(known, 0.1), Error);
    }
    assert_eq!(slave.all(), before);
    Passed
}

fn tunable(fmu: &Fmu) -> Outcome {
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

fn fixed_early(fmu: &Fmu) -> Outcome {
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

fn start_values(fmu: &Fmu) -> Outcome {
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

fn inputs(fmu: &Fmu) -> Outcome {
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

fn outputs_early(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    assert_eq!([slave.setup(), slave.raw.enterInitializationMode()], [OK; 2]);
    let before = slave.read(&fmu.outputs());
    assert_eq!(slave.raw.exitInitializationMode(), OK);
    assert_eq!(before, slave.read(&fmu.outputs()));
    Passed
}

fn read_all(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..3);
    let mut references = fmu.references(|_| true);
    let values = slave.read(&references);
    assert_eq!(values, slave.read(&references));
    references.extend(references.clone());
    assert_eq!([values.clone(), values].concat(), slave.read(&references));
    Passed
}

fn nan_values(fmu: &Fmu) -> Outcome {
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

fn out_of_range(fmu: &Fmu) -> Outcome {
    let variables = &fmu.description.modelVariables;
    if variables.iter().all(|variable| limits(variable) == [None; 2]) {
        return Nothing("it has no limit of a variable");
    }
    let slave = fmu.slave();
    for variable in variables {
        let [min, max] = limits(variable);
        for value in [min.map(|min| min - 1.0), max.map(|max| max + 1.0)].into_iter().flatten() {
            assert_eq!(slave.put(variable.valueReference, value), Error);
        }
    }
    slave.start();
    Passed
}

fn no_steps(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    assert_eq!([slave.step(0.0, 0.0), slave.step(0.0, -0.01)], [Error; 2]);
    slave.run(0..1);
    Passed
}

fn nan_steps(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!([slave.step(odd, 0.01), slave.step(0.0, odd)], [Error; 2]);
    }
    slave.run(0..1);
    Passed
}

fn far_steps(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..2);
    assert_eq!([slave.step(36_000.0, 0.01), slave.step(-36_000.0, 0.01)], [Error; 2]);
    Passed
}

fn stop_time(fmu: &Fmu) -> Outcome {
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

fn start_time(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    slave.start_with(None, 2.5, None);
    assert_eq!([slave.step(2.5, 0.25), slave.step(2.75, 0.25)], [OK; 2]);
    assert_eq!(slave.last_time(), 3.0);
    Passed
}

fn wrong_first_step(fmu: &Fmu) -> Outcome {
    assert_eq!(fmu.started().step(18_000.0, 0.01), Error);
    Passed
}

fn variable_steps(fmu: &Fmu) -> Outcome {
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

fn determinism(fmu: &Fmu) -> Outcome {
    let run = |fixed: fmi2Boolean| {
        let slave = fmu.started();
        (0..50).for_each(|step| assert_eq!(slave.raw.doStep(f64::from(step) * 0.01, 0.01, fixed), OK));
        slave.all()
    };
    assert!(run(fmi2False) == run(fmi2False) && run(fmi2False) == run(fmi2True));
    Passed
}

fn accumulated(fmu: &Fmu) -> Outcome {
    let (slave, mut time) = (fmu.started(), 0.0);
    for _ in 0..1000 {
        assert_eq!(slave.step(time, 0.0007), OK, "{:?}", slave.messages());
        time += 0.0007;
    }
    assert!((slave.last_time() - time).abs() < 1e-12);
    Passed
}

fn two_instances(fmu: &Fmu) -> Outcome {
    let expected = fmu.started().run(0..20);
    let (first, second) = (fmu.started(), fmu.started());
    for step in 0..20 {
        let wanted = &expected[step as usize..=step as usize];
        assert!(first.run(step..step + 1) == wanted && second.run(step..step + 1) == wanted);
    }
    Passed
}

/// An instance that may go to another thread: one thread at a time uses it.
struct Sent<T>(T);
// SAFETY: see above. fmi-rs does not say so itself.
unsafe impl<T> Send for Sent<T> {}

impl<T> Sent<T> {
    fn take(self) -> T {
        self.0
    }
}

fn threads(fmu: &Fmu) -> Outcome {
    let expected = &fmu.started().run(0..200);
    std::thread::scope(|scope| {
        for _ in 0..8 {
            let slave = Sent(fmu.started());
            scope.spawn(move || assert!(slave.take().run(0..200) == *expected));
        }
    });
    Passed
}

fn another_thread(fmu: &Fmu) -> Outcome {
    let expected = &fmu.started().run(0..5);
    let slave = Sent(fmu.slave());
    std::thread::scope(|scope| {
        scope.spawn(move || {
            let slave = slave.take();
            slave.start();
            assert_eq!(slave.run(0..5), *expected);
        });
    });
    Passed
}

/// Resident memory in bytes.
fn resident() -> usize {
    let text = std::fs::read_to_string("/proc/self/statm").expect("Linux");
    4096 * text.split(' ').nth(1).expect("a number").parse::<usize>().expect("a number")
}

fn memory(fmu: &Fmu) -> Outcome {
    let once = || drop(fmu.started().run(0..3));
    (0..20).for_each(|_| once());
    let before = resident();
    (0..300).for_each(|_| once());
    let growth = resident().saturating_sub(before);
    assert!(growth < 3 << 20, "{growth} bytes");
    Passed
}

/// fmi-rs unloads the library with the last of its instances.
fn reload(fmu: &Fmu) -> Outcome {
    let expected = fmu.started().run(0..3);
    (0..5).for_each(|_| assert_eq!(fmu.started().run(0..3), expected));
    Passed
}

/// The process of a case prints nothing of its own before it ends: whoever runs it sees what the FMU would print.
fn silent(fmu: &Fmu) -> Outcome {
    let folder = std::env::current_dir().expect("a folder");
    let small = std::hint::black_box(f64::EPSILON / 8.0);
    let slave = fmu.started();
    slave.run(0..5);
    slave.put(UNKNOWN, 1.0);
    slave.raw.terminate();
    drop(slave);
    assert_eq!(folder, std::env::current_dir().expect("a folder"));
    assert_eq!([1.0 + small, 1.0 - small], [1.0; 2]);
    Passed
}

fn saved_state(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..13);
    let state = slave.save();
    let expected = slave.run(13..40);
    for _ in 0..2 {
        assert_eq!(slave.raw.setFMUstate(state), OK);
        assert_eq!(slave.run(13..40), expected);
    }
    assert_eq!(fmu.started().run(0..40)[13..], expected, "saving changes nothing");
    slave.free(state);
    Passed
}

fn reused_state(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    let (mut first, second) = (slave.save(), slave.save());
    let place = first;
    slave.run(0..3);
    assert_eq!((slave.raw.getFMUstate(&mut first), first), (OK, place));
    slave.free(second);
    let expected = slave.run(3..6);
    assert_eq!(slave.raw.setFMUstate(first), OK);
    assert_eq!(slave.run(3..6), expected);
    slave.free(first);
    assert_eq!([slave.raw.freeFMUstate(&mut null_mut()), slave.raw.freeFMUstate(null_mut())], [OK; 2]);
    Passed
}

fn whole_state(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    assert_eq!([slave.setup(), slave.raw.enterInitializationMode()], [OK; 2]);
    let early = slave.save();
    assert_eq!(slave.raw.exitInitializationMode(), OK);
    slave.run(0..3);
    let late = slave.save();
    let (values, time) = (slave.all(), slave.last_time());
    for reference in fmu.inputs().into_iter().chain(fmu.tunable()) {
        assert_eq!(slave.put(reference, fmu.other(reference)), OK);
    }
    assert_eq!([slave.step(0.03, 0.01), slave.raw.terminate(), slave.raw.setFMUstate(late)], [OK; 3]);
    assert_eq!((slave.all(), slave.last_time()), (values, time));
    assert_eq!([slave.raw.setFMUstate(early), slave.step(0.0, 0.01)], [OK, Error], "initialization mode is back");
    assert_eq!(slave.raw.exitInitializationMode(), OK);
    [early, late].into_iter().for_each(|state| slave.free(state));
    Passed
}

fn serialised(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..13);
    let state = slave.save();
    let bytes = slave.bytes(state);
    let expected = slave.run(13..40);
    let other = fmu.slave();
    let copy = other.deserialize(&bytes).expect("own bytes");
    assert_eq!(other.bytes(copy), bytes);
    assert_eq!(other.raw.setFMUstate(copy), OK);
    assert_eq!(other.run(13..40), expected);
    slave.free(state);
    other.free(copy);
    Passed
}

fn damaged(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    let state = slave.save();
    let mut bytes = slave.bytes(state);
    let mut small = vec![0; bytes.len() - 1];
    assert_eq!([slave.raw.serializeFMUstate(state, &mut small), slave.raw.setFMUstate(null_mut())], [Error; 2]);
    for place in 0..bytes.len() {
        assert_eq!(slave.deserialize(&bytes[..place]), Err(Error));
        for bit in [1, 0x10] {
            bytes[place] ^= bit;
            assert_eq!(slave.deserialize(&bytes), Err(Error), "byte {place}");
            bytes[place] ^= bit;
        }
    }
    slave.free(state);
    slave.run(0..2);
    Passed
}

fn capabilities(fmu: &Fmu) -> Outcome {
    let description = &fmu.description;
    let slave = description.coSimulation.as_ref().expect("Co-Simulation");
    assert!(slave.canGetAndSetFMUstate && slave.canSerializeFMUstate && slave.providesDirectionalDerivative);
    assert!(slave.canInterpolateInputs && !slave.canRunAsynchronuously);
    if let Some(exchange) = &description.modelExchange {
        assert!(exchange.canGetAndSetFMUstate && exchange.canSerializeFMUstate);
        assert!(exchange.providesDirectionalDerivative);
    }
    assert_eq!(fmu.started().raw.cancelStep(), Error);
    Passed
}

fn directional(fmu: &Fmu) -> Outcome {
    let knowns = [fmu.inputs(), fmu.tunable()].concat();
    if knowns.is_empty() {
        return Nothing("it has no input and no tunable parameter");
    }
    let unknowns = fmu.references(|one| matches!(one.causality, Causality::Output | Causality::Local));
    let slave = fmu.started();
    slave.run(0..7);
    for known in knowns {
        let exact = slave.derivatives(&unknowns, known);
        let before = slave.get(known).expect("readable");
        let at = |change: f64| {
            assert_eq!(slave.put(known, before + change), OK);
            slave.read(&unknowns)
        };
        let found = difference(at, 1e-2);
        assert_eq!(slave.put(known, before), OK);
        agree(fmu, &unknowns, &exact, &found, 1e-7);
    }
    for (unknown, known) in [(unknowns[0], UNKNOWN), (UNKNOWN, unknowns[0])] {
        assert_eq!(slave.raw.getDirectionalDerivative(&[unknown], &[known], &[1.0], &mut [0.0]), Error);
    }
    Passed
}

/// All but `fmi2GetStatus`, for which fmi-rs has no method.
fn status(fmu: &Fmu) -> Outcome {
    use fmi2StatusKind::{DoStepStatus, PendingStatus};
    let slave = fmu.started();
    slave.run(0..4);
    assert!((slave.last_time() - 0.04).abs() < 1e-12);
    let (raw, mut integer) = (&slave.raw, 0);
    let found = [
        raw.getRealStatus(&PendingStatus, &mut 0.0),
        raw.getIntegerStatus(&DoStepStatus, &mut integer),
        raw.getBooleanStatus(&DoStepStatus, &mut integer),
        raw.getStringStatus(&PendingStatus, &mut String::new()),
    ];
    assert_eq!(found, [Discard; 4]);
    assert_eq!(raw.cancelStep(), Error);
    Passed
}

fn terminated_status(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..1);
    let mut terminated = 7;
    assert_eq!(slave.raw.getBooleanStatus(&fmi2StatusKind::Terminated, &mut terminated), OK);
    assert_eq!(terminated, fmi2False);
    Passed
}

fn log_messages(fmu: &Fmu) -> Outcome {
    let slave = fmu.make(&Arguments { logging: true, ..Arguments::default() }).expect("instantiates");
    slave.start();
    slave.run(0..3);
    slave.put(UNKNOWN, 1.0);
    slave.step(9.0, 1.0);
    slave.raw.terminate();
    let log = slave.messages();
    assert!(log.len() >= 5, "{log:?}");
    let categories = &fmu.description.logCategories;
    for (status, category, message) in log {
        assert!(categories.iter().any(|known| known.name == category), "{category}");
        assert!(!message.is_empty() && !message.ends_with('\n'));
        assert_eq!(status == Error, category == "errors");
    }
    Passed
}

fn log_silence(fmu: &Fmu) -> Outcome {
    let slave = fmu.started();
    slave.run(0..10);
    slave.raw.terminate();
    assert!(slave.messages().is_empty());
    Passed
}

/// fmi-rs formats messages as C does: a percent sign in a message must have been doubled.
fn log_printf(fmu: &Fmu) -> Outcome {
    let slave = fmu.make(&Arguments { name: "%s%n%d #r1#", ..Arguments::default() }).expect("instantiates");
    slave.put(UNKNOWN, 1.0);
    slave.step(f64::NAN, 1.0);
    assert_eq!(slave.messages().len(), 2);
    Passed
}

fn strings(fmu: &Fmu) -> Outcome {
    let real = |variable: &ScalarVariable| matches!(variable.variableType, VariableType::Real { .. });
    assert!(fmu.description.modelVariables.iter().all(real), "there are none");
    assert_eq!(fmu.started().raw.getString(&[], &mut []), OK);
    Passed
}

fn tolerances(fmu: &Fmu) -> Outcome {
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

fn stop_before_start(fmu: &Fmu) -> Outcome {
    let slave = fmu.slave();
    let setup = |start, stop| slave.raw.setupExperiment(None, start, stop);
    assert_eq!([setup(1.0, Some(0.5)), setup(f64::NAN, None)], [Error; 2]);
    slave.start();
    Passed
}

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

fn exchange_order(fmu: &Fmu) -> Outcome {
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

fn exchange_sizes(fmu: &Fmu) -> Outcome {
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
        assert_eq!(raw.setContinuousStates(&[f64::NAN].repeat(count)), Error);
    }
    Passed
}

fn exchange_derivatives(fmu: &Fmu) -> Outcome {
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

fn exchange_state(fmu: &Fmu) -> Outcome {
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

fn second_library(fmu: &Fmu) -> Outcome {
    let (_kept, folder) = elsewhere(fmu, "another");
    let expected = fmu.started().run(0..20);
    let other = fmu.make(&Arguments { folder: Some(folder), ..Arguments::default() }).expect("instantiates");
    other.start();
    let first = fmu.started();
    for step in 0..20 {
        let wanted = &expected[step as usize..=step as usize];
        assert!(first.run(step..step + 1) == wanted && other.run(step..step + 1) == wanted);
    }
    Passed
}

/// Names the file with a state, in the process that writes it.
const STATE: &str = "FMI_RS_CLIENT_STATE";

fn state_from_file(fmu: &Fmu) -> Outcome {
    if let Some(file) = std::env::var_os(STATE) {
        let slave = fmu.started();
        slave.run(0..13);
        std::fs::write(file, slave.bytes(slave.save())).expect("a file");
        return Passed;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("state.bin");
    let mut other = Command::new(std::env::current_exe().expect("a program"));
    let written = other.arg("case").arg(&fmu.folder).arg("X02").env(STATE, &file).output().expect("a process");
    assert!(written.status.success());
    let slave = fmu.slave();
    let state = slave.deserialize(&std::fs::read(&file).expect("a file")).expect("own bytes");
    assert_eq!(slave.raw.setFMUstate(state), OK);
    assert_eq!(slave.run(13..40), fmu.started().run(0..40)[13..]);
    slave.free(state);
    Passed
}

fn impossible_initial(fmu: &Fmu) -> Outcome {
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

fn damaged_resources(fmu: &Fmu) -> Outcome {
    let (_kept, folder) = elsewhere(fmu, "copy");
    let file = folder.join("resources/program.bin");
    let whole = std::fs::read(&file).expect("a program");
    let with = Arguments { folder: Some(folder), ..Arguments::default() };
    let refused = |bytes: &[u8]| {
        std::fs::write(&file, bytes).expect("a file");
        assert!(fmu.make(&with).is_err());
    };
    for place in (0..whole.len()).step_by(whole.len() / 60 + 1) {
        let mut changed = whole.clone();
        changed[place] ^= 0x24;
        refused(&changed);
        refused(&whole[..place]);
    }
    refused(&[&whole[..], b"more"].concat());
    std::fs::remove_file(&file).expect("a file");
    assert!(fmu.make(&with).is_err());
    fmu.started();
    Passed
}

/// In turns with an instance of each other model, each from its own library.
fn another_model(fmu: &Fmu) -> Outcome {
    let beside = std::fs::read_dir(fmu.folder.parent().expect("models beside it")).expect("a folder");
    let folders = beside.map(|entry| entry.expect("an entry").path());
    let folders = folders.filter(|path| path.join("modelDescription.xml").is_file() && *path != fmu.folder);
    let others: Vec<Fmu> = folders.map(|folder| Fmu::open(&folder)).collect();
    assert!(!others.is_empty());
    let expected = fmu.started().run(0..20);
    let slave = fmu.started();
    let strangers: Vec<Instance<CS>> = others.iter().map(Fmu::started).collect();
    for step in 0..20 {
        strangers.iter().for_each(|stranger| drop(stranger.run(step..step + 1)));
        assert!(slave.run(step..step + 1) == expected[step as usize..=step as usize]);
    }
    let state = strangers[0].save();
    assert_eq!(slave.deserialize(&strangers[0].bytes(state)), Err(Error));
    strangers[0].free(state);
    Passed
}

/// What fmi-rs itself finds wrong with the description.
fn description(fmu: &Fmu) -> Outcome {
    let problems: Vec<String> = fmu.description.validate().into_iter().map(|problem| problem.message).collect();
    assert!(problems.is_empty(), "{problems:?}");
    Passed
}
