//! `cotree optimize`

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::{ArgGroup, Args};
use cotree::scene::{Requested, Scene};
use cotree_study::fit::{Vary, with_values};
use cotree_study::motion;
use cotree_study::optimize::{
    self, Aim, Best, Ended, Goal, LimitError, MeasureLimit, OptimizeError, OptimizeRequest, SearchProgress,
};
use indicatif::{ProgressBar, ProgressStyle};

use super::columns::Columns;
use super::failure::Failure;
use super::times::TimeArguments;
use super::units::InUnits;
use super::{MessageFormat, output, stop, study};

/// Searches of an experiment, and of a turn, each of whose motions is computed again beside it for each quantity.
const STARTS: usize = 64;
const TURN_STARTS: usize = 8;

/// Optimize parameters: minimize or maximize measures under constraints, or match a curve
///
/// Parameters, constant inputs and initial values are changed by sequential quadratic programming with exact derivatives of the motion, from many starts: the values of the scene, and points
/// between the bounds. Different optima are listed with the number of searches that reached each, and the cost of each constraint. The same --seed gives the same result. Ctrl-C ends the search with the
/// best values so far.
#[derive(Args)]
#[command(group = ArgGroup::new("aim").required(true).args(["minimize", "maximize", "matched"]))]
#[command(after_help = "Examples:\n  \
                  cotree optimize press.toml --vary \"crank=40..160 mm,rod=0.2..0.8 m\" --minimize \"peak(crank_pivot.torque)\" \\\n      \
                  --subject-to \"range(ram.s) = 120 mm\" -o best.toml\n  \
                  cotree optimize walker.toml --vary \"crank=5..30 mm,rod=20..90 mm\" --match path.csv --starts 200\n\n\
                  Measures: max, min, peak (of the magnitude), range, mean, rms, first, last of a variable; a variable alone is its\n\
                  last value. Sums have weights: \"peak(a.torque) + 0.1*rms(b.fn)\".\n\
                  Limits: \"max(x) <= 3 mm\", \">=\", \"=\".")]
pub struct OptimizeCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Quantities to optimize, with bounds: parameters, constant inputs or initial values, such as "crank=40..160 mm,rod=0.2..0.8 m" [bounds by default: the scene's]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', required = true)]
    vary: Vec<String>,
    /// Objective to minimize: a measure such as "peak(motor.torque)", or a weighted sum of measures
    #[arg(long, value_name = "MEASURE", allow_hyphen_values = true)]
    minimize: Option<String>,
    /// Objective to maximize
    #[arg(long, value_name = "MEASURE", allow_hyphen_values = true)]
    maximize: Option<String>,
    /// Curves to match by least squares: a CSV file with the columns `time` and variables of the scene
    #[arg(id = "matched", long = "match", value_name = "FILE")]
    matched: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// A constraint, such as "range(ram.s) = 120 mm"; may be given several times
    #[arg(long = "subject-to", value_name = "LIMIT", allow_hyphen_values = true)]
    limits: Vec<String>,
    /// Measure the figures of one turn or stroke of this joint, as `motion` does, instead of the experiment: transmission, time_ratio, stroke, drive, |shaking force| and other columns of its table
    #[arg(long, value_name = "JOINT", conflicts_with = "matched")]
    turn: Option<String>,
    /// The output motion of a turn: a joint on the ground, a variable or an output of the scene [default: the first other joint that can move]
    #[arg(long = "of", value_name = "NAME", requires = "turn")]
    of_interest: Option<String>,
    /// Set a parameter or an input, also the start value of the first search; may be given several times
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    #[arg(
        long,
        value_name = "COUNT",
        help = "Number of searches, each from another start; the first starts from the values of the scene [default: 64; of turns, which take longer, 8]"
    )]
    starts: Option<usize>,
    /// Seed of the starts: the same seed gives the same starts
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Number of searches in parallel [default: one per processor]
    #[arg(long, value_name = "COUNT", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    #[command(flatten)]
    units: InUnits,
    /// The result as JSON, for scripts, in SI units
    #[arg(long)]
    json: bool,
    /// Write the end of each search: a CSV file
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
    /// Continue earlier searches: the file of an earlier --table; searches that are not in it begin at their starts
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Plot the objective and the constraints over each quantity, the others at their best values: an SVG or a PNG file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Write the scene with the best values; the rest of it is unchanged
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    times: TimeArguments,
}

