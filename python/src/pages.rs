//! The solver of pages in files and notebooks: this process answers what they ask, as long as it lasts.

use std::io;
use std::sync::{Mutex, PoisonError};

use cotree_page::desk::Desk;
use cotree_page::serve;

/// The process that serves, and its address. A process that was forked has no thread of its parent's server.
static SERVER: Mutex<Option<(u32, String)>> = Mutex::new(None);

/// Where this process answers pages.
pub fn address() -> io::Result<String> {
    let mut server = SERVER.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    match &*server {
        Some((server, address)) if *server == process => Ok(address.clone()),
        _ => {
            let address = serve::for_files(Desk::default())?;
            *server = Some((process, address.clone()));
            Ok(address)
        }
    }
}
