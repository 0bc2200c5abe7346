//! `cotree man`

use std::path::{Path, PathBuf};

use clap::{Args, Command};
use clap_mangen::Man;
use cotree::files;

use super::failure::Failure;
use super::output;

/// Write the manual pages of cotree and of each of its commands into a folder
#[derive(Args)]
#[command(after_help = "Example:\n  cotree man ~/.local/share/man/man1 && man cotree-simulate")]
pub struct Manual {
    /// The folder; it is made if it is not there
    folder: PathBuf,
}

impl Manual {
    pub fn run(self, mut command: Command) -> Result<(), Failure> {
        // Gives the commands their full names, such as `cotree-show`.
        command.build();
        std::fs::create_dir_all(&self.folder).map_err(|error| Failure::file("make", &self.folder, error))?;
        let mut written = page(&self.folder, command.clone())?;
        for own in command.get_subcommands().filter(|own| own.get_name() != "help") {
            written += &page(&self.folder, own.clone())?;
        }
        output::print(&written)
    }
}

/// Writes one page; its file.
fn page(folder: &Path, command: Command) -> Result<String, Failure> {
    let path = folder.join(format!("{}.1", command.get_display_name().unwrap_or(command.get_name())));
    let failed = |error| Failure::file("write", &path, error);
    let mut text = Vec::new();
    Man::new(command).render(&mut text).map_err(failed)?;
    files::write(&path, &text).map_err(failed)?;
    Ok(format!("{}\n", path.display()))
}
