//! `cotree fit`

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::Args;
use cotree::diagnostic::lines;
use cotree::model::Units;
use cotree::report::csv::{CsvTable, Naming};
use cotree::scene::{Requested, Scene};
use cotree::typeset::counted;
use cotree_study::analysis::Study;
use cotree_study::fit::{self, Fit as Found, FitEnded, FitError, FitRequest, FitTrial, Vary};
use indicatif::ProgressBar;

use super::columns::Columns;
use super::failure::Failure;
use super::times::TimeArguments;
use super::units::InUnits;
use super::{MessageFormat, output, stop, study};

/// Fit parameters to a measured motion by least squares, with standard errors and correlations
///
/// Parameters, constant inputs and initial values are changed until the outputs are as close as possible to the measured values, by the Levenberg-Marquardt
/// method with exact derivatives of the motion. Columns are weighted by their standard deviations, which are estimated from the residuals
/// unless --sigma gives them. Numbers without a unit are SI. On a terminal each motion shows its values and residuals; Ctrl-C ends the search
/// with the best values so far. Rows in which a variable has no value or no derivative at the first values are left out, and counted.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
                  cotree fit suspension.toml --to measured.csv --vary stiffness,damping --plot fit.png\n  \
                  cotree fit suspension.toml --to measured.csv --vary \"stiffness=1..50 kN/m\" --sigma \"wheel.s=0.2 mm\" -o fitted.toml\n  \
                  cotree fit suspension.toml --to light.csv --to heavy.csv --set 2:load=200 --vary stiffness,damping\n\n\
                  The table begins with a line such as `time,wheel.s` or `time [ms]; wheel.s [mm]`: names of variables of the scene,\n\
                  in any order. An empty cell was not measured.")]
pub struct FitCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Measured values: a CSV file with the columns `time` and variables of the scene; may be given several times, for experiments that are fitted together
    #[arg(long = "to", value_name = "FILE", required = true)]
    measured: Vec<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// Quantities to fit: parameters, constant inputs or initial values, with optional bounds, such as stiffness,damping=0..10
    #[arg(long, value_name = "NAMES", value_delimiter = ',', required = true)]
    vary: Vec<String>,
    /// Standard deviation of a column, such as "wheel.s=0.2 mm"; may be given several times [default: estimated from the residuals]
    #[arg(long = "sigma", value_name = "NAME=VALUE")]
    deviations: Vec<String>,
    /// Inputs over time during the measurement: a CSV file with the columns `time` and inputs of the scene; with several experiments one for each, in their order
    #[arg(long, value_name = "FILE")]
    input: Vec<PathBuf>,
    /// Set a parameter or an input, also the start value of the search; may be given several times; 2:NAME=VALUE sets it in the second experiment only
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Draw measured and fitted values, and the residuals: an SVG or a PNG file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    units: InUnits,
    /// The result as JSON, for scripts, in SI units
    #[arg(long)]
    json: bool,
    /// Write the scene with the fitted values; the rest of it is unchanged
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// End of the simulation, such as 10 or "10 s" [default: the scene's]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    stop: Option<String>,
    /// Relative tolerance of the solver [default: the scene's]
    #[arg(long, value_name = "NUMBER")]
    tolerance: Option<f64>,
}

