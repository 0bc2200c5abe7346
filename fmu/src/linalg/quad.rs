//! One number of each of four motions: what is written for any kind of number gives those of all four at once, each rounded as if it were alone.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::inverse::Inverse;
use super::lane::{Lane, WIDTH, ZERO, add, at_each, multiply, splat, subtract};
use super::matrix::Solve;
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
    /// The number of one motion.
    #[inline(always)]
    pub fn get(self, member: usize) -> f64 {
        self.0[member]
    }

    /// Replaces the number of one motion.
    #[inline(always)]
    pub fn set(&mut self, member: usize, value: f64) {
        self.0[member] = value;
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

/// The inverses of the matrices of four poses.
#[derive(Clone, Debug)]
pub(crate) struct Inverses {
    /// Where the solution of each equation goes.
    targets: Vec<usize>,
    /// By columns: those of a solution lie side by side.
    entries: Vec<Quad>,
}

impl Inverses {
    /// For solutions at these places.
    pub fn new(targets: Vec<usize>) -> Self {
        Self { entries: vec![Quad::ZERO; targets.len() * targets.len()], targets }
    }

    /// Takes the inverse of one motion over.
    pub fn take(&mut self, member: usize, inverse: &Inverse) {
        let size = self.targets.len();
        for (column, entries) in self.entries.chunks_exact_mut(size.max(1)).enumerate() {
            for (row, entry) in entries.iter_mut().enumerate() {
                entry.set(member, inverse.entry(row, column));
            }
        }
    }
}

impl Solve<Quad> for Inverses {
    fn none() -> Self {
        Self::new(Vec::new())
    }

    /// In the order of [`Inverse::times`].
    #[inline(always)]
    fn solve(&mut self, vector: &[Quad], solution: &mut [Quad]) {
        let size = self.targets.len();
        let vector = &vector[..size];
        for (column, &target) in self.targets.iter().enumerate() {
            let entries = &self.entries[column * size..][..size];
            let (mut even, mut odd, mut i) = (Quad::ZERO, Quad::ZERO, 0);
            while i + 1 < size {
                even += entries[i] * vector[i];
                odd += entries[i + 1] * vector[i + 1];
                i += 2;
            }
            if i < size {
                even += entries[i] * vector[i];
            }
            solution[target] = even + odd;
        }
    }

    fn solve_rest(&self, _: usize, _: &[Quad], _: &mut [Quad]) -> bool {
        false
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
