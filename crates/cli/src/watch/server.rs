//! A page on the loopback, and news of it as server-sent events (<https://html.spec.whatwg.org/multipage/server-sent-events.html>).

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use cotree_page::page::waiting_html;
use serde_json::json;

/// A page that is closed is noticed after this time.
const HEARTBEAT: Duration = Duration::from_secs(5);

/// Longest request with its headers [bytes]: browsers send a few hundred, and cookies of other pages of this machine.
const LARGEST_HEAD: u64 = 1 << 16;

/// What there is to see of the file as it is now.
pub enum Shown {
    /// A page, and what is odd about the scene though it is no fault.
    Page(String, Option<String>),
    Fault(String),
}

/// The last good page, what is wrong with the file, and how often it has changed.
#[derive(Default)]
struct State {
    page: Option<String>,
    warnings: Option<String>,
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
            Shown::Page(page, warnings) => {
                state.good = state.version;
                (state.page, state.warnings, state.fault) = (Some(page), warnings, None);
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
        format!("data: {}\n\n", json!({ "good": state.good, "fault": state.fault, "warnings": state.warnings }))
    }
}

/// Serves the board on this machine alone. Returns the address for a browser.
pub fn start(port: u16, board: Arc<Board>) -> io::Result<String> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
    let address = listener.local_addr()?;
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let board = Arc::clone(&board);
            std::thread::spawn(move || answer(stream, address, &board));
        }
    });
    Ok(format!("http://{address}/"))
}

/// A browser that goes away is no fault.
fn answer(mut stream: TcpStream, address: SocketAddr, board: &Board) -> io::Result<()> {
    stream.set_read_timeout(Some(HEARTBEAT))?;
    let Some(head) = head(&mut stream)? else { return respond(stream, "431 Request Header Fields Too Large", "") };
    let mut lines = head.split("\r\n");
    let request = lines.next().unwrap_or_default();
    match request.rsplit_once(' ').map(|(asked, _)| asked) {
        // Another site whose name leads here does not get anything.
        _ if !is_ours(lines, address) => respond(stream, "403 Forbidden", ""),
        Some("GET /") => respond(stream, "200 OK", &board.page()),
        Some("GET /events") => report(stream, board),
        _ => respond(stream, "404 Not Found", ""),
    }
}

/// The request with its headers; none if they are longer than any that a browser sends.
fn head(stream: &mut TcpStream) -> io::Result<Option<String>> {
    let mut head = Vec::new();
    let mut reader = BufReader::new(stream.take(LARGEST_HEAD));
    loop {
        let line = reader.read_until(b'\n', &mut head)?;
        if head.ends_with(b"\r\n\r\n") {
            return Ok(Some(String::from_utf8_lossy(&head).into_owned()));
        }
        if line == 0 {
            return Ok(None);
        }
    }
}

fn respond(mut stream: TcpStream, status: &str, page: &str) -> io::Result<()> {
    let length = page.len();
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: text/html; charset=utf-8\r\nCache-Control: no-store\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{page}"
    )
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
fn is_ours<'a>(mut headers: impl Iterator<Item = &'a str>, address: SocketAddr) -> bool {
    let names = [address.to_string(), format!("localhost:{}", address.port())];
    headers.any(|header| {
        let (field, value) = header.split_once(':').unwrap_or_default();
        field.eq_ignore_ascii_case("host") && names.iter().any(|name| value.trim() == name)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the server answers to a request.
    fn answered(request: impl Fn(&str) -> Vec<u8>) -> String {
        let address = start(0, Arc::default()).expect("a free port");
        let host = address.trim_start_matches("http://").trim_end_matches('/');
        let mut stream = TcpStream::connect(host).expect("it listens");
        // Where the server has heard enough it closes, and the rest cannot be sent.
        let _ = stream.write_all(&request(host));
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    #[test]
    fn pages_are_for_this_machine_and_nothing_else_is_there() {
        let get = |path: &str, host: &str| format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").into_bytes();
        let page = answered(|host| get("/", host));
        assert!(page.starts_with("HTTP/1.1 200 OK\r\n") && page.ends_with(&waiting_html()), "{page}");
        assert!(answered(|host| get("/other", host)).starts_with("HTTP/1.1 404 "));
        assert!(answered(|_| get("/", "elsewhere.example")).starts_with("HTTP/1.1 403 "));
    }

    #[test]
    fn headers_without_end_are_not_kept() {
        let endless = |host: &str| {
            let long = "x".repeat(4 * LARGEST_HEAD as usize);
            format!("GET / HTTP/1.1\r\nHost: {host}\r\nCookie: {long}").into_bytes()
        };
        let answer = answered(endless);
        assert!(answer.is_empty() || answer.starts_with("HTTP/1.1 431 "), "{answer}");
    }
}
