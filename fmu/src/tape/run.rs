//! Running a tape over registers of every kind: one code, which knows nothing but [`super::field::Field`].
//!
//! What is run at four points at once, or along four directions, costs less to be read; every place of a lane gets the bits that it gets alone. Lanes are compiled
//! twice, for AVX2 and for any processor.

use super::file::{Beside, FEW_REGISTERS, WithErrors};
use super::series::Series;
use super::{Operation, Tape};
use crate::linalg::lane::{Lane, by_width};

/// Derivatives along so many directions at four points.
pub(crate) const LANE_DIRECTIONS: usize = 3;
pub(crate) type Lanes = [Lane; LANE_DIRECTIONS];

impl Operation {
    /// The result of an operation that is no arithmetic.
    pub(crate) fn of_numbers(self, operands: [f64; 3]) -> f64 {
        self.value(operands)
    }
}

impl Tape {
    /// The results, in order, after [`Tape::run`].
    pub fn results<'a>(&'a self, registers: &'a [f64]) -> impl ExactSizeIterator<Item = f64> + 'a {
        self.results.iter().map(|&register| registers[register as usize])
    }

    /// Runs the tape over a register file.
    ///
    /// # Panics
    /// If an instruction names a register outside the file; a program that passed its check has none.
    pub fn run(&self, registers: &mut [f64]) {
        match <&mut [f64; FEW_REGISTERS]>::try_from(&mut *registers) {
            Ok(few) => self.run_over(few),
            Err(_) => self.run_over(registers),
        }
    }

    /// Runs the tape over `registers`, and its derivative over `tangents`, whose entries for what the tape reads are the direction.
    ///
    /// # Panics
    /// As [`Tape::run`]; both files must have the same size.
    pub fn run_tangent(&self, registers: &mut [f64], tangents: &mut [f64]) {
        self.run_over(&mut Beside { values: registers, tangents: tangents.as_chunks_mut::<1>().0 });
    }

    /// Runs the tape over `registers`, and over `errors` bounds of the errors of all results, whose entries for what the tape reads are those of its errors.
    ///
    /// # Panics
    /// As [`Tape::run`]; both files must have the same size.
    pub(crate) fn run_errors(&self, registers: &mut [f64], errors: &mut [f64]) {
        self.run_over(&mut WithErrors { values: registers, errors });
    }

    /// Runs the tape over a register file of series.
    ///
    /// # Panics
    /// As [`Tape::run`].
    pub fn run_series(&self, registers: &mut [Series]) {
        self.run_over(registers);
    }

    by_width! {
        /// Runs the tape over four register files, interleaved.
        ///
        /// # Panics
        /// As [`Tape::run`].
        pub fn run_lanes(&self: Tape, registers: &mut [Lane]) = run_any_lanes
    }

    by_width! {
        /// Runs the tape over `registers`, and its derivatives along four directions over `tangents`, whose entries for what the tape reads are the
        /// directions.
        ///
        /// # Panics
        /// As [`Tape::run_tangent`].
        pub fn run_tangents(&self: Tape, registers: &mut [f64], tangents: &mut [Lane]) = run_any_tangents
    }

    by_width! {
        /// Runs the tape over four register files, interleaved, and its derivatives along some directions, the same at each of the four points.
        ///
        /// # Panics
        /// As [`Tape::run_tangent`].
        pub(crate) fn run_lanes_tangents(&self: Tape, registers: &mut [Lane], tangents: &mut [Lanes]) = run_any_lanes_tangents
    }

    #[inline(always)]
    fn run_any_lanes(&self, registers: &mut [Lane]) {
        self.run_over(registers);
    }

    #[inline(always)]
    fn run_any_tangents(&self, registers: &mut [f64], tangents: &mut [Lane]) {
        self.run_over(&mut Beside { values: registers, tangents });
    }

    #[inline(always)]
    fn run_any_lanes_tangents(&self, registers: &mut [Lane], tangents: &mut [Lanes]) {
        self.run_over(&mut Beside { values: registers, tangents });
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Instruction, Operation};
    use super::*;
    use crate::math::Random;

    const REGISTERS: usize = 7;

    /// Numbers of all sizes and signs, and those that are none.
    fn number(random: &mut Random) -> f64 {
        const SPECIAL: [f64; 8] = [0.0, -0.0, 1.0, -1.0, f64::NAN, f64::INFINITY, 1e-310, -3e5];
        let choice = random.symmetric();
        if choice > 0.7 {
            SPECIAL[(random.symmetric().abs() * 8.0) as usize % 8]
        } else {
            random.symmetric() * if choice < 0.0 { 1.0 } else { 100.0 }
        }
    }

