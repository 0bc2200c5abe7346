//! Pages that this machine serves, where there are no modules for browsers: the program itself is their front end and solver.

use std::io;
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;

use cotree::export::ExportError;
use cotree::export::runtime::Runtime;
use cotree_page::desk::Desk;
use cotree_page::serve::Calls;
use cotree_page::serve::http::{self, Askers, Request, respond};

use super::export::available;
use super::failure::{self, Failure};
use super::output;

/// What FMUs that are written in a page carry: the runtimes in a folder, or the one in this program.
pub fn desk(folder: &Path) -> Result<Desk, Failure> {
    let found = available(folder).into_iter().map(|platform| Runtime::find(platform, folder));
    let runtimes = found.collect::<Result<_, _>>().map_err(ExportError::from)?;
    Ok(Desk { runtimes, module: None })
}

/// Starts to serve; returns the address of the page.
pub fn start(
    port: u16,
    answer: impl Fn(&Request, TcpStream) -> io::Result<()> + Send + Sync + 'static,
) -> Result<String, Failure> {
    http::serve(port, Askers::Own, answer)
        .map_err(|error| Failure::Usage(format!("cannot serve a page on port {port} of this machine: {error}")))
}

/// Serves one page until the program is ended; its address is printed, and given to `begun`.
pub fn page(html: String, desk: Desk, begun: impl FnOnce(&str)) -> Result<(), Failure> {
    let calls = Arc::new(Calls::new(desk));
    let address = start(0, move |request, stream| match request.line.as_str() {
        "GET /" => respond(stream, "200 OK", html.as_bytes()),
        requested => calls.respond(requested, &request.body, Askers::Own, stream),
    })?;
    output::print(&format!("{address}\n"))?;
    begun(&address);
    failure::say("open this address in a browser on this machine; Ctrl-C stops the server\n");
    loop {
        std::thread::park();
    }
}
