//! Real numbers of one motion, or of several motions at once: what is written for either serves for both.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::lane::{self, at_each};
use super::turn::cosines_and_sines;

/// A real number, or several that take part in the same operations.
pub(crate) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self> + AddAssign + SubAssign
{
    /// Nothing.
    const ZERO: Self;
    /// Is a full matrix of few rows faster than sparse factors? Its loops are unrolled for each size, so where it gains nothing it is not compiled.
    const FULL: bool = true;
    /// For which of them something is true.
    type Which: Which;

    /// The same for all.
    fn all(value: f64) -> Self;
    /// self / other
    fn over(self, other: Self) -> Self;
    /// 1 / self
    fn reciprocal(self) -> Self;
    /// |self|
    fn magnitude(self) -> Self;
    /// c self
    fn times(self, c: f64) -> Self;
    /// The larger magnitude of each; NaN stays.
    fn larger(self, other: Self) -> Self;
    /// Which of them are larger than a bound? Not a number is not.
    fn exceeds(self, bound: Self) -> Self::Which;
    /// Which of them, and of what belongs to them, are smaller than a bound? Not a number is not.
    fn is_below(self, bound: f64) -> Self::Which;
    /// Nothing where something is true.
    fn unless(self, which: Self::Which) -> Self;
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

/// Truth values.
pub(crate) trait Which: Copy {
    /// True for all.
    const ALL: Self;
    /// Where both are true.
    fn and(self, other: Self) -> Self;
    /// Is none true?
    fn is_none(self) -> bool;
    /// Are all true?
    fn is_all(self) -> bool;
}

impl Number for f64 {
    const ZERO: Self = 0.0;
    type Which = bool;

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

    #[inline(always)]
    fn is_below(self, bound: f64) -> bool {
        self < bound
    }

    #[inline(always)]
    fn unless(self, which: bool) -> Self {
        if which { 0.0 } else { self }
    }
}

impl Which for bool {
    const ALL: Self = true;

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self && other
    }

    #[inline(always)]
    fn is_none(self) -> bool {
        !self
    }

    #[inline(always)]
    fn is_all(self) -> bool {
        self
    }
}

/// The same number of W motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Many<const W: usize>(pub [f64; W]);

/// One operation on each of them.
macro_rules! each {
    ($i:ident => $value:expr) => {{
        let mut result = [0.0; W];
        at_each!(W, $i => result[$i] = $value);
        Self(result)
    }};
}

impl<const W: usize> Add for Many<W> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        each!(i => self.0[i] + other.0[i])
    }
}

impl<const W: usize> Sub for Many<W> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        each!(i => self.0[i] - other.0[i])
    }
}

impl<const W: usize> Mul for Many<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        each!(i => self.0[i] * other.0[i])
    }
}

impl<const W: usize> Neg for Many<W> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each!(i => -self.0[i])
    }
}

impl<const W: usize> AddAssign for Many<W> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const W: usize> SubAssign for Many<W> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const W: usize> Number for Many<W> {
    const ZERO: Self = Self([0.0; W]);
    type Which = [bool; W];

    #[inline(always)]
    fn all(value: f64) -> Self {
        Self([value; W])
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        each!(i => self.0[i] / other.0[i])
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        Self::all(1.0).over(self)
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        each!(i => self.0[i].abs())
    }

    #[inline(always)]
    fn times(self, c: f64) -> Self {
        self * Self::all(c)
    }

    #[inline(always)]
    fn exceeds(self, bound: Self) -> [bool; W] {
        let mut result = [false; W];
        at_each!(W, i => result[i] = self.0[i] > bound.0[i]);
        result
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        each!(i => lane::above(self.0[i], other.0[i]))
    }

    #[inline(always)]
    fn is_below(self, bound: f64) -> [bool; W] {
        Self::all(bound).exceeds(self)
    }

    #[inline(always)]
    fn unless(self, which: [bool; W]) -> Self {
        each!(i => if which[i] { 0.0 } else { self.0[i] })
    }
}

impl<const W: usize> Elementary for Many<W> {
    #[inline(always)]
    fn root(self) -> Self {
        each!(i => self.0[i].sqrt())
    }

    fn logarithm(self) -> Self {
        Self(self.0.map(libm::log))
    }

    fn power(self, exponent: Self) -> Self {
        each!(i => libm::pow(self.0[i], exponent.0[i]))
    }

    #[inline(always)]
    fn cosine_and_sine(self) -> [Self; 2] {
        cosines_and_sines(self)
    }

    fn arc_tangent(self, x: Self) -> Self {
        each!(i => libm::atan2(self.0[i], x.0[i]))
    }
}

impl<const W: usize> Which for [bool; W] {
    const ALL: Self = [true; W];

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        let mut result = self;
        at_each!(W, i => result[i] &= other[i]);
        result
    }

    #[inline(always)]
    fn is_none(self) -> bool {
        self == [false; W]
    }

    #[inline(always)]
    fn is_all(self) -> bool {
        self == [true; W]
    }
}
