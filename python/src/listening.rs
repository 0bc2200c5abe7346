//! Ctrl-C: a call that computes asks from time to time whether the user has pressed it.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pyo3::marker::Ungil;
use pyo3::prelude::*;

/// How often a call asks.
pub const PATIENCE: Duration = Duration::from_millis(50);

/// What the thread listens to.
enum Listening {
    /// To the interpreter's signals: when it asked last, and what was raised.
    Signals(Instant, Option<PyErr>),
    /// To the thread that does.
    Flag(Arc<AtomicBool>),
}

thread_local! {
    static LISTENING: RefCell<Option<Listening>> = const { RefCell::new(None) };
}

/// Is the motion that this thread computes to end?
pub fn wants_end() -> bool {
    let is_due = LISTENING.with_borrow_mut(|listening| match listening {
        None => Some(false),
        Some(Listening::Flag(flag)) => Some(flag.load(Ordering::Relaxed)),
        Some(Listening::Signals(_, Some(_))) => Some(true),
        Some(Listening::Signals(last, None)) if last.elapsed() < PATIENCE => Some(false),
        Some(Listening::Signals(last, None)) => {
            *last = Instant::now();
            None
        }
    });
    is_due.unwrap_or_else(|| {
        // A handler of signals may call this package: nothing is borrowed meanwhile.
        let Err(raised) = Python::attach(|py| py.check_signals()) else { return false };
        LISTENING.with_borrow_mut(|listening| {
            if let Some(Listening::Signals(_, kept)) = listening {
                *kept = Some(raised);
            }
        });
        true
    })
}

/// Computes without the interpreter's lock, and raises what a signal raises meanwhile.
pub fn interruptible<T: Ungil + Send>(py: Python<'_>, compute: impl FnOnce() -> T + Ungil + Send) -> PyResult<T> {
    let outer = LISTENING.replace(Some(Listening::Signals(Instant::now(), None)));
    let computed = py.detach(compute);
    match LISTENING.replace(outer) {
        Some(Listening::Signals(_, Some(raised))) => Err(raised),
        Some(Listening::Signals(_, None) | Listening::Flag(_)) | None => Ok(computed),
    }
}

/// The motions that this thread computes from now on end with the flag.
pub fn follow(flag: &Arc<AtomicBool>) {
    LISTENING.with_borrow_mut(|listening| {
        if !matches!(listening, Some(Listening::Signals(..))) {
            *listening = Some(Listening::Flag(Arc::clone(flag)));
        }
    });
}
