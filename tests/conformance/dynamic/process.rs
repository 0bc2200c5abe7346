//! Instances, threads and the process around them.

use std::cell::{Cell, RefCell};
use std::ffi::c_void;
use std::ptr::null_mut;

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Error, fmi2OK};
use cotree_fmu::fmi2::types::*;

use super::super::fmu::*;
use super::super::process::{Sent, keeps_its_memory, leaves_no_trace, on_a_small_stack, under_traps};
use super::instantiation::{good, make};
use super::values::UNKNOWN;

// SAFETY of all calls: the component is alive, and arrays are as long as announced.

pub(super) fn two_instances(fmu: &Fmu) {
    let expected = fmu.started().run(0..20);
    let (first, second) = (fmu.started(), fmu.started());
    for step in 0..20 {
        let wanted = &expected[step as usize..=step as usize];
        assert!(first.run(step..step + 1) == wanted && second.run(step..step + 1) == wanted);
    }
}

pub(super) fn threads(fmu: &Fmu) {
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

/// Importers whose threads have small stacks.
pub(super) fn small_stack(fmu: &Fmu) {
    let expected = fmu.started().run(0..20);
    let found = on_a_small_stack(|| {
        let slave = fmu.started();
        let values = slave.run(0..20);
        let state = slave.save();
        slave.bytes(state);
        slave.free(state);
        values
    });
    assert!(found == expected);
}

pub(super) fn another_thread(fmu: &Fmu) {
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

pub(super) fn memory(fmu: &Fmu) {
    keeps_its_memory(|| drop(fmu.started().run(0..3)));
}

pub(super) fn reload(fmu: &Fmu) {
    let expected = fmu.started().run(0..3);
    for _ in 0..5 {
        let again = Fmu::open(&fmu.folder);
        assert_eq!(again.started().run(0..3), expected);
    }
}

pub(super) fn silent(fmu: &Fmu) {
    leaves_no_trace(|| {
        let slave = fmu.started();
        slave.run(0..5);
        slave.put(UNKNOWN, 1.0);
        slave.terminate();
    });
}

/// What the importer's logger needs to call back.
struct Caller<'a> {
    fmu: &'a Fmu,
    component: Cell<fmi2Component>,
    answers: RefCell<Vec<fmi2Status>>,
}

unsafe extern "C" fn call_back(
    environment: fmi2ComponentEnvironment,
    _: fmi2String,
    _: fmi2Status,
    _: fmi2String,
    _: fmi2String,
) {
    // SAFETY: the environment is the `Caller` below, which outlives its component.
    let caller = unsafe { &*environment.cast::<Caller>() };
    let (c, library, mut value) = (caller.component.get(), &caller.fmu.library, 0.0);
    if !c.is_null() {
        let answers = unsafe { [(library.get_real)(c, &0, 1, &mut value), (library.do_step)(c, 0.0, 0.1, 1)] };
        caller.answers.borrow_mut().extend(answers);
    }
}

/// A call while another one is under way is refused, whoever makes it.
pub(super) fn busy(fmu: &Fmu) {
    let caller = Caller { fmu, component: Cell::new(null_mut()), answers: RefCell::default() };
    let mut callbacks = callbacks(&Messages::default());
    // SAFETY: as in `callbacks`.
    callbacks.logger = Some(unsafe {
        std::mem::transmute::<
            unsafe extern "C" fn(*mut c_void, fmi2String, fmi2Status, fmi2String, fmi2String),
            unsafe extern "C" fn(*mut c_void, fmi2String, fmi2Status, fmi2String, fmi2String, ...),
        >(call_back)
    });
    callbacks.componentEnvironment = std::ptr::from_ref(&caller).cast_mut().cast();
    let [name, guid, location] = good(fmu);
    let c = make(fmu, [Some(&name), Some(&guid), Some(&location)], &callbacks);
    caller.component.set(c);
    let library = &fmu.library;
    unsafe {
        assert_eq!((library.set_real)(c, &UNKNOWN, 1, &0.0), fmi2Error);
        assert_eq!(*caller.answers.borrow(), [fmi2Error; 2]);
        assert_eq!((library.reset)(c), fmi2OK, "idle again");
        (library.free_instance)(c);
    }
}

/// Nothing traps, and results have the same bits.
pub(super) fn traps(fmu: &Fmu) {
    let expected = fmu.started().run(0..20);
    let slave = under_traps(|| fmu.slave());
    let calls: [&dyn Fn() -> fmi2Status; 3] = [&|| slave.setup(0.0, None, None), &|| slave.enter(), &|| slave.exit()];
    calls.into_iter().for_each(|call| assert_eq!(under_traps(call), fmi2OK));
    let references = fmu.references(|_| true);
    for (step, expected) in (0..20_u32).zip(&expected) {
        let (time, value) = (f64::from(step) * 0.01, 0.1 * f64::from(step % 7));
        for input in fmu.inputs().into_iter().filter(|_| step % 5 == 0) {
            assert_eq!(under_traps(|| slave.put(input, value)), fmi2OK);
        }
        assert_eq!(under_traps(|| slave.step(time, 0.01)), fmi2OK);
        let values = under_traps(|| slave.read(&references));
        assert!(values.iter().map(|value| value.to_bits()).eq(expected.iter().copied()), "step {step}");
    }
}
