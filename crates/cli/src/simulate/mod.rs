//! `cotree simulate`

mod contacts;
mod happened;
mod progress;
mod record;
mod request;
mod requested;
mod sensitivity;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use clap::Args;
use cotree::compile::Compiled;
use cotree::model::Units;
use cotree::report::csv::CsvTable;
use cotree::run as simulate;
use cotree::run::{Finish, Gaps, Run, RunError};
use cotree::scene::{Requested, Scene};
use cotree::typeset::counted;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use super::columns::Columns;
use super::failure::Failure;
use super::times::TimeArguments;
use super::units::{InUnits, ShownUnits};
use super::{MessageFormat, output, stop, study};
use progress::RunProgress;
use record::RunRecord;

/// Simulate a scene: its outputs over time as a table, a plot or a summary
///
/// Runs exactly the code that the FMU runs. The table is CSV: `time` first, then the outputs of the scene. All is SI; with `--units` or
/// `[display]` in the scene it is in those units, and the header says which. If the solver cannot go on, table and plot hold what comes
/// before, and the exit code is 3; Ctrl-C keeps the rows so far, too.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree simulate slider_crank.toml -o result.csv --plot result.png\n  \
                  cotree simulate slider_crank.toml --set rod_length=\"1.2 m\" --stop \"2 s\" --step \"1 ms\"\n  \
                  cotree simulate slider_crank.toml --summary --units deg,mm,kN\n  \
                  cotree simulate end_stop.toml --summary --log impacts.csv\n  \
                  cotree simulate four_bar.toml --x coupler.tip.x --y coupler.tip.y --plot curve.svg -o curve.csv\n  \
                  cotree simulate slider_crank.toml --sensitivity rod_length --step \"10 ms\"\n  \
                  cotree simulate slider_crank.toml --sensitivity rod_length --summary --crossing cylinder.s=\"1.8 m\"\n  \
                  cotree simulate slider_crank.toml --input gas.csv | head\n\n\
                  An input table begins with a line such as `time,gas_force` or `time [ms]; gas_force [kN]`; values between its rows are \
                  interpolated.")]
pub struct SimulateCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Output file of the table; `-` is standard output [default: -, unless there is a summary or a plot]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw the outputs over time: an SVG or a PNG file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Print minimum and maximum of each variable with their times, mean, RMS and last value, instead of the table
    #[arg(long)]
    summary: bool,
    /// Write a log of all events with their times: events of the scene, impacts with their impulses, opening, closing, sticking and slipping of hard stops, contacts, ropes and friction; a CSV file, `-` is standard output
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Print the summary as JSON, for scripts
    #[arg(long, requires = "summary")]
    json: bool,
    /// Variables to report instead of the scene's outputs, such as crank.angle,pin.fx
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    variables: Vec<String>,
    #[command(flatten)]
    units: InUnits,
    /// Report every n-th row only, such as 10, or one row per time, such as "10 ms"
    #[arg(long, value_name = "NUMBER|TIME", conflicts_with = "step")]
    every: Option<String>,
    /// Wrap angles to -180 to 180 degrees
    #[arg(long)]
    wrap: bool,
    /// Variable on the horizontal axis of the plot instead of the time, such as coupler.tip.x; both axes of lengths have the same scale
    #[arg(long, value_name = "NAME", requires = "y", requires = "plot")]
    x: Option<String>,
    /// Variables to plot, such as coupler.tip.y
    #[arg(long, value_name = "NAMES", value_delimiter = ',', requires = "plot")]
    y: Vec<String>,
    /// Measured values: a CSV file with the columns `time` and variables, drawn as dots, with the RMS error of the simulation; --column maps other column names
    #[arg(long, value_name = "FILE", conflicts_with = "x")]
    overlay: Option<PathBuf>,
    /// Inputs over time: a CSV file with the columns `time` and inputs of the scene; --column maps other column names
    #[arg(long, value_name = "FILE")]
    input: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// Start at the equilibrium that `cotree equilibrium` finds, instead of at `[initial]`
    #[arg(long)]
    from_equilibrium: bool,
    /// Set a parameter or a constant input, such as rod_length="1.2 m"; may be given several times
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Add the derivatives of all variables with respect to a parameter, constant input or initial value, at fixed time; may be given several times
    #[arg(long, value_name = "NAME", conflicts_with_all = ["plot", "log", "units", "every", "wrap", "overlay", "input", "from_equilibrium"])]
    sensitivity: Vec<String>,
    /// With --sensitivity and --summary: also the times at which a variable crosses a value, such as cylinder.s="1.2 m"; may be given several times
    #[arg(long, value_name = "NAME=VALUE", requires = "sensitivity", requires = "summary")]
    crossing: Vec<String>,
    #[command(flatten)]
    times: TimeArguments,
}

