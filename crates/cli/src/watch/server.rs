//! A page on the loopback, and news of it as server-sent events (<https://html.spec.whatwg.org/multipage/server-sent-events.html>).

use std::fs;
use std::io::{self, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use cotree::files;
use cotree_page::page::waiting_html;
use cotree_page::serve::Calls;
use cotree_page::serve::http::{Askers, HEARTBEAT, Request, respond};
use serde::Deserialize;
use serde_json::json;

use crate::failure::Failure;
use crate::serve;

/// What there is to see of the file as it is now.
pub enum ShownScene {
    Page {
        html: String,
        /// The text of the scene's own file.
        text: String,
        /// What is odd about the scene though it is no fault.
        warnings: Option<String>,
    },
    Fault(String),
}

/// The last good page, what is wrong with the file, and how often it has changed.
#[derive(Default)]
struct ServerState {
    page: Option<String>,
    text: String,
    warnings: Option<String>,
    fault: Option<String>,
    version: u64,
    /// The version of the page.
    good: u64,
}

/// What the server shows; whoever waits is told of a change.
#[derive(Default)]
pub struct Board {
    /// The scene's own file.
    file: PathBuf,
    state: Mutex<ServerState>,
    changed: Condvar,
}

/// What the page makes of the text that it was made from.
#[derive(Deserialize)]
struct Change {
    before: String,
    after: String,
}

impl Board {
    pub fn of(file: PathBuf) -> Self {
        Board { file, ..Board::default() }
    }

    /// Writes what the page has made of the scene into its file, unless that holds another text by now: whoever saved it would lose what he wrote.
    fn write(&self, change: &Change) -> Result<(), (&'static str, String)> {
        let wrong = |error: io::Error| ("500 Internal Server Error", format!("`{}`: {error}", self.file.display()));
        let now = fs::read(&self.file).map_err(wrong)?;
        if now != change.before.as_bytes() {
            let message = "the file has been saved by another program meanwhile".to_owned();
            return Err(("409 Conflict", message));
        }
        files::write(&self.file, change.after.as_bytes()).map_err(wrong)
    }

    pub fn show(&self, shown: ShownScene) {
        let mut state = self.state();
        state.version += 1;
        match shown {
            ShownScene::Page { html, text, warnings } => {
                state.good = state.version;
                (state.page, state.text, state.warnings, state.fault) = (Some(html), text, warnings, None);
            }
            ShownScene::Fault(fault) => state.fault = Some(fault),
        }
        self.changed.notify_all();
    }

    /// A thread that failed while it held the lock has left whole values: they are only replaced.
    fn state(&self) -> MutexGuard<'_, ServerState> {
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
        format!(
            "data: {}\n\n",
            json!({ "good": state.good, "text": state.text, "fault": state.fault, "warnings": state.warnings })
        )
    }
}

/// Serves the board on this machine alone. Returns the address for a browser.
pub fn start(port: u16, board: Arc<Board>, calls: Calls) -> Result<String, Failure> {
    serve::start(port, move |request, stream| answer(request, stream, &board, &calls))
}

fn answer(request: &Request, stream: TcpStream, board: &Board, calls: &Calls) -> io::Result<()> {
    match request.line.as_str() {
        "GET /" => respond(stream, "200 OK", board.page().as_bytes()),
        "GET /events" => report(stream, board),
        "POST /scene" => {
            let (status, message) = match serde_json::from_slice(&request.body).map(|change| board.write(&change)) {
                Ok(Ok(())) => ("200 OK", String::new()),
                Ok(Err(refused)) => refused,
                Err(_) => ("400 Bad Request", String::new()),
            };
            respond(stream, status, message.as_bytes())
        }
        requested => calls.respond(requested, &request.body, Askers::Own, stream),
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

#[cfg(test)]
mod tests {
    use std::io::Read;

    use cotree_page::desk::Desk;

    use super::*;

    #[test]
    fn a_page_of_this_server_writes_and_nobody_else_does() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.toml");
        fs::write(&file, "old").unwrap();
        let address = start(0, Arc::new(Board::of(file.clone())), Calls::new(Desk::default())).unwrap();
        let (host, token) = address.trim_start_matches("http://").trim_end_matches('/').split_once('/').unwrap();
        let post = |origin: &str, before: &str| {
            let body = json!({ "before": before, "after": "new" }).to_string();
            let mut stream = TcpStream::connect(host).unwrap();
            let length = body.len();
            write!(
                stream,
                "POST /{token}/scene HTTP/1.1\r\nHost: {host}\r\n{origin}Content-Length: {length}\r\n\r\n{body}"
            )
            .unwrap();
            let mut answer = String::new();
            let _ = stream.read_to_string(&mut answer);
            (answer, fs::read_to_string(&file).unwrap())
        };
        let origin = format!("Origin: http://{host}\r\n");
        for origin in ["", "Origin: http://elsewhere.example\r\n", "Origin: null\r\n"] {
            let (answer, text) = post(origin, "old");
            assert!(answer.starts_with("HTTP/1.1 403") && text == "old", "{origin}: {answer}");
        }
        let (answer, text) = post(&origin, "older");
        assert!(answer.starts_with("HTTP/1.1 409") && answer.contains("another program") && text == "old", "{answer}");
        let (answer, text) = post(&origin, "old");
        assert!(answer.starts_with("HTTP/1.1 200") && text == "new", "{answer}");
    }
}
