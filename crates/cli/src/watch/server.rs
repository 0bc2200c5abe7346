//! A page on the loopback, and news of it as server-sent events (<https://html.spec.whatwg.org/multipage/server-sent-events.html>).

use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use cotree::files;
use cotree::scene::Scene;
use cotree_page::page::waiting_html;
use serde::Deserialize;
use serde_json::json;

/// A page that is closed is noticed after this time.
const HEARTBEAT: Duration = Duration::from_secs(5);

/// Longest request with its headers [bytes]: browsers send a few hundred, and cookies of other pages of this machine.
const LARGEST_HEAD: u64 = 1 << 16;

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
    let mut reader = BufReader::new(&mut stream);
    let Some(head) = head(&mut reader)? else { return respond(stream, "431 Request Header Fields Too Large", "") };
    let mut lines = head.split("\r\n");
    let request = lines.next().unwrap_or_default();
    match request.rsplit_once(' ').map(|(asked, _)| asked) {
        // Another site whose name leads here does not get anything.
        _ if !is_ours(lines.clone(), address) => respond(stream, "403 Forbidden", ""),
        Some("GET /") => respond(stream, "200 OK", &board.page()),
        Some("GET /events") => report(stream, board),
        // Nor does it write anything: browsers say whose page asks.
        Some("POST /scene") if !is_from_here(lines.clone(), address) => respond(stream, "403 Forbidden", ""),
        Some("POST /scene") => {
            let (status, message) = match body(&mut reader, lines)?.map(|change| board.write(&change)) {
                Some(Ok(())) => ("200 OK", String::new()),
                Some(Err(refused)) => refused,
                None => ("400 Bad Request", String::new()),
            };
            respond(stream, status, &message)
        }
        _ => respond(stream, "404 Not Found", ""),
    }
}

/// What the request brings: none if that is no change of a scene, or larger than any.
fn body<'a>(reader: &mut impl BufRead, headers: impl Iterator<Item = &'a str>) -> io::Result<Option<Change>> {
    let length = field(headers, "content-length").and_then(|length| length.parse::<u64>().ok());
    // Two texts, each with its escapes.
    let Some(length) = length.filter(|length| *length <= 4 * Scene::LARGEST) else { return Ok(None) };
    let mut body = Vec::new();
    reader.take(length).read_to_end(&mut body)?;
    Ok(serde_json::from_slice(&body).ok())
}

/// The request with its headers; none if they are longer than any that a browser sends.
fn head(reader: &mut impl BufRead) -> io::Result<Option<String>> {
    let mut head = Vec::new();
    let mut reader = reader.take(LARGEST_HEAD);
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

/// The value of a header.
fn field<'a>(mut headers: impl Iterator<Item = &'a str>, name: &str) -> Option<&'a str> {
    headers.find_map(|header| {
        let (field, value) = header.split_once(':')?;
        field.eq_ignore_ascii_case(name).then(|| value.trim())
    })
}

/// This server by its names.
fn own_names(address: SocketAddr) -> [String; 2] {
    [address.to_string(), format!("localhost:{}", address.port())]
}

/// True if this machine is asked by its own name.
fn is_ours<'a>(headers: impl Iterator<Item = &'a str>, address: SocketAddr) -> bool {
    field(headers, "host").is_some_and(|host| own_names(address).iter().any(|name| host == name))
}

/// True if a page of this server asks.
fn is_from_here<'a>(headers: impl Iterator<Item = &'a str>, address: SocketAddr) -> bool {
    let origin = field(headers, "origin").and_then(|origin| origin.strip_prefix("http://"));
    origin.is_some_and(|origin| own_names(address).iter().any(|name| origin == name))
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
    fn a_page_of_this_server_writes_and_nobody_else_does() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.toml");
        fs::write(&file, "old").unwrap();
        let address = start(0, Arc::new(Board::of(file.clone()))).unwrap();
        let host = address.trim_start_matches("http://").trim_end_matches('/');
        let post = |origin: &str, before: &str| {
            let body = json!({ "before": before, "after": "new" }).to_string();
            let mut stream = TcpStream::connect(host).unwrap();
            let length = body.len();
            write!(stream, "POST /scene HTTP/1.1\r\nHost: {host}\r\n{origin}Content-Length: {length}\r\n\r\n{body}")
                .unwrap();
            let mut answer = String::new();
            let _ = stream.read_to_string(&mut answer);
            (answer, fs::read_to_string(&file).unwrap())
        };
        let own = format!("Origin: http://{host}\r\n");
        for origin in ["", "Origin: http://elsewhere.example\r\n", "Origin: null\r\n"] {
            let (answer, text) = post(origin, "old");
            assert!(answer.starts_with("HTTP/1.1 403") && text == "old", "{origin}: {answer}");
        }
        let (answer, text) = post(&own, "older");
        assert!(answer.starts_with("HTTP/1.1 409") && answer.contains("another program") && text == "old", "{answer}");
        let (answer, text) = post(&own, "old");
        assert!(answer.starts_with("HTTP/1.1 200") && text == "new", "{answer}");
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
