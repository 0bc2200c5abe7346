//! `cotree info`

use std::path::PathBuf;

use clap::Args;
use cotree::report::inspect::Contents;

use super::failure::Failure;
use super::output;

/// Show the contents of an FMU that cotree made
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree info slider_crank.fmu\n  cotree info slider_crank.fmu --scene > slider_crank.toml"
)]
pub struct InfoCommand {
    /// FMU file
    fmu: PathBuf,
    /// Print the scene from which the FMU was made, and nothing else
    #[arg(long)]
    scene: bool,
}

impl InfoCommand {
    pub fn run(self) -> Result<(), Failure> {
        let contents = Contents::read(&self.fmu).map_err(|error| Failure::file("read", &self.fmu, error))?;
        if !self.scene {
            return output::print(&contents.to_string());
        }
        let scene = contents.scene.ok_or_else(|| {
            Failure::file("print the scene of", &self.fmu, "its scene was built in Rust, not read from a file")
        })?;
        output::print_file(&scene)
    }
}
