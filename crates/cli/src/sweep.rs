//! `cotree sweep`

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use cotree::compile::Compiled;
use cotree::export::description::Description;
use cotree::files;
use cotree::run::Measure;
use cotree::scene::Scene;
use cotree_draw::study::sweep::SweepPicture;
use cotree_study::sweep::{
    self, Design, DesignError, DesignFactor, Inaccurate, RecordError, Sampling, SweepPart, SweepRecord,
};
use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use super::failure::Failure;
use super::times::TimeArguments;
use super::units::InUnits;
use super::{MessageFormat, output, stop};

/// The largest table of runs [bytes].
const LARGEST_TABLE: u64 = 1 << 30;

/// Run a scene with many values, and write a table with measures of each run
///
/// Runs use all processors; each has the bits of a single simulation. The table is CSV: the number of the run, the values that were set, the
/// measures, and the error of a failed run. With -o it is kept in FILE.part until the sweep is finished: after Ctrl-C, --resume continues.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
                  cotree sweep slider_crank.toml --set crank_length=0.4..0.6:21 --set rod_length=1.4,1.5 --output \"max(cylinder.fn)\" --plot out.png\n  \
                  cotree sweep slider_crank.toml --random 10000 --set \"rod_length=1.5 m~1 mm\" --output \"max(cylinder.s)\" -o out.csv\n  \
                  cotree sweep slider_crank.toml --table runs.csv --output \"peak(crank.omega)\" -o out.csv --resume\n  \
                  cotree sweep slider_crank.toml --random 1000000 --set \"rod_length=1.5 m~1 mm\" --part 7/100 -o out_7.csv\n\n\
                  Values: 1,1.2 (these); 0.4..0.6:21 (so many, both ends among them); with --random or --latin also 0.4..0.6 (any\n\
                  between), 0.5+-0.01 or 0.5+-2% (any within), 0.5~0.01 (normal, by its standard deviation). Numbers may have units.\n\
                  Measures: max, min, peak (of the magnitude), range, mean, rms, first, last, when_max, when_min of a variable, of its\n\
                  values at communication points; a variable alone is its last value.")]
pub struct SweepCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Quantity to vary, with its values: a parameter, a constant input or an initial value; several give all combinations
    #[arg(long = "set", value_name = "NAME=VALUES")]
    factors: Vec<String>,
    /// A measure of each run, such as "max(cylinder.fn)"; may be given several times [default: the last values of the scene's outputs]
    #[arg(long = "output", value_name = "MEASURE")]
    measures: Vec<String>,
    /// The runs as a CSV table: a line of names, then one line per run
    #[arg(long, value_name = "FILE", conflicts_with_all = ["random", "latin"])]
    table: Option<PathBuf>,
    /// Number of runs with random values
    #[arg(long, value_name = "RUNS", conflicts_with = "latin")]
    random: Option<usize>,
    /// Number of runs with random values spread evenly over each range (Latin hypercube)
    #[arg(long, value_name = "RUNS")]
    latin: Option<usize>,
    /// Seed of the random numbers: the same seed gives the same runs
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Output file of the table; `-` is standard output [default: -]
    #[arg(short = 'o', long = "csv", value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    units: InUnits,
    /// Plot the measures: curves over one quantity, a map over two, histograms of random runs; an SVG or a PNG file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Continue a sweep that was stopped
    #[arg(long, requires = "output")]
    resume: bool,
    /// Run only this part, such as 7/100, for one job of an array; `cotree join` joins the tables of all parts
    #[arg(long, value_name = "NUMBER/COUNT", requires = "output", conflicts_with = "plot")]
    part: Option<SweepPart>,
    /// Number of runs in parallel [default: one per processor]
    #[arg(long, value_name = "COUNT", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    #[command(flatten)]
    times: TimeArguments,
}