    fn file(random: &mut Random) -> [Lane; REGISTERS] {
        std::array::from_fn(|_| std::array::from_fn(|_| number(random)))
    }

    /// The bits, but of numbers that are none only that they are none: which of two goes on is not the same on every processor.
    fn bits(value: f64) -> u64 {
        if value.is_nan() { f64::NAN.to_bits() } else { value.to_bits() }
    }

    fn place(lanes: &[Lane], i: usize) -> Vec<f64> {
        lanes.iter().map(|lane| lane[i]).collect()
    }

    fn same(lanes: &[Lane], i: usize, alone: &[f64]) -> bool {
        place(lanes, i).iter().zip(alone).all(|(a, b)| bits(*a) == bits(*b))
    }

    /// Every operation, with targets apart from and among its operands, and a second one that reads what it wrote.
    fn tapes() -> impl Iterator<Item = Tape> {
        let targets = [(3, 4), (0, 1), (1, 0), (2, 5)];
        Operation::ALL.iter().flat_map(move |&operation| {
            targets.map(|(target, second)| {
                let c = if operation == Operation::SinCos { second } else { 2 };
                let first = Instruction { operation, target, a: 0, b: 1, c };
                let then = Instruction { operation: Operation::MultiplyAdd, target: 6, a: target, b: second, c: 2 };
                Tape::new(vec![first, then], vec![6])
            })
        })
    }

    #[test]
    fn four_points_at_once_have_the_bits_of_one_after_the_other() {
        let mut random = Random::new(5);
        for tape in tapes() {
            for _ in 0..300 {
                let start = file(&mut random);
                let [mut wide, mut any] = [start; 2];
                tape.run_lanes(&mut wide);
                tape.run_any_lanes(&mut any);
                for i in 0..4 {
                    let mut alone = place(&start, i);
                    tape.run(&mut alone);
                    assert!(same(&wide, i, &alone), "{tape:?} {start:?}: {wide:?} for {alone:?}");
                    assert!(same(&any, i, &alone), "{tape:?} {start:?}: {any:?} for {alone:?}");
                }
            }
        }
    }

    #[test]
    fn four_directions_at_once_have_the_bits_of_one_after_the_other() {
        let mut random = Random::new(6);
        for tape in tapes() {
            for _ in 0..300 {
                let point = place(&file(&mut random), 0);
                let start = file(&mut random);
                let [mut wide, mut any] = [start; 2];
                let [mut registers, mut others] = [point.clone(), point.clone()];
                tape.run_tangents(&mut registers, &mut wide);
                tape.run_any_tangents(&mut others, &mut any);
                for i in 0..4 {
                    let (mut values, mut alone) = (point.clone(), place(&start, i));
                    tape.run_tangent(&mut values, &mut alone);
                    assert!(same(&wide, i, &alone), "{tape:?} {point:?} {start:?}: {wide:?} for {alone:?}");
                    assert!(same(&any, i, &alone), "{tape:?} {point:?} {start:?}: {any:?} for {alone:?}");
                    for found in [&registers, &others] {
                        assert!(found.iter().zip(&values).all(|(a, b)| bits(*a) == bits(*b)), "{tape:?} {point:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn directions_at_four_points_have_the_bits_of_one_after_the_other() {
        let mut random = Random::new(7);
        for tape in tapes() {
            for _ in 0..300 {
                let points = file(&mut random);
                let start: [Lanes; REGISTERS] =
                    std::array::from_fn(|_| std::array::from_fn(|_| std::array::from_fn(|_| number(&mut random))));
                let [mut wide, mut any] = [start; 2];
                let [mut registers, mut others] = [points; 2];
                tape.run_lanes_tangents(&mut registers, &mut wide);
                tape.run_any_lanes_tangents(&mut others, &mut any);
                for (k, i) in (0..LANE_DIRECTIONS).flat_map(|k| (0..4).map(move |i| (k, i))) {
                    let direction = |lanes: &[Lanes]| lanes.iter().map(|lanes| lanes[k]).collect::<Vec<Lane>>();
                    let (mut values, mut alone) = (place(&points, i), place(&direction(&start), i));
                    tape.run_tangent(&mut values, &mut alone);
                    assert!(
                        same(&direction(&wide), i, &alone),
                        "{tape:?} {points:?} {start:?}: {wide:?} for {alone:?}"
                    );
                    assert!(same(&direction(&any), i, &alone), "{tape:?} {points:?} {start:?}: {any:?} for {alone:?}");
                    assert!(same(&registers, i, &values) && same(&others, i, &values), "{tape:?} {points:?}");
                }
            }
        }
    }

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
            for instruction in &instructions {
                Tape::new(vec![*instruction], Vec::new()).run(&mut alone);
            }
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
