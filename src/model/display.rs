//! The units in which people see numbers; inside, everything is SI.

use super::{DisplayUnit, Unit};

/// Units to show values in, each for one kind of value. What has no unit here is shown in SI; velocities and accelerations follow the
/// units of lengths and angles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Units {
    units: Vec<Unit>,
}

/// J and N.m have the same exponents, but nobody means the one by the other.
const ENERGY: [i8; 4] = [1, 2, -2, 0];

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
        let [kg, m, s, rad] = unit.exponents;
        let base = [kg, m, 0, rad];
        let base =
            self.units.iter().find(|known| matches!(base, [0, 1, 0, 0] | [0, 0, 0, 1]) && known.exponents == base);
        match (base.map(shown), s) {
            (Some(base), -1) => DisplayUnit { name: format!("{}/s", base.name), ..base },
            (Some(base), -2) => DisplayUnit { name: format!("{}/s2", base.name), ..base },
            _ => DisplayUnit { name: unit.si.clone(), factor: 1.0 },
        }
    }
}

fn same(known: &Unit, unit: &Unit) -> bool {
    known.exponents == unit.exponents && (known.exponents != ENERGY || known.si == unit.si)
}

/// A unit as it was written; the SI unit if it was.
fn shown(unit: &Unit) -> DisplayUnit {
    unit.display.clone().unwrap_or_else(|| DisplayUnit { name: unit.si.clone(), factor: 1.0 })
}
