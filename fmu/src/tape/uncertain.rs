//! A number with a bound of its error, to first order: what a tape makes of the errors of what it reads.
//!
//! Errors of operands add up by the absolute slopes and never cancel (running error analysis: Higham, *Accuracy and Stability of Numerical Algorithms*, 3.3). So a small difference of large numbers
//! has the errors of these numbers.

use super::Operation;
use super::field::Field;
use super::field::of_two;

/// A value, and by how much it may be wrong.
#[derive(Clone, Copy)]
pub(super) struct Uncertain {
    pub value: f64,
    pub error: f64,
}

impl Uncertain {
    /// The result of an operation, which rounds once.
    #[inline(always)]
    fn rounded(value: f64, error: f64) -> Self {
        Self { value, error: error + f64::EPSILON * value.abs() }
    }
}

impl Field for Uncertain {
    of_two! {
        self, other:
        add = Self::rounded(self.value + other.value, self.error + other.error);
        subtract = Self::rounded(self.value - other.value, self.error + other.error);
        multiply = {
            let error = self.value.abs() * other.error + (other.value.abs() + other.error) * self.error;
            Self::rounded(self.value * other.value, error)
        };
        divide = {
            let value = self.value / other.value;
            Self::rounded(value, (self.error + value.abs() * other.error) / other.value.abs())
        };
    }

    #[inline(always)]
    fn negate(self) -> Self {
        Self { value: -self.value, error: self.error }
    }

    /// The slope is infinite at zero, where loops are closed; the increase is not.
    #[inline(always)]
    fn square_root(self) -> Self {
        let root = self.value.sqrt();
        Self::rounded(root, (self.value + self.error).sqrt() - root)
    }

    #[inline(always)]
    fn sine_and_cosine(self) -> [Self; 2] {
        let [sine, cosine] = self.value.sine_and_cosine();
        let error = |slope: f64| slope.abs() * self.error;
        [Self::rounded(sine, error(cosine)), Self::rounded(cosine, error(sine))]
    }

    #[inline(always)]
    fn function(operation: Operation, operands: [Self; 3]) -> Self {
        let values = operands.map(|operand| operand.value);
        let value = operation.value(values);
        // At its corner the slope is none.
        if operation == Operation::Absolute {
            return Self { value, error: operands[0].error };
        }
        let error = (0..operation.operands()).fold(0.0, |sum, index| {
            let mut direction = [0.0; 3];
            direction[index] = operands[index].error;
            sum + operation.slope(value, values, direction).abs()
        });
        Self::rounded(value, error)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Instruction, Tape};
    use super::Operation::{self, *};
    use crate::math::Random;

    const OPERANDS: [[f64; 3]; 3] = [[0.6, 1.7, 2.5], [0.3, 0.2, -1.0], [0.9, -0.4, 0.1]];

    fn tape(operation: Operation) -> Tape {
        let c = if operation == SinCos { 4 } else { 2 };
        Tape::new(vec![Instruction { operation, target: 3, a: 0, b: 1, c }], vec![3])
    }

    fn errors_of(operation: Operation, [a, b, c]: [f64; 3], [da, db, dc]: [f64; 3]) -> f64 {
        let (mut registers, mut errors) = ([a, b, c, 0.0, 0.0], [da, db, dc, 0.0, 0.0]);
        tape(operation).run_errors(&mut registers, &mut errors);
        errors[3]
    }

    /// Operands that are wrong by no more than their errors give no result that is wrong by more than its error; and some of them nearly that.
    #[test]
    fn every_operation_bounds_what_wrong_operands_do() {
        let mut random = Random::new(1);
        for &operation in Operation::ALL {
            for point in OPERANDS {
                let errors = [1e-6, 3e-6, 2e-6];
                let bound = errors_of(operation, point, errors);
                let at = |point: [f64; 3]| {
                    let [a, b, c] = point;
                    let mut registers = [a, b, c, 0.0, 0.0];
                    tape(operation).run(&mut registers);
                    registers[3]
                };
                let mut most: f64 = 0.0;
                for _ in 0..200 {
                    let wrong = std::array::from_fn(|i| point[i] + errors[i] * random.symmetric().signum());
                    most = most.max((at(wrong) - at(point)).abs());
                }
                assert!(
                    most <= bound * 1.001 && bound <= 1.001 * most + 1e-15,
                    "{operation:?} {point:?}: {most} {bound}"
                );
            }
        }
    }

    /// A difference has the errors of its operands, and a length that is zero that of its components.
    #[test]
    fn differences_keep_the_errors_of_their_operands() {
        assert!((errors_of(Subtract, [1e3, 1e3, 0.0], [1e-9, 1e-9, 0.0]) - 2e-9).abs() < 1e-14);
        assert!((errors_of(SquareRoot, [0.0; 3], [1e-22, 0.0, 0.0]) - 1e-11).abs() < 1e-25);
        assert_eq!(errors_of(Absolute, [0.0; 3], [1e-9, 0.0, 0.0]), 1e-9);
    }
}
