//! `cotree synthesize`

use std::path::{Path, PathBuf};

use clap::Args;
use cotree::task::Task;
use cotree_study::synthesis::{self, Answer};

use super::failure::Failure;
use super::units::InUnits;
use super::{MessageFormat, output};

/// Find linkages for a task: a body through poses, a function, a path, a stroke
///
/// All four-bars, slider-cranks and slotted linkages that meet the task are found, judged and ranked. What is printed as good has been driven by the
/// program itself: on one circuit, without a dead point, in order, every pose met. Bare numbers of a task are in metres and radians.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree synthesize boot_lid.toml -o lids\n  cotree synthesize curve.toml --json\n  \
                  cotree synthesize press.toml --all\n\n\
                  A task is a file with one of [poses], [function], [path] and [stroke], and with [limits]:\n  \
                  [poses]\n  at = [[\"0 mm\", \"0 mm\", \"0 deg\"], [\"35 mm\", \"20 mm\", \"14 deg\"], [\"80 mm\", \"60 mm\", \"38 deg\"]]\n  \
                  [limits]\n  transmission = \"35 deg\""
)]
pub struct SynthesizeCommand {
    /// Task file (TOML or JSON)
    task: PathBuf,
    /// Folder for the scenes `1.toml`, `2.toml`, ... and the picture `solutions.svg`
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Show those too that are not good, with the reason
    #[arg(long)]
    all: bool,
    #[command(flatten)]
    units: InUnits,
    /// Everything as JSON, in SI units
    #[arg(long)]
    json: bool,
}

impl SynthesizeCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        if !self.task.is_file() {
            return Err(Failure::file("read", &self.task, "there is no such file"));
        }
        let task = Task::read(&self.task)?;
        output::warn(task.warnings.as_ref(), format);
        let answer = synthesis::synthesize(&task, self.all)?;
        if let Some(folder) = &self.output {
            write(&answer, folder, format)?;
        }
        let report = answer.report();
        if self.json {
            return output::print(&report.json());
        }
        let units = self.units.before(&synthesis::report::usual())?;
        output::print(&report.text(&units))
    }
}

/// The scenes and the picture.
fn write(answer: &Answer, folder: &Path, format: MessageFormat) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| Failure::file("write", folder, error))?;
    for (index, own) in answer.solutions.iter().enumerate() {
        if let (Some(scene), None) = (&own.scene, &own.reason) {
            let path = folder.join(format!("{}.toml", index + 1));
            output::write(&path, scene)?;
            output::wrote(&path, own.class, format);
        }
    }
    if answer.solutions.is_empty() {
        return Ok(());
    }
    let picture = cotree_draw::study::synthesis::picture(answer);
    output::picture(&folder.join("solutions.svg"), &picture, "the linkages with the task in them", format)
}
