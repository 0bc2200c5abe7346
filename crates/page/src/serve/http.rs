//! The little of HTTP/1.1 (RFC 9112) that a page on the loopback needs. Others are kept out three times: only this machine reaches the port; the path begins with a random
//! token; and a request must name this server as its host and, where it changes something, as its origin, so that pages of other sites do nothing by a name that leads here.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use cotree::scene::Scene;

/// A browser that says nothing for so long has gone.
pub const HEARTBEAT: Duration = Duration::from_secs(5);
/// A request is whole after so long, however slowly it comes: on this machine the largest takes a second.
const DEADLINE: Duration = Duration::from_secs(10);
/// So many requests are answered at once: browsers open six connections to a server, and pages wait for changes on one each.
const MOST_AT_ONCE: usize = 128;
/// How long no connection is taken where that has failed, as it does at once while descriptors have run out.
const PAUSE: Duration = Duration::from_millis(100);
/// Longest request with its headers \[bytes\]: browsers send a few hundred, and cookies of other pages of this machine.
pub const LARGEST_HEAD: u64 = 1 << 16;
/// Largest content of a request [bytes]: two scenes, each with its escapes.
const LARGEST_BODY: u64 = 4 * Scene::LARGEST;

/// Whose pages may ask for more than a page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Askers {
    /// Those of this server.
    Own,
    /// Files and sandboxed frames, too, which browsers call `null`: they know the token.
    Files,
}

/// What a page of this server asks for.
pub struct Request {
    /// Method and path below the token, such as `GET /`.
    pub line: String,
    pub body: Vec<u8>,
}

/// 128 bits that nobody guesses: each is of SipHash with keys that the operating system has drawn.
fn token() -> String {
    let word = |_| RandomState::new().build_hasher().finish();
    [0, 1].map(word).iter().map(|word| format!("{word:016x}")).collect()
}

/// Serves on this machine alone: each request is answered in a thread of its own. Returns the address for a browser.
///
/// # Errors
/// The port is taken.
pub fn serve(
    port: u16,
    askers: Askers,
    answer: impl Fn(&Request, TcpStream) -> io::Result<()> + Send + Sync + 'static,
) -> io::Result<String> {
    serve_within(port, askers, (DEADLINE, MOST_AT_ONCE), answer)
}

fn serve_within(
    port: u16,
    askers: Askers,
    (deadline, most): (Duration, usize),
    answer: impl Fn(&Request, TcpStream) -> io::Result<()> + Send + Sync + 'static,
) -> io::Result<String> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
    let address = listener.local_addr()?;
    let (token, answer) = (Arc::<str>::from(token()), Arc::new(answer));
    let page = format!("http://{address}/{token}/");
    // Each thread holds a copy for as long as it lives.
    let present = Arc::new(());
    let admit_each = move |stream: TcpStream| {
        if Arc::strong_count(&present) > most {
            // Whoever has gone meanwhile is not told.
            let _ = respond(stream, "503 Service Unavailable", b"");
            return;
        }
        let (token, answer, present) = (Arc::clone(&token), Arc::clone(&answer), Arc::clone(&present));
        let thread = thread::Builder::new().spawn(move || {
            // A browser that goes away is no fault.
            let _ = admit(stream, address, (&token, askers), deadline, &*answer);
            drop(present);
        });
        // Without a thread the connection is closed.
        drop(thread);
    };
    thread::spawn(move || take(listener.incoming(), admit_each, || thread::sleep(PAUSE)));
    Ok(page)
}

/// Takes connections; pauses after each that fails.
fn take<S>(connections: impl Iterator<Item = io::Result<S>>, admit: impl Fn(S), mut pause: impl FnMut()) {
    for connection in connections {
        match connection {
            Ok(stream) => admit(stream),
            Err(_) => pause(),
        }
    }
}

/// What comes from a browser up to a time, with no pause that is longer than a heartbeat.
struct Timely<'s> {
    stream: &'s TcpStream,
    until: Instant,
}

impl Read for Timely<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = self.until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(Some(left.min(HEARTBEAT)))?;
        let mut stream = self.stream;
        stream.read(buffer)
    }
}

