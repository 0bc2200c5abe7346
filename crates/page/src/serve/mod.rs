//! Pages on this machine whose solver and front end are this program: for whoever has built cotree without the modules for browsers.
//!
//! [`http`] lets a browser of this machine in, by an address that nobody guesses. A page asks as it would ask the modules inside a static page: the front end of `tools/front` by
//! [`Calls::answer`] through [`crate::desk`], the solver of `tools/web` through [`solver`], whole runs at a time.

pub mod http;
pub mod solver;

use cotree::export::FmiVersion;

use crate::desk::{self, Answer, Desk, failed};
use solver::Solvers;

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
}
