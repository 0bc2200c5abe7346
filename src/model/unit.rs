//! Units, and the parameters and inputs that have them.

use thiserror::Error;

use super::measure::{ANGLE, LENGTH, TIME, Wanted};
use super::{Exponents, Formula};
use crate::diagnostic::Span;
use crate::typeset::rounded;

/// Why a variable cannot have a value.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct ValueError(pub String);

/// What kind of value it measures, and how the user writes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unit {
    /// Exponents of kilogram, metre, second, radian and ampere.
    pub exponents: Exponents,
    /// SI name, such as `N.m`; empty for a pure number.
    pub si: String,
    /// The user's unit, such as `mm`, if not the SI name.
    pub display: Option<DisplayUnit>,
}

impl Unit {
    /// That of a kind of values.
    pub fn of(wanted: &Wanted, display: Option<DisplayUnit>) -> Unit {
        Unit { exponents: wanted.exponents.unwrap_or_default(), si: wanted.si.to_owned(), display }
    }

    /// s
    pub fn time() -> Unit {
        Unit::of(&TIME, None)
    }

    /// rad
    pub fn angle() -> Unit {
        Unit::of(&ANGLE, None)
    }

    /// m
    pub fn length() -> Unit {
        Unit::of(&LENGTH, None)
    }

    /// May the two stand for the same kind of value? The radian counts as a pure number; but 1 Hz is one turn a second to some and one radian a second to others.
    pub fn is_compatible(&self, other: &Unit) -> bool {
        let [one, two] = [self, other].map(|unit| unit.exponents);
        let is_in_hertz = |exponents: Exponents| exponents == Exponents::HERTZ;
        one.is_compatible(two) && (!one.is_compatible(Exponents::HERTZ) || is_in_hertz(one) == is_in_hertz(two))
    }

    /// May a value \[SI\] of this unit lie within these bounds?
    ///
    /// # Errors
    /// Why not.
    pub fn permit(&self, value: f64, bounds: [Option<f64>; 2]) -> Result<(), ValueError> {
        match bounds {
            _ if !value.is_finite() => Err(ValueError("is not a finite number".to_owned())),
            [Some(min), _] if value < min => Err(ValueError(format!("must be at least {min:?} {si}", si = self.si))),
            [_, Some(max)] if value > max => Err(ValueError(format!("must be at most {max:?} {si}", si = self.si))),
            _ => Ok(()),
        }
    }

    /// This unit divided by the second: rad/s, m/s2.
    pub fn per_second(&self) -> Unit {
        let si = match self.si.strip_suffix("/s") {
            Some(base) => format!("{base}/s2"),
            None => format!("{}/s", self.si),
        };
        Unit { exponents: self.exponents.over(Exponents::SECOND), si, display: None }
    }
}

/// A unit that the user wrote: `value in SI = factor * value`.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Its name, such as `mm`, `deg`, `rpm`.
    pub name: String,
    /// SI value of one of it.
    pub factor: f64,
}

impl DisplayUnit {
    /// A value in SI as `12.5 mm`, with four digits.
    pub fn show(&self, value: f64) -> String {
        format!("{} {}", rounded(value / self.factor, 4), self.name)
    }
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameter {
    /// The user's name.
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    /// Unit as the user sees it.
    pub unit: Unit,
    /// Default value, SI.
    pub value: f64,
    /// Smallest permitted value, SI.
    pub min: Option<f64>,
    /// Largest permitted value, SI.
    pub max: Option<f64>,
    /// May it change after initialisation?
    pub tunable: bool,
    /// Where it stands in the file.
    pub span: Span,
}

/// A parameter that follows others: it cannot be set.
#[derive(Clone, Debug, PartialEq)]
pub struct Calculated {
    /// Its name, and its value with the defaults of the others; its limits are kept as [`super::Bound`]s.
    pub parameter: Parameter,
    /// What it is calculated from: numbers and parameters that can be set. Expressions that use it have this in its place.
    pub formula: Formula,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// The user's name.
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    /// Unit as the user sees it.
    pub unit: Unit,
    /// Value until it is set, SI.
    pub start: f64,
    /// Smallest permitted value, SI.
    pub min: Option<f64>,
    /// Largest permitted value, SI.
    pub max: Option<f64>,
    /// Where it stands in the file.
    pub span: Span,
}

#[cfg(test)]
mod tests {
    use crate::model::{Exponents, Unit};

    #[test]
    fn hertz_are_no_unit_of_an_angular_velocity() {
        let unit = |exponents| Unit { exponents, ..Unit::default() };
        let (hertz, velocity) = (unit(Exponents::HERTZ), unit(Exponents::RADIAN.over(Exponents::SECOND)));
        let (angle, number) = (unit(Exponents::RADIAN), unit(Exponents::NONE));
        assert!(!hertz.is_compatible(&velocity) && !velocity.is_compatible(&hertz));
        assert!(hertz.is_compatible(&hertz) && angle.is_compatible(&number) && !angle.is_compatible(&velocity));
    }
}
