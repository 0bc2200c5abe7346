//! The times of a run and its tolerance, as options.

use clap::Args;
use cotree::model::{Experiment, Unit};
use cotree::{compile, run as simulate};

use super::failure::Failure;

/// Times and tolerance; what is not given is the scene's.
#[derive(Args)]
pub struct TimeArguments {
    /// End of the simulation, such as 10 or "10 s" [default: the scene's]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    stop: Option<String>,
    /// Output step: time between reported values [default: the scene's]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    step: Option<String>,
    /// Relative tolerance of the solver [default: the scene's]
    #[arg(long, value_name = "NUMBER")]
    tolerance: Option<f64>,
}

impl TimeArguments {
    /// Of a command that has some of them only.
    pub fn of(stop: Option<String>, step: Option<String>, tolerance: Option<f64>) -> Self {
        TimeArguments { stop, step, tolerance }
    }

    /// Together with those of the scene.
    pub fn experiment(&self, scene: Experiment) -> Result<Experiment, Failure> {
        let time = |name, text: &Option<String>, default| text.as_ref().map_or(Ok(default), |text| seconds(name, text));
        let stop = time("stop", &self.stop, scene.stop)?;
        let step = time("step", &self.step, scene.step)?;
        let tolerance = self.tolerance.unwrap_or(scene.tolerance);
        let experiment = Experiment { stop, step, tolerance, ..scene };
        check(experiment)?;
        Ok(experiment)
    }
}

/// A time of the command line \[s\].
pub fn seconds(option: &str, text: &str) -> Result<f64, Failure> {
    compile::quantity(text, &Unit::time()).map_err(|message| Failure::Usage(format!("--{option}: {message}")))
}

/// Can a run have these times and this tolerance?
pub fn check(experiment: Experiment) -> Result<(), Failure> {
    simulate::check(experiment).map_err(|(option, message)| Failure::Usage(format!("--{option}: {message}")))
}
