//! The units that results are shown in.

use clap::Args;
use cotree::compile;
use cotree::model::{DisplayUnit, Unit, Units};
use cotree::scene::{Faults, Scene};
use cotree::typeset::titled;

use super::failure::Failure;

/// As an option.
#[derive(Args)]
pub struct InUnits {
    /// Units of the results, such as deg,mm,kN; `si` for SI with units in the header [default: the scene's]
    #[arg(long, value_name = "UNITS", value_delimiter = ',')]
    units: Vec<String>,
}

impl InUnits {
    /// Those of the command line, then those of the scene.
    pub fn of(&self, scene: &Scene) -> Result<ShownUnits, Failure> {
        let units = self.before(&display(scene)?)?;
        Ok(ShownUnits { in_header: self.is_si() || units != Units::default(), units })
    }

    /// Those of the command line, and others for kinds of values that it does not name; SI instead of these if it says so.
    pub fn before(&self, others: &Units) -> Result<Units, Failure> {
        let mut requested = Units::default();
        for name in self.units.iter().filter(|name| !is_si(name)) {
            requested.add(compile::unit(name).map_err(|message| Failure::Usage(format!("--units {name}: {message}")))?);
        }
        Ok(if self.is_si() { requested } else { requested.before(others) })
    }

    /// Does it ask for SI?
    pub fn is_si(&self) -> bool {
        self.units.iter().any(|name| is_si(name))
    }
}

fn is_si(name: &str) -> bool {
    name.eq_ignore_ascii_case("si")
}

/// The units of the scene's `[display]`.
pub fn display(scene: &Scene) -> Result<Units, Faults> {
    Ok(scene.resolve()?.mechanism.display)
}

/// The units of results.
pub struct ShownUnits {
    pub units: Units,
    /// Are units written into the header of the table?
    in_header: bool,
}

impl ShownUnits {
    /// How values of a unit are shown.
    pub fn of(&self, unit: &Unit) -> DisplayUnit {
        self.units.of(unit)
    }

    /// A column of the table: its heading, and the SI value of one in it.
    pub fn column(&self, name: &str, unit: &Unit) -> (String, f64) {
        let unit = self.of(unit);
        (if self.in_header { titled(name, &unit.name) } else { name.to_owned() }, unit.factor)
    }
}
