//! What `equilibrium`, `linearize` and `modes` share: the scene with its settings, and where results go.

use std::path::{Path, PathBuf};

use clap::Args;
use cotree::compile::{self, Compiled, compile_asking};
use cotree::report::data::Report;
use cotree::scene::{Faults, Requested, Scene};
use cotree::typeset::short;
use cotree_study::analysis::{AnalysisFailure, Study, StudyError};

use super::argument::{AssignmentError, ModeForm};
use super::failure::Failure;
use super::times::seconds;
use super::units::InUnits;
use super::{MessageFormat, output};

/// The scene, its settings, and the form of the result.
#[derive(Args)]
pub struct Arguments {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Set a parameter or an input, such as rod_length="1.2 m"; may be given several times
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Mode of a hard stop, contact or rope (open, closed), freewheel (free, caught) or dry friction (sticks, slides+, slides-, idle), such as guide.max=closed,pad.friction=sticks [default: the mode in which it is]
    #[arg(long = "mode", value_name = "NAME=WORD", value_delimiter = ',')]
    modes: Vec<String>,
    #[command(flatten)]
    units: InUnits,
    /// The result as JSON, for scripts, in SI units
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// The result as CSV, one value per line
    #[arg(long)]
    csv: bool,
    /// Output file of the result; `-` is standard output [default: -]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Arguments {
    /// Reads the scene, applies the settings.
    pub fn open(&self) -> Result<Study, Failure> {
        output::apart(&[Some(&self.scene)], &[output::file(self.output.as_deref())])?;
        let mut study = with_settings(&output::load(&self.scene)?, &self.settings)?;
        let modes = Failure::every(self.modes.iter().map(|text| mode(text)))?;
        study.set_modes(&modes).map_err(|message| Failure::Usage(format!("--mode: {message}")))?;
        Ok(study)
    }

    /// The output file, if its name asks for a script of MATLAB.
    pub fn script(&self) -> Option<&Path> {
        self.output.as_deref().filter(|path| output::has_extension(path, "m"))
    }

    /// Writes a result and the warnings of the study.
    pub fn write(
        &self,
        mut study: Study,
        format: MessageFormat,
        result: Result<Report, StudyError>,
    ) -> Result<(), Failure> {
        output::warn(study.take_warnings().as_ref(), format);
        let (result, units) = (result?, self.units.before(study.display())?);
        let text = match (self.json, self.csv) {
            (true, _) => result.json(),
            (_, true) => result.csv(&units),
            _ => result.text(&units),
        };
        output::put(output::file(self.output.as_deref()), &text)
    }
}

/// A time given on the command line, not before the start.
pub fn time(option: &str, text: &str, start: f64) -> Result<f64, Failure> {
    let time = seconds(option, text)?;
    match time.is_finite() && time >= start {
        true => Ok(time),
        false => {
            let [time, start] = [time, start].map(short);
            Err(Failure::Usage(format!("--{option}: {time} s is before the start, {start} s")))
        }
    }
}

/// A study of a scene with `name=value` of parameters and inputs.
pub fn with_settings(scene: &Scene, settings: &[String]) -> Result<Study, Failure> {
    asking(scene, &Requested::Own, settings)
}

/// As [`with_settings`], with the outputs that are asked for.
pub fn asking(scene: &Scene, requested: &Requested, settings: &[String]) -> Result<Study, Failure> {
    let mut study = Study::asking(scene, requested)?;
    let set = |setting: &String| set(&mut study, setting).map_err(|message| format!("--set {setting}: {message}"));
    Failure::every(settings.iter().map(set))?;
    Ok(study)
}

/// The program for these settings: they are its defaults where they change which loop equations are imposed. What is wrong with a setting is said where the run is given it.
pub fn compiled(scene: &Scene, requested: &Requested, settings: &[String]) -> Result<Compiled, Faults> {
    let set = (!settings.is_empty()).then(|| asking(scene, requested, settings).ok()).flatten();
    match set.filter(|study| study.restricts_otherwise(scene)) {
        Some(study) => study.compiled(),
        None => compile_asking(scene, requested).map(|(compiled, _)| compiled),
    }
}

/// `name=word`
fn mode(text: &str) -> Result<(String, String), ModeForm> {
    let (name, word) = text.split_once('=').ok_or_else(|| ModeForm(text.to_owned()))?;
    Ok((name.trim().to_owned(), word.trim().to_owned()))
}

/// `name=value` for a parameter or an input.
fn set(study: &mut Study, setting: &str) -> Result<(), AssignmentError> {
    let (name, text) = setting.split_once('=').ok_or_else(|| AssignmentError("write name=value".to_owned()))?;
    Ok(study.set(name.trim(), |unit| compile::quantity(text.trim(), unit))?)
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Scene(faults) => Failure::Scene(faults),
            StudyError::Analysis(AnalysisFailure::Unknown(wrong)) => Failure::usage(&wrong),
            StudyError::Analysis(error @ AnalysisFailure::Followed { .. }) => Failure::Usage(error.to_string()),
            StudyError::Analysis(error) => Failure::Numerical(error.to_string()),
        }
    }
}
