//! Instances, threads and the process around them.

use std::ffi::{CStr, CString};
use std::os::fd::AsRawFd;
use std::ptr::null;

use super::values::UNKNOWN;
use crate::fmu::*;

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

/// Resident memory in bytes.
fn resident() -> usize {
    let text = std::fs::read_to_string("/proc/self/statm").expect("Linux");
    4096 * text.split(' ').nth(1).expect("a number").parse::<usize>().expect("a number")
}

pub(super) fn memory(fmu: &Fmu) {
    let once = || drop(fmu.started().run(0..3));
    (0..20).for_each(|_| once());
    let before = resident();
    (0..300).for_each(|_| once());
    let growth = resident().saturating_sub(before);
    assert!(growth < 3 << 20, "{growth} bytes");
}

pub(super) fn reload(fmu: &Fmu) {
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

pub(super) fn silent(fmu: &Fmu) {
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
