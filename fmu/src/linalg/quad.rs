//! One number of each of four motions: what is written for any kind of number gives those of all four at once, each rounded as if it were alone.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::lane::{Lane, WIDTH, ZERO, add, at_each, larger, multiply, splat, subtract};
use super::number::{Elementary, Number};
use super::turn;
use crate::math;

/// A number of each motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Quad(Lane);

/// In each place what an expression says.
macro_rules! each {
    ($i:ident => $value:expr) => {{
        let mut quad = Quad::ZERO;
        at_each!(WIDTH, $i => quad.0[$i] = $value);
        quad
    }};
}

impl Quad {
    /// These numbers.
    #[inline(always)]
    pub fn of(numbers: Lane) -> Self {
        Self(numbers)
    }

    /// All numbers.
    #[inline(always)]
    pub fn numbers(self) -> Lane {
        self.0
    }

    /// The number of one motion.
    #[inline(always)]
    pub fn get(&self, member: usize) -> f64 {
        self.0[member]
    }

    /// Replaces the number of one motion.
    #[inline(always)]
    pub fn set(&mut self, member: usize, value: f64) {
        self.0[member] = value;
    }

    /// The larger magnitudes, or NaN.
    #[inline(always)]
    pub fn larger(self, other: Self) -> Self {
        Self(larger(self.0, other.0))
    }

    /// What a function gives for the number of each motion.
    #[inline(always)]
    pub fn map(self, function: impl Fn(f64) -> f64) -> Self {
        each!(i => function(self.0[i]))
    }

    /// What a function gives for two numbers of each motion.
    #[inline(always)]
    pub fn with(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        each!(i => function(self.0[i], other.0[i]))
    }

    /// The number of another quad where this is so of a motion.
    #[inline(always)]
    pub fn replaced(self, other: Self, so: [bool; WIDTH]) -> Self {
        each!(i => if so[i] { other.0[i] } else { self.0[i] })
    }
}

impl Add for Quad {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(add(self.0, other.0))
    }
}

impl Sub for Quad {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(subtract(self.0, other.0))
    }
}

impl Mul for Quad {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(multiply(self.0, other.0))
    }
}

impl Neg for Quad {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each!(i => -self.0[i])
    }
}

impl AddAssign for Quad {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Quad {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Number for Quad {
    const ZERO: Self = Self(ZERO);

    #[inline(always)]
    fn all(value: f64) -> Self {
        Self(splat(value))
    }

    /// The number of the first motion: decisions are not made for four motions at once.
    #[inline(always)]
    fn value(self) -> f64 {
        self.0[0]
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        each!(i => self.0[i] / other.0[i])
    }

    #[inline(always)]
    fn times(self, c: f64) -> Self {
        Self(multiply(splat(c), self.0))
    }
}

impl Elementary for Quad {
    #[inline(always)]
    fn root(self) -> Self {
        each!(i => self.0[i].sqrt())
    }

    fn logarithm(self) -> Self {
        Self(self.0.map(libm::log))
    }

    fn exponential(self) -> Self {
        Self(self.0.map(libm::exp))
    }

    fn power(self, exponent: Self) -> Self {
        each!(i => libm::pow(self.0[i], exponent.0[i]))
    }

    #[inline(always)]
    fn cosine_and_sine(self) -> [Self; 2] {
        turn::cosine_and_sine(self.0).map(Self)
    }

    fn arc_tangent(self, x: Self) -> Self {
        each!(i => libm::atan2(self.0[i], x.0[i]))
    }

    fn hyperbolic_tangent(self) -> [Self; 2] {
        [Self(self.0.map(libm::tanh)), Self(self.0.map(math::steepness))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::number::operations::operations;

    #[test]
    fn every_motion_has_the_bits_that_it_has_alone() {
        let (a, b) = (Quad([0.6, -2.3, 1e9, -0.0]), Quad([1.7, 0.4, -3.0, 2.0]));
        for ((name, together), (_, alone)) in operations::<Quad>().into_iter().zip(operations::<f64>()) {
            let found = together(a, b);
            for member in 0..WIDTH {
                let expected = alone(a.get(member), b.get(member));
                assert_eq!(found.get(member).to_bits(), expected.to_bits(), "{name}, {member}");
            }
        }
    }
}
