//! `cotree equilibrium`

use clap::Args;

use super::MessageFormat;
use super::failure::Failure;
use super::study::Arguments;

/// Find an equilibrium: configuration, reactions of all joints and drivers, stability
///
/// The search starts from the configuration of `[initial]`, so the guess chooses one of several equilibria. Drivers and loads keep
/// their values at the start.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree equilibrium four_bar.toml\n  \
                  cotree equilibrium four_bar.toml --set stall_torque=\"2 N.m\" --json -o rest.json\n  \
                  cotree equilibrium four_bar.toml --sensitivity stall_torque")]
pub struct EquilibriumCommand {
    #[command(flatten)]
    arguments: Arguments,
    /// Print instead the outputs at the equilibrium and their derivatives with respect to a parameter or constant input; may be given several times
    #[arg(long, value_name = "NAME")]
    sensitivity: Vec<String>,
}

impl EquilibriumCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let mut study = self.arguments.open()?;
        if !self.sensitivity.is_empty() {
            let found = study.equilibrium_sensitivities(&self.sensitivity);
            return self.arguments.write(study, format, found.map(|found| found.report()));
        }
        let found = study.equilibrium();
        self.arguments.write(study, format, found.map(|found| found.report()))
    }
}
