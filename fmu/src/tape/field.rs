//! What a tape can be run on: a number, four points side by side, either with its derivatives, or the first coefficients of a series in time. Each operation of
//! arithmetic is said once for all of them; what seldom occurs is said by its value, its slope and its series in the table of operations.

use super::file::File;
use super::{Instruction, Operation};
use crate::linalg::lane::{self, Lane, WIDTH};
use crate::linalg::turn::{Angles, cosine_and_sine};
use crate::math;

/// Methods that find something from two numbers.
macro_rules! of_two {
    ($self:ident, $other:ident: $($name:ident = $of:expr;)+) => {
        $(
            #[inline(always)]
            fn $name($self, $other: Self) -> Self {
                $of
            }
        )+
    };
}
pub(super) use of_two;

/// What the registers of a tape hold. Every operation rounds once, in the same way wherever the number stands.
pub(super) trait Field: Copy {
    fn add(self, other: Self) -> Self;
    fn subtract(self, other: Self) -> Self;
    fn multiply(self, other: Self) -> Self;
    fn divide(self, other: Self) -> Self;
    fn negate(self) -> Self;
    fn square_root(self) -> Self;
    fn sine_and_cosine(self) -> [Self; 2];
    /// Any other operation.
    fn function(operation: Operation, operands: [Self; 3]) -> Self;

    /// Runs instructions that are all `SinCos`.
    #[inline(always)]
    fn run_sines_and_cosines<F: File<Value = Self> + ?Sized>(instructions: &[Instruction], file: &mut F) {
        for instruction in instructions {
            file.run_sine_and_cosine(instruction);
        }
    }

    /// Runs instructions that are all this function.
    #[inline(always)]
    fn run_functions<F: File<Value = Self> + ?Sized>(function: Operation, instructions: &[Instruction], file: &mut F) {
        let last = function.operands() - 1;
        for &Instruction { target, a, b, c, .. } in instructions {
            // The last operand stands for those that are not read.
            let operands = [0, 1, 2].map(|k| file.get([a, b, c][last.min(k)]));
            file.set(target, Self::function(function, operands));
        }
    }
}

/// Numbers without derivatives: what a value with derivatives is made of.
pub(super) trait Real: Field {
    fn constant(value: f64) -> Self;
    /// self times a direction, but nothing for nothing: what does not move has derivative zero even where the slope is infinite.
    fn chain(self, direction: Self) -> Self;
    /// Derivative of any other operation, given its value, its operands and their derivatives.
    fn slope(operation: Operation, value: Self, operands: [Self; 3], directions: [Self; 3]) -> Self;
}

impl Field for f64 {
    of_two! { self, other: add = self + other; subtract = self - other; multiply = self * other; divide = self / other; }

    #[inline(always)]
    fn negate(self) -> Self {
        -self
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn sine_and_cosine(self) -> [Self; 2] {
        math::sin_cos(self).into()
    }

    #[inline(always)]
    fn function(operation: Operation, operands: [Self; 3]) -> Self {
        operation.value(operands)
    }

    /// A decision for all of them, not one for each: cams, springs and limits have many.
    #[inline(always)]
    fn run_functions<F: File<Value = f64> + ?Sized>(function: Operation, instructions: &[Instruction], file: &mut F) {
        function.run_values(instructions, file);
    }

    /// Four angles in the time of one and a half, unless one of them is a result of another.
    fn run_sines_and_cosines<F: File<Value = f64> + ?Sized>(instructions: &[Instruction], file: &mut F) {
        for four in instructions.chunks(WIDTH) {
            let written = |a: u32, before: usize| four[..before].iter().any(|first| first.target == a || first.c == a);
            let last = four.len() - 1;
            if last == 0 || four.iter().enumerate().any(|(i, instruction)| written(instruction.a, i)) {
                four.iter().for_each(|instruction| file.run_sine_and_cosine(instruction));
                continue;
            }
            let [cosines, sines] = Angles(std::array::from_fn(|i| file.get(four[i.min(last)].a))).cosines_and_sines();
            for ((instruction, cosine), sine) in four.iter().zip(cosines).zip(sines) {
                file.set(instruction.c, cosine);
                file.set(instruction.target, sine);
            }
        }
    }
}

impl Real for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn chain(self, direction: Self) -> Self {
        if direction == 0.0 { 0.0 } else { self * direction }
    }

    #[inline(always)]
    fn slope(operation: Operation, value: Self, operands: [Self; 3], directions: [Self; 3]) -> Self {
        operation.slope(value, operands, directions)
    }
}

impl Field for Lane {
    of_two! {
        self, other:
        add = lane::add(self, other);
        subtract = lane::subtract(self, other);
        multiply = lane::multiply(self, other);
        divide = [self[0] / other[0], self[1] / other[1], self[2] / other[2], self[3] / other[3]];
    }

    #[inline(always)]
    fn negate(self) -> Self {
        [-self[0], -self[1], -self[2], -self[3]]
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        [self[0].sqrt(), self[1].sqrt(), self[2].sqrt(), self[3].sqrt()]
    }

    #[inline(always)]
    fn sine_and_cosine(self) -> [Self; 2] {
        let [cosine, sine] = cosine_and_sine(self);
        [sine, cosine]
    }

    /// One after the other.
    #[inline(never)]
    fn function(operation: Operation, [a, b, c]: [Self; 3]) -> Self {
        std::array::from_fn(|i| operation.value([a[i], b[i], c[i]]))
    }
}

impl Real for Lane {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        lane::splat(value)
    }

    #[inline(always)]
    fn chain(self, direction: Self) -> Self {
        let product = lane::multiply(self, direction);
        let pick = |i: usize| if direction[i] == 0.0 { 0.0 } else { product[i] };
        [pick(0), pick(1), pick(2), pick(3)]
    }

    /// One after the other.
    #[inline(never)]
    fn slope(operation: Operation, value: Self, [a, b, c]: [Self; 3], [da, db, dc]: [Self; 3]) -> Self {
        std::array::from_fn(|i| operation.slope(value[i], [a[i], b[i], c[i]], [da[i], db[i], dc[i]]))
    }
}
