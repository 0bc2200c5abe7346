//! `cotree watch`

mod server;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use clap::Args;

use super::failure::Failure;
use super::output;
use crate::compile::page;
use crate::export::{ExportError, runtime};
use crate::output::page::Page;
use crate::scene::{Scene, Source};
use server::{Board, Shown};

/// How often the file's date and length are looked at: often enough that nobody waits, and next to no work.
const PATIENCE: Duration = Duration::from_millis(30);
/// An editor that replaces the file takes it away for a moment: it is missed after so many looks.
const MISSED: u32 = 20;

/// See it move while you edit: serves the page of `cotree view` on this machine and renews it whenever the file is saved
///
/// Only this machine can reach it. The page keeps the time, the zoom and the sliders; faults appear in it with their place.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree watch slider_crank.toml\n  cotree watch slider_crank.toml --port 8000")]
pub struct Watch {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Port of the page [default: any that is free]
    #[arg(long, value_name = "NUMBER", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Folder with the runtimes, made by tools/build-runtimes.sh [default: `runtimes` beside the program]
    #[arg(long, value_name = "FOLDER", env = "COTREE_RUNTIMES")]
    runtimes: Option<PathBuf>,
}

impl Watch {
    pub fn run(self) -> Result<(), Failure> {
        let folder = self.runtimes.unwrap_or_else(runtime::default_folder);
        let module = runtime::for_browsers(&folder).map_err(ExportError::from)?;
        match output::load(&self.scene) {
            Ok(_) | Err(Failure::Scene(_)) => {} // what is wrong may be mended while we watch
            Err(other) => return Err(other),
        }
        let board = Arc::new(Board::default());
        let address = server::start(self.port, Arc::clone(&board)).map_err(|error| {
            Failure::Usage(format!("cannot serve a page on port {} of this machine: {error}", self.port))
        })?;
        output::print(&format!("{address}\n"))?;
        let mut files = vec![self.scene.clone()];
        let (mut last, mut before, mut missed) = (None, None, 0);
        loop {
            let now: Vec<Option<Stamp>> = files.iter().map(|file| Stamp::of(file)).collect();
            let is_there = now.first().is_some_and(Option::is_some);
            missed = if is_there { 0 } else { missed + 1 };
            let now = Some(now);
            // A file that is just being written changes from one look to the next.
            let settled = now == before && is_there || missed == MISSED;
            if now != last && settled {
                let (page, further) = shown(&self.scene, module.clone());
                board.show(page);
                // Files of which nothing is known yet may have changed meanwhile: then it is shown again.
                let all: Vec<PathBuf> = std::iter::once(self.scene.clone()).chain(further).collect();
                last = if all == files { now.clone() } else { None };
                files = all;
            }
            before = now;
            std::thread::sleep(PATIENCE);
        }
    }
}

/// What changes when a file is saved, replaced, or a link leads to another.
#[derive(Clone, PartialEq)]
struct Stamp {
    modified: Option<SystemTime>,
    length: u64,
    place: Option<PathBuf>,
    #[cfg(unix)]
    number: u64,
}

impl Stamp {
    /// None if there is no such file now.
    fn of(path: &Path) -> Option<Self> {
        let data = fs::metadata(path).ok()?;
        Some(Stamp {
            modified: data.modified().ok(),
            length: data.len(),
            place: path.canonicalize().ok(),
            #[cfg(unix)]
            number: std::os::unix::fs::MetadataExt::ino(&data),
        })
    }
}

/// The page of the scene, or why there is none; and the further files that it is made of.
fn shown(path: &Path, module: Option<Vec<u8>>) -> (Shown, Vec<PathBuf>) {
    let further = |source: &Source| source.further.iter().map(|file| PathBuf::from(&file.name)).collect();
    let scene = match output::load(path) {
        Ok(scene) => scene,
        Err(failure) => {
            let files = if let Failure::Scene(faults) = &failure { further(&faults.source) } else { Vec::new() };
            return (faulty(failure), files);
        }
    };
    let files = further(&scene.source);
    (made(&scene, module).map_or_else(faulty, |page| Shown::Page(page.live_html())), files)
}

fn faulty(failure: Failure) -> Shown {
    match failure {
        Failure::Scene(faults) => Shown::Fault(faults.render(false, 100)),
        Failure::Usage(message) | Failure::Numerical(message) | Failure::Stopped(message) => Shown::Fault(message),
        Failure::ClosedPipe => Shown::Fault(String::new()),
    }
}

fn made(scene: &Scene, module: Option<Vec<u8>>) -> Result<Page, Failure> {
    let (_, page) = page::page(scene, module)?;
    page.map_err(Failure::Numerical)
}
