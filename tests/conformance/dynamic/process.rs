//! Instances, threads and the process around them.

use std::cell::{Cell, RefCell};
use std::ffi::c_void;
use std::ptr::null_mut;

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Error, fmi2OK};
use cotree_fmu::fmi2::types::*;

use super::instantiation::{good, make};
use super::values::UNKNOWN;
use crate::fmu::*;
use crate::process::{keeps_its_memory, leaves_no_trace};

// SAFETY of all calls: the component is alive, and arrays are as long as announced.

pub(super) fn two_instances(fmu: &Fmu) {
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

/// What docs/fmu.md says that a thread needs.
const STACK: usize = 128 << 10;

/// Importers whose threads have small stacks.
pub(super) fn small_stack(fmu: &Fmu) {
    let expected = fmu.started().run(0..20);
    let sent = Sent(fmu);
    std::thread::scope(|scope| {
        let all = move || {
            let slave = sent.take().started();
            let values = slave.run(0..20);
            let state = slave.save();
            slave.bytes(state);
            slave.free(state);
            values
        };
        let run = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, all).expect("a thread");
        assert!(run.join().expect("no panic") == expected);
    });
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

/// Runs a call where division by zero and invalid operations trap and results are rounded up; it leaves that as it is, flags included.
#[cfg(target_arch = "x86_64")]
fn under_traps<T>(call: impl FnOnce() -> T) -> T {
    use std::arch::asm;
    // Unmasked: invalid (bit 7) and division by zero (bit 9); rounding up (bit 14); the flag of precision (bit 5).
    const ODD: u32 = 0x1F80 & !(1 << 7) & !(1 << 9) | 1 << 14 | 1 << 5;
    let (mut usual, mut after) = (0_u32, 0_u32);
    // SAFETY: the register is as before at the end, and nothing is computed under the odd one but by the call.
    let result = unsafe {
        asm!("stmxcsr [{}]", "ldmxcsr [{}]", in(reg) &mut usual, in(reg) &ODD);
        let result = call();
        asm!("stmxcsr [{}]", "ldmxcsr [{}]", in(reg) &mut after, in(reg) &usual);
        result
    };
    assert_eq!(after, ODD, "the floating-point environment is not as before");
    result
}

#[cfg(not(target_arch = "x86_64"))]
fn under_traps<T>(call: impl FnOnce() -> T) -> T {
    call()
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
