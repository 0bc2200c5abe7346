//! What an FMU must leave as it is in the process around it.

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
