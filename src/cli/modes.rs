//! `cotree modes`

use clap::Args;

use super::MessageFormat;
use super::failure::Failure;
use super::study::{self, Motion, Study};
use crate::analysis::report::Vibration;
use crate::analysis::{Point, StateSpace, Variation, modes};
use crate::formulate::Formulated;

/// Find how a mechanism vibrates: natural frequencies, damping ratios and mode shapes
///
/// About the equilibrium next to the start, or about a point of the motion. Of each pair of eigenvalues one is reported. Shapes are given in all
/// branch coordinates, those that follow others included.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree modes vibration.toml\n  \
                  cotree modes four_bar.toml --set stall_torque=0 --csv -o modes.csv\n  \
                  cotree modes governor.toml --at \"20 s\"")]
pub struct Modes {
    #[command(flatten)]
    study: Study,
    /// At this time of the motion [default: at the equilibrium next to its start]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    at: Option<String>,
}

impl Modes {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let (scene, mechanism) = self.study.open(format)?;
        let report = match &self.at {
            None => study::rest(&scene, &mechanism, format, |formulated, variation, equilibrium| {
                vibration(formulated, variation, &equilibrium.point, true)
            })?,
            Some(at) => {
                let time = study::time("at", at, mechanism.experiment.start)?;
                let mut formulated = study::equations(&scene, &mechanism, format)?;
                let variation = Variation::new(&mut formulated);
                let point = Motion::new(&formulated)?.point(time)?;
                vibration(&formulated, &variation, &point, false)?
            }
        };
        self.study.write(&report)
    }
}

fn vibration(
    formulated: &Formulated,
    variation: &Variation,
    point: &Point,
    resting: bool,
) -> Result<Vibration, Failure> {
    let system = StateSpace::new(formulated, variation, point, None)?;
    Ok(Vibration {
        name: formulated.equations.system.mechanism.name.clone(),
        time: point.time(),
        resting,
        coordinates: formulated.equations.coordinates.iter().map(|q| q.name.position.clone()).collect(),
        modes: modes(formulated, &system)?,
    })
}
