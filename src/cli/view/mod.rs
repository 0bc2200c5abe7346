//! `cotree view`

pub mod page;

use std::path::PathBuf;

use clap::Args;

use super::failure::Failure;
use super::{MessageFormat, output};
use crate::export::{ExportError, runtime};

/// See it move: one page for a browser, with the mechanism in motion, plots and sliders
///
/// The page needs no network. It has the solver of the FMU inside if the runtime for browsers is there (`web/cotree_runtime.wasm` in
/// the folder of runtimes, made by tools/build-runtimes.sh); otherwise it plays a run that is stored in it, and says so.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree view slider_crank.toml\n  cotree view slider_crank.toml -o crank.html --runtimes target/runtimes"
)]
pub struct View {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Where the page goes [default: the name of the scene, .html, in the current folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Folder with the runtimes, made by tools/build-runtimes.sh [default: `runtimes` beside the program]
    #[arg(long, value_name = "FOLDER", env = "COTREE_RUNTIMES")]
    runtimes: Option<PathBuf>,
}

impl View {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let folder = self.runtimes.unwrap_or_else(runtime::default_folder);
        let module = runtime::for_browsers(&folder).map_err(ExportError::from)?;
        let scene = output::load(&self.scene)?;
        let (compiled, page) = page::page(&scene, module)?;
        output::warn_of(&compiled, format);
        let page = page.map_err(Failure::Numerical)?;
        let path = self.output.unwrap_or_else(|| format!("{}.html", compiled.description.identifier).into());
        output::apart(&[Some(&self.scene)], &[Some(&path)])?;
        output::write(&path, &page.html())?;
        output::print(&format!("{}\n", path.display()))
    }
}
