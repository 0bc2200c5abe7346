//! What an instruction reads and writes.

use super::file::File;
use super::{Instruction, Operation, Tape};
use crate::linalg::lane::WIDTH;
use crate::linalg::turn::Angles;
use crate::math;

impl Tape {
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
            self.operation.value([a, b, registers[self.c as usize]])
        };
        registers[self.target as usize] = value;
    }
}

/// Runs instructions that are all `SinCos`: four angles in the time of one and a half, unless one of them is a result of another.
pub(super) fn sines_and_cosines<F: File + ?Sized>(instructions: &[Instruction], file: &mut F) {
    for four in instructions.chunks(WIDTH) {
        let written = |a: u32, before: usize| four[..before].iter().any(|first| first.target == a || first.c == a);
        let last = four.len() - 1;
        if last == 0 || four.iter().enumerate().any(|(i, instruction)| written(instruction.a, i)) {
            for instruction in four {
                let (sine, cosine) = math::sin_cos(file.get(instruction.a));
                file.set(instruction.c, cosine);
                file.set(instruction.target, sine);
            }
            continue;
        }
        let [cosines, sines] = Angles(std::array::from_fn(|i| file.get(four[i.min(last)].a))).cosines_and_sines();
        for ((instruction, cosine), sine) in four.iter().zip(cosines).zip(sines) {
            file.set(instruction.c, cosine);
            file.set(instruction.target, sine);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;

    /// Among few registers, so that many angles are results of the instructions before.
    #[test]
    fn many_sines_and_cosines_have_the_bits_of_one_after_the_other() {
        let mut random = Random::new(3);
        for round in 0..2000 {
            let size = if round % 2 == 0 { 8.0 } else { 60.0 };
            let mut register = || (random.symmetric().abs() * size) as u32 % size as u32;
            let instruction =
                |[target, a, c]: [u32; 3]| Instruction { operation: Operation::SinCos, target, a, b: 0, c };
            let instructions: Vec<_> = (0..1 + round % 11).map(|_| instruction([(); 3].map(|()| register()))).collect();
            let mut alone: Vec<f64> = (0..60).map(|i| f64::from(i) * 1.7 - 40.0).collect();
            let mut together = alone.clone();
            instructions.iter().for_each(|instruction| instruction.run(&mut alone));
            Tape::new(instructions, Vec::new()).run(&mut together);
            assert_eq!(together, alone);
        }
    }

    fn apply(operation: Operation, a: f64, b: f64, c: f64) -> [f64; 5] {
        let mut registers = [a, b, c, 0.0, 0.0];
        let c = if operation == Operation::SinCos { 4 } else { 2 };
        let tape = Tape::new(vec![Instruction { operation, target: 3, a: 0, b: 1, c }], vec![3]);
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
            (MultiplySubtract, a * b - c),
            (SubtractProduct, c - a * b),
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
