//! The units in which people see numbers; inside, everything is SI.

use super::{DisplayUnit, Exponents, Unit};

/// Units to show values in, each for one kind of value. What has no unit here is shown in SI; velocities and accelerations follow the
/// units of lengths and angles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Units {
    units: Vec<Unit>,
}

/// Units with the exponents of others by which nobody means them: J and N.m, Wb and N.m/A.
const AMBIGUOUS: [Exponents; 2] = [Exponents::JOULE, Exponents::WEBER];

impl Units {
    /// Adds a unit, unless there is one of its kind already.
    pub fn add(&mut self, unit: Unit) {
        if !self.units.iter().any(|known| same(known, &unit)) {
            self.units.push(unit);
        }
    }

    /// Units that these complete: they count where the others have none of a kind.
    #[must_use]
    pub fn before(mut self, others: &Units) -> Units {
        others.units.iter().for_each(|unit| self.add(unit.clone()));
        self
    }

    /// How a value in this SI unit is shown.
    pub fn of(&self, unit: &Unit) -> DisplayUnit {
        if let Some(known) = self.units.iter().find(|known| same(known, unit)) {
            return shown(known);
        }
        let base = unit.exponents.without_second();
        let is_base = base == Exponents::METRE || base == Exponents::RADIAN;
        let base = self.units.iter().find(|known| is_base && known.exponents == base);
        match (base.map(shown), unit.exponents.second) {
            (Some(base), -1) => DisplayUnit { name: format!("{}/s", base.name), ..base },
            (Some(base), -2) => DisplayUnit { name: format!("{}/s2", base.name), ..base },
            _ => DisplayUnit { name: unit.si.clone(), factor: 1.0 },
        }
    }
}

fn same(known: &Unit, unit: &Unit) -> bool {
    known.exponents == unit.exponents && (known.si == unit.si || !AMBIGUOUS.contains(&known.exponents))
}

/// A unit as it was written; the SI unit if it was.
fn shown(unit: &Unit) -> DisplayUnit {
    unit.display.clone().unwrap_or_else(|| DisplayUnit { name: unit.si.clone(), factor: 1.0 })
}
