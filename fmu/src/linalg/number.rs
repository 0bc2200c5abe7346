//! Real numbers, alone or with their derivatives: what is written for either serves for both.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::lane::Lane;
use super::turn;
use crate::math;

/// A real number, or one that brings its derivatives.
pub(crate) trait Number:
    Copy
    + Debug
    + Default
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// Nothing.
    const ZERO: Self;
    /// A constant.
    fn all(value: f64) -> Self;
    /// Without derivatives.
    fn value(self) -> f64;
    /// self / other
    fn over(self, other: Self) -> Self;
    /// c self
    fn times(self, c: f64) -> Self;
}

/// What poses and laws need besides.
pub(crate) trait Elementary: Number {
    /// The square root.
    fn root(self) -> Self;
    /// The natural logarithm.
    fn logarithm(self) -> Self;
    /// The exponential function.
    fn exponential(self) -> Self;
    /// self^exponent
    fn power(self, exponent: Self) -> Self;
    /// Cosine and sine.
    fn cosine_and_sine(self) -> [Self; 2];
    /// The same of all numbers of a lane.
    #[inline(always)]
    fn cosines_and_sines<const L: usize>(lane: Lane<Self, L>) -> [Lane<Self, L>; 2] {
        let both = lane.map(Self::cosine_and_sine);
        [both.map(|[cosine, _]| cosine), both.map(|[_, sine]| sine)]
    }
    /// The angle of (x, self).
    fn arc_tangent(self, x: Self) -> Self;
    /// The hyperbolic tangent, and its slope 1 - tanh^2.
    fn hyperbolic_tangent(self) -> [Self; 2];
}

impl Number for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn all(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        self / other
    }

    #[inline(always)]
    fn times(self, c: f64) -> Self {
        c * self
    }
}

impl Elementary for f64 {
    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn logarithm(self) -> Self {
        libm::log(self)
    }

    #[inline(always)]
    fn exponential(self) -> Self {
        libm::exp(self)
    }

    #[inline(always)]
    fn power(self, exponent: Self) -> Self {
        libm::pow(self, exponent)
    }

    #[inline(always)]
    fn cosine_and_sine(self) -> [Self; 2] {
        let (sine, cosine) = math::sin_cos(self);
        [cosine, sine]
    }

    #[inline(always)]
    fn cosines_and_sines<const L: usize>(lane: Lane<Self, L>) -> [Lane<Self, L>; 2] {
        turn::cosine_and_sine(lane)
    }

    #[inline(always)]
    fn arc_tangent(self, x: Self) -> Self {
        libm::atan2(self, x)
    }

    #[inline(always)]
    fn hyperbolic_tangent(self) -> [Self; 2] {
        [libm::tanh(self), math::steepness(self)]
    }
}

#[cfg(test)]
pub(crate) mod operations {
    use super::Elementary;

    pub type Operation<N> = fn(N, N) -> N;

    /// |a|
    fn size<N: Elementary>(a: N) -> N {
        (a * a).root()
    }

    /// All operations of a kind of number, with their names.
    pub fn operations<N: Elementary>() -> [(&'static str, Operation<N>); 18] {
        [
            ("a + b", |a, b| a + b),
            ("a - b", |a, b| a - b),
            ("a b", |a, b| a * b),
            ("-a", |a, _| -a),
            ("a += b", |mut a, b| {
                a += b;
                a
            }),
            ("a -= b", |mut a, b| {
                a -= b;
                a
            }),
            ("a / b", N::over),
            ("3 a", |a, _| a.times(3.0)),
            ("root", |a, _| size(a).root()),
            ("log", |a, _| size(a).logarithm()),
            ("exp", |a, _| a.exponential()),
            ("a^b", |a, b| size(a).power(b)),
            ("|a|", |a, _| size(a)),
            ("tanh", |a, _| a.hyperbolic_tangent()[0]),
            ("its slope", |a, _| a.hyperbolic_tangent()[1]),
            ("cos", |a, _| a.cosine_and_sine()[0]),
            ("sin", |a, _| a.cosine_and_sine()[1]),
            ("atan2", N::arc_tangent),
        ]
    }
}
