//! A tape along a step of the series: its results as polynomials of time.
//!
//! Each instruction is run to the last order at once, by the recurrences of automatic differentiation (Jorba and Zou, *Experimental Mathematics* 14, 2005). What does not move is a number. The same instructions
//! serve for one result alone at one time, where the polynomials of the coordinates are exact and those of the results are truncated.

use super::products::{convolution, inner_square, power, tail, weighted};
use crate::math::horner;
use crate::program::Layout;
use crate::program::arm_form::{MAX_ORDER, ORDERS};
use crate::tape::{Operation, Tape};

/// The coefficients of one polynomial of the time since the step began.
pub(crate) type Coefficients = [f64; ORDERS];

/// What is not a result of the tape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Leaf {
    Time,
    Coordinate(usize),
    /// The rate of a coordinate.
    Rate(usize),
    /// A register that is constant within a step.
    Register(usize),
}

/// An instruction, whose registers are places of polynomials, each of which is written once.
#[derive(Clone, Copy, Debug)]
struct Recurrence {
    operation: Operation,
    target: usize,
    /// The cosine of `SinCos`.
    second: usize,
    operands: [usize; 3],
}

/// What one result is made of: numbers of sources and steps in their order.
#[derive(Clone, Debug, Default)]
struct Needs {
    sources: Vec<usize>,
    steps: Vec<usize>,
    is_linear: bool,
}

/// A tape that can be run along a step. Allocated once.
#[derive(Clone, Debug)]
pub(crate) struct TapeAlong {
    sources: Vec<(usize, Leaf)>,
    steps: Vec<Recurrence>,
    /// True for what depends on time.
    moves: Vec<bool>,
    results: Vec<usize>,
    needs: Vec<Needs>,
    polynomials: Vec<Coefficients>,
    values: Vec<f64>,
    order: usize,
}

impl TapeAlong {
    /// A tape of time, coordinates, their rates and what is constant within a step; none if it reads anything else, or if an operation that moves is in pieces or has no recurrence here.
    pub fn new(layout: &Layout, tape: &Tape) -> Option<Self> {
        let mut builder = Builder::default();
        for instruction in tape.instructions() {
            let mut operands = [0; 3];
            for (operand, register) in operands.iter_mut().zip(instruction.operands()) {
                *operand = builder.read(layout, register as usize)?;
            }
            let count = instruction.operation.operands();
            // What is not read stands for nothing.
            (count..3).for_each(|place| operands[place] = operands[0]);
            let moves = operands.iter().any(|&operand| builder.moves[operand]);
            if moves && !has_recurrence(instruction.operation, operands.map(|operand| builder.moves[operand])) {
                return None;
            }
            let is_double = instruction.operation == Operation::SinCos;
            let second = if is_double { builder.write(instruction.c as usize, moves) } else { 0 };
            let target = builder.write(instruction.target as usize, moves);
            let second = if is_double { second } else { target };
            builder.steps.push(Recurrence { operation: instruction.operation, target, second, operands });
        }
        let results = tape.results.iter().map(|&register| builder.read(layout, register as usize));
        let results = results.collect::<Option<Vec<usize>>>()?;
        let Builder { sources, steps, moves, .. } = builder;
        let places = moves.len();
        let needs = results.iter().map(|&result| needs(&sources, &steps, &moves, result)).collect();
        let polynomials = vec![[0.0; ORDERS]; places];
        Some(Self { sources, steps, moves, results, needs, polynomials, values: vec![0.0; places], order: 0 })
    }

