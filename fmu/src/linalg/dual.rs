//! Dual numbers: a value with its derivatives along several directions, each operation with its chain rule.
//!
//! What is written for any kind of number gives, in dual numbers, its own derivatives, exactly. A direction does not know of the others: its bits are the same alone.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::lane::{Lane, WIDTH, ZERO, add, at_each, multiply, splat, subtract};
use super::number::{Elementary, Number};
use crate::math;

/// A value, in every place of a lane so that it meets each tangent without being moved, and its derivatives along `D` directions: whole lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Dual<const D: usize> {
    value: Lane,
    tangents: [f64; D],
}

/// The derivative along direction i, which lies in place j of its lane.
macro_rules! along {
    ($value:expr, $i:ident, $j:ident => $tangent:expr) => {{
        let mut tangents = [0.0; D];
        at_each!(D, $i => {
            let $j = $i % WIDTH;
            tangents[$i] = $tangent;
        });
        Self { value: $value, tangents }
    }};
}

impl<const D: usize> Dual<D> {
    /// A value and its derivatives.
    #[inline(always)]
    pub fn new(value: f64, tangents: [f64; D]) -> Self {
        Self { value: splat(value), tangents }
    }

    #[inline(always)]
    pub fn tangents(&self) -> &[f64; D] {
        &self.tangents
    }

    /// f of a value, with the slope of f there.
    #[inline(always)]
    fn chained(self, value: f64, slope: f64) -> Self {
        along!(splat(value), i, _j => slope * self.tangents[i])
    }
}

impl<const D: usize> Add for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        along!(add(self.value, other.value), i, _j => self.tangents[i] + other.tangents[i])
    }
}

impl<const D: usize> Sub for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        along!(subtract(self.value, other.value), i, _j => self.tangents[i] - other.tangents[i])
    }
}

impl<const D: usize> Mul for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let [a, b] = [self.value, other.value];
        along!(multiply(a, b), i, j => self.tangents[i] * b[j] + a[j] * other.tangents[i])
    }
}

impl<const D: usize> Neg for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        along!(self.value.map(|value| -value), i, _j => -self.tangents[i])
    }
}

impl<const D: usize> AddAssign for Dual<D> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const D: usize> SubAssign for Dual<D> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const D: usize> Default for Dual<D> {
    fn default() -> Self {
        Self::ZERO
    }
}

impl<const D: usize> Number for Dual<D> {
    const ZERO: Self = Self { value: ZERO, tangents: [0.0; D] };

    #[inline(always)]
    fn all(value: f64) -> Self {
        Self::new(value, [0.0; D])
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value[0]
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        let (value, inverse) = (self.value() / other.value(), 1.0 / other.value());
        along!(splat(value), i, _j => (self.tangents[i] - value * other.tangents[i]) * inverse)
    }

    #[inline(always)]
    fn times(self, c: f64) -> Self {
        along!(multiply(splat(c), self.value), i, _j => c * self.tangents[i])
    }
}

impl<const D: usize> Elementary for Dual<D> {
    #[inline(always)]
    fn root(self) -> Self {
        let root = self.value().sqrt();
        self.chained(root, 0.5 / root)
    }

    fn logarithm(self) -> Self {
        self.chained(libm::log(self.value()), 1.0 / self.value())
    }

    fn exponential(self) -> Self {
        let value = libm::exp(self.value());
        self.chained(value, value)
    }

    fn power(self, exponent: Self) -> Self {
        let value = libm::pow(self.value(), exponent.value());
        let slope = exponent.value() * libm::pow(self.value(), exponent.value() - 1.0);
        let growth = value * libm::log(self.value());
        // An exponent that stands still does not ask for the logarithm.
        let other = |tangent: f64| if tangent == 0.0 { 0.0 } else { growth * tangent };
        along!(splat(value), i, _j => slope * self.tangents[i] + other(exponent.tangents[i]))
    }

    #[inline(always)]
    fn cosine_and_sine(self) -> [Self; 2] {
        let (sine, cosine) = math::sin_cos(self.value());
        [self.chained(cosine, -sine), self.chained(sine, cosine)]
    }

    fn arc_tangent(self, x: Self) -> Self {
        let inverse = 1.0 / (self.value() * self.value() + x.value() * x.value());
        let [by_y, by_x] = [x.value() * inverse, self.value() * inverse];
        let angle = libm::atan2(self.value(), x.value());
        along!(splat(angle), i, _j => by_y * self.tangents[i] - by_x * x.tangents[i])
    }

    fn hyperbolic_tangent(self) -> [Self; 2] {
        let [value, slope] = self.value().hyperbolic_tangent();
        [self.chained(value, slope), self.chained(slope, -2.0 * value * slope)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::number::operations::operations;

    const DIRECTIONS: usize = 4;
    type Dual = super::Dual<DIRECTIONS>;

    fn dual(value: f64, tangent: f64, place: usize) -> Dual {
        let mut dual = Dual::all(value);
        dual.tangents[place] = tangent;
        dual
    }

    #[test]
    fn every_operation_agrees_with_differences() {
        let h = 1e-5;
        for (name, operation) in operations::<Dual>() {
            for [a, b] in [[0.6, 1.7], [-2.3, 0.4], [1.1, -0.8], [-0.3, -2.0]] {
                for [da, db] in [[1.0, 0.0], [0.0, 1.0], [0.3, -0.7]] {
                    let at = |s: f64| operation(Dual::all(a + s * da), Dual::all(b + s * db)).value();
                    let difference = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
                    for place in 0..DIRECTIONS {
                        let found = operation(dual(a, da, place), dual(b, db, place));
                        assert_eq!(found.value().to_bits(), at(0.0).to_bits(), "{name}");
                        for (index, tangent) in found.tangents.iter().enumerate() {
                            let expected = if index == place { difference } else { 0.0 };
                            assert!((tangent - expected).abs() < 1e-9, "{name} {a} {b}: {tangent} {expected}");
                        }
                    }
                }
            }
        }
    }
}
