//! Running a tape together with its derivative along one direction: a second register file holds the derivative of the first.
//!
//! Where a function has no derivative (a step, a corner) the one of the active side is taken. What does not move has derivative zero even
//! where the slope is infinite, as that of a square root at zero is; nor does a quotient whose divisor is.

use super::{Instruction, Operation, Tape};

impl Tape {
    /// Runs the tape over `registers`, and its derivative over `tangents`, whose entries for what the tape reads are the direction.
    ///
    /// # Panics
    /// As [`Tape::run`]; both files must have the same size.
    pub fn run_tangent(&self, registers: &mut [f64], tangents: &mut [f64]) {
        for instruction in self.instructions() {
            instruction.run_tangent(registers, tangents);
        }
    }
}

impl Instruction {
    #[inline]
    fn run_tangent(&self, registers: &mut [f64], tangents: &mut [f64]) {
        // Operands first: the target may be one of them.
        let mut operands = [self.a, self.b, self.c].map(|register| registers[register as usize]);
        let directions = [self.a, self.b, self.c].map(|register| tangents[register as usize]);
        self.run(registers);
        let value = registers[self.target as usize];
        if self.operation == Operation::SinCos {
            // The second result, at c, is the cosine.
            operands[2] = registers[self.c as usize];
            tangents[self.c as usize] = chain(-value, directions[0]);
        }
        tangents[self.target as usize] = self.operation.tangent(value, operands, directions);
    }
}

/// slope * direction, but nothing for nothing.
pub(super) fn chain(slope: f64, direction: f64) -> f64 {
    if direction == 0.0 { 0.0 } else { slope * direction }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Operation::*;

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
