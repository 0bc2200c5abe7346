//! `cotree linearize`

use clap::Args;
use cotree::model::Experiment;
use cotree::run as simulate;
use cotree_study::analysis::LinearisedAt;

use super::failure::Failure;
use super::study::{self, Arguments};
use super::{MessageFormat, output, times};

/// More points than this are a mistake in `--step` or `--stop`.
const MOST_POINTS: u64 = 1_000_000;

/// Linearize a mechanism: state-space matrices A, B, C, D from the inputs of the scene to its outputs
///
/// dx/dt = A x + B u, y = C x + D u for small changes about a point of the motion. If the point is not an equilibrium its dx/dt is reported too.
/// The states are independent coordinates and their rates, two per degree of freedom. The derivatives are exact. An output file that
/// ends in `.m` is a script of MATLAB and Octave.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree linearize cart_pole.toml\n  \
                  cotree linearize cart_pole.toml --equilibrium --json -o plant.json\n  \
                  cotree linearize cart_pole.toml --equilibrium --discrete \"10 ms\" -o plant.m\n  \
                  cotree linearize four_bar.toml --at \"0.5 s\"\n  \
                  cotree linearize four_bar.toml --along --step \"50 ms\" --csv -o matrices.csv")]
pub struct LinearizeCommand {
    #[command(flatten)]
    arguments: Arguments,
    /// At this time of the motion [default: at its start]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, conflicts_with_all = ["equilibrium", "along"])]
    at: Option<String>,
    /// At the equilibrium nearest to the start
    #[arg(long, conflicts_with = "along")]
    equilibrium: bool,
    /// At every communication point of the motion
    #[arg(long)]
    along: bool,
    /// Discretize for this sample time, with zero-order hold of the inputs: x(k+1) = A x(k) + B u(k)
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    discrete: Option<String>,
    /// With --along: end of the motion [default: the scene's]
    #[arg(long, value_name = "TIME", requires = "along", allow_hyphen_values = true)]
    stop: Option<String>,
    /// With --along: time between points [default: the scene's]
    #[arg(long, value_name = "TIME", requires = "along", allow_hyphen_values = true)]
    step: Option<String>,
}

impl LinearizeCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let mut study = self.arguments.open()?;
        let at = if self.equilibrium {
            LinearisedAt::Equilibrium
        } else {
            LinearisedAt::Times(self.times(study.experiment())?)
        };
        let mut found = study.linearize(&at);
        if let Some(text) = &self.discrete {
            let step = times::seconds("discrete", text)?;
            if !(step > 0.0 && step.is_finite()) {
                return Err(Failure::Usage(format!("--discrete: {step:?} s must be positive")));
            }
            found = found.and_then(|found| Ok(found.held(step)?));
        }
        match self.arguments.script() {
            Some(path) => {
                output::warn(study.take_warnings().as_ref(), format);
                let text = found?.matlab();
                let text = text.ok_or_else(|| {
                    Failure::Usage("a `.m` file has the matrices of one point: remove --along".to_owned())
                })?;
                output::write(path, text)
            }
            None => self.arguments.write(study, format, found.map(|found| found.report())),
        }
    }

    fn times(&self, mut experiment: Experiment) -> Result<Vec<f64>, Failure> {
        let start = experiment.start;
        if !self.along {
            return Ok(vec![self.at.as_deref().map_or(Ok(start), |at| study::time("at", at, start))?]);
        }
        if let Some(stop) = &self.stop {
            experiment.stop = study::time("stop", stop, start)?;
        }
        if let Some(step) = &self.step {
            experiment.step = study::time("step", step, 0.0)?;
        }
        if experiment.step <= 0.0 || simulate::count(experiment) > MOST_POINTS {
            let message = format!("--step: {:?} s gives no points, or more than {MOST_POINTS}", experiment.step);
            return Err(Failure::Usage(message));
        }
        Ok(simulate::points(experiment).collect())
    }
}
