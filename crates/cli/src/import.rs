//! `cotree import`

use std::path::PathBuf;

use clap::Args;
use cotree::files;
use cotree::import::{Imported, import};
use cotree::model::identifier;

use super::failure::{self, Failure};
use super::{MessageFormat, output};

/// Nobody draws a linkage of more bytes by hand.
const LARGEST: u64 = 16 << 20;

/// Take over a linkage from PMKS+ or pylinkage: a commented scene to go on with
///
/// Read are `.pmks` files of PMKS+, the addresses that it shares (in a text file), and the JSON that pylinkage's
/// `mechanism_to_json` writes.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree import linkage.pmks\n  cotree import fourbar.json -o four_bar.toml")]
pub struct ImportCommand {
    /// File of PMKS+ or pylinkage
    file: PathBuf,
    /// Where the scene goes [default: the name of the file, .toml, in the current folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl ImportCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let stem = self.file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let path = self.output.unwrap_or_else(|| PathBuf::from(format!("{}.toml", identifier(&stem))));
        output::apart(&[Some(&self.file)], &[Some(&path)])?;
        if path.exists() {
            return Err(Failure::Usage(format!("`{}` exists already; choose another name with -o", path.display())));
        }
        let bytes = files::read(&self.file, LARGEST).map_err(|error| Failure::file("read", &self.file, error))?;
        let wrong = |what: &str| Failure::file("import", &self.file, what);
        let text = String::from_utf8(bytes).map_err(|_| wrong("it is not a text"))?;
        let name = path.file_stem().map_or(stem, |stem| stem.to_string_lossy().into_owned());
        let Imported { scene, notes } = import(&name, &text).map_err(|faults| wrong(&faults.join("\n  ")))?;
        output::write(&path, &scene)?;
        if format == MessageFormat::Human {
            notes.iter().for_each(|note| failure::say(&format!("note: {note}\n")));
        }
        output::print(&format!("{0}\nNext: cotree check {0}\n", path.display()))
    }
}
