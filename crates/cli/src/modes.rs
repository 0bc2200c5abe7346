//! `cotree modes`

use clap::Args;

use super::MessageFormat;
use super::failure::Failure;
use super::study::{self, Arguments};

/// Compute natural frequencies, damping ratios and mode shapes
///
/// About the equilibrium nearest to the start, or about a point of the motion. One of each pair of eigenvalues is reported. Shapes contain all
/// branch coordinates, dependent ones too.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree modes vibration.toml\n  \
                  cotree modes four_bar.toml --set stall_torque=0 --csv -o modes.csv\n  \
                  cotree modes governor.toml --at \"20 s\"\n  \
                  cotree modes four_bar.toml --sensitivity stall_torque")]
pub struct ModesCommand {
    #[command(flatten)]
    arguments: Arguments,
    /// At this time of the motion [default: at the equilibrium nearest to the start]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    at: Option<String>,
    /// Print instead the derivatives of frequencies and damping ratios with respect to a parameter or constant input; may be given several times
    #[arg(long, value_name = "NAME", conflicts_with = "at")]
    sensitivity: Vec<String>,
}

impl ModesCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let mut study = self.arguments.open()?;
        if !self.sensitivity.is_empty() {
            let found = study.mode_sensitivities(&self.sensitivity);
            return self.arguments.write(study, format, found.map(|found| found.report()));
        }
        let start = study.experiment().start;
        let at = self.at.as_deref().map(|at| study::time("at", at, start)).transpose()?;
        let found = study.modes(at);
        self.arguments.write(study, format, found.map(|found| found.report()))
    }
}
