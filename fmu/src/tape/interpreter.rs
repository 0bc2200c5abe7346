//! Running a tape.

use super::{Instruction, Operation, Tape};
use crate::math;

impl Tape {
    /// Runs the tape over a register file.
    ///
    /// # Panics
    /// If an instruction names a register outside the file; a program that passed [`crate::program::Program::check`] has none.
    pub fn run(&self, registers: &mut [f64]) {
        for instruction in &self.instructions {
            instruction.run(registers);
        }
    }

    /// The results, in order, after [`Tape::run`].
    pub fn results<'a>(&'a self, registers: &'a [f64]) -> impl ExactSizeIterator<Item = f64> + 'a {
        self.results.iter().map(|&register| registers[register as usize])
    }
}

impl Instruction {
    /// Registers read, as many of a, b, c as the operation uses.
    pub fn operands(&self) -> impl Iterator<Item = u32> {
        [self.a, self.b, self.c].into_iter().take(self.operation.operands())
    }

    /// Registers written.
    pub fn targets(&self) -> impl Iterator<Item = u32> {
        let second = (self.operation == Operation::SinCos).then_some(self.c);
        core::iter::once(self.target).chain(second)
    }

    #[inline(always)]
    pub(super) fn run(&self, registers: &mut [f64]) {
        let a = registers[self.a as usize];
        let b = registers[self.b as usize];
        let value = if self.operation == Operation::SinCos {
            let (sine, cosine) = math::sin_cos(a);
            registers[self.c as usize] = cosine;
            sine
        } else {
            self.operation.value(a, b, || registers[self.c as usize])
        };
        registers[self.target as usize] = value;
    }
}

impl Operation {
    /// The first result.
    #[inline(always)]
    pub(super) fn value(self, a: f64, b: f64, c: impl FnOnce() -> f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Negate => -a,
            Self::MultiplyAdd => a * b + c(),
            Self::SquareRoot => a.sqrt(),
            Self::Absolute => a.abs(),
            Self::SinCos => math::sin_cos(a).0,
            Self::Tangent => libm::tan(a),
            Self::ArcSine => libm::asin(a),
            Self::ArcCosine => libm::acos(a),
            Self::ArcTangent => libm::atan(a),
            Self::ArcTangent2 => libm::atan2(a, b),
            Self::Exponential => libm::exp(a),
            Self::Logarithm => libm::log(a),
            Self::HyperbolicTangent => libm::tanh(a),
            Self::Power => libm::pow(a, b),
            Self::Sign => math::sign(a),
            Self::Floor => a.floor(),
            Self::Minimum => math::minimum(a, b),
            Self::Maximum => math::maximum(a, b),
            Self::Less => f64::from(u8::from(a < b)),
            Self::LessEqual => f64::from(u8::from(a <= b)),
            Self::Select => {
                if a != 0.0 {
                    b
                } else {
                    c()
                }
            }
            Self::Copy => a,
        }
    }

    /// How many of the operands a, b, c it reads.
    pub fn operands(self) -> usize {
        match self {
            Self::MultiplyAdd | Self::Select => 3,
            Self::Add
            | Self::Subtract
            | Self::Multiply
            | Self::Divide
            | Self::ArcTangent2
            | Self::Power
            | Self::Minimum
            | Self::Maximum
            | Self::Less
            | Self::LessEqual => 2,
            Self::Negate
            | Self::SquareRoot
            | Self::Absolute
            | Self::SinCos
            | Self::Tangent
            | Self::ArcSine
            | Self::ArcCosine
            | Self::ArcTangent
            | Self::Exponential
            | Self::Logarithm
            | Self::HyperbolicTangent
            | Self::Sign
            | Self::Floor
            | Self::Copy => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apply(operation: Operation, a: f64, b: f64, c: f64) -> [f64; 5] {
        let mut registers = [a, b, c, 0.0, 0.0];
        let c = if operation == Operation::SinCos { 4 } else { 2 };
        let tape = Tape { instructions: vec![Instruction { operation, target: 3, a: 0, b: 1, c }], results: vec![3] };
        tape.run(&mut registers);
        assert_eq!(tape.results(&registers).next().map(f64::to_bits), Some(registers[3].to_bits()));
        registers
    }

    #[test]
    fn every_operation_computes_what_its_comment_says() {
        use Operation::*;
        let (a, b, c) = (0.6_f64, -1.7_f64, 2.5);
        let expected = [
            (Add, a + b),
            (Subtract, a - b),
            (Multiply, a * b),
            (Divide, a / b),
            (Negate, -a),
            (MultiplyAdd, a * b + c),
            (SquareRoot, a.sqrt()),
            (Absolute, a.abs()),
            (SinCos, a.sin()),
            (Tangent, a.tan()),
            (ArcSine, a.asin()),
            (ArcCosine, a.acos()),
            (ArcTangent, a.atan()),
            (ArcTangent2, a.atan2(b)),
            (Exponential, a.exp()),
            (Logarithm, a.ln()),
            (HyperbolicTangent, a.tanh()),
            (Power, a.powf(b)),
            (Sign, 1.0),
            (Floor, 0.0),
            (Minimum, b),
            (Maximum, a),
            (Less, 0.0),
            (LessEqual, 0.0),
            (Select, b),
            (Copy, a),
        ];
        for (operation, value) in expected {
            let found = apply(operation, a, b, c)[3];
            assert!((found - value).abs() <= 4e-16 * value.abs().max(1.0), "{operation:?}: {found} for {value}");
        }
        assert!((apply(SinCos, a, b, c)[4] - a.cos()).abs() <= 2e-16);
        assert_eq!(apply(Select, 0.0, b, c)[3], c);
        assert_eq!(apply(LessEqual, b, b, c)[3], 1.0);
        assert_eq!(apply(Less, b, a, c)[3], 1.0);
    }
}
