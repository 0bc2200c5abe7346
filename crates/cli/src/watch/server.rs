//! A page on the loopback, and news of it as server-sent events (<https://html.spec.whatwg.org/multipage/server-sent-events.html>).

use std::io::{self, Write};
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use cotree_file::page::waiting_html;
use serde_json::json;
use tiny_http::{Header, Method, Request, Response, Server};

/// A page that is closed is noticed after this time.
const HEARTBEAT: Duration = Duration::from_secs(5);

/// What there is to see of the file as it is now.
pub enum Shown {
    Page(String),
    Fault(String),
}

/// The last good page, what is wrong with the file, and how often it has changed.
#[derive(Default)]
struct State {
    page: Option<String>,
    fault: Option<String>,
    version: u64,
    /// The version of the page.
    good: u64,
}

/// What the server shows; whoever waits is told of a change.
#[derive(Default)]
pub struct Board {
    state: Mutex<State>,
    changed: Condvar,
}

impl Board {
    pub fn show(&self, shown: Shown) {
        let mut state = self.state();
        state.version += 1;
        match shown {
            Shown::Page(page) => {
                state.good = state.version;
                (state.page, state.fault) = (Some(page), None);
            }
            Shown::Fault(fault) => state.fault = Some(fault),
        }
        self.changed.notify_all();
    }

    /// A thread that failed while it held the lock has left whole values: they are only replaced.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn page(&self) -> String {
        self.state().page.clone().unwrap_or_else(waiting_html)
    }

    /// The version that comes after `seen`, as an event; a comment if none comes for a while.
    fn next(&self, seen: &mut u64) -> String {
        let state = self.state();
        let waited = self.changed.wait_timeout_while(state, HEARTBEAT, |state| state.version == *seen);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        if state.version == *seen {
            return ": still here\n\n".to_owned();
        }
        *seen = state.version;
        format!("data: {}\n\n", json!({ "good": state.good, "fault": state.fault }))
    }
}

/// Serves the board on this machine alone. Returns the address for a browser.
pub fn start(port: u16, board: Arc<Board>) -> io::Result<String> {
    let server = Server::http((Ipv4Addr::LOCALHOST, port)).map_err(io::Error::other)?;
    let address = server.server_addr().to_ip().ok_or_else(|| io::Error::other("no address"))?;
    std::thread::spawn(move || {
        for request in server.incoming_requests() {
            let board = Arc::clone(&board);
            std::thread::spawn(move || answer(request, address, &board));
        }
    });
    Ok(format!("http://{address}/"))
}

/// A browser that goes away is no fault.
fn answer(request: Request, address: SocketAddr, board: &Board) -> io::Result<()> {
    match (request.method(), request.url()) {
        // Another site whose name leads here does not get anything.
        _ if !is_ours(&request, address) => request.respond(Response::empty(403)),
        (Method::Get, "/") => {
            let mut response = Response::from_string(board.page()).with_chunked_threshold(usize::MAX);
            let headers = ["Content-Type: text/html; charset=utf-8", "Cache-Control: no-store"];
            headers.iter().flat_map(|header| header.parse::<Header>()).for_each(|header| response.add_header(header));
            request.respond(response)
        }
        (Method::Get, "/events") => report(request.into_writer(), board),
        _ => request.respond(Response::empty(404)),
    }
}

/// Every change, until the page is closed.
fn report(mut stream: impl Write, board: &Board) -> io::Result<()> {
    write!(stream, "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n\r\n")?;
    let mut seen = 0;
    loop {
        stream.write_all(board.next(&mut seen).as_bytes())?;
        stream.flush()?;
    }
}

/// Is it asked of this machine by its own name?
fn is_ours(request: &Request, address: SocketAddr) -> bool {
    let names = [address.to_string(), format!("localhost:{}", address.port())];
    request
        .headers()
        .iter()
        .any(|header| header.field.equiv("Host") && names.iter().any(|name| header.value.as_str() == name))
}
