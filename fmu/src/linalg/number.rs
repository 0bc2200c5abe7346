//! Real numbers, alone or with their derivatives: what is written for either serves for both.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::lane;

/// A real number, or one that brings its derivatives.
pub(crate) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self> + AddAssign + SubAssign
{
    /// Nothing.
    const ZERO: Self;
    /// A constant.
    fn all(value: f64) -> Self;
    /// self / other
    fn over(self, other: Self) -> Self;
    /// 1 / self
    fn reciprocal(self) -> Self;
    /// |self|
    fn magnitude(self) -> Self;
    /// c self
    fn times(self, c: f64) -> Self;
    /// The larger magnitude; NaN stays.
    fn larger(self, other: Self) -> Self;
    /// Is it larger than a bound? Not a number is not.
    fn exceeds(self, bound: Self) -> bool;
}

/// What laws need besides.
pub(crate) trait Elementary: Number {
    /// The square root.
    fn root(self) -> Self;
    /// The natural logarithm.
    fn logarithm(self) -> Self;
    /// self^exponent
    fn power(self, exponent: Self) -> Self;
    /// Cosine and sine.
    fn cosine_and_sine(self) -> [Self; 2];
    /// The angle of (x, self).
    fn arc_tangent(self, x: Self) -> Self;
}

impl Number for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn all(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        self / other
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        1.0 / self
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn times(self, c: f64) -> Self {
        c * self
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        lane::above(self, other)
    }

    #[inline(always)]
    fn exceeds(self, bound: Self) -> bool {
        self > bound
    }
}