impl FitCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let read = [&self.scene].into_iter().chain(&self.measured).chain(&self.input);
        let read: Vec<Option<&Path>> = read.map(|path| Some(path.as_path())).collect();
        output::apart(&read, &[self.plot.as_deref(), self.output.as_deref()])?;
        output::is_written_as(self.plot.as_deref(), &["svg", "png"])?;
        let scene = output::load(&self.scene)?;
        let request = self.request(&scene, format)?;
        let units = self.units.of(&scene)?.units;
        let mut studies = self.studies(&scene, &request, format)?;
        let (stop, mut progress) = (stop::listen()?, FitProgress::new(&request));
        let found = fit::fit_watched(&mut studies, &request, &mut |trial| {
            progress.show(trial);
            !stop.load(Ordering::Relaxed)
        });
        progress.end();
        // All are studies of one scene.
        output::warn(studies.first_mut().and_then(Study::take_warnings).as_ref(), format);
        let named: Vec<String> = self.measured.iter().map(|path| path.display().to_string()).collect();
        let found = found.map_err(|error| failure(error, &named.join("`, `")))?;
        let report = found.report();
        output::print(&if self.json { report.json() } else { report.text(&units) })?;
        self.write(&scene, &found, &units, format)?;
        match found.ended {
            FitEnded::Stopped => Err(Failure::Stopped("stopped: these are the best values so far".to_owned())),
            FitEnded::Settled | FitEnded::Exhausted => Ok(()),
        }
    }

    fn request(&self, scene: &Scene, format: MessageFormat) -> Result<FitRequest, Failure> {
        let (chosen, units) = (self.columns.chosen()?, scene.variables()?);
        let wrong = |option: &str, text: &str, message: String| Failure::Usage(format!("--{option} {text}: {message}"));
        let vary =
            self.vary.iter().map(|text| Vary::read(text).map_err(|error| wrong("vary", text, error.to_string())));
        let deviation = |text: &String| {
            let pair = text.split_once('=').map(|(name, value)| (name.trim().to_owned(), value.trim().to_owned()));
            pair.ok_or_else(|| wrong("sigma", text, "write name=value".to_owned()))
        };
        let unit_of = |name: &str| units.get(name).cloned();
        let table = |path: &PathBuf| output::table_with_gaps(path, &chosen.naming(&unit_of), format);
        Ok(FitRequest {
            tables: self.measured.iter().map(table).collect::<Result<_, _>>()?,
            vary: vary.collect::<Result<_, _>>()?,
            deviations: self.deviations.iter().map(deviation).collect::<Result<_, _>>()?,
        })
    }

    /// The study of each experiment.
    fn studies(&self, scene: &Scene, request: &FitRequest, format: MessageFormat) -> Result<Vec<Study>, Failure> {
        let count = self.measured.len();
        if !self.input.is_empty() && self.input.len() != count {
            let [inputs, tables] = [self.input.len(), count].map(|count| counted(count, "time"));
            let message = format!("--input is given {inputs}, --to {tables}: each experiment has its own");
            return Err(Failure::Usage(message));
        }
        let settings = self.settings.iter().map(|text| numbered(text, count)).collect::<Result<Vec<_>, _>>()?;
        let times = TimeArguments::of(self.stop.clone(), None, self.tolerance);
        let study = |(index, (path, table)): (usize, (&PathBuf, &CsvTable))| {
            let settings = settings.iter().filter(|(number, _)| number.is_none_or(|number| number == index + 1));
            let settings: Vec<String> = settings.map(|(_, setting)| (*setting).to_owned()).collect();
            let study = study::asking(scene, &Requested::these(table.names()), &settings);
            let mut study = study.map_err(|failure| requested(failure, &path.display().to_string()))?;
            self.input.get(index).map_or(Ok(()), |path| drive(&mut study, path, &settings, format))?;
            study.set_experiment(times.experiment(study.experiment())?);
            Ok(study)
        };
        self.measured.iter().zip(&request.tables).enumerate().map(study).collect()
    }

    /// The picture, and the scene with the values that were found.
    fn write(&self, scene: &Scene, found: &Found, units: &Units, format: MessageFormat) -> Result<(), Failure> {
        if let Some(path) = &self.plot {
            output::picture(
                path,
                &cotree_draw::study::fit::plot(found, units).svg(),
                "measured and fitted values, residuals",
                format,
            )?;
        }
        if let Some(path) = &self.output {
            let values =
                found.quantities.iter().map(|quantity| (quantity.name.clone(), quantity.value, quantity.unit.clone()));
            let guesses = found.guesses.iter().map(|guess| (guess.name.clone(), guess.found, guess.unit.si.clone()));
            let values = values.chain(guesses);
            let text = fit::with_values(scene, &values.collect::<Vec<_>>())
                .map_err(|error| Failure::Usage(error.to_string()))?;
            output::write(path, &text)?;
            output::wrote(path, "the scene with these values", format);
        }
        Ok(())
    }
}

/// A setting, and the number of the experiment that it belongs to; none for all.
fn numbered(text: &str, count: usize) -> Result<(Option<usize>, &str), Failure> {
    let pair = text.split_once(':').and_then(|(number, setting)| Some((number.trim().parse::<usize>().ok()?, setting)));
    match pair {
        None => Ok((None, text)),
        Some((number, setting)) if (1..=count).contains(&number) => Ok((Some(number), setting)),
        Some((number, _)) => Err(Failure::Usage(format!(
            "--set {text}: there is no experiment {number}: --to is given {}",
            counted(count, "time")
        ))),
    }
}

/// Gives a study its inputs over time.
fn drive(study: &mut Study, path: &Path, settings: &[String], format: MessageFormat) -> Result<(), Failure> {
    let table = output::table(path, &Naming { unit_of: &|name| study.input_unit(name).cloned(), chosen: &[] }, format)?;
    let is_set = |name: &&String| {
        settings.iter().any(|setting| setting.split_once('=').is_some_and(|(set, _)| set.trim() == name.as_str()))
    };
    if let Some(name) = table.names().iter().find(is_set) {
        return Err(Failure::Usage(format!("`{name}` is given by --set and by the input table")));
    }
    study.set_inputs(table).map_err(|message| Failure::Usage(format!("input table: {message}")))
}

/// The motions so far, on standard error if that is a terminal.
struct FitProgress {
    bar: ProgressBar,
    names: Vec<String>,
    trials: usize,
}

impl FitProgress {
    fn new(request: &FitRequest) -> Self {
        let names = request.vary.iter().map(|vary| vary.name.clone()).collect();
        Self { bar: output::spinner(), names, trials: 0 }
    }

    fn show(&mut self, trial: FitTrial) {
        self.trials += 1;
        let residuals = trial.length.map_or("no motion".to_owned(), |length| format!("residuals {length:.6}"));
        let verdict = if trial.is_accepted { "" } else { ", rejected" };
        let values = self.names.iter().zip(trial.values).map(|(name, value)| format!("{name} = {value:.6}"));
        let values = values.collect::<Vec<_>>().join(", ");
        self.bar.println(format!("motion {}: {residuals}{verdict}; {values}", self.trials));
        self.bar.tick();
    }

    fn end(&self) {
        self.bar.finish_and_clear();
    }
}

/// Variables that the table names and the scene does not have are no fault of the scene.
fn requested(failure: Failure, table: &str) -> Failure {
    match failure {
        Failure::Scene(faults) => output::unknown(faults, &format!("`{table}`")),
        other => other,
    }
}

fn failure(error: FitError, table: &str) -> Failure {
    match error {
        FitError::Study(error) => requested(error.into(), table),
        FitError::Request(faults) => Failure::Usage(lines(&faults)),
        FitError::Undetermined(why) => Failure::Numerical(why.to_string()),
    }
}
