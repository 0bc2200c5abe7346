//! `cotree equilibrium`

use clap::Args;

use super::MessageFormat;
use super::failure::Failure;
use super::study::{self, Study};
use crate::analysis::report::Statics;

/// Find where a mechanism rests: its pose, the reactions of all joints and drivers, and whether it is stable
///
/// The search starts from the pose that `[initial]` gives: of several equilibria the scene's guess picks one. Drivers and loads stay
/// as they are at the start.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree equilibrium four_bar.toml\n  \
                  cotree equilibrium four_bar.toml --set stall_torque=\"2 N.m\" --json -o rest.json")]
pub struct Equilibrium {
    #[command(flatten)]
    study: Study,
}

impl Equilibrium {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let (scene, mechanism) = self.study.open(format)?;
        let report = study::rest(&scene, &mechanism, format, |formulated, _, equilibrium| {
            Ok(Statics::new(formulated, equilibrium))
        })?;
        self.study.write(&report)
    }
}
