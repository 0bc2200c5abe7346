//! `cotree simulate`

mod progress;
mod request;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use cotree_fmu::instance::InstanceError;
use cotree_fmu::model::Model;

use super::MessageFormat;
use super::failure::Failure;
use super::output::{self, Output};
use super::times::Times;
use crate::export::description::Description;
use crate::output::csv::Writer;
use crate::output::plot::{Plot, Series};
use crate::simulate::{self, RunError};
use progress::Progress;

/// Simulate a scene: its outputs over time, as a table and as a plot
///
/// Runs exactly the code that the FMU runs. The table is CSV: `time` [s] first, then the outputs of the scene in SI
/// units. If the solver cannot go on, table and plot hold what comes before, and the exit code is 3.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree simulate slider_crank.toml -o result.csv --plot result.svg\n  \
                  cotree simulate slider_crank.toml --set rod_length=\"1.2 m\" --stop \"2 s\" --step \"1 ms\"\n  \
                  cotree simulate slider_crank.toml --input gas.csv | head\n\n\
                  An input table begins with a line such as `time,gas_force`; values between its rows are interpolated.")]
pub struct Simulate {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Where the table goes; `-` is standard output [default: -]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw the outputs over time, as an SVG file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Inputs over time: a CSV file with the columns `time` and inputs of the scene
    #[arg(long, value_name = "FILE")]
    input: Option<PathBuf>,
    /// Set a parameter or a constant input, such as rod_length="1.2 m"; may be given several times
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    #[command(flatten)]
    times: Times,
}

impl Simulate {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let written = [self.file(), self.plot.as_deref()];
        output::apart(&[Some(&self.scene), self.input.as_deref()], &written)?;
        let compiled = output::compile(&self.scene, format)?;
        let table = self.input.as_deref().map(request::table).transpose()?;
        let run = request::run(&self, &compiled.description, table.as_ref())?;
        let model = Model::new(compiled.program.clone()).map_err(|error| Failure::Numerical(error.to_string()))?;
        let columns = run.reported.iter().map(|&index| compiled.description.variables[index].name.as_str());
        let mut writer = Writer::new(Output::new(self.file())?, columns)?;
        let mut plot = self.plot.is_some().then(|| empty_plot(&compiled.description, &run.reported));
        let mut progress = Progress::new(simulate::count(run.experiment));
        let mut rows = 0;
        let ended = run.start(Arc::new(model), |time, values| {
            progress.step(time);
            if let Some(plot) = &mut plot {
                extend(plot, time, values);
            }
            rows += 1;
            writer.row(time, values)
        });
        progress.end();
        let failure = match ended {
            // What was worked out before the solver gave up is worth having.
            Err(RunError::Instance(error)) if rows > 0 => Some(self.cut_short(error, rows)),
            ended => {
                ended?;
                None
            }
        };
        if let (Some(plot), Some(path)) = (plot, &self.plot) {
            output::write(path, &plot.svg())?;
        }
        let named = |error| match self.file() {
            Some(path) => Failure::file("write", path, error),
            None => Failure::from(error),
        };
        writer.finish().map_err(named)?.commit().map_err(named)?;
        failure.map_or(Ok(()), Err)
    }

    fn file(&self) -> Option<&Path> {
        output::file(self.output.as_deref())
    }

    /// The failure of a run that has some of its rows.
    fn cut_short(&self, error: InstanceError, rows: u64) -> Failure {
        let place = self.file().map_or("the table".to_owned(), |path| format!("`{}`", path.display()));
        let note = format!("{place} has the {rows} row{} before that", if rows == 1 { "" } else { "s" });
        Failure::from(RunError::Instance(error)).with_note(&note)
    }
}

fn empty_plot(description: &Description, reported: &[usize]) -> Plot {
    let variables = reported.iter().map(|&index| &description.variables[index]);
    let series = variables.map(|variable| Series {
        name: variable.name.clone(),
        unit: variable.unit.si.clone(),
        values: Vec::new(),
    });
    Plot { title: description.model_name.clone(), time: Vec::new(), series: series.collect() }
}

fn extend(plot: &mut Plot, time: f64, values: &[f64]) {
    plot.time.push(time);
    for (series, &value) in plot.series.iter_mut().zip(values) {
        series.values.push(value);
    }
}
