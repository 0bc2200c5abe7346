//! Pages on this machine whose solver and front end are this program: for whoever has built cotree without the modules for browsers.
//!
//! [`http`] lets a browser of this machine in, by an address that nobody guesses. A page asks as it would ask the modules inside a static page: the front end of `tools/front` by
//! [`Calls::answer`] through [`crate::desk`], the solver of `tools/web` through [`solver`], whole runs at a time.

pub mod http;
pub mod solver;

use std::io::{self, Write};

use cotree::export::FmiVersion;

use crate::desk::{self, Answer, Desk, failed};
use http::{Askers, respond, respond_with};
use solver::Solvers;

/// Files and sandboxed frames read an answer only if it says that they may.
const TO_FILES: &str = "Access-Control-Allow-Origin: null\r\nAccess-Control-Expose-Headers: Cotree-Failed\r\n";

/// What pages ask.
pub struct Calls {
    desk: Desk,
    solvers: Solvers,
}

impl Calls {
    pub fn new(desk: Desk) -> Self {
        Calls { desk, solvers: Solvers::default() }
    }

    /// The answer to a call by its name, or what is wrong; none if there is no such call.
    pub fn answer(&self, name: &str, body: &[u8]) -> Option<Answer> {
        let text = || String::from_utf8_lossy(body);
        Some(match name {
            "front_look" => Ok(desk::look(&text())),
            "front_edit" => desk::edit(&text()),
            "front_page" => desk::page(&text()),
            "front_answers" => Ok(desk::answers(&text())),
            "front_import" => desk::import(body),
            "front_gallery" => Ok(desk::gallery()),
            "front_fmu?2" => self.desk.fmu(&text(), FmiVersion::V2),
            "front_fmu?3" => self.desk.fmu(&text(), FmiVersion::V3),
            "load" => self.solvers.load(body).map_err(|message| failed(&message)),
            "solve" | "grip" | "pull" => self.solvers.ask(name, body).map_err(|message| failed(&message)),
            _ => return None,
        })
    }

    /// Answers a request of a page: a call by its name.
    ///
    /// # Errors
    /// The browser has gone.
    pub fn respond(&self, requested: &str, body: &[u8], askers: Askers, stream: impl Write) -> io::Result<()> {
        let to = if askers == Askers::Files { TO_FILES } else { "" };
        match requested.strip_prefix("POST /call/").and_then(|name| self.answer(name, body)) {
            Some(Ok(answer)) => respond_with(stream, "200 OK", to, &answer),
            // No status of a failure: browsers report those to whoever develops the page.
            Some(Err(faults)) => {
                respond_with(stream, "200 OK", &format!("{to}Cotree-Failed: 1\r\n"), faults.to_string().as_bytes())
            }
            None => respond(stream, "404 Not Found", b""),
        }
    }
}

/// Answers the calls of pages that lie in files and frames, in threads of their own; returns the address that those pages name.
///
/// # Errors
/// This machine gives no port.
pub fn for_files(desk: Desk) -> io::Result<String> {
    let calls = Calls::new(desk);
    http::serve(0, Askers::Files, move |request, stream| {
        calls.respond(&request.line, &request.body, Askers::Files, stream)
    })
}
