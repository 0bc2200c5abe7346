//! The `cotree` command.

fn main() -> std::process::ExitCode {
    #[cfg(target_os = "linux")]
    closed::keep();
    cotree_cli::run()
}

/// A standard output that is closed from the start (`>&-`). Rust opens `/dev/null` in its place before `main`, and everything that is written
/// would be lost without a word; so whether it is closed is asked still earlier.
#[cfg(target_os = "linux")]
mod closed {
    use std::sync::atomic::{AtomicBool, Ordering};

    use rustix::io::{Errno, fcntl_getfd};
    use rustix::stdio::{dup2_stdout, stdout};

    static CLOSED: AtomicBool = AtomicBool::new(false);

    // SAFETY: the loader calls what stands in this section before the runtime of Rust starts; the function needs nothing of it.
    #[used]
    #[unsafe(link_section = ".init_array")]
    static FIRST: extern "C" fn() = look;

    extern "C" fn look() {
        CLOSED.store(fcntl_getfd(stdout()) == Err(Errno::BADF), Ordering::Relaxed);
    }

    /// Writing to a closed standard output fails as it does where a reader has gone.
    pub fn keep() {
        if CLOSED.load(Ordering::Relaxed) {
            // Its end for reading is dropped. Without a pipe what is printed is lost, as without this.
            let _ = rustix::pipe::pipe().and_then(|(_, writing)| dup2_stdout(writing));
        }
    }
}
