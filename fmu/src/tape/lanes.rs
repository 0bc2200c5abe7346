//! Running a tape at four points at once, or along four directions: what it costs to read the instructions is then shared.
//!
//! Every place of a lane gets the bits that [`Tape::run`] and [`Tape::run_tangent`] give it alone. The code is compiled twice, for AVX2 and for any
//! processor.

use super::{Instruction, Operation, Tape};
use crate::linalg::lane::{Lane, ZERO, add, by_width, multiply, splat, subtract};
use crate::linalg::turn::cosine_and_sine;

impl Tape {
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
    fn run_any_lanes_tangents(&self, registers: &mut [Lane], tangents: &mut [Lanes]) {
        for instruction in self.instructions() {
            instruction.run_lanes_tangents(registers, tangents);
        }
    }

    #[inline(always)]
    fn run_any_lanes(&self, registers: &mut [Lane]) {
        for instruction in self.instructions() {
            instruction.run_lanes(registers);
        }
    }

    #[inline(always)]
    fn run_any_tangents(&self, registers: &mut [f64], tangents: &mut [Lane]) {
        for instruction in self.instructions() {
            instruction.run_tangents(registers, tangents);
        }
    }
}

impl Instruction {
    #[inline(always)]
    fn run_lanes(&self, registers: &mut [Lane]) {
        let a = registers[self.a as usize];
        let b = registers[self.b as usize];
        let value = match self.operation {
            Operation::Add => add(a, b),
            Operation::Subtract => subtract(a, b),
            Operation::Multiply => multiply(a, b),
            Operation::MultiplyAdd => add(multiply(a, b), registers[self.c as usize]),
            Operation::MultiplySubtract => subtract(multiply(a, b), registers[self.c as usize]),
            Operation::SubtractProduct => subtract(registers[self.c as usize], multiply(a, b)),
            Operation::Divide => divide(a, b),
            Operation::Negate => [-a[0], -a[1], -a[2], -a[3]],
            Operation::SquareRoot => [a[0].sqrt(), a[1].sqrt(), a[2].sqrt(), a[3].sqrt()],
            Operation::SinCos => {
                let [cosine, sine] = cosine_and_sine(a);
                registers[self.c as usize] = cosine;
                sine
            }
            operation => alone(operation, a, b, registers[self.c as usize]),
        };
        registers[self.target as usize] = value;
    }

    #[allow(clippy::needless_range_loop, reason = "a closure would not be compiled for AVX2")]
    #[inline(always)]
    fn run_lanes_tangents(&self, registers: &mut [Lane], tangents: &mut [Lanes]) {
        // Operands first: the target may be one of them.
        let [a, b, c] = [self.a, self.b, self.c].map(|register| registers[register as usize]);
        self.run_lanes(registers);
        let value = registers[self.target as usize];
        match self.operation {
            Operation::Add => self.along(tangents, |da, db, _| add(da, db)),
            Operation::Subtract => self.along(tangents, |da, db, _| subtract(da, db)),
            Operation::Multiply => self.along(tangents, |da, db, _| add(chains(b, da), chains(a, db))),
            Operation::MultiplyAdd => self.along(tangents, |da, db, dc| add(add(chains(b, da), chains(a, db)), dc)),
            Operation::MultiplySubtract => {
                self.along(tangents, |da, db, dc| subtract(add(chains(b, da), chains(a, db)), dc))
            }
            Operation::SubtractProduct => {
                self.along(tangents, |da, db, dc| subtract(dc, add(chains(b, da), chains(a, db))))
            }
            Operation::Divide => self.along(tangents, |da, db, _| divide(subtract(da, chains(db, value)), b)),
            Operation::Negate => self.along(tangents, |da, _, _| da.map(|da| -da)),
            Operation::SquareRoot => {
                let slope = value.map(|value| 0.5 / value);
                self.along(tangents, |da, _, _| chains(slope, da));
            }
            Operation::SinCos => {
                let [sine, cosine] = [value.map(|value| -value), registers[self.c as usize]];
                for k in 0..DIRECTIONS {
                    let direction = tangents[self.a as usize][k];
                    tangents[self.c as usize][k] = chains(sine, direction);
                    tangents[self.target as usize][k] = chains(cosine, direction);
                }
            }
            operation => self.along(tangents, |da, db, dc| alone_at(operation, value, [a, b, c], [da, db, dc])),
        }
    }

