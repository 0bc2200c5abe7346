//! Units of expressions, checked where both sides are known.
//!
//! A number alone is compatible with everything, and so is what `sin`, `exp` and the like return; as a factor it is a pure number. Only
//! where it multiplies something that moves, an input or the time it may be a coefficient with a unit of its own, as in `-0.5*crank.omega`: such a
//! product is open. What a parameter without a unit is made of is not known. The radian counts as a pure number. 1 Hz is one turn a second to some and one
//! radian a second to others: what is written in hertz and becomes an angle needs a factor that says which, `2*pi` or `1 rad`.

use crate::expr::{Binary, Function, UnitRule};
pub(crate) use crate::model::measure::*;
use crate::model::{Exponents, Formula};

/// What is known of the unit of an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum KnownUnit {
    Nothing,
    /// It is made of numbers alone.
    Number,
    Unit(MeasuredUnit),
}

/// A unit, and what it is the unit of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeasuredUnit {
    exponents: Exponents,
    /// Has it a number as a factor?
    scaled: bool,
    /// Does it depend on the time or the motion?
    moving: bool,
    /// How many of its seconds are written as hertz.
    hertz: i8,
}

impl KnownUnit {
    /// The unit of a parameter, if it has one.
    pub fn constant(unit: Option<Exponents>) -> KnownUnit {
        unit.map_or(KnownUnit::Nothing, |exponents| {
            KnownUnit::Unit(MeasuredUnit { exponents, scaled: false, moving: false, hertz: 0 })
        })
    }

    /// The unit of a number that is written with it. An angle in degrees is a number, too: as a coefficient it may have a unit of its own, as in `360[deg]*t`.
    pub fn written(exponents: Exponents) -> KnownUnit {
        KnownUnit::Unit(MeasuredUnit { exponents, scaled: exponents == Exponents::RADIAN, moving: false, hertz: 0 })
    }

    /// The same, so many times in hertz.
    pub fn in_hertz(self, hertz: i8) -> KnownUnit {
        match self {
            KnownUnit::Unit(unit) => KnownUnit::Unit(MeasuredUnit { hertz, ..unit }),
            other => other,
        }
    }

    /// How many times it is in hertz, without a factor that says what turns.
    pub fn hertz(self) -> i8 {
        match self {
            KnownUnit::Unit(unit) if !unit.scaled && unit.exponents.radian == 0 => unit.hertz,
            _ => 0,
        }
    }

    /// The unit of the time, of an input or of a variable.
    pub fn moving(unit: Option<Exponents>) -> KnownUnit {
        unit.map_or(KnownUnit::Nothing, |exponents| {
            KnownUnit::Unit(MeasuredUnit { exponents, scaled: false, moving: true, hertz: 0 })
        })
    }

    /// The unit, unless a coefficient may have changed it.
    pub fn unit(self) -> Option<Exponents> {
        match self {
            KnownUnit::Unit(unit) if !(unit.scaled && unit.moving) => Some(unit.exponents),
            _ => None,
        }
    }

    /// Is it in square metres with a number as a factor? As a moment of inertia the number is the mass, as in `0.5*2.0*radius^2`.
    pub fn is_area_times_number(self) -> bool {
        matches!(self, KnownUnit::Unit(unit) if unit.scaled && Some(unit.exponents) == AREA.exponents)
    }

    fn measured(self) -> Option<MeasuredUnit> {
        match self {
            KnownUnit::Nothing => None,
            KnownUnit::Number => {
                Some(MeasuredUnit { exponents: Exponents::NONE, scaled: true, moving: false, hertz: 0 })
            }
            KnownUnit::Unit(unit) => Some(unit),
        }
    }
}

/// The unit of a sum, a comparison, or of either of two values; the two units if they cannot be combined.
pub(crate) fn join(a: KnownUnit, b: KnownUnit) -> Result<KnownUnit, (Exponents, Exponents)> {
    let moving = [a, b].into_iter().filter_map(KnownUnit::measured).any(|unit| unit.moving);
    // A sum with a certain unit is certain, whatever factors its terms have.
    let hertz = if a.hertz() == 0 { b.hertz() } else { a.hertz() };
    let certain = |exponents| Ok(KnownUnit::Unit(MeasuredUnit { exponents, scaled: false, moving, hertz }));
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
        (None, None) if a == KnownUnit::Nothing || b == KnownUnit::Number => Ok(a),
        (None, None) => Ok(b),
    }
}

/// The unit of a product, quotient or power; `exponent` is the formula of the right side.
pub(crate) fn multiply(operator: Binary, a: KnownUnit, b: KnownUnit, exponent: &Formula) -> KnownUnit {
    if operator == Binary::Power {
        return power(a, b, exponent);
    }
    if (a, b) == (KnownUnit::Number, KnownUnit::Number) {
        return KnownUnit::Number;
    }
    let sign = if operator == Binary::Divide { -1 } else { 1 };
    let (Some(a), Some(b)) = (a.measured(), b.measured()) else {
        return KnownUnit::Nothing;
    };
    let Some(exponents) = Exponents::product([(a.exponents, 1), (b.exponents, i32::from(sign))]) else {
        return KnownUnit::Nothing;
    };
    let hertz = a.hertz.saturating_add(b.hertz.saturating_mul(sign));
    KnownUnit::Unit(MeasuredUnit { exponents, scaled: a.scaled || b.scaled, moving: a.moving || b.moving, hertz })
}

fn power(base: KnownUnit, right: KnownUnit, exponent: &Formula) -> KnownUnit {
    let KnownUnit::Unit(unit) = base else {
        return if (base, right) == (KnownUnit::Number, KnownUnit::Number) {
            KnownUnit::Number
        } else {
            KnownUnit::Nothing
        };
    };
    let Formula::Number(exponent) = exponent else {
        let is_pure = unit.exponents.is_compatible(Exponents::NONE);
        return if is_pure {
            KnownUnit::Unit(MeasuredUnit { exponents: Exponents::NONE, ..unit })
        } else {
            KnownUnit::Nothing
        };
    };
    let Some(exponents) = unit.exponents.raised(*exponent) else {
        return KnownUnit::Nothing;
    };
    let hertz = (f64::from(unit.hertz) * exponent) as i8;
    KnownUnit::Unit(MeasuredUnit { exponents, hertz, ..unit })
}

/// The unit that a function returns, given the joined unit of its arguments.
pub(crate) fn returned(function: Function, argument: KnownUnit) -> KnownUnit {
    let moving = argument.measured().is_some_and(|unit| unit.moving);
    match function.units() {
        UnitRule::Kept => argument,
        UnitRule::Halved => power(argument, KnownUnit::Number, &Formula::Number(0.5)),
        UnitRule::Bearing | UnitRule::Angle => {
            KnownUnit::Unit(MeasuredUnit { exponents: Exponents::RADIAN, scaled: false, moving, hertz: 0 })
        }
        UnitRule::Dropped | UnitRule::Pure => KnownUnit::Number,
    }
}

/// Must the argument be a pure number or an angle? Seconds pass as well: `sin(t)` is what everyone writes.
pub(crate) fn accepts(function: Function, argument: KnownUnit) -> bool {
    let takes_any = !matches!(function.units(), UnitRule::Angle | UnitRule::Pure);
    takes_any || argument.unit().is_none_or(|unit| unit.is_compatible(Exponents::NONE) || unit == Exponents::SECOND)
}
