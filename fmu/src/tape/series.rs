//! Running a tape on truncated Taylor series: each register holds the first coefficients of a function of time.
//!
//! Where a function has no derivative (a step, a corner) the series of the active side is taken. What does not move stays a constant even
//! where the slope is infinite.

use super::Operation;
use super::field::Field;
use crate::math;

/// The highest order kept.
pub const ORDER: usize = 4;
/// Integer powers up to this are products; beyond, and for all others, the base must not be zero.
const PRODUCTS: f64 = 32.0;

/// The coefficients of 1, t, t^2, ... of a function of time t.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Series(pub [f64; ORDER + 1]);

impl Field for Series {
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }

    fn subtract(self, other: Self) -> Self {
        self.add(other.scale(-1.0))
    }

    fn multiply(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| (0..=k).map(|j| self.0[j] * other.0[k - j]).sum()))
    }

    fn divide(self, divisor: Self) -> Self {
        let mut quotient = Self::default();
        for k in 0..=ORDER {
            let known: f64 = (1..=k).map(|j| divisor.0[j] * quotient.0[k - j]).sum();
            quotient.0[k] = (self.0[k] - known) / divisor.0[0];
        }
        quotient
    }

    fn negate(self) -> Self {
        self.scale(-1.0)
    }

    fn square_root(self) -> Self {
        self.map(self.0[0].sqrt(), |root| Self::constant(0.5).divide(root))
    }

    fn sine_and_cosine(self) -> [Self; 2] {
        let values = math::sin_cos(self.0[0]);
        let (mut sine, mut cosine) = (Self::constant(values.0), Self::constant(values.1));
        for _ in 0..ORDER {
            let next = cosine.multiply(self.rate()).integral(values.0);
            cosine = sine.multiply(self.rate()).negate().integral(values.1);
            sine = next;
        }
        [sine, cosine]
    }

    fn function(operation: Operation, operands: [Self; 3]) -> Self {
        operation.series(operands)
    }
}

impl Series {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        let mut series = Self::default();
        series.0[0] = value;
        series
    }

    /// The derivative of that order at t = 0.
    pub fn derivative(&self, order: usize) -> f64 {
        (1..=order).fold(self.0[order], |value, factor| value * factor as f64)
    }

    /// d/dt; the last coefficient is lost.
    pub fn rate(&self) -> Self {
        Self(std::array::from_fn(|k| if k < ORDER { (k + 1) as f64 * self.0[k + 1] } else { 0.0 }))
    }

    /// The integral that starts from this value.
    pub fn integral(&self, start: f64) -> Self {
        Self(std::array::from_fn(|k| if k == 0 { start } else { self.0[k - 1] / k as f64 }))
    }

    fn moves(&self) -> bool {
        self.0[1..].iter().any(|coefficient| *coefficient != 0.0)
    }

    pub(super) fn plus(mut self, value: f64) -> Self {
        self.0[0] += value;
        self
    }

    pub(super) fn scale(self, factor: f64) -> Self {
        Self(self.0.map(|coefficient| factor * coefficient))
    }

    /// f(self) from its first value and its slope, which may depend on f: each round is right to one order more.
    pub(super) fn map(self, value: f64, slope: impl Fn(Self) -> Self) -> Self {
        let mut result = Self::constant(value);
        if self.moves() {
            for _ in 0..ORDER {
                result = slope(result).multiply(self.rate()).integral(value);
            }
        }
        result
    }

    /// 1 / sqrt(1 - a^2)
    pub(super) fn arc_slope(self) -> Self {
        let square = self.multiply(self).scale(-1.0).plus(1.0);
        Self::constant(1.0).divide(square.square_root())
    }

    /// atan2(self, x)
    pub(super) fn arc_tangent(self, x: Self) -> Self {
        let value = libm::atan2(self.0[0], x.0[0]);
        if !self.moves() && !x.moves() {
            return Self::constant(value);
        }
        let turning = x.multiply(self.rate()).subtract(self.multiply(x.rate()));
        turning.divide(self.multiply(self).add(x.multiply(x))).integral(value)
    }

    pub(super) fn power(self, exponent: Self) -> Self {
        let (base, power) = (self.0[0], exponent.0[0]);
        let value = libm::pow(base, power);
        if exponent.moves() {
            let logarithm = self.map(libm::log(base), |_| Self::constant(1.0).divide(self));
            return exponent.multiply(logarithm).map(value, |value| value);
        }
        if power == power.floor() && (0.0..=PRODUCTS).contains(&power) {
            let mut product = (0..power as u32).fold(Self::constant(1.0), |product, _| product.multiply(self));
            product.0[0] = value;
            return product;
        }
        self.map(value, |value| value.scale(power).divide(self))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Instruction, Tape};
    use super::*;
    use Operation::*;

    fn instruction(operation: Operation) -> Tape {
        let c = if operation == SinCos { 4 } else { 2 };
        Tape::new(vec![Instruction { operation, target: 3, a: 0, b: 1, c }], vec![3])
    }

    fn at(series: &Series, t: f64) -> f64 {
        series.0.iter().rev().fold(0.0, |sum, coefficient| sum * t + coefficient)
    }

    /// The error of the truncated series falls with the fifth power of time.
    #[test]
    fn every_operation_is_right_to_the_last_order() {
        let operands = [
            Series([0.6, 0.3, -0.2, 0.1, 0.05]),
            Series([1.7, -0.4, 0.3, 0.2, -0.1]),
            Series([2.5, 0.1, 0.2, -0.3, 0.4]),
        ];
        for &operation in Operation::ALL {
            let mut series = operands.to_vec();
            series.resize(5, Series::default());
            instruction(operation).run_series(&mut series);
            for result in [3, 4] {
                let error = |t: f64| {
                    let mut registers = [at(&operands[0], t), at(&operands[1], t), at(&operands[2], t), 0.0, 0.0];
                    instruction(operation).run(&mut registers);
                    (registers[result] - at(&series[result], t)).abs()
                };
                let (near, far) = (error(0.01), error(0.02));
                assert!(near < 1e-8 && far < 64.0 * near.max(1e-14), "{operation:?}: {near:e}, {far:e}");
            }
        }
    }

    /// Derivatives of t^2, t^3 about zero, where a logarithm of the base has none.
    #[test]
    fn powers_of_what_passes_zero() {
        let t = Series([0.0, 1.0, 0.0, 0.0, 0.0]);
        assert_eq!(t.power(Series::constant(2.0)), Series([0.0, 0.0, 1.0, 0.0, 0.0]));
        assert_eq!(t.power(Series::constant(3.0)).derivative(3), 6.0);
    }

    #[test]
    fn what_stands_still_has_no_derivative_even_at_infinite_slopes() {
        for operation in [SquareRoot, Logarithm, ArcTangent2] {
            let mut registers = [Series::default(); 5];
            instruction(operation).run_series(&mut registers);
            assert!(registers[3].0[1..].iter().all(|coefficient| *coefficient == 0.0), "{operation:?}");
        }
    }

    #[test]
    fn integrals_and_rates_are_inverse() {
        let series = Series([0.5, 1.0, 2.0, 3.0, 0.0]);
        assert_eq!(series.integral(7.0).rate(), series);
        assert_eq!(Series([1.0, 2.0, 3.0, 4.0, 5.0]).derivative(4), 120.0);
    }
}
