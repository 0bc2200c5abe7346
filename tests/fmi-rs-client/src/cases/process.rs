//! Instances, threads and the process around them.

use super::Outcome::{self, Passed};
use super::values::UNKNOWN;
use crate::fmu::*;

pub(super) fn two_instances(fmu: &Fmu) -> Outcome {
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

pub(super) fn threads(fmu: &Fmu) -> Outcome {
    let expected = &fmu.started().run(0..200);
    std::thread::scope(|scope| {
        for _ in 0..8 {
            let slave = Sent(fmu.started());
            scope.spawn(move || assert!(slave.take().run(0..200) == *expected));
        }
    });
    Passed
}

pub(super) fn another_thread(fmu: &Fmu) -> Outcome {
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

pub(super) fn memory(fmu: &Fmu) -> Outcome {
    let once = || drop(fmu.started().run(0..3));
    (0..20).for_each(|_| once());
    let before = resident();
    (0..300).for_each(|_| once());
    let growth = resident().saturating_sub(before);
    assert!(growth < 3 << 20, "{growth} bytes");
    Passed
}

/// fmi-rs unloads the library with the last of its instances.
pub(super) fn reload(fmu: &Fmu) -> Outcome {
    let expected = fmu.started().run(0..3);
    (0..5).for_each(|_| assert_eq!(fmu.started().run(0..3), expected));
    Passed
}

/// The process of a case prints nothing of its own before it ends: whoever runs it sees what the FMU would print.
pub(super) fn silent(fmu: &Fmu) -> Outcome {
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
