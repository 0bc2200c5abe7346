//! A page on the loopback, and news of it as server-sent events (<https://html.spec.whatwg.org/multipage/server-sent-events.html>).

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::json;

use crate::output::page::waiting_html;

/// A request of a browser is far shorter.
const LONGEST_REQUEST: u64 = 1 << 16;
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
fn answer(stream: TcpStream, address: SocketAddr, board: &Board) -> io::Result<()> {
    stream.set_read_timeout(Some(HEARTBEAT))?;
    let mut reader = BufReader::new(stream.take(LONGEST_REQUEST));
    let (place, ours) = request(&mut reader, address)?;
    let mut stream = reader.into_inner().into_inner();
    match place.as_str() {
        // Another site whose name leads here does not get anything.
        _ if !ours => write!(stream, "HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"),
        "/" => {
            let page = board.page();
            let length = page.len();
            write!(
                stream,
                "HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {length}\r\n"
            )?;
            write!(stream, "Cache-Control: no-store\r\nConnection: close\r\n\r\n{page}")
        }
        "/events" => {
            write!(stream, "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n\r\n")?;
            let mut seen = 0;
            loop {
                stream.write_all(board.next(&mut seen).as_bytes())?;
                stream.flush()?;
            }
        }
        _ => write!(stream, "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"),
    }
}

/// What is asked for, and is it asked of this machine by its own name?
fn request(reader: &mut impl BufRead, address: SocketAddr) -> io::Result<(String, bool)> {
    let mut first = String::new();
    reader.read_line(&mut first)?;
    let place = first.strip_prefix("GET ").and_then(|rest| rest.split(' ').next()).unwrap_or_default().to_owned();
    let mut ours = false;
    loop {
        let mut line = String::new();
        if reader.read_line(&mut line)? == 0 || line.trim().is_empty() {
            return Ok((place, ours));
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("host")
        {
            let names = [address.to_string(), format!("localhost:{}", address.port())];
            ours = names.iter().any(|name| name == value.trim());
        }
    }
}