    /// Finds the polynomials of all results up to an order from those of the coordinates, which `coordinate` writes. The registers hold what is constant.
    pub fn begin(
        &mut self,
        registers: &[f64],
        (time, order): (f64, usize),
        coordinate: impl Fn(usize, &mut Coefficients),
    ) {
        self.order = order.min(MAX_ORDER);
        for &(place, source) in &self.sources {
            let polynomial = &mut self.polynomials[place];
            match source {
                Leaf::Time => (polynomial[0], polynomial[1]) = (time, 1.0),
                Leaf::Coordinate(index) => coordinate(index, polynomial),
                Leaf::Rate(index) => {
                    coordinate(index, polynomial);
                    differentiate(polynomial, self.order);
                }
                Leaf::Register(register) => polynomial[0] = registers[register],
            }
            self.values[place] = polynomial[0];
        }
        for index in 0..self.steps.len() {
            let step = self.steps[index];
            if self.moves[step.target] {
                self.expand(step);
            } else {
                self.evaluate(step);
                self.polynomials[step.target][0] = self.values[step.target];
                self.polynomials[step.second][0] = self.values[step.second];
            }
        }
    }

    /// The polynomial of a result.
    pub fn polynomial(&self, result: usize) -> &[f64] {
        &self.polynomials[self.results[result]][..=self.order]
    }

    /// True for a result that does not change within a step.
    pub fn is_constant(&self, result: usize) -> bool {
        !self.moves[self.results[result]]
    }

    /// True for a result that is a sum of coordinates times constants: its polynomial is exact.
    pub fn is_linear(&self, result: usize) -> bool {
        self.needs[result].is_linear
    }

    /// A result so long after the step began, from the polynomials of the coordinates.
    pub fn value(&mut self, result: usize, dt: f64) -> f64 {
        for place in 0..self.needs[result].sources.len() {
            let (slot, _) = self.sources[self.needs[result].sources[place]];
            self.values[slot] = horner(&self.polynomials[slot][..=self.order], dt);
        }
        for place in 0..self.needs[result].steps.len() {
            self.evaluate(self.steps[self.needs[result].steps[place]]);
        }
        self.values[self.results[result]]
    }

    /// One instruction on numbers.
    #[inline(always)]
    fn evaluate(&mut self, step: Recurrence) {
        let [a, b, c] = step.operands.map(|operand| self.values[operand]);
        self.values[step.target] = match step.operation {
            Operation::Add => a + b,
            Operation::Subtract => a - b,
            Operation::Multiply => a * b,
            Operation::Divide => a / b,
            Operation::Negate => -a,
            Operation::MultiplyAdd => a * b + c,
            Operation::MultiplySubtract => a * b - c,
            Operation::SubtractProduct => c - a * b,
            Operation::SquareRoot => a.sqrt(),
            Operation::SinCos => {
                let (sine, cosine) = crate::math::sin_cos(a);
                self.values[step.second] = cosine;
                sine
            }
            function => function.of_numbers([a, b, c]),
        };
    }

    /// One instruction on polynomials. A place is written once, after those that it is found from.
    fn expand(&mut self, step: Recurrence) {
        let length = self.order + 1;
        let (known, written) = self.polynomials.split_at_mut(step.second.min(step.target));
        let [a, b, c] = step.operands.map(|operand| &known[operand]);
        let moves = step.operands.map(|operand| self.moves[operand]);
        let target = &mut written[step.target - known.len()];
        match step.operation {
            Operation::Add => fill(target, length, |k| a[k] + b[k]),
            Operation::Subtract => fill(target, length, |k| a[k] - b[k]),
            Operation::Multiply => product([a, b], moves, target, length, |_, product| product),
            Operation::Divide if !moves[1] => fill(target, length, |k| a[k] / b[0]),
            Operation::Negate => fill(target, length, |k| -a[k]),
            Operation::MultiplyAdd => product([a, b], moves, target, length, |k, product| product + c[k]),
            Operation::MultiplySubtract => product([a, b], moves, target, length, |k, product| product - c[k]),
            Operation::SubtractProduct => product([a, b], moves, target, length, |k, product| c[k] - product),
            Operation::Copy => fill(target, length, |k| a[k]),
            Operation::SinCos => sine_and_cosine(a, &mut written[..2], length),
            operation => {
                for k in 0..length {
                    target[k] = recurrence(operation, [a, b], target, k);
                }
            }
        }
    }
}

