//! Pages that this machine serves, where there are no modules for browsers: the program itself is their front end and solver.

use std::io::{self, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;

use cotree::export::ExportError;
use cotree::export::runtime::Runtime;
use cotree_page::desk::Desk;
use cotree_page::serve::Calls;
use cotree_page::serve::http::{self, Request, respond, respond_with};

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
    http::serve(port, answer)
        .map_err(|error| Failure::Usage(format!("cannot serve a page on port {port} of this machine: {error}")))
}

/// Answers a call of the page.
pub fn call(calls: &Calls, asked: &str, body: &[u8], stream: impl Write) -> io::Result<()> {
    match asked.strip_prefix("POST /call/").and_then(|name| calls.answer(name, body)) {
        Some(Ok(answer)) => respond(stream, "200 OK", &answer),
        // No status of a failure: browsers report those to whoever develops the page.
        Some(Err(faults)) => respond_with(stream, "200 OK", "Cotree-Failed: 1\r\n", faults.to_string().as_bytes()),
        None => respond(stream, "404 Not Found", b""),
    }
}

/// Serves one page until the program is ended.
pub fn page(html: String, desk: Desk) -> Result<(), Failure> {
    let calls = Arc::new(Calls::new(desk));
    let address = start(0, move |request, stream| match request.asked.as_str() {
        "GET /" => respond(stream, "200 OK", html.as_bytes()),
        asked => call(&calls, asked, &request.body, stream),
    })?;
    output::print(&format!("{address}\n"))?;
    failure::say("open this address in a browser of this machine; Ctrl-C ends the page\n");
    loop {
        std::thread::park();
    }
}
