//! Ctrl-C as a wish: what is known so far is kept.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use cotree_fmu::context;
use signal_hook::consts::SIGINT;
use signal_hook::flag;

use super::failure::Failure;

/// Becomes true with the first Ctrl-C; a second one ends the program at once.
pub fn listen() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let listening = flag::register_conditional_default(SIGINT, Arc::clone(&stop))
        .and_then(|_| flag::register(SIGINT, Arc::clone(&stop)));
    listening.map_err(|error| Failure::Usage(format!("cannot listen to Ctrl-C: {error}")))?;
    Ok(stop)
}

/// The same, and it ends motions within their steps: one of them may take minutes.
pub fn ending_motions() -> Result<Arc<AtomicBool>, Failure> {
    static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    let stop = listen()?;
    let _ = STOP.set(Arc::clone(&stop)); // a program runs one command
    context::listen(|| STOP.get().is_some_and(|stop| stop.load(Ordering::Relaxed)));
    Ok(stop)
}