/// The first coefficients of a polynomial, each by itself.
#[inline(always)]
fn fill(target: &mut Coefficients, length: usize, value: impl Fn(usize) -> f64) {
    for k in 0..length.min(ORDERS) {
        target[k] = value(k);
    }
}

/// The first coefficients of a polynomial from those of a product of two others, of which one may be a number.
#[inline(always)]
fn product(
    [a, b]: [&Coefficients; 2],
    moves: [bool; 3],
    target: &mut Coefficients,
    length: usize,
    value: impl Fn(usize, f64) -> f64,
) {
    match moves {
        [true, true, _] => fill(target, length, |k| value(k, convolution(a, b, k))),
        [true, false, _] => fill(target, length, |k| value(k, a[k] * b[0])),
        [false, true, _] => fill(target, length, |k| value(k, a[0] * b[k])),
        [false, false, _] => fill(target, length, |k| value(k, if k == 0 { a[0] * b[0] } else { 0.0 })),
    }
}

/// One coefficient of an operation that needs the lower ones of its result.
#[inline(always)]
fn recurrence(operation: Operation, [a, b]: [&Coefficients; 2], lower: &Coefficients, k: usize) -> f64 {
    match operation {
        Operation::Divide => (a[k] - tail(b, lower, k)) / b[0],
        Operation::SquareRoot if k == 0 => a[0].sqrt(),
        Operation::SquareRoot => (a[k] - inner_square(lower, k)) / (2.0 * lower[0]),
        Operation::Power if k == 0 => libm::pow(a[0], b[0]),
        Operation::Power => power(a, lower, b[0], k),
        // Steps end where a law goes on with the next integer.
        Operation::Floor if k == 0 => libm::floor(a[0]),
        Operation::Floor => 0.0,
        // None of these has been admitted.
        _ => f64::NAN,
    }
}

/// The cosine, then the sine, of a polynomial.
fn sine_and_cosine(a: &Coefficients, written: &mut [Coefficients], length: usize) {
    let [cosine, sine] = written else { return };
    (sine[0], cosine[0]) = crate::math::sin_cos(a[0]);
    for k in 1..length {
        let next = [weighted(a, cosine, k), -weighted(a, sine, k)];
        [sine[k], cosine[k]] = next.map(|sum| sum / k as f64);
    }
}

/// The derivative of a polynomial.
fn differentiate(polynomial: &mut Coefficients, order: usize) {
    for k in 0..order {
        polynomial[k] = (k + 1) as f64 * polynomial[k + 1];
    }
    polynomial[order] = 0.0;
}

/// What is known while the instructions are looked through.
#[derive(Default)]
struct Builder {
    sources: Vec<(usize, Leaf)>,
    steps: Vec<Recurrence>,
    moves: Vec<bool>,
    /// The place of what a register holds at present.
    places: std::collections::BTreeMap<usize, usize>,
}

impl Builder {
    /// The place of a register that is read; none if it is neither constant nor known as a polynomial.
    fn read(&mut self, layout: &Layout, register: usize) -> Option<usize> {
        if let Some(&place) = self.places.get(&register) {
            return Some(place);
        }
        let (coordinates, rates) = (layout.positions()..layout.rates(), layout.rates()..layout.accelerations());
        let is_constant = layout.constant_between_instants().contains(&register) || register >= layout.constants();
        let source = if register == layout.time() {
            Leaf::Time
        } else if coordinates.contains(&register) {
            Leaf::Coordinate(register - coordinates.start)
        } else if rates.contains(&register) {
            Leaf::Rate(register - rates.start)
        } else if is_constant {
            Leaf::Register(register)
        } else {
            return None;
        };
        let place = self.write(register, !is_constant);
        self.sources.push((place, source));
        Some(place)
    }

    /// A new place for what is written to a register.
    fn write(&mut self, register: usize, moves: bool) -> usize {
        self.moves.push(moves);
        self.places.insert(register, self.moves.len() - 1);
        self.moves.len() - 1
    }
}

