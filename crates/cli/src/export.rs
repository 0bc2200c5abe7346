//! `cotree export`

use std::path::{Path, PathBuf};

use clap::Args;
use cotree::export::runtime::{self, PLATFORMS, Platform, Runtime, RuntimeError};
use cotree::export::{ExportError, FmiVersion};
use cotree_page::Made;

use super::failure::Failure;
use super::words::one_of;
use super::{MessageFormat, output};

/// Export an FMU for any tool that reads FMI 2.0, or 3.0 with --fmi 3
///
/// The FMU contains its solver and needs no other program. The same scene gives the same file.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree export slider_crank.toml\n  cotree export slider_crank.toml -o fmus/crank.fmu\n  cotree export slider_crank.toml --fmi 3\n  \
                  cotree export slider_crank.toml --platform linux64,win64 --runtimes target/runtimes"
)]
pub struct ExportCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Output file of the FMU [default: the name of the scene file, .fmu, in the current folder; for `scene.toml` the name in it]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Export every variable of the mechanism, not only the outputs of the scene
    #[arg(long)]
    all: bool,
    /// Version of FMI
    #[arg(long, value_name = "VERSION", default_value = "2", value_parser = one_of(&FmiVersion::WORDS))]
    fmi: FmiVersion,
    /// Platforms on which the FMU runs, such as linux64,win64 [default: all for which there is a runtime]
    #[arg(long, value_name = "PLATFORMS", value_delimiter = ',')]
    platform: Vec<String>,
    /// Write a smaller file: the page in its documentation plays a stored run and does not include the runtime for browsers (400 kB)
    #[arg(long)]
    lean: bool,
    /// Folder with the runtimes of other platforms, made by tools/build-runtimes.sh [default: `runtimes` beside the program]
    #[arg(long, value_name = "FOLDER", env = "COTREE_RUNTIMES")]
    runtimes: Option<PathBuf>,
}

impl ExportCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let runtimes = self.runtimes().map_err(ExportError::from)?;
        let scene = output::load(&self.scene)?;
        let made = Made::of(&scene, self.all)?;
        let compiled = &made.compiled;
        output::warn(compiled.warnings.as_ref(), format);
        if let Some(inaccuracy) = made.accuracy.as_ref().ok().and_then(|accuracy| accuracy.inaccuracy.as_ref()) {
            output::warn_inaccurate(compiled, "", inaccuracy, format);
        }
        let module = if self.lean { None } else { runtime::for_browsers(&self.folder()).map_err(ExportError::from)? };
        let extras = made.extras(self.fmi, module)?;
        let named = || output::after(&self.scene, &compiled.description.identifier, "fmu", format);
        let path = self.output.clone().unwrap_or_else(named);
        output::apart(&[Some(&self.scene)], &[Some(&path)])?;
        compiled.write_fmu(self.fmi, extras, &runtimes, &path)?;
        output::print(&format!("{}\n", path.display()))
    }

    fn folder(&self) -> PathBuf {
        self.runtimes.clone().unwrap_or_else(runtime::default_folder)
    }

    /// The runtimes for the platforms asked for.
    fn runtimes(&self) -> Result<Vec<Runtime>, RuntimeError> {
        let folder = self.folder();
        let platforms = match &self.platform[..] {
            names if names.is_empty() || names == ["all"] => available(&folder),
            names => names.iter().map(|name| Platform::named(name)).collect::<Result<_, _>>()?,
        };
        if platforms.is_empty() {
            return Err(RuntimeError::Host);
        }
        platforms.into_iter().map(|platform| Runtime::find(platform, &folder)).collect()
    }
}

/// The platforms that there is a runtime for.
pub(super) fn available(folder: &Path) -> Vec<Platform> {
    let is_there = |platform: &Platform| Platform::host() == Some(*platform) || platform.file(folder).exists();
    PLATFORMS.iter().copied().filter(is_there).collect()
}
