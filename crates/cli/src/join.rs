//! `cotree join`

use std::path::PathBuf;

use clap::Args;
use cotree_study::sweep;

use super::failure::Failure;
use super::output;

/// Join the tables of `cotree sweep --part`, with the same bytes as one sweep of all runs
///
/// All parts must be finished, and belong to the same sweep.
#[derive(Args)]
#[command(after_help = "Example:\n  cotree join out_*.csv -o out.csv")]
pub struct JoinCommand {
    /// The tables of all parts, in any order
    #[arg(required = true)]
    parts: Vec<PathBuf>,
    /// Output file of the table
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

impl JoinCommand {
    pub fn run(self) -> Result<(), Failure> {
        let parts: Vec<_> = self.parts.iter().map(|part| Some(part.as_path())).collect();
        output::apart(&parts, &[Some(&self.output)])?;
        let runs = sweep::join(&self.parts, &self.output).map_err(|error| Failure::Usage(error.to_string()))?;
        output::print(&format!("{}: {runs} runs\n", self.output.display()))
    }
}
