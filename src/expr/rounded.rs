//! Numbers that know how far off rounding may have left them (running error analysis, Wilkinson 1986): whether a sum is zero by
//! cancellation can then be told from whether it is small.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number and a bound on its rounding error, to first order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounded {
    /// The number.
    pub value: f64,
    error: f64,
}

impl Rounded {
    /// A number that is what it is.
    pub const fn exact(value: f64) -> Self {
        Rounded { value, error: 0.0 }
    }

    /// Is this zero but for rounding, because terms cancel whose digits are known?
    pub fn is_zero(self) -> bool {
        /// The bound is of first order, and functions are good to a few roundings only.
        const MARGIN: f64 = 8.0;
        self.error.is_finite() && self.value.abs() <= MARGIN * self.error
    }

    /// Are its first digits known, or that it is zero?
    fn is_known(self) -> bool {
        const DIGITS: f64 = 1e-4;
        self.error <= DIGITS * self.value.abs() || self.is_zero()
    }

    /// This result of an operation on numbers. Bounds grow faster than errors do: in a long calculation a number may drown in its bound, and
    /// then nobody knows whether it is zero.
    fn unless_lost(self, known: bool) -> Self {
        if known || !self.is_zero() { self } else { Rounded { error: f64::INFINITY, ..self } }
    }

    /// Is it more than rounding? Nothing if it is no number, or lost in its bound.
    pub fn is_not_zero(self) -> Option<bool> {
        self.is_finite().then_some(!self.is_zero())
    }

    /// This number, if a correction of it is still to be made: it is off by so much.
    pub fn off_by(self, correction: Self) -> Self {
        Rounded { value: self.value, error: self.error + correction.value.abs() + correction.error }
    }

    /// Are both the number and the bound finite?
    pub fn is_finite(self) -> bool {
        self.value.is_finite() && self.error.is_finite()
    }

    /// f(self), given f and its slope there.
    pub fn apply(self, value: f64, slope: f64) -> Self {
        Rounded::computed(value, slope.abs() * self.error).unless_lost(self.is_known())
    }

    /// Its square.
    pub fn square(self) -> Self {
        self * self
    }

    /// Its square root.
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.apply(root, 0.5 / root)
    }

    fn computed(value: f64, inherited: f64) -> Self {
        Rounded { value, error: inherited + f64::EPSILON * value.abs() }
    }
}

impl Add for Rounded {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        // Nothing is added: nothing is rounded.
        if other == Rounded::default() {
            return self;
        }
        let sum = Rounded::computed(self.value + other.value, self.error + other.error);
        sum.unless_lost(self.is_known() && other.is_known())
    }
}

impl Sub for Rounded {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Rounded {
    type Output = Self;

    fn neg(self) -> Self {
        Rounded { value: -self.value, ..self }
    }
}

impl Mul for Rounded {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = Rounded::computed(
            self.value * other.value,
            self.value.abs() * other.error + (other.value.abs() + other.error) * self.error,
        );
        product.unless_lost(self.is_zero() || other.is_zero())
    }
}

impl Div for Rounded {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        Rounded::computed(quotient, (self.error + quotient.abs() * other.error) / other.value.abs())
            .unless_lost(self.is_zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cancels_is_zero_and_what_is_small_is_not() {
        let third = Rounded::exact(1.0) / Rounded::exact(3.0);
        let large = Rounded::exact(1e6);
        let one = third + third + third;
        assert!((large * one - large).is_zero());
        let small = Rounded::exact(1e-12);
        assert!(!small.is_zero());
        assert!(!((one + Rounded::exact(1e-9)) - one).is_zero());
        let angle = third * Rounded::exact(2.0);
        let (sine, cosine) = angle.value.sin_cos();
        let (sine, cosine) = (angle.apply(sine, cosine), angle.apply(cosine, sine));
        assert!((sine.square() + cosine.square() - Rounded::exact(1.0)).is_zero());
        assert!((third.sqrt().square() - third).is_zero());
    }

    /// Each step keeps all but one of its digits, but its bound does not know that.
    #[test]
    fn what_drowns_in_its_bound_is_not_taken_for_zero() {
        let third = Rounded::exact(1.0) / Rounded::exact(3.0);
        let small = (0..60).fold(third, |x, _| (x + x + x + x) - (x + x + x) + x * third - x);
        assert!(small.value > 1e-30 && 8.0 * small.error > small.value, "{small:?}");
        assert_eq!(small.is_not_zero(), None);
        assert_eq!((small * third + third).is_not_zero(), None);
        assert_eq!((third - third).is_not_zero(), Some(false));
        assert_eq!(((third - third) * third).is_not_zero(), Some(false));
    }
}