    /// Derivatives of the target from those of the operands.
    #[allow(clippy::needless_range_loop, reason = "a closure would not be compiled for AVX2")]
    #[inline(always)]
    fn along(&self, tangents: &mut [Lanes], of: impl Fn(Lane, Lane, Lane) -> Lane) {
        for k in 0..DIRECTIONS {
            let [da, db, dc] = [self.a, self.b, self.c].map(|register| tangents[register as usize][k]);
            tangents[self.target as usize][k] = of(da, db, dc);
        }
    }

    #[inline(always)]
    fn run_tangents(&self, registers: &mut [f64], tangents: &mut [Lane]) {
        // Operands first: the target may be one of them.
        let [a, b, c] = [self.a, self.b, self.c].map(|register| registers[register as usize]);
        let [da, db, dc] = [self.a, self.b, self.c].map(|register| tangents[register as usize]);
        self.run(registers);
        let value = registers[self.target as usize];
        let tangent = match self.operation {
            Operation::Add => add(da, db),
            Operation::Subtract => subtract(da, db),
            Operation::Multiply => add(chain(b, da), chain(a, db)),
            Operation::MultiplyAdd => add(add(chain(b, da), chain(a, db)), dc),
            Operation::MultiplySubtract => subtract(add(chain(b, da), chain(a, db)), dc),
            Operation::SubtractProduct => subtract(dc, add(chain(b, da), chain(a, db))),
            Operation::Divide => divide(subtract(da, chains(db, splat(value))), splat(b)),
            Operation::Negate => da.map(|da| -da),
            Operation::SinCos => {
                let cosine = registers[self.c as usize];
                tangents[self.c as usize] = chain(-value, da);
                chain(cosine, da)
            }
            operation => alone_along(operation, value, [a, b, c], [da, db, dc]),
        };
        tangents[self.target as usize] = tangent;
    }
}

/// Derivatives along so many directions at four points.
pub(crate) const DIRECTIONS: usize = 3;
pub(crate) type Lanes = [Lane; DIRECTIONS];

/// One after the other, what seldom occurs.
#[inline(never)]
fn alone(operation: Operation, a: Lane, b: Lane, c: Lane) -> Lane {
    std::array::from_fn(|i| operation.value([a[i], b[i], c[i]]))
}

/// The same for derivatives.
#[inline(never)]
fn alone_along(operation: Operation, value: f64, operands: [f64; 3], [da, db, dc]: [Lane; 3]) -> Lane {
    std::array::from_fn(|i| operation.tangent(value, operands, [da[i], db[i], dc[i]]))
}

/// The same for derivatives at four points.
#[inline(never)]
fn alone_at(operation: Operation, value: Lane, [a, b, c]: [Lane; 3], [da, db, dc]: [Lane; 3]) -> Lane {
    std::array::from_fn(|i| operation.tangent(value[i], [a[i], b[i], c[i]], [da[i], db[i], dc[i]]))
}

#[inline(always)]
fn divide(a: Lane, b: Lane) -> Lane {
    [a[0] / b[0], a[1] / b[1], a[2] / b[2], a[3] / b[3]]
}

/// slope * direction, but nothing for nothing.
#[inline(always)]
fn chain(slope: f64, direction: Lane) -> Lane {
    chains(splat(slope), direction)
}

/// The same with a slope for each.
#[inline(always)]
fn chains(slope: Lane, direction: Lane) -> Lane {
    let product = multiply(slope, direction);
    let pick = |i: usize| if direction[i] == 0.0 { ZERO[i] } else { product[i] };
    [pick(0), pick(1), pick(2), pick(3)]
}

#[cfg(test)]
mod tests {
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
                for (k, i) in (0..DIRECTIONS).flat_map(|k| (0..4).map(move |i| (k, i))) {
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
}
