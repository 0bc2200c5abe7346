//! `cotree bench`

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use clap::Args;
use cotree::model::Units;
use cotree_fmu::model::Model;
use cotree_study::bench::{Next, measure_watched};

use super::failure::Failure;
use super::{MessageFormat, output, stop};

/// Measure computing time and error of every method at many tolerances, for this scene
///
/// Errors are those of the outputs at a thousand times or more, from dense output, against a converged run: of the two most accurate methods
/// the one that the model does not use by default. Time is processor time (on Windows wall time), the fastest of several runs
/// on one thread, without initialization. Parameters and inputs have their defaults. On a terminal the present run is shown; Ctrl-C ends with the runs so far.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree bench slider_crank.toml --plot slider_crank.svg\n  \
                  cotree bench slider_crank.toml --json > slider_crank.json\n\n\
                  Methods: auto (the choice of the FMU), taylor, explicit, implicit; loops if drivers determine the motion.")]
pub struct BenchCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// As JSON, for scripts
    #[arg(long)]
    json: bool,
    /// Draw time over error, an SVG or a PNG file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

impl BenchCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        output::apart(&[Some(&self.scene)], &[self.plot.as_deref()])?;
        output::is_written_as(self.plot.as_deref(), &["svg", "png"])?;
        let compiled = output::compile(&output::load(&self.scene)?, format)?;
        let variables = compiled.description.reported();
        let experiment = compiled.description.experiment;
        let model = Model::new(compiled.program).map_err(|error| Failure::Numerical(error.to_string()))?;
        let bar = output::spinner();
        let show = |text: String| {
            bar.set_message(text);
            bar.tick();
        };
        show("a converged run, against which errors are measured".to_owned());
        let mut stop = None;
        let bench = measure_watched(&Arc::new(model), &variables, experiment, &mut |next| {
            let Next { method, tolerance, done, all } = next;
            show(format!("run {} of {all}: {method}, {tolerance:e}", done + 1));
            // Until now there was nothing to keep.
            let stop = stop.get_or_insert_with(stop::listen);
            stop.as_ref().is_ok_and(|stop| !stop.load(Ordering::Relaxed))
        });
        bar.finish_and_clear();
        let bench = bench.map_err(|error| Failure::Numerical(error.to_string()))?;
        let is_stopped = stop.transpose()?.is_some_and(|stop| stop.load(Ordering::Relaxed));
        if let Some(path) = &self.plot {
            output::picture(path, &cotree_draw::study::bench::svg(&bench), "time over error", format)?;
        }
        match self.json {
            true => output::json(&bench)?,
            false => output::print(&bench.report().text(&Units::default()))?,
        }
        match is_stopped {
            true => Err(Failure::Stopped("stopped: these are the runs that were measured".to_owned())),
            false => Ok(()),
        }
    }
}
