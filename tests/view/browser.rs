//! Headless Chromium on a page: a server on the loopback hands out the page inside a frame, a script beside the frame looks at it and
//! posts what it saw.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A page must be ready, and the script done, within this time on a slow and busy machine.
const PATIENCE: Duration = Duration::from_secs(180);

pub struct Browser {
    program: PathBuf,
    /// Do its readers like dark colours?
    dark: bool,
}

/// Where the page in the frame comes from.
pub struct Source<'a> {
    pub page: &'a str,
    /// Host of a server that has it, and its events, if it is no text.
    pub server: &'a str,
    /// What is done if the script asks for `/edit/` and a number.
    pub edit: &'a dyn Fn(usize),
}

/// What the script saw, and what the browser wrote on its console.
pub struct Seen {
    pub verdict: serde_json::Value,
    pub console: Vec<String>,
}

/// The script runs as soon as the page in the frame is ready: `page` is its window, `cotree` its handle.
const FRAME: &str = r#"<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,">
<iframe src="/page" width="1300" height="800"></iframe><script>
const frame = document.querySelector("iframe"), wait = ms => new Promise(done => setTimeout(done, ms));
const post = verdict => fetch("/verdict", { method: "POST", body: JSON.stringify(verdict) });
(async () => {
  const page = frame.contentWindow;
  while (!page.document?.documentElement?.dataset.ready) await wait(20);
  const cotree = page.cotree, $ = id => page.document.getElementById(id);
  return (async () => { SCRIPT })();
})().then(post, fault => post({ fault: String(fault) }));
</script>"#;

impl Browser {
    pub fn find() -> Option<Browser> {
        let folders = std::env::var_os("PATH")?;
        let names = ["chromium", "chromium-browser", "google-chrome"];
        let places = std::env::split_paths(&folders).flat_map(|folder| names.map(|name| folder.join(name)));
        let program = places.into_iter().find(|place| place.is_file());
        if program.is_none() {
            eprintln!("skipped: there is no Chromium");
        }
        program.map(|program| Browser { program, dark: false })
    }

    pub fn dark(&self, dark: bool) -> Browser {
        Browser { program: self.program.clone(), dark }
    }

    pub fn look(&self, page: &str, script: &str) -> Seen {
        self.look_at(&Source { page, server: "", edit: &|_| () }, script)
    }

    pub fn look_at(&self, source: &Source, script: &str) -> Seen {
        let folder = tempfile::tempdir().unwrap();
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("http://{}/", server.local_addr().unwrap());
        let mut child = self.start(folder.path(), &address);
        let console = BufReader::new(child.stderr.take().unwrap());
        let listening = std::thread::spawn(move || {
            console.lines().map_while(Result::ok).filter(|line| line.contains(":CONSOLE")).collect::<Vec<_>>()
        });
        let verdict = serve(&server, source, &FRAME.replace("SCRIPT", script));
        let _ = child.kill();
        let _ = child.wait();
        let console = listening.join().unwrap();
        let verdict = verdict.unwrap_or_else(|| panic!("the page was not ready in time\n{}", console.join("\n")));
        Seen { verdict, console }
    }

    fn start(&self, folder: &Path, address: &str) -> Child {
        let mut command = Command::new(&self.program);
        command.args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"]);
        command.args(["--disable-background-networking", "--enable-logging=stderr", "--v=0"]);
        command.arg(format!("--blink-settings=preferredColorScheme={}", u8::from(!self.dark)));
        command.arg(format!("--user-data-dir={}", folder.display())).arg(address);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().unwrap_or_else(|error| panic!("{} cannot be started: {error}", self.program.display()))
    }
}

/// Answers until the verdict comes.
fn serve(server: &TcpListener, source: &Source, frame: &str) -> Option<serde_json::Value> {
    server.set_nonblocking(true).unwrap();
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        match server.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(false).unwrap();
                stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
                if let Some(verdict) = answer(stream, source, frame) {
                    return Some(verdict);
                }
            }
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
    }
    None
}

fn answer(stream: TcpStream, source: &Source, frame: &str) -> Option<serde_json::Value> {
    let mut reader = BufReader::new(stream);
    let mut first = String::new();
    reader.read_line(&mut first).ok()?;
    let mut length = 0;
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).ok()?;
        if line.trim().is_empty() {
            break;
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("content-length")
        {
            length = value.trim().parse().ok()?;
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).ok()?;
    let place = first.split(' ').nth(1).unwrap_or_default();
    let requested = match place {
        "/page" => "/",
        other => other,
    };
    if !source.server.is_empty() && (["/page", "/events", "/scene"].contains(&place) || place.starts_with("/call/")) {
        let method = first.split(' ').next().unwrap_or_default();
        let (server, token) = source.server.split_once('/').unwrap();
        pass_on(server, &format!("{method} /{token}{requested}"), &body, reader.into_inner());
        return None;
    }
    if let Some(number) = place.strip_prefix("/edit/") {
        (source.edit)(number.parse().ok()?);
    }
    let content = match place {
        "/" => frame,
        "/page" => source.page,
        _ => "",
    };
    let head = format!(
        "HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
        content.len()
    );
    let mut stream = reader.into_inner();
    let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(content.as_bytes()));
    (place == "/verdict").then(|| serde_json::from_slice(&body).unwrap())
}

/// Asks another server as a page of its own would, and passes its answer on as it comes.
fn pass_on(server: &str, requested: &str, body: &[u8], mut to: TcpStream) {
    let mut from = TcpStream::connect(server).unwrap();
    let length = body.len();
    write!(from, "{requested} HTTP/1.1\r\nHost: {server}\r\nOrigin: http://{server}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n").unwrap();
    from.write_all(body).unwrap();
    std::thread::spawn(move || {
        // Either side may go away.
        let _ = std::io::copy(&mut from, &mut to);
    });
}
