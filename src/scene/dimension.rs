//! Units of expressions, checked where both sides are known.
//!
//! A bare number has no known unit and is compatible with everything; so is every product with one, and what `sin`,
//! `exp` and the like return. The radian counts as a pure number.

use super::unit::{Exponents, compatible};
use crate::mechanism::{BinaryOperator, Formula, Function};

/// The unit of an expression if it is known.
pub(crate) type Known = Option<Exponents>;

pub(crate) const PURE: Exponents = [0; 4];
pub(crate) const SECOND: Exponents = [0, 0, 1, 0];
const RADIAN: Exponents = [0, 0, 0, 1];

/// What a key wants.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    /// "a length"
    pub what: &'static str,
    /// "m"; empty for a pure number.
    pub si: &'static str,
    /// None: anything goes.
    pub exponents: Known,
}

const fn wanted(what: &'static str, si: &'static str, exponents: Exponents) -> Wanted {
    Wanted { what, si, exponents: Some(exponents) }
}

pub(crate) const ANYTHING: Wanted = Wanted { what: "a number", si: "", exponents: None };
pub(crate) const NUMBER: Wanted = wanted("a pure number", "", PURE);
pub(crate) const TIME: Wanted = wanted("a time", "s", SECOND);
pub(crate) const MASS: Wanted = wanted("a mass", "kg", [1, 0, 0, 0]);
pub(crate) const INERTIA: Wanted = wanted("a moment of inertia", "kg.m2", [1, 2, 0, 0]);
pub(crate) const LENGTH: Wanted = wanted("a length", "m", [0, 1, 0, 0]);
pub(crate) const VELOCITY: Wanted = wanted("a velocity", "m/s", [0, 1, -1, 0]);
pub(crate) const ACCELERATION: Wanted = wanted("an acceleration", "m/s2", [0, 1, -2, 0]);
pub(crate) const ANGLE: Wanted = wanted("an angle", "rad", RADIAN);
pub(crate) const ANGULAR_VELOCITY: Wanted = wanted("an angular velocity", "rad/s", [0, 0, -1, 1]);
pub(crate) const ANGULAR_ACCELERATION: Wanted = wanted("an angular acceleration", "rad/s2", [0, 0, -2, 1]);
pub(crate) const FORCE: Wanted = wanted("a force", "N", [1, 1, -2, 0]);
pub(crate) const TORQUE: Wanted = wanted("a torque", "N.m", [1, 2, -2, 0]);
pub(crate) const ENERGY: Wanted = wanted("an energy", "J", [1, 2, -2, 0]);
pub(crate) const POWER: Wanted = wanted("a power", "W", [1, 2, -3, 0]);
pub(crate) const STIFFNESS: Wanted = wanted("a stiffness", "N/m", [1, 0, -2, 0]);
pub(crate) const TORSION_STIFFNESS: Wanted = wanted("a torsional stiffness", "N.m/rad", [1, 2, -2, -1]);
pub(crate) const CUBIC_STIFFNESS: Wanted = wanted("a cubic stiffness", "N/m3", [1, -2, -2, 0]);
pub(crate) const CUBIC_TORSION_STIFFNESS: Wanted = wanted("a cubic torsional stiffness", "N.m/rad3", [1, 2, -2, -3]);
pub(crate) const DAMPING: Wanted = wanted("a damping coefficient", "N.s/m", [1, 0, -1, 0]);
pub(crate) const TORSION_DAMPING: Wanted = wanted("a torsional damping coefficient", "N.m.s", [1, 2, -1, 0]);

/// The unit of a sum, a comparison, or of either of two values; the two units if they cannot be combined.
pub(crate) fn join(a: Known, b: Known) -> Result<Known, (Exponents, Exponents)> {
    match (a, b) {
        (Some(a), Some(b)) if !compatible(a, b) => Err((a, b)),
        (Some(a), Some(b)) => Ok(Some(if a[3] == 0 { b } else { a })),
        (known, None) | (None, known) => Ok(known),
    }
}

/// The unit of a product, quotient or power; `exponent` is the formula of the right side.
pub(crate) fn multiply(operator: BinaryOperator, a: Known, b: Known, exponent: &Formula) -> Known {
    let sign = match operator {
        BinaryOperator::Power => return power(a?, exponent),
        BinaryOperator::Divide => -1,
        _ => 1,
    };
    let (a, b) = (a?, b?);
    let mut product = a;
    for (sum, other) in product.iter_mut().zip(b) {
        *sum = sum.checked_add(other.checked_mul(sign)?)?;
    }
    Some(product)
}

fn power(base: Exponents, exponent: &Formula) -> Known {
    let Formula::Number(exponent) = exponent else {
        return None;
    };
    if exponent.fract() != 0.0 || exponent.abs() > 9.0 {
        return None;
    }
    let mut result = base;
    for e in &mut result {
        // At most 9 in size: see above.
        *e = e.checked_mul(*exponent as i8)?;
    }
    Some(result)
}

/// The unit that a function returns, given the joined unit of its arguments.
pub(crate) fn returned(function: Function, argument: Known) -> Known {
    match function {
        Function::Abs | Function::Min | Function::Max | Function::Floor => argument,
        Function::Asin | Function::Acos | Function::Atan | Function::Atan2 => Some(RADIAN),
        Function::Sqrt => argument.filter(|e| e.iter().all(|e| e % 2 == 0)).map(|e| e.map(|e| e / 2)),
        Function::Sin
        | Function::Cos
        | Function::Tan
        | Function::Exp
        | Function::Log
        | Function::Tanh
        | Function::Sign => None,
    }
}

/// Must the argument be a pure number or an angle? Seconds pass as well: `sin(t)` is what everyone writes.
pub(crate) fn accepts(function: Function, argument: Known) -> bool {
    let takes_any = matches!(
        function,
        Function::Abs
            | Function::Min
            | Function::Max
            | Function::Floor
            | Function::Sqrt
            | Function::Sign
            | Function::Atan2
    );
    takes_any || argument.is_none_or(|unit| compatible(unit, PURE) || unit == SECOND)
}
