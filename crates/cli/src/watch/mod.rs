//! `cotree watch`

mod changes;
mod server;

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use clap::Args;
use cotree::export::{ExportError, runtime};
use cotree::scene::Source;
use cotree_page::moving;
use cotree_page::serve::Calls;

use super::failure::Failure;
use super::{output, serve};
use changes::FolderChanges;
use server::{Board, ShownScene};

/// Between two looks at files that change: what is the same in both has been written.
const SETTLED: Duration = Duration::from_millis(30);
/// An editor that replaces the file takes it away for a moment: it is missed after so many looks.
const MISSED: u32 = 20;
/// Between two looks at files of which nothing is heard: folders of other machines tell nothing of their changes.
const PATIENCE: Duration = Duration::from_secs(1);
/// The largest file whose content is compared [bytes]: a larger one has changed when its date has.
const LARGEST: u64 = 64 << 20;

/// Show the motion while you edit: serve the page of `cotree view` and reload it whenever the file is saved
///
/// Only this machine can open it. Changes in the page are written into the file, and changes in the file are shown in the page, which keeps its time and
/// zoom; errors appear in it with their place. If both change at once, the page says so, and nothing is lost.
/// Files of parts and tables are watched too.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree watch slider_crank.toml\n  cotree watch slider_crank.toml --port 8000")]
pub struct WatchCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Port of the page [default: any that is free]
    #[arg(long, value_name = "NUMBER", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Folder with the runtimes, made by tools/build-runtimes.sh [default: `runtimes` beside the program]
    #[arg(long, value_name = "FOLDER", env = "COTREE_RUNTIMES")]
    runtimes: Option<PathBuf>,
}

impl WatchCommand {
    pub fn run(self) -> Result<(), Failure> {
        if output::is_standard(&self.scene) {
            return Err(Failure::Usage("`watch` needs a file: standard input can be read only once".to_owned()));
        }
        let folder = self.runtimes.unwrap_or_else(runtime::default_folder);
        // Without the module this program is the page's solver.
        let module = runtime::for_browsers(&folder).map_err(ExportError::from)?.unwrap_or_default();
        match output::load(&self.scene) {
            Ok(_) | Err(Failure::Scene(_)) => {} // what is wrong may be mended while we watch
            Err(other) => return Err(other),
        }
        let board = Arc::new(Board::of(self.scene.clone()));
        let address = server::start(self.port, Arc::clone(&board), Calls::new(serve::desk(&folder)?))?;
        output::print(&format!("{address}\n"))?;
        WatchedScene::new(self.scene).follow(&board, &module);
    }
}

/// A scene and the files that it is made of.
struct WatchedScene {
    files: Vec<PathBuf>,
    /// The files as they were when they were shown.
    shown: Option<Vec<Option<Stamp>>>,
    contents: Option<Vec<Option<u64>>>,
}

impl WatchedScene {
    fn new(scene: PathBuf) -> Self {
        WatchedScene { files: vec![scene], shown: None, contents: None }
    }

    /// Shows the scene, and again whenever it changes.
    fn follow(mut self, board: &Board, module: &[u8]) -> ! {
        let mut changes = FolderChanges::new();
        changes.follow(&self.files);
        let (mut before, mut missed) = (None, 0);
        loop {
            let now: Vec<Option<Stamp>> = self.files.iter().map(|file| Stamp::of(file)).collect();
            let is_there = now.first().is_some_and(Option::is_some);
            missed = if is_there { 0 } else { missed + 1 };
            let now = Some(now);
            // A file that is just being written changes from one look to the next.
            let settled = now == before && is_there || missed == MISSED;
            if now != self.shown && settled && self.show(board, module, now.clone()) {
                changes.follow(&self.files);
            }
            match now == self.shown {
                true => changes.wait(PATIENCE),
                // Every write is an event: what is still being written would look settled between two of them.
                false => std::thread::sleep(SETTLED),
            }
            before = now;
        }
    }

    /// Shows what has changed. Are there other files now?
    fn show(&mut self, board: &Board, module: &[u8], now: Option<Vec<Option<Stamp>>>) -> bool {
        let contents = self.files.iter().map(|file| content(file)).collect::<Option<Vec<_>>>();
        // Saved as it was.
        let is_same = contents.is_some() && contents == self.contents;
        (self.shown, self.contents) = (now, contents);
        if is_same {
            return false;
        }
        let scene = self.files[0].clone();
        let (page, further) = shown(&scene, module.to_vec());
        board.show(page);
        let all: Vec<PathBuf> = std::iter::once(scene).chain(further).collect();
        let are_others = all != self.files;
        if are_others {
            // Files of which nothing was known may have changed meanwhile: all is shown again.
            *self = WatchedScene { files: all, shown: None, contents: None };
        }
        are_others
    }
}

/// A digest of what is in a file: of nothing if there is none; None if it is too large for that.
fn content(path: &Path) -> Option<Option<u64>> {
    match fs::metadata(path) {
        Ok(data) if data.is_file() && data.len() <= LARGEST => {
            let mut digest = DefaultHasher::new();
            let bytes = fs::read(path).ok();
            bytes.hash(&mut digest);
            Some(bytes.map(|_| digest.finish()))
        }
        Ok(_) => None,
        Err(_) => Some(None),
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
fn shown(path: &Path, module: Vec<u8>) -> (ShownScene, Vec<PathBuf>) {
    let further = |source: &Source| source.further.iter().map(|file| PathBuf::from(&file.name)).collect();
    let scene = match output::load(path) {
        Ok(scene) => scene,
        Err(failure) => {
            let files = if let Failure::Scene(faults) = &failure { further(&faults.source) } else { Vec::new() };
            return (faulty(failure), files);
        }
    };
    let files = further(&scene.source);
    let shown = match moving::page(&scene, Some(module)) {
        Err(faults) => faulty(faults.into()),
        Ok((_, Err(why))) => faulty(Failure::Numerical(why.to_string())),
        Ok((compiled, Ok(page))) => {
            let text = scene.source.own_text().to_owned();
            ShownScene::Page {
                html: page.live_html(),
                text,
                warnings: compiled.warnings.map(|warning| warning.render(false, 100)),
            }
        }
    };
    (shown, files)
}

fn faulty(failure: Failure) -> ShownScene {
    match failure {
        Failure::Scene(faults) => ShownScene::Fault(faults.render(false, 100)),
        Failure::Usage(message) | Failure::Limit(message) | Failure::Numerical(message) | Failure::Stopped(message) => {
            ShownScene::Fault(message)
        }
        Failure::Told(_) | Failure::ClosedPipe => ShownScene::Fault(String::new()),
    }
}
