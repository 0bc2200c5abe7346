//! Surroundings of an FMU: the process that it must leave as it is, small stacks, traps.

use std::ffi::{CStr, CString};
use std::os::fd::AsRawFd;
use std::path::PathBuf;
use std::ptr::null;

/// Resident memory in bytes.
fn resident() -> usize {
    let text = std::fs::read_to_string("/proc/self/statm").expect("Linux");
    4096 * text.split(' ').nth(1).expect("a number").parse::<usize>().expect("a number")
}

/// Doing this again and again needs no more memory.
pub fn keeps_its_memory(once: impl Fn()) {
    (0..20).for_each(|_| once());
    let before = resident();
    (0..300).for_each(|_| once());
    let growth = resident().saturating_sub(before);
    assert!(growth < 3 << 20, "{growth} bytes");
}

/// What the process is like: folder, locale, rounding, handlers of faults.
fn surroundings() -> (PathBuf, CString, [bool; 2], [usize; 2]) {
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

/// Doing this prints nothing, and leaves the process as it was.
pub fn leaves_no_trace(run: impl FnOnce()) {
    let before = surroundings();
    let file = tempfile::tempfile().expect("a file");
    // SAFETY: the file descriptors are open.
    let kept = unsafe { [1, 2].map(|fd| (fd, libc::dup(fd))) };
    [1, 2].iter().for_each(|&fd| assert_eq!(unsafe { libc::dup2(file.as_raw_fd(), fd) }, fd));
    run();
    kept.iter().for_each(|&(fd, copy)| assert_eq!(unsafe { libc::dup2(copy, fd) }, fd));
    assert_eq!(file.metadata().expect("open").len(), 0, "something was printed");
    assert_eq!(surroundings(), before);
}

/// Something that may go to another thread: one thread at a time uses it.
pub struct Sent<T>(pub T);
// SAFETY: see above.
unsafe impl<T> Send for Sent<T> {}

impl<T> Sent<T> {
    pub fn take(self) -> T {
        self.0
    }
}

/// What docs/fmu.md says that a thread needs.
const STACK: usize = 64 << 10;

/// Runs something on a thread with as much stack as that.
pub fn on_a_small_stack<T: Send>(run: impl FnOnce() -> T) -> T {
    let sent = Sent(run);
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, move || sent.take()());
        thread.expect("a thread").join().expect("no panic")
    })
}

/// Runs a call where division by zero and invalid operations trap and results are rounded up; it leaves that as it is, flags included.
#[cfg(target_arch = "x86_64")]
pub fn under_traps<T>(call: impl FnOnce() -> T) -> T {
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
pub fn under_traps<T>(call: impl FnOnce() -> T) -> T {
    call()
}
