//! Ctrl-C: a call that computes asks from time to time whether the user has pressed it.

use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
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

/// A function of Python that is called with how much is done, and of how much.
pub struct Watched {
    progress: Option<Py<PyAny>>,
    /// When it was called last, and what it has raised.
    last: Mutex<(Option<Instant>, Option<PyErr>)>,
}

impl Watched {
    pub fn new(progress: Option<Py<PyAny>>) -> Self {
        Watched { progress, last: Mutex::default() }
    }

    /// Tells how far it is, now and then and at the end. False once the function has raised something.
    pub fn tell(&self, done: usize, all: usize) -> bool {
        let Some(progress) = &self.progress else { return true };
        let is_due = {
            let (last, raised) = &mut *self.last();
            if raised.is_some() {
                return false;
            }
            let is_due = done == all || last.is_none_or(|last| last.elapsed() >= PATIENCE);
            if is_due {
                *last = Some(Instant::now());
            }
            is_due
        };
        // Nothing is locked meanwhile: the function may do anything.
        let called = if is_due { Python::attach(|py| progress.call1(py, (done, all)).map(drop)) } else { Ok(()) };
        let is_well = called.is_ok();
        if let Err(error) = called {
            self.last().1 = Some(error);
        }
        is_well
    }

    /// What the function has raised.
    pub fn raised(&self) -> PyResult<()> {
        self.last().1.take().map_or(Ok(()), Err)
    }

    fn last(&self) -> MutexGuard<'_, (Option<Instant>, Option<PyErr>)> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }
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
