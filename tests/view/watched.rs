//! `cotree watch` as a browser meets it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

pub struct Watched {
    child: Child,
    /// Such as `127.0.0.1:40123`.
    pub host: String,
    /// The same with the path of the page.
    pub page: String,
}

impl Watched {
    pub fn start(scene: &Path) -> Watched {
        Self::start_with(scene, None)
    }

    /// With the runtime for browsers in a folder.
    pub fn start_with(scene: &Path, runtimes: Option<&Path>) -> Watched {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cotree"));
        command.arg("watch");
        if let Some(folder) = runtimes {
            command.arg("--runtimes").arg(folder);
        }
        command.arg(scene);
        Self::serving(command)
    }

    /// A command that serves a page and prints its address.
    pub fn serving(mut command: Command) -> Watched {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let mut address = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
        let host = address.trim().strip_prefix("http://").and_then(|rest| rest.strip_suffix('/'));
        let page = host.unwrap_or_else(|| panic!("no address: {address:?}")).to_owned();
        assert!(page.starts_with("127.0.0.1:"), "{page}");
        let (host, token) = page.split_once('/').expect("a random path");
        assert_eq!(token.len(), 32, "{token}");
        Watched { child, host: host.to_owned(), page }
    }

    fn ask(&self, place: &str, host: &str) -> TcpStream {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
        let token = self.page.trim_start_matches(&self.host);
        write!(stream, "GET {token}{place} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
        stream
    }

    /// The whole answer.
    pub fn get(&self, place: &str, host: &str) -> String {
        let mut answer = String::new();
        self.ask(place, host).read_to_string(&mut answer).unwrap();
        answer
    }

    pub fn events(&self) -> Events {
        Events(BufReader::new(self.ask("/events", &self.host)))
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub struct Events(BufReader<TcpStream>);

impl Events {
    /// What the next event says.
    pub fn next(&mut self) -> serde_json::Value {
        loop {
            let mut line = String::new();
            assert!(self.0.read_line(&mut line).unwrap() > 0, "the events end");
            if let Some(data) = line.strip_prefix("data: ") {
                return serde_json::from_str(data).unwrap();
            }
        }
    }
}
