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

    /// May this be zero but for rounding?
    pub fn is_zero(self) -> bool {
        /// The bound is of first order, and functions are good to a few roundings only.
        const MARGIN: f64 = 8.0;
        self.value.abs() <= MARGIN * self.error
    }

    /// Is it more than rounding? Nothing if it is no number.
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
        Rounded::computed(value, slope.abs() * self.error)
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
        Rounded::computed(self.value + other.value, self.error + other.error)
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
        Rounded::computed(
            self.value * other.value,
            self.value.abs() * other.error + (other.value.abs() + other.error) * self.error,
        )
    }
}

impl Div for Rounded {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        Rounded::computed(quotient, (self.error + quotient.abs() * other.error) / other.value.abs())
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
}
