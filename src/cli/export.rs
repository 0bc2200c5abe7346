//! `cotree export`

use std::path::PathBuf;

use clap::Args;

use super::failure::Failure;
use super::{MessageFormat, output};
use crate::export::archive;

/// Make an FMU: one file for any tool that reads FMI 2.0 for Co-Simulation
///
/// The FMU has its solver inside and needs neither cotree nor anything else. The same scene gives the same file.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree export slider_crank.toml\n  cotree export slider_crank.toml -o fmus/crank.fmu"
)]
pub struct Export {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Where the FMU goes [default: <name of the scene>.fmu in the current folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Export {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let compiled = output::compile(&self.scene, format)?;
        let path = self.output.unwrap_or_else(|| format!("{}.fmu", compiled.description.identifier).into());
        let program = compiled.program.to_bytes().map_err(|error| Failure::file("write", &path, error))?;
        archive::write(&compiled.package(&program), &path)?;
        output::print(&format!("{}\n", path.display()))
    }
}