/// How a run ends, or why it fails.
type Ended = Result<Finish, Failure>;

/// A run whose table is written.
struct WrittenRun {
    rows: u64,
    /// Why it ends before its time or is not as accurate as it should be.
    ended: Ended,
    /// Which values it lacks.
    gaps: Gaps,
}

impl SimulateCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let read = [Some(self.scene.as_path()), self.input.as_deref(), self.overlay.as_deref()];
        output::apart(&read, &[self.file(), self.plot.as_deref()])?;
        output::is_written_as(self.plot.as_deref(), &["svg", "png"])?;
        output::is_table(self.file(), "; with --summary --json the figures are JSON")?;
        let scene = output::load(&self.scene)?;
        if !self.sensitivity.is_empty() {
            return sensitivity::run(&self, &scene, format);
        }
        let compiled = self.compiled(&scene, &requested::also(&self))?;
        output::warn(compiled.warnings.as_ref(), format);
        let shown = self.units.of(&scene)?;
        let (chosen, units) = (self.columns.chosen()?, compiled.description.units());
        let unit_of = |name: &str| units.get(name).copied().cloned();
        let read = |file: &Option<PathBuf>| {
            file.as_deref().map(|file| output::table(file, &chosen.naming(&unit_of), format)).transpose()
        };
        let [input, overlay] = [&self.input, &self.overlay].map(read);
        let (input, overlay) = (input?, overlay?);
        let reported = requested::reported(&self, &compiled)?;
        let mut record = RunRecord::new(&compiled, &reported, &shown);
        let run = request::run(&self, &compiled.description, input.as_ref(), reported)?;
        let model = Model::new(compiled.program.clone()).map_err(|error| Failure::Numerical(error.to_string()))?;
        let WrittenRun { rows, ended, gaps } = self.table(&run, Arc::new(model), &mut record, &shown)?;
        output::warn_gaps(&scene, &gaps, &record.names(), format);
        if let Ok(finish) = &ended {
            output::tell_end(&compiled, finish, format);
        }
        self.draw(&run, &record, overlay.as_ref(), &shown, format)?;
        self.conclude((&record, ended.as_ref().ok()), rows, format)?;
        if let (Ok(finish), true, false) = (&ended, self.summary, self.json) {
            self.say_happened(finish, &shown)?;
        }
        if self.summary {
            self.say_contacts(&scene, input.as_ref(), &shown, format)?;
        }
        ended.map(drop)
    }

    /// The program, which begins where the options say.
    fn compiled(&self, scene: &Scene, requested: &Requested) -> Result<Compiled, Failure> {
        let compiled = if self.from_equilibrium {
            let mut study = study::asking(scene, requested, &self.settings)?;
            study.begin_at_rest()?;
            study.compiled()
        } else {
            study::compiled(scene, requested, &self.settings)
        };
        compiled.map_err(|faults| output::unknown(faults, "the command line"))
    }

    /// Runs, and writes the table as it comes.
    fn table(
        &self,
        run: &Run,
        model: Arc<Model>,
        record: &mut RunRecord,
        shown: &ShownUnits,
    ) -> Result<WrittenRun, Failure> {
        let is_wanted = self.output.is_some() || !(self.summary || self.plot.is_some());
        let mut writer = is_wanted.then(|| output::begin(self.file(), record.table(shown))).transpose()?;
        let is_kept = self.plot.is_some() || self.summary || self.overlay.is_some();
        let every = request::thinning(self)?;
        let mut progress = RunProgress::new(simulate::count(run.experiment));
        let (mut points, mut rows, mut gaps) = (0, 0, Gaps::default());
        let stop = stop::ending_motions()?;
        let times = simulate::points(run.experiment);
        let ended = run.start_at(&mut Instance::new(model), times, |time, values| {
            if stop.load(Ordering::Relaxed) {
                return Err(std::io::ErrorKind::Interrupted.into());
            }
            progress.step(time);
            points += 1;
            if (points - 1) % every != 0 {
                return Ok(());
            }
            let row = if self.wrap { record.wrapped(time, values) } else { [&[time], values].concat() };
            if is_kept {
                record.push(&row);
            }
            rows += 1;
            gaps.note(time, values);
            writer.as_mut().map_or(Ok(()), |writer| writer.row(&row))
        });
        progress.end();
        self.write_log(match &ended {
            Ok(finish) => &finish.log,
            Err(failed) => &failed.log,
        })?;
        // What was worked out before the solver gave up, or the user stopped it, is worth having.
        let ended = match ended.map_err(RunError::from) {
            Err(_) if stop.load(Ordering::Relaxed) => Err(Failure::Stopped(format!("stopped: {}", self.kept(rows)))),
            Err(RunError::Instance(error)) if rows > 0 => {
                Err(Failure::from(RunError::Instance(error)).with_note(&self.kept(rows)))
            }
            ended => Ok(ended?),
        };
        writer.map_or(Ok(()), |writer| output::finish(writer, self.file()))?;
        Ok(WrittenRun { rows, ended, gaps })
    }

    /// Draws the plot, and says how far it is from what was measured.
    fn draw(
        &self,
        run: &Run,
        record: &RunRecord,
        overlay: Option<&CsvTable>,
        shown: &ShownUnits,
        format: MessageFormat,
    ) -> Result<(), Failure> {
        let file = self.overlay.as_deref().map(|path| path.display().to_string()).unwrap_or_default();
        let measured = overlay.map(|table| record.overlay(table, &file)).transpose()?;
        if let Some(path) = &self.plot {
            let mut plot = record.plot(self, run, shown)?;
            plot.series.extend(measured.iter().flat_map(|(series, _)| series.clone()));
            output::picture(path, &plot.svg(), &format!("{} curves", plot.series.len()), format)?;
        }
        measured.map_or(Ok(()), |(_, report)| match self.summary {
            true => output::print(&report),
            false => {
                super::failure::say(&report);
                Ok(())
            }
        })
    }

    /// Prints the figures; says what was written and what can be done next.
    fn conclude(
        &self,
        (record, finish): (&RunRecord, Option<&Finish>),
        rows: u64,
        format: MessageFormat,
    ) -> Result<(), Failure> {
        if self.summary && self.json {
            let mut figures = serde_json::to_value(record.statistics()).map_err(std::io::Error::from)?;
            if let Some(finish) = finish.filter(|finish| !finish.events.is_empty()) {
                figures["happened"] = happened::data(finish);
            }
            output::json(&figures)?;
        } else if self.summary {
            output::print(&record.statistics().report().text(&Units::default()))?;
        }
        if let Some(path) = self.file() {
            output::wrote(path, &format!("{rows} rows"), format);
        }
        if (self.file().is_some() || self.plot.is_some()) && format == MessageFormat::Human {
            let scene = self.scene.display();
            super::failure::say(&format!(
                "next: `cotree view {scene}` shows the motion, `cotree export {scene}` makes the FMU\n"
            ));
        }
        Ok(())
    }

    fn file(&self) -> Option<&Path> {
        output::file(self.output.as_deref())
    }

    /// Which rows there are of a run that has ended early.
    fn kept(&self, rows: u64) -> String {
        let place = self.file().map_or("the table".to_owned(), |path| format!("`{}`", path.display()));
        format!("{place} has the {} before that", counted(rows as usize, "row"))
    }
}
