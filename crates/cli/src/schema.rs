//! `cotree schema`

use std::path::PathBuf;

use clap::Args;
use cotree::component;

use super::failure::Failure;
use super::output;

/// Print the JSON Schema of scene files, by which editors complete and check them
///
/// It is made from the keys that cotree itself reads. A TOML scene names it in its first line: `#:schema scene.schema.json`.
#[derive(Args)]
#[command(after_help = "Example:\n  cotree schema -o scene.schema.json")]
pub struct Schema {
    /// Where it goes; `-` is standard output [default: -]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Schema {
    pub fn run(self) -> Result<(), Failure> {
        output::put(output::file(self.output.as_deref()), &component::schema())
    }
}