impl OptimizeCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        output::apart(
            &[Some(&self.scene), self.matched.as_deref()],
            &[self.table.as_deref(), self.plot.as_deref(), self.output.as_deref()],
        )?;
        output::is_written_as(self.plot.as_deref(), &["svg", "png"])?;
        output::is_table(self.table.as_deref(), "; with --json everything is printed as JSON")?;
        let scene = output::load(&self.scene)?;
        let request = self.request(&scene, format)?;
        let units = self.units.of(&scene)?.units;
        let wanted = Requested::these(request.variables());
        let mut study = study::asking(&scene, &wanted, &self.settings).map_err(requested)?;
        study.set_experiment(self.times.experiment(study.experiment())?);
        let (stop, bar) = (stop::listen()?, bar(request.starts));
        let from = self.resume.as_deref().map_or(Ok(Vec::new()), |path| searched(path, &request))?;
        let found = optimize::resume(&scene, &mut study, &request, &from, &|progress| {
            show(&bar, progress);
            !stop.load(Ordering::Relaxed)
        });
        bar.finish_and_clear();
        output::warn(study.take_warnings().as_ref(), format);
        let found = found?;
        let report = found.report();
        output::print(&if self.json { report.json() } else { report.text(&units) })?;
        if let Some(path) = &self.table {
            output::write(path, report.csv(&units))?;
            output::wrote(path, &format!("{} searches", found.searches.len()), format);
        }
        self.write(&scene, &found, format)?;
        if let (Some(path), false) = (&self.plot, stop.load(Ordering::Relaxed)) {
            let around = optimize::around(&scene, &mut study, &request, &found)?;
            let picture = cotree_draw::study::optimize::plot(&found, &around, &units).svg();
            output::picture(path, &picture, "the goal and the limits around the best values", format)?;
        }
        match stop.load(Ordering::Relaxed) {
            true => Err(Failure::Stopped("stopped: these are the best values so far".to_owned())),
            false => Ok(()),
        }
    }

    fn request(&self, scene: &Scene, format: MessageFormat) -> Result<OptimizeRequest, Failure> {
        let wrong = |option: &str, text: &str, message: &dyn Display| format!("--{option} {text}: {message}");
        let vary = self.vary.iter().map(|text| Vary::read(text).map_err(|error| wrong("vary", text, &error)));
        let limits =
            self.limits.iter().map(|text| text.parse().map_err(|error: LimitError| wrong("subject-to", text, &error)));
        let (vary, limits): (Result<Vec<Vary>, Failure>, Result<Vec<MeasureLimit>, Failure>) =
            (Failure::every(vary), Failure::every(limits));
        let goal = |option: &str, text: &String| {
            text.parse::<Goal>().map_err(|error| Failure::Usage(wrong(option, text, &error)))
        };
        let least = self.minimize.as_ref().map(|text| goal("minimize", text)).transpose()?.map(Aim::Least);
        let most = self.maximize.as_ref().map(|text| goal("maximize", text)).transpose()?.map(Aim::Most);
        let aim = match (least.or(most), &self.matched) {
            (Some(aim), _) => aim,
            (None, Some(path)) => {
                let (chosen, units) = (self.columns.chosen()?, scene.variables()?);
                Aim::Match(output::table(path, &chosen.naming(&|name| units.get(name).cloned()), format)?)
            }
            (None, None) => return Err(Failure::Usage("give --minimize, --maximize or --match".to_owned())),
        };
        let turn = self.turn.as_ref().map(|joint| motion::MotionRequest {
            input: Some(joint.clone()),
            output: self.of_interest.clone(),
            ..motion::MotionRequest::default()
        });
        let starts = self.starts.unwrap_or(if turn.is_some() { TURN_STARTS } else { STARTS });
        Ok(OptimizeRequest { vary: vary?, aim, limits: limits?, turn, starts, seed: self.seed, threads: self.threads })
    }

    /// The scene with the best values.
    fn write(&self, scene: &Scene, found: &Best, format: MessageFormat) -> Result<(), Failure> {
        let Some(path) = &self.output else { return Ok(()) };
        let values =
            found.quantities.iter().map(|quantity| (quantity.name.clone(), quantity.value, quantity.unit.clone()));
        let guesses = found.guesses.iter().map(|guess| (guess.name.clone(), guess.found, guess.unit.si.clone()));
        let text = with_values(scene, &values.chain(guesses).collect::<Vec<_>>())
            .map_err(|error| Failure::Usage(error.to_string()))?;
        output::write(path, &text)?;
        let what = if found.ended == Ended::Settled {
            "the scene with the best values"
        } else {
            "the scene with the best values so far"
        };
        output::wrote(path, what, format);
        Ok(())
    }
}

/// Where searches ended before.
fn searched(path: &Path, request: &OptimizeRequest) -> Result<Vec<(usize, Vec<f64>)>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::file("read", path, error))?;
    optimize::searched(&text, request).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))
}

/// A bar on standard error, if that is a terminal.
fn bar(all: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} searches, {msg}, {elapsed}");
    ProgressBar::new(all as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn show(bar: &ProgressBar, progress: SearchProgress) {
    bar.set_position(progress.done as u64);
    let best = progress.best.map_or("nothing yet".to_owned(), |best| format!("best {best:.6}"));
    bar.set_message(format!("{} motions, {best}", progress.evaluations));
}

/// Variables that were asked for and that the scene does not have are no fault of the scene.
fn requested(failure: Failure) -> Failure {
    match failure {
        Failure::Scene(faults) => output::unknown(faults, "what is measured"),
        other => other,
    }
}

impl From<OptimizeError> for Failure {
    fn from(error: OptimizeError) -> Self {
        match error {
            OptimizeError::Study(error) => requested(error.into()),
            OptimizeError::Request(faults) => Failure::usage(&faults),
            error @ (OptimizeError::Unmet { .. } | OptimizeError::Stopped | OptimizeError::OtherBranch) => {
                Failure::Numerical(error.to_string())
            }
        }
    }
}
