//! Units of expressions, checked where both sides are known.
//!
//! A number alone is compatible with everything, and so is what `sin`, `exp` and the like return; as a factor it is a pure number. Only
//! where it multiplies something that moves, an input or the time it may be a coefficient with a unit of its own, as in `-0.5*crank.omega`: such a
//! product is open. What a parameter without a unit is made of is not known. The radian counts as a pure number. 1 Hz is one turn a second to some and one
//! radian a second to others: what is written in hertz and becomes an angle needs a factor that says which, `2*pi` or `1 rad`.

use crate::expr::{Binary, Function, Units};
pub(crate) use crate::model::measure::*;
use crate::model::{Exponents, Formula};

/// What is known of the unit of an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Known {
    Nothing,
    /// It is made of numbers alone.
    Number,
    Unit(Measured),
}

/// A unit, and what it is the unit of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Measured {
    exponents: Exponents,
    /// Has it a number as a factor?
    scaled: bool,
    /// Does it depend on the time or the motion?
    moving: bool,
    /// How many of its seconds are written as hertz.
    hertz: i8,
}

impl Known {
    /// The unit of a parameter, if it has one.
    pub fn constant(unit: Option<Exponents>) -> Known {
        unit.map_or(Known::Nothing, |exponents| {
            Known::Unit(Measured { exponents, scaled: false, moving: false, hertz: 0 })
        })
    }

    /// The unit of a number that is written with it. An angle in degrees is a number, too: as a coefficient it may have a unit of its own, as in `360[deg]*t`.
    pub fn written(exponents: Exponents) -> Known {
        Known::Unit(Measured { exponents, scaled: exponents == Exponents::RADIAN, moving: false, hertz: 0 })
    }

    /// The same, so many times in hertz.
    pub fn in_hertz(self, hertz: i8) -> Known {
        match self {
            Known::Unit(unit) => Known::Unit(Measured { hertz, ..unit }),
            other => other,
        }
    }

    /// How many times it is in hertz, without a factor that says what turns.
    pub fn hertz(self) -> i8 {
        match self {
            Known::Unit(unit) if !unit.scaled && unit.exponents.radian == 0 => unit.hertz,
            _ => 0,
        }
    }

    /// The unit of the time, of an input or of a variable.
    pub fn moving(unit: Option<Exponents>) -> Known {
        unit.map_or(Known::Nothing, |exponents| {
            Known::Unit(Measured { exponents, scaled: false, moving: true, hertz: 0 })
        })
    }

    /// The unit, unless a coefficient may have changed it.
    pub fn unit(self) -> Option<Exponents> {
        match self {
            Known::Unit(unit) if !(unit.scaled && unit.moving) => Some(unit.exponents),
            _ => None,
        }
    }

    /// Is it in square metres with a number as a factor? As a moment of inertia the number is the mass, as in `0.5*2.0*radius^2`.
    pub fn is_area_times_number(self) -> bool {
        matches!(self, Known::Unit(unit) if unit.scaled && Some(unit.exponents) == AREA.exponents)
    }

    fn measured(self) -> Option<Measured> {
        match self {
            Known::Nothing => None,
            Known::Number => Some(Measured { exponents: Exponents::NONE, scaled: true, moving: false, hertz: 0 }),
            Known::Unit(unit) => Some(unit),
        }
    }
}

/// The unit of a sum, a comparison, or of either of two values; the two units if they cannot be combined.
pub(crate) fn join(a: Known, b: Known) -> Result<Known, (Exponents, Exponents)> {
    let moving = [a, b].into_iter().filter_map(Known::measured).any(|unit| unit.moving);
    // A sum with a certain unit is certain, whatever factors its terms have.
    let hertz = if a.hertz() == 0 { b.hertz() } else { a.hertz() };
    let certain = |exponents| Ok(Known::Unit(Measured { exponents, scaled: false, moving, hertz }));
    match (a.unit(), b.unit()) {
        (Some(a), Some(b)) if !a.is_compatible(b) => Err((a, b)),
        // What is open stays so beside an angle.
        (Some(a), Some(b)) => certain(if a.radian == 0 && hertz == 0 {
            b
        } else if hertz == 0 {
            a
        } else {
            a.without_radian()
        }),
        (Some(unit), None) | (None, Some(unit)) => certain(unit),
        (None, None) if a == Known::Nothing || b == Known::Number => Ok(a),
        (None, None) => Ok(b),
    }
}

/// The unit of a product, quotient or power; `exponent` is the formula of the right side.
pub(crate) fn multiply(operator: Binary, a: Known, b: Known, exponent: &Formula) -> Known {
    if operator == Binary::Power {
        return power(a, b, exponent);
    }
    if (a, b) == (Known::Number, Known::Number) {
        return Known::Number;
    }
    let sign = if operator == Binary::Divide { -1 } else { 1 };
    let (Some(a), Some(b)) = (a.measured(), b.measured()) else {
        return Known::Nothing;
    };
    let Some(exponents) = Exponents::product([(a.exponents, 1), (b.exponents, i32::from(sign))]) else {
        return Known::Nothing;
    };
    let hertz = a.hertz.saturating_add(b.hertz.saturating_mul(sign));
    Known::Unit(Measured { exponents, scaled: a.scaled || b.scaled, moving: a.moving || b.moving, hertz })
}

fn power(base: Known, right: Known, exponent: &Formula) -> Known {
    let Known::Unit(unit) = base else {
        return if (base, right) == (Known::Number, Known::Number) { Known::Number } else { Known::Nothing };
    };
    let Formula::Number(exponent) = exponent else {
        let is_pure = unit.exponents.is_compatible(Exponents::NONE);
        return if is_pure { Known::Unit(Measured { exponents: Exponents::NONE, ..unit }) } else { Known::Nothing };
    };
    let Some(exponents) = unit.exponents.raised(*exponent) else {
        return Known::Nothing;
    };
    let hertz = (f64::from(unit.hertz) * exponent) as i8;
    Known::Unit(Measured { exponents, hertz, ..unit })
}

/// The unit that a function returns, given the joined unit of its arguments.
pub(crate) fn returned(function: Function, argument: Known) -> Known {
    let moving = argument.measured().is_some_and(|unit| unit.moving);
    match function.units() {
        Units::Kept => argument,
        Units::Halved => power(argument, Known::Number, &Formula::Number(0.5)),
        Units::Bearing | Units::Angle => {
            Known::Unit(Measured { exponents: Exponents::RADIAN, scaled: false, moving, hertz: 0 })
        }
        Units::Dropped | Units::Pure => Known::Number,
    }
}

/// Must the argument be a pure number or an angle? Seconds pass as well: `sin(t)` is what everyone writes.
pub(crate) fn accepts(function: Function, argument: Known) -> bool {
    let takes_any = !matches!(function.units(), Units::Angle | Units::Pure);
    takes_any || argument.unit().is_none_or(|unit| unit.is_compatible(Exponents::NONE) || unit == Exponents::SECOND)
}
