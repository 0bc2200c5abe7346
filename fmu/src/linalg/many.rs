//! Real numbers of one motion, or of several motions at once: what is written for either serves for both.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::lane::{self, Lane, WIDTH, ZERO, add, multiply, splat, subtract};
use super::turn::cosine_and_sine;

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

/// The same number of four motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Many(pub Lane);

/// One operation on each of them, without a loop: unrolling them wherever numbers meet took a third of all compilation.
macro_rules! each {
    ($i:ident => $value:expr) => {
        [
            {
                let $i = 0;
                $value
            },
            {
                let $i = 1;
                $value
            },
            {
                let $i = 2;
                $value
            },
            {
                let $i = 3;
                $value
            },
        ]
    };
}

impl Add for Many {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(add(self.0, other.0))
    }
}

impl Sub for Many {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(subtract(self.0, other.0))
    }
}

impl Mul for Many {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(multiply(self.0, other.0))
    }
}

impl Neg for Many {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(each!(i => -self.0[i]))
    }
}

impl AddAssign for Many {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Many {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Number for Many {
    const ZERO: Self = Self(ZERO);
    type Which = [bool; WIDTH];

    #[inline(always)]
    fn all(value: f64) -> Self {
        Self(splat(value))
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        Self(each!(i => self.0[i] / other.0[i]))
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        Self::all(1.0).over(self)
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        Self(each!(i => self.0[i].abs()))
    }

    #[inline(always)]
    fn times(self, c: f64) -> Self {
        self * Self::all(c)
    }

    #[inline(always)]
    fn exceeds(self, bound: Self) -> [bool; WIDTH] {
        each!(i => self.0[i] > bound.0[i])
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(lane::larger(self.0, other.0))
    }

    #[inline(always)]
    fn is_below(self, bound: f64) -> [bool; WIDTH] {
        Self::all(bound).exceeds(self)
    }

    #[inline(always)]
    fn unless(self, which: [bool; WIDTH]) -> Self {
        Self(each!(i => if which[i] { 0.0 } else { self.0[i] }))
    }
}

impl Elementary for Many {
    #[inline(always)]
    fn root(self) -> Self {
        Self(each!(i => self.0[i].sqrt()))
    }

    fn logarithm(self) -> Self {
        Self(self.0.map(libm::log))
    }

    fn power(self, exponent: Self) -> Self {
        Self(each!(i => libm::pow(self.0[i], exponent.0[i])))
    }

    #[inline(always)]
    fn cosine_and_sine(self) -> [Self; 2] {
        cosine_and_sine(self.0).map(Self)
    }

    fn arc_tangent(self, x: Self) -> Self {
        Self(each!(i => libm::atan2(self.0[i], x.0[i])))
    }
}

impl Which for [bool; WIDTH] {
    const ALL: Self = [true; WIDTH];

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        each!(i => self[i] & other[i])
    }

    #[inline(always)]
    fn is_none(self) -> bool {
        self == [false; WIDTH]
    }

    #[inline(always)]
    fn is_all(self) -> bool {
        self == [true; WIDTH]
    }
}
