//! Units of expressions, checked where both sides are known.
//!
//! A bare number has no known unit and is compatible with everything; so is every product with one, and what `sin`,
//! `exp` and the like return. The radian counts as a pure number.

use super::unit::{Exponents, compatible};
use crate::expr::{Function, Units};
pub(crate) use crate::mechanism::measure::*;
use crate::mechanism::{BinaryOperator, Formula};

/// The unit of an expression if it is known.
pub(crate) type Known = Option<Exponents>;

pub(crate) const PURE: Exponents = [0; 4];
pub(crate) const SECOND: Exponents = [0, 0, 1, 0];
const RADIAN: Exponents = [0, 0, 0, 1];

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
    match function.units() {
        Units::Kept => argument,
        Units::Halved => argument.filter(|e| e.iter().all(|e| e % 2 == 0)).map(|e| e.map(|e| e / 2)),
        Units::Bearing | Units::Angle => Some(RADIAN),
        Units::Dropped | Units::Pure => None,
    }
}

/// Must the argument be a pure number or an angle? Seconds pass as well: `sin(t)` is what everyone writes.
pub(crate) fn accepts(function: Function, argument: Known) -> bool {
    let takes_any = !matches!(function.units(), Units::Angle | Units::Pure);
    takes_any || argument.is_none_or(|unit| compatible(unit, PURE) || unit == SECOND)
}