/// Reads a request and has it answered, if it comes from where it may.
fn admit(
    stream: TcpStream,
    address: SocketAddr,
    (token, askers): (&str, Askers),
    deadline: Duration,
    answer: &impl Fn(&Request, TcpStream) -> io::Result<()>,
) -> io::Result<()> {
    // A browser that reads nothing has gone, too.
    stream.set_write_timeout(Some(HEARTBEAT))?;
    stream.set_nodelay(true)?;
    let mut reader = BufReader::new(Timely { stream: &stream, until: Instant::now() + deadline });
    let Some(head) = head(&mut reader)? else { return respond(stream, "431 Request Header Fields Too Large", b"") };
    let mut lines = head.split("\r\n");
    let (method, path) = lines
        .next()
        .and_then(|line| line.rsplit_once(' '))
        .and_then(|(line, _)| line.split_once(' '))
        .unwrap_or_default();
    let is_ours = field(lines.clone(), "host").is_some_and(|host| own_names(address).iter().any(|name| host == name));
    let origin = field(lines.clone(), "origin");
    let site = origin.and_then(|origin| origin.strip_prefix("http://"));
    let is_from_here = site.is_some_and(|origin| own_names(address).iter().any(|name| origin == name))
        || askers == Askers::Files && origin == Some("null");
    if !is_ours || method != "GET" && !is_from_here {
        return respond(stream, "403 Forbidden", b"");
    }
    let Some(place) = path.strip_prefix('/').and_then(|path| path.strip_prefix(token)) else {
        return respond(stream, "404 Not Found", b"");
    };
    let Some(body) = body(&mut reader, lines)? else { return respond(stream, "400 Bad Request", b"") };
    answer(&Request { line: format!("{method} {place}"), body }, stream)
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

/// What the request brings; none if that is larger than anything that a page sends.
fn body<'a>(reader: &mut impl BufRead, headers: impl Iterator<Item = &'a str>) -> io::Result<Option<Vec<u8>>> {
    let length = field(headers, "content-length").map_or(Ok(0), str::parse::<u64>);
    let Some(length) = length.ok().filter(|length| *length <= LARGEST_BODY) else { return Ok(None) };
    let mut body = Vec::new();
    reader.take(length).read_to_end(&mut body)?;
    Ok(Some(body))
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

/// Answers with a page, or other bytes.
///
/// # Errors
/// The browser has gone.
pub fn respond(stream: impl Write, status: &str, content: &[u8]) -> io::Result<()> {
    respond_with(stream, status, "", content)
}

/// The same with a header more, with its line end.
///
/// # Errors
/// The browser has gone.
pub fn respond_with(mut stream: impl Write, status: &str, header: &str, content: &[u8]) -> io::Result<()> {
    let length = content.len();
    let mut answer = Vec::with_capacity(length + 512);
    // One write: a write for each piece sends a packet for each.
    write!(
        answer,
        "HTTP/1.1 {status}\r\nContent-Type: text/html; charset=utf-8\r\nCache-Control: no-store\r\n\
         Referrer-Policy: no-referrer\r\nContent-Length: {length}\r\n{header}Connection: close\r\n\r\n"
    )?;
    answer.extend_from_slice(content);
    stream.write_all(&answer)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a server that always says "here" answers to a request.
    fn answered(request: impl Fn(&str, &str) -> String) -> String {
        answered_to(Askers::Own, request)
    }

    fn answered_to(askers: Askers, request: impl Fn(&str, &str) -> String) -> String {
        let address =
            serve(0, askers, |request, stream| respond(stream, "200 OK", format!("here: {}", request.line).as_bytes()))
                .unwrap();
        let (host, token) = address.trim_start_matches("http://").trim_end_matches('/').split_once('/').unwrap();
        let mut stream = TcpStream::connect(host).unwrap();
        // Where the server has heard enough it closes, and the rest cannot be sent.
        let _ = stream.write_all(request(host, token).as_bytes());
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    #[test]
    fn pages_are_for_those_who_know_the_address() {
        let get = |path: &str, host: &str| format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
        assert!(answered(|host, token| get(&format!("/{token}/a"), host)).ends_with("here: GET /a"));
        for path in ["/", "/a", "/0123456789abcdef0123456789abcdef/"] {
            assert!(answered(|host, _| get(path, host)).starts_with("HTTP/1.1 404 "), "{path}");
        }
        assert!(answered(|_, token| get(&format!("/{token}/"), "elsewhere.example")).starts_with("HTTP/1.1 403 "));
        assert_ne!(token(), token());
    }

    #[test]
    fn only_pages_of_this_server_ask_for_more_than_pages() {
        let post = |origin: &str, host: &str, token: &str| {
            format!("POST /{token}/call HTTP/1.1\r\nHost: {host}\r\n{origin}Content-Length: 1\r\n\r\nx")
        };
        for origin in ["", "Origin: http://elsewhere.example\r\n", "Origin: null\r\n"] {
            assert!(answered(|host, token| post(origin, host, token)).starts_with("HTTP/1.1 403 "), "{origin}");
        }
        for askers in [Askers::Own, Askers::Files] {
            assert!(
                answered_to(askers, |host, token| post(&format!("Origin: http://{host}\r\n"), host, token))
                    .ends_with("here: POST /call")
            );
        }
    }

    #[test]
    fn files_ask_where_they_may_and_know_the_token() {
        let post = |origin: &str, host: &str, token: &str| {
            format!("POST /{token}/call HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\nContent-Length: 1\r\n\r\nx")
        };
        let files = |origin: &'static str| answered_to(Askers::Files, move |host, token| post(origin, host, token));
        assert!(files("null").ends_with("here: POST /call"));
        assert!(files("http://elsewhere.example").starts_with("HTTP/1.1 403 "));
        assert!(answered_to(Askers::Files, |host, _| post("null", host, "0123")).starts_with("HTTP/1.1 404 "));
    }

    /// A connection has one request: what follows it is not read as another one.
    #[test]
    fn what_follows_a_request_is_not_another_one() {
        let answer = answered(|host, token| {
            let get =
                |path: &str| format!("GET /{token}/{path} HTTP/1.1\r\nHost: {host}\r\nConnection: keep-alive\r\n\r\n");
            get("first") + &get("second")
        });
        assert!(answer.contains("\r\nConnection: close\r\n") && answer.ends_with("here: GET /first"), "{answer}");
    }

    #[test]
    fn a_length_that_is_none_or_too_large_is_refused() {
        for length in ["-1", "1e3", "", "99999999999999999999999", &(LARGEST_BODY + 1).to_string()] {
            let answer = answered(|host, token| {
                format!(
                    "POST /{token}/call HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nContent-Length: {length}\r\n\r\nx"
                )
            });
            assert!(answer.starts_with("HTTP/1.1 400 "), "{length}: {answer}");
        }
    }

    /// Whoever sends a byte now and then held a thread and a descriptor for days.
    #[test]
    fn a_request_that_drips_is_cut() {
        let limits = (Duration::from_millis(200), MOST_AT_ONCE);
        let address = serve_within(0, Askers::Own, limits, |_, stream| respond(stream, "200 OK", b"here")).unwrap();
        let host = address.trim_start_matches("http://").split('/').next().unwrap();
        let mut stream = TcpStream::connect(host).unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\nCookie: ").unwrap();
        const MOST: usize = 10_000;
        let sent = (0..MOST).take_while(|_| {
            thread::sleep(Duration::from_millis(5));
            stream.write_all(b"x").is_ok()
        });
        assert!(sent.count() < MOST, "never cut");
    }

    #[test]
    fn more_connections_than_are_answered_at_once_are_closed() {
        let answer = |_: &Request, stream: TcpStream| respond(stream, "200 OK", b"here");
        let address = serve_within(0, Askers::Own, (DEADLINE, 2), answer).unwrap();
        let (host, token) = address.trim_start_matches("http://").trim_end_matches('/').split_once('/').unwrap();
        let get = || {
            let (mut stream, mut answer) = (TcpStream::connect(host).unwrap(), Vec::new());
            let _ = stream.write_all(format!("GET /{token}/ HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
            let _ = stream.read_to_end(&mut answer);
            String::from_utf8_lossy(&answer).ends_with("here")
        };
        let silent = [(); 2].map(|()| TcpStream::connect(host).unwrap());
        assert!(!get());
        drop(silent);
        let again = (0..1000).any(|_| {
            thread::sleep(Duration::from_millis(5));
            get()
        });
        assert!(again, "who has gone makes room");
    }

    /// While descriptors have run out each connection fails at once: that took a whole core.
    #[test]
    fn a_pause_follows_each_connection_that_fails() {
        let connections = [Err(()), Ok(1), Err(()), Err(()), Ok(2)];
        let connections = connections.map(|found| found.map_err(|()| io::Error::other("too many open files")));
        let (admitted, mut pauses) = (std::cell::RefCell::new(Vec::new()), 0);
        take(connections.into_iter(), |stream| admitted.borrow_mut().push(stream), || pauses += 1);
        assert_eq!((admitted.into_inner(), pauses), (vec![1, 2], 3));
    }

    #[test]
    fn headers_without_end_are_not_kept() {
        let long = "x".repeat(4 * LARGEST_HEAD as usize);
        let answer = answered(|host, _| format!("GET / HTTP/1.1\r\nHost: {host}\r\nCookie: {long}"));
        assert!(answer.is_empty() || answer.starts_with("HTTP/1.1 431 "), "{answer}");
    }
}
