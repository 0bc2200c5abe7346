//! A number with its derivatives along some directions: what a tape finds together with its own derivatives.
//!
//! Where a function has no derivative (a step, a corner) the one of the active side is taken. What does not move has derivative zero even
//! where the slope is infinite, as that of a square root at zero is; nor does a quotient whose divisor is.

use super::Operation;
use super::field::{Field, Real, of_two};

/// A value and its derivatives.
#[derive(Clone, Copy)]
pub(super) struct Tangent<V, const D: usize> {
    pub value: V,
    pub along: [V; D],
}

impl<V: Real, const D: usize> Tangent<V, D> {
    /// This value, with derivatives from those of this number and another one.
    #[inline(always)]
    fn with(&self, other: &Self, value: V, of: impl Fn(V, V) -> V) -> Self {
        let mut along = self.along;
        for i in 0..D {
            along[i] = of(self.along[i], other.along[i]);
        }
        Self { value, along }
    }

    /// This value, with derivatives from those of this number.
    #[inline(always)]
    fn of(&self, value: V, of: impl Fn(V) -> V) -> Self {
        self.with(self, value, |tangent, _| of(tangent))
    }
}

impl<V: Real, const D: usize> Field for Tangent<V, D> {
    of_two! {
        self, other:
        add = self.with(&other, self.value.add(other.value), V::add);
        subtract = self.with(&other, self.value.subtract(other.value), V::subtract);
        multiply = {
            let [a, b] = [self.value, other.value];
            self.with(&other, a.multiply(b), |da, db| b.chain(da).add(a.chain(db)))
        };
        divide = {
            let (value, divisor) = (self.value.divide(other.value), other.value);
            self.with(&other, value, |da, db| da.subtract(db.chain(value)).divide(divisor))
        };
    }

    #[inline(always)]
    fn negate(self) -> Self {
        self.of(self.value.negate(), |da| da.negate())
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        let root = self.value.square_root();
        let slope = V::constant(0.5).divide(root);
        self.of(root, |da| slope.chain(da))
    }

    #[inline(always)]
    fn sine_and_cosine(self) -> [Self; 2] {
        let [sine, cosine] = self.value.sine_and_cosine();
        let falling = sine.negate();
        [self.of(sine, |da| cosine.chain(da)), self.of(cosine, |da| falling.chain(da))]
    }

    #[inline(always)]
    fn function(operation: Operation, [a, b, c]: [Self; 3]) -> Self {
        let operands = [a.value, b.value, c.value];
        let value = V::function(operation, operands);
        let mut along = a.along;
        for i in 0..D {
            along[i] = V::slope(operation, value, operands, [a.along[i], b.along[i], c.along[i]]);
        }
        Self { value, along }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Instruction, Tape};
    use super::Operation::{self, *};

    /// Values and derivatives of both results.
    fn apply(operation: Operation, point: [f64; 3], direction: [f64; 3]) -> [[f64; 2]; 2] {
        let c = if operation == SinCos { 4 } else { 2 };
        let tape = Tape::new(vec![Instruction { operation, target: 3, a: 0, b: 1, c }], vec![3]);
        let [mut registers, mut tangents] = [point, direction].map(|[a, b, c]| [a, b, c, 0.0, 0.0]);
        tape.run_tangent(&mut registers, &mut tangents);
        [[registers[3], registers[4]], [tangents[3], tangents[4]]]
    }

    #[test]
    fn every_operation_agrees_with_differences() {
        let h = 1e-5;
        for &operation in Operation::ALL {
            for point in [[0.6, 1.7, 2.5], [0.3, 0.2, -1.0], [0.9, -0.4, 0.1]] {
                for direction in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.3, -0.7, 0.2]] {
                    let at = |s: f64| apply(operation, std::array::from_fn(|i| point[i] + s * direction[i]), direction);
                    let [_, tangent] = at(0.0);
                    let ([above, _], [below, _]) = (at(h), at(-h));
                    for k in 0..2 {
                        let difference = (above[k] - below[k]) / (2.0 * h);
                        assert!(
                            (tangent[k] - difference).abs() < 1e-6,
                            "{operation:?} {point:?} {direction:?}: {tangent:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_target_may_be_an_operand() {
        let square = Instruction { operation: Multiply, target: 0, a: 0, b: 0, c: 0 };
        let (mut registers, mut tangents) = ([3.0], [2.0]);
        Tape::new(vec![square, square], vec![0]).run_tangent(&mut registers, &mut tangents);
        assert_eq!((registers, tangents), ([81.0], [4.0 * 27.0 * 2.0]));
    }

    #[test]
    fn what_stands_still_has_no_derivative_even_at_infinite_slopes() {
        for (operation, point) in
            [(SquareRoot, [0.0; 3]), (ArcSine, [1.0; 3]), (Logarithm, [0.0; 3]), (Power, [0.0, 0.5, 0.0])]
        {
            assert_eq!(apply(operation, point, [0.0; 3])[1][0], 0.0, "{operation:?}");
        }
        assert_eq!(apply(Absolute, [0.0; 3], [1.0; 3])[1][0], 0.0);
        // 1/(1 + exp a) where exp a is beyond all numbers.
        assert_eq!(apply(Divide, [1.0, f64::INFINITY, 0.0], [0.0, f64::INFINITY, 0.0])[1][0], 0.0);
        assert_eq!(apply(Power, [-2.0, 2.0, 0.0], [1.0, 0.0, 0.0])[1][0], -4.0);
    }
}