/// True if an operation is run to all orders, some operands of which move.
fn has_recurrence(operation: Operation, moves: [bool; 3]) -> bool {
    match operation {
        Operation::Add
        | Operation::Subtract
        | Operation::Multiply
        | Operation::Divide
        | Operation::Negate
        | Operation::MultiplyAdd
        | Operation::MultiplySubtract
        | Operation::SubtractProduct
        | Operation::SquareRoot
        | Operation::SinCos
        | Operation::Floor
        | Operation::Copy => true,
        Operation::Power => !moves[1],
        _ => false,
    }
}

/// True for an operation whose operands move and are added, or multiplied by what does not move.
fn is_linear(step: &Recurrence, moves: &[bool]) -> bool {
    let [a, b, _] = step.operands.map(|operand| moves[operand]);
    match step.operation {
        Operation::Add | Operation::Subtract | Operation::Negate | Operation::Copy => true,
        Operation::Multiply | Operation::MultiplyAdd | Operation::MultiplySubtract | Operation::SubtractProduct => {
            !(a && b)
        }
        Operation::Divide => !b,
        _ => false,
    }
}

/// What a result is made of, but for what does not move.
fn needs(sources: &[(usize, Leaf)], steps: &[Recurrence], moves: &[bool], result: usize) -> Needs {
    let mut wanted = vec![false; moves.len()];
    wanted[result] = true;
    let mut needs = Needs::default();
    for (index, step) in steps.iter().enumerate().rev() {
        if moves[step.target] && (wanted[step.target] || wanted[step.second]) {
            step.operands.iter().for_each(|&operand| wanted[operand] = true);
            needs.steps.push(index);
        }
    }
    needs.steps.reverse();
    needs.is_linear = needs.steps.iter().all(|&index| is_linear(&steps[index], moves));
    needs.sources = (0..sources.len()).filter(|&index| wanted[sources[index].0] && moves[sources[index].0]).collect();
    needs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;
    use crate::tape::Instruction;
    use crate::tape::Operation::*;

    /// One parameter, two coordinates.
    fn layout() -> Layout {
        Layout::new([1, 0, 0, 0], [2, 0], 0)
    }

    fn instruction(operation: Operation, target: u32, operands: [u32; 3]) -> Instruction {
        let [a, b, c] = operands;
        Instruction { operation, target, a, b, c }
    }

    const FIRST: u32 = 40;
    const ORDER: usize = 20;

    /// Random tapes of admitted operations over time, a parameter, two coordinates and what has been found before, positive where it is divided by.
    fn random_tape(random: &mut Random) -> Tape {
        const ALL: [Operation; 12] = [
            Add,
            Subtract,
            Multiply,
            Divide,
            Negate,
            MultiplyAdd,
            MultiplySubtract,
            SubtractProduct,
            SquareRoot,
            SinCos,
            Copy,
            Power,
        ];
        let positions = layout().positions() as u32;
        let mut known = vec![0, 1, positions, positions + 1];
        let mut instructions = Vec::new();
        let mut next = FIRST;
        for _ in 0..10 {
            let mut pick = |from: &[u32]| from[(random.unit() * from.len() as f64) as usize % from.len()];
            let operands = [pick(&known), pick(&known), pick(&known)];
            let operation = ALL[(random.unit() * ALL.len() as f64) as usize % ALL.len()];
            // 2 + sin is positive, wherever its angle is.
            let (angle, positive) = (next, next + 3);
            instructions.push(instruction(SinCos, angle, [operands[1], 0, angle + 1]));
            instructions.push(instruction(Add, next + 2, [angle, 1, 0]));
            instructions.push(instruction(Add, positive, [next + 2, 1, 0]));
            let target = next + 4;
            let made = match operation {
                Divide => [operands[0], positive, 0],
                SquareRoot => [positive, 0, 0],
                // The parameter is the exponent.
                Power => [positive, 1, 0],
                SinCos => [operands[0], 0, next + 5],
                _ => operands,
            };
            instructions.push(instruction(operation, target, made));
            known.extend([angle, positive, target]);
            next += 6;
        }
        Tape::new(instructions, vec![next - 2, next - 3])
    }

    #[test]
    fn polynomials_of_random_tapes_are_their_values_along_the_step() {
        let (mut random, mut moved) = (Random::new(21), 0);
        for _ in 0..300 {
            let tape = random_tape(&mut random);
            let mut along = TapeAlong::new(&layout(), &tape).unwrap();
            let paths: [[f64; 3]; 2] = std::array::from_fn(|_| std::array::from_fn(|_| random.symmetric()));
            let (start, parameter) = (random.symmetric(), 1.5);
            let mut registers = vec![0.0; 200];
            registers[1] = parameter;
            along.begin(&registers, (start, ORDER), |index, coefficients| {
                coefficients.fill(0.0);
                coefficients[..3].copy_from_slice(&paths[index]);
            });
            for dt in [0.0, 0.01, 0.03] {
                registers[0] = start + dt;
                for (index, path) in paths.iter().enumerate() {
                    registers[layout().positions() + index] = horner(path, dt);
                }
                tape.run(&mut registers);
                let values: Vec<f64> = tape.results(&registers).collect();
                if values.iter().any(|value| value.abs() > 1e3) {
                    continue;
                }
                for (result, value) in values.into_iter().enumerate() {
                    let [one, series] = [along.value(result, dt), horner(along.polynomial(result), dt)];
                    assert!((one - value).abs() <= 1e-12 * value.abs().max(1.0), "{tape:?}: {one} for {value}");
                    assert!(
                        (series - value).abs() <= 1e-9 * value.abs().max(1.0),
                        "{tape:?} {dt}: {series} for {value}"
                    );
                    moved += usize::from(dt > 0.0);
                }
            }
        }
        assert!(moved > 500, "{moved}");
    }

    #[test]
    fn what_is_in_pieces_or_reads_something_else_is_declined() {
        let positions = layout().positions() as u32;
        let of = |operation, operands| {
            TapeAlong::new(&layout(), &Tape::new(vec![instruction(operation, FIRST, operands)], vec![FIRST]))
        };
        assert!(of(Add, [positions, 1, 0]).unwrap().is_linear(0));
        assert!(of(MultiplyAdd, [positions, 1, positions]).unwrap().is_linear(0));
        assert!(!of(Multiply, [positions, positions + 1, 0]).unwrap().is_linear(0));
        assert!(!of(Divide, [1, positions, 0]).unwrap().is_linear(0));
        // The absolute value of a constant is a constant.
        assert!(of(Absolute, [1, 0, 0]).is_some());
        assert!(of(Absolute, [positions, 0, 0]).is_none());
        assert!(of(Select, [1, positions, positions + 1]).is_none());
        assert!(of(Power, [1, positions, 0]).is_none());
        // Steps end at the next integer.
        assert!(of(Floor, [positions, 0, 0]).is_some());
        let accelerations = layout().accelerations() as u32;
        assert!(of(Add, [positions, accelerations, 0]).is_none());
    }

    /// Registers are used again.
    #[test]
    fn a_register_holds_what_was_written_last() {
        let positions = layout().positions() as u32;
        let tape = Tape::new(
            vec![
                instruction(Multiply, FIRST, [positions, positions, 0]),
                instruction(Multiply, FIRST, [FIRST, FIRST, 0]),
            ],
            vec![FIRST],
        );
        let mut along = TapeAlong::new(&layout(), &tape).unwrap();
        along.begin(&[0.0; 50], (0.0, 6), |_, coefficients| coefficients[..2].copy_from_slice(&[1.0, 1.0]));
        assert_eq!(along.polynomial(0), [1.0, 4.0, 6.0, 4.0, 1.0, 0.0, 0.0]);
        assert_eq!(along.value(0, 1.0), 16.0);
    }
}
