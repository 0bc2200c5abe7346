//! `cotree synthesize`

use std::path::{Path, PathBuf};

use clap::Args;
use cotree::task::Task;
use cotree_study::synthesis::{self, Answer};

use super::failure::Failure;
use super::units::InUnits;
use super::{MessageFormat, output};

/// Find linkages for a task: poses of a body, a function, a path or a stroke
///
/// All four-bars, slider-cranks and slotted linkages that meet the task are found, checked and ranked. Good linkages have been simulated:
/// they have no circuit, branch or order defect. Bare numbers of a task are in metres and radians.
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
    /// Also list the rejected linkages, with the reason
    #[arg(long)]
    all: bool,
    /// Report the effect of manufacturing deviations: `length=0.1mm` of bars and of the coupler point, `pivot=0.2mm` of each coordinate of pivots
    #[arg(long, value_name = "WHAT=LENGTH", value_parser = deviation)]
    tolerance: Vec<(Deviation, f64)>,
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
        let deviations = (!self.tolerance.is_empty()).then(|| {
            let of = |what: Deviation| {
                self.tolerance.iter().filter(|(deviation, _)| *deviation == what).map(|(_, length)| length).sum()
            };
            answer.tolerance_report([of(Deviation::Length), of(Deviation::Pivot)])
        });
        if self.json {
            let mut data = report.data.clone();
            if let Some(deviations) = deviations {
                data["tolerances"] = deviations.data;
            }
            return output::print(&format!("{data:#}\n"));
        }
        let units = self.units.before(&synthesis::report::usual())?;
        output::print(&report.text(&units))?;
        match deviations {
            Some(tolerances) => output::print(&format!("\n{}", tolerances.text(&units))),
            None => Ok(()),
        }
    }
}

/// What deviates.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Deviation {
    Length,
    Pivot,
}

fn deviation(text: &str) -> Result<(Deviation, f64), String> {
    let (name, value) = text.split_once('=').ok_or("write `length=0.1mm` or `pivot=0.1mm`")?;
    let what = match name.trim() {
        "length" => Deviation::Length,
        "pivot" => Deviation::Pivot,
        other => return Err(format!("`{other}` is neither `length` nor `pivot`")),
    };
    let length =
        cotree::compile::quantity(value.trim(), &cotree::model::Unit::length()).map_err(|fault| fault.to_string())?;
    if length > 0.0 && length.is_finite() { Ok((what, length)) } else { Err("a deviation must be positive".to_owned()) }
}

/// The scenes and the picture.
fn write(answer: &Answer, folder: &Path, format: MessageFormat) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| Failure::file("write", folder, error))?;
    for (prefix, list) in [("", &answer.solutions), ("shorter_", &answer.shorter)] {
        for (index, solution) in list.iter().enumerate() {
            if let (Some(scene), None) = (&solution.scene, &solution.reason) {
                let path = folder.join(format!("{prefix}{}.toml", index + 1));
                output::write(&path, scene)?;
                output::wrote(&path, solution.class, format);
            }
        }
    }
    for (index, six_bar) in answer.six_bars.iter().enumerate() {
        let path = folder.join(format!("six_{}.toml", index + 1));
        output::write(&path, &six_bar.scene)?;
        output::wrote(&path, six_bar.kind.name(), format);
    }
    if answer.solutions.is_empty() {
        return Ok(());
    }
    let picture = cotree_draw::study::synthesis::picture(answer);
    output::picture(&folder.join("solutions.svg"), &picture, "the linkages with the task in them", format)
}
