//! Cost model of a tape; fixed, so that the same scene gives the same choice on every machine.
//!
//! ns = 1.02 operations + 3.2 pairs + 0.06 cycles, where pairs are sines with their cosines (and other functions of that weight),
//! operations the other instructions, and cycles the length of the critical path with the latencies of a present-day processor. The
//! constants are a least-squares fit (relative, 6 % rms) to the times of 77 acceleration kernels in the interpreter, from pendulums to a chain of 80
//! bodies: `cargo run --release --example tree_study fit` repeats it. Nothing is measured at export.

use std::collections::HashMap;

use cotree_fmu::program::Layout;
use cotree_fmu::tape::{Operation, Tape};

use super::assembler::Assembler;
use crate::equations::Equations;
use crate::expr::Expr;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Instructions other than pairs.
    pub operations: usize,
    /// Sines with their cosines, and other functions of that weight.
    pub pairs: usize,
    pub cycles: usize,
}

impl Cost {
    pub fn of(tape: &Tape) -> Cost {
        let mut cost = Cost::default();
        let mut ready: HashMap<u32, usize> = HashMap::new();
        for instruction in tape.instructions() {
            let alone = weigh(instruction.operation);
            cost.operations += alone.operations;
            cost.pairs += alone.pairs;
            let start = instruction.operands().filter_map(|register| ready.get(&register).copied()).max();
            let end = start.unwrap_or(0) + alone.cycles;
            cost.cycles = cost.cycles.max(end);
            ready.extend(instruction.targets().map(|register| (register, end)));
        }
        cost
    }

    /// Time by the model \[ns\].
    pub fn nanoseconds(&self) -> f64 {
        1.02 * self.operations as f64 + 3.2 * self.pairs as f64 + 0.06 * self.cycles as f64
    }
}

/// What an operation costs alone.
fn weigh(operation: Operation) -> Cost {
    let simple = |cycles| Cost { operations: 1, pairs: 0, cycles };
    match operation {
        Operation::Copy | Operation::Negate | Operation::Absolute | Operation::Sign | Operation::Select => simple(1),
        Operation::Add
        | Operation::Subtract
        | Operation::Multiply
        | Operation::Minimum
        | Operation::Maximum
        | Operation::Less
        | Operation::LessEqual
        | Operation::Floor => simple(3),
        Operation::MultiplyAdd | Operation::MultiplySubtract | Operation::SubtractProduct => simple(6),
        Operation::Divide => simple(13),
        Operation::SquareRoot => simple(20),
        Operation::SinCos
        | Operation::Tangent
        | Operation::ArcSine
        | Operation::ArcCosine
        | Operation::ArcTangent
        | Operation::ArcTangent2
        | Operation::Exponential
        | Operation::Logarithm
        | Operation::HyperbolicTangent
        | Operation::Power => Cost { operations: 0, pairs: 1, cycles: 45 },
    }
}

/// What a kernel with these results costs.
pub fn kernel_cost(equations: &Equations, results: &[Expr]) -> Cost {
    let mut assembler = Assembler::new(&equations.system.arena, layout(equations, 0), &[results]);
    Cost::of(&assembler.tape(results))
}

/// The registers of the symbols of equations; `starts`: initial values that can be set, which are parameters of the program.
pub(crate) fn layout(equations: &Equations, starts: usize) -> Layout {
    let mechanism = &equations.system.mechanism;
    Layout::new(
        [
            mechanism.parameters.len() + starts,
            mechanism.discrete.len(),
            mechanism.inputs.len(),
            equations.system.followers.len(),
        ],
        [equations.coordinates.len(), equations.states.len()],
        equations.constraints.len(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use cotree_fmu::tape::Instruction;

    #[test]
    fn operations_and_the_longest_chain_of_latencies_are_counted() {
        let step = |operation, target, a, b, c| Instruction { operation, target, a, b, c };
        let instructions = vec![
            step(Operation::SinCos, 10, 0, 0, 11),
            step(Operation::Multiply, 12, 1, 2, 0),
            step(Operation::MultiplyAdd, 13, 12, 11, 3),
            step(Operation::Divide, 12, 13, 10, 0),
            step(Operation::Add, 14, 1, 2, 0),
        ];
        let tape = Tape::new(instructions, vec![12, 14]);
        assert_eq!(Cost::of(&tape), Cost { operations: 4, pairs: 1, cycles: 45 + 6 + 13 });
    }
}