impl SweepCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        output::apart(&[Some(&self.scene), self.table.as_deref()], &[self.file(), self.plot.as_deref()])?;
        output::is_written_as(self.plot.as_deref(), &["svg", "png"])?;
        output::is_table(
            self.file(),
            "; from Python, `model.sweep(..., to=\"runs.parquet\")` writes Parquet and Arrow",
        )?;
        let scene = output::load(&self.scene)?;
        let (compiled, measures) = self.compiled(&scene, format)?;
        let design = self.design(&compiled.description)?;
        let experiment = self.times.experiment(compiled.description.experiment)?;
        let units = self.units.of(&scene)?.units;
        let sweep =
            sweep::Sweep { part: self.part.unwrap_or(SweepPart::WHOLE), compiled, experiment, measures, design, units };
        let drawn = |_| SweepPicture::new(&sweep).map_err(|message| Failure::Usage(format!("--plot: {message}")));
        let mut picture = self.plot.as_ref().map(drawn).transpose()?;
        let stop = stop::listen()?;
        match self.file() {
            Some(path) => self.record(path, &sweep, &stop, picture.as_mut(), format),
            None => self.print(&sweep, &stop, picture.as_mut(), format),
        }?;
        let (Some(path), Some(picture)) = (&self.plot, picture) else { return Ok(()) };
        output::picture(path, &picture.svg(&sweep), &format!("the picture of {} runs", sweep.design.len()), format)
    }

    fn file(&self) -> Option<&Path> {
        output::file(self.output.as_deref())
    }

    /// The scene with what is measured: what was asked for, else the last value of each output.
    fn compiled(&self, scene: &Scene, format: MessageFormat) -> Result<(Compiled, Vec<Measure>), Failure> {
        let read = |text: &String| text.parse::<Measure>().map_err(|message| format!("--output {text}: {message}"));
        match Failure::every(self.measures.iter().map(read)) {
            Ok(requested) if !requested.is_empty() => {
                let compiled = sweep::measured(scene, &requested)?;
                output::warn(compiled.warnings.as_ref(), format);
                Ok((compiled, requested))
            }
            Ok(_) => {
                let compiled = output::compile(scene, format)?;
                let Compiled { description, .. } = &compiled;
                let name = |index: usize| &description.variables[index].name;
                let measures = description.reported().into_iter().map(|index| Measure::last(name(index))).collect();
                Ok((compiled, measures))
            }
            // What is wrong with the values is said, too.
            Err(Failure::Usage(wrong)) => match self.design(&output::compile(scene, format)?.description) {
                Err(Failure::Usage(more)) => Err(Failure::usage(&[wrong, more])),
                _ => Err(Failure::Usage(wrong)),
            },
            Err(other) => Err(other),
        }
    }

    /// That rounding errors are larger than the tolerance in some runs.
    fn warn(&self, sweep: &sweep::Sweep, inaccurate: Option<&Inaccurate>, format: MessageFormat) {
        if let Some(Inaccurate { runs, first }) = inaccurate {
            let count = format!("{runs} of {} runs: ", sweep.runs().len());
            output::warn_inaccurate(&sweep.compiled, &count, first, format);
        }
    }

    fn design(&self, description: &Description) -> Result<Design, Failure> {
        let read =
            |text: &String| DesignFactor::read(description, text).map_err(|message| format!("--set {text}: {message}"));
        let factors = Failure::every(self.factors.iter().map(read))?;
        let design = match (&self.table, self.random, self.latin) {
            (Some(path), ..) => {
                let bytes = files::read(path, LARGEST_TABLE).map_err(|error| Failure::file("read", path, error))?;
                let text = String::from_utf8(bytes).map_err(|_| Failure::file("read", path, "it is not a text"))?;
                let placed = |error: DesignError| format!("{}: {error}", path.display());
                return Design::table(description, &text, factors)
                    .map_err(|wrong| Failure::usage(&wrong.into_iter().map(placed).collect::<Vec<_>>()));
            }
            (_, Some(count), _) => Design::random(factors, Sampling::Random, count, self.seed),
            (_, _, Some(count)) => Design::random(factors, Sampling::Latin, count, self.seed),
            _ => Design::grid(factors),
        };
        design.map_err(|error| Failure::Usage(error.to_string()))
    }

    fn record(
        &self,
        path: &Path,
        sweep: &sweep::Sweep,
        stop: &AtomicBool,
        mut picture: Option<&mut SweepPicture>,
        format: MessageFormat,
    ) -> Result<(), Failure> {
        let mut record = SweepRecord::open(path, sweep, self.resume)?;
        if let Some(picture) = &mut picture {
            picture.add(&record.outcomes(sweep)?);
        }
        let Range { start, end } = sweep.runs();
        let bar = bar(end - start, record.done() - start);
        let mut failed = 0;
        let ended = sweep.run(record.done(), self.threads, stop, |first, outcomes| {
            failed += outcomes.iter().filter(|outcome| outcome.is_err()).count();
            picture.iter_mut().for_each(|picture| picture.add(&outcomes));
            bar.set_position((first + outcomes.len() - start) as u64);
            record.write(sweep, first, &outcomes)
        });
        bar.finish_and_clear();
        let all = end - start;
        self.warn(sweep, ended?.as_ref(), format);
        if stop.load(Ordering::Relaxed) && record.done() < end {
            let (done, part) = (record.done() - start, record.part().display());
            return Err(Failure::Stopped(format!("stopped: {done} of {all} runs are in `{part}`; --resume goes on")));
        }
        record.finish()?;
        output::print(&format!("{}: {all} runs{}\n", path.display(), said(failed)))
    }

    fn print(
        &self,
        sweep: &sweep::Sweep,
        stop: &AtomicBool,
        mut picture: Option<&mut SweepPicture>,
        format: MessageFormat,
    ) -> Result<(), Failure> {
        let mut out = std::io::stdout().lock();
        sweep::begin(&mut out, sweep)?;
        let mut done = 0;
        let inaccurate = sweep.run(0, self.threads, stop, |first, outcomes| {
            done = first + outcomes.len();
            picture.iter_mut().for_each(|picture| picture.add(&outcomes));
            sweep::write(&mut out, sweep, first, &outcomes)
        })?;
        let all = sweep.design.len();
        self.warn(sweep, inaccurate.as_ref(), format);
        match stop.load(Ordering::Relaxed) && done < all {
            true => Err(Failure::Stopped(format!("stopped after {done} of {all} runs"))),
            false => Ok(()),
        }
    }
}

/// A bar on standard error, if that is a terminal.
fn bar(all: usize, done: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} runs, {rate}/s, {eta} left");
    let rate = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
        let _ = write!(out, "{:.0}", state.per_sec()); // a bar cannot say that it cannot be drawn
    };
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar()).with_key("rate", rate);
    let bar = ProgressBar::new(all as u64).with_style(style);
    bar.set_position(done as u64);
    bar.reset_eta();
    bar
}

/// How many of this session's runs failed.
fn said(failed: usize) -> String {
    if failed == 0 { String::new() } else { format!(", {failed} of them failed: see the column `failure`") }
}

cotree::diagnostic::from_messages!(Failure as Failure::Usage: RecordError);
