//! Ctrl-C as a wish: what is known so far is kept.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

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
