//! Straight-line programs over a register file of `f64`.

mod field;
mod file;
mod operations;
mod run;
mod series;
mod tangent;
mod uncertain;

use serde::{Deserialize, Serialize};

pub(crate) use file::FEW_REGISTERS;
pub use operations::Operation;
pub(crate) use run::{LANE_DIRECTIONS, Lanes};
pub use series::{ORDER, Series};

/// A straight-line program: no branch, no loop, no memory but the registers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Content")]
pub struct Tape {
    instructions: Vec<Instruction>,
    /// Registers that hold the results afterwards.
    pub results: Vec<u32>,
    /// Instructions in a row with the same operation: how many.
    #[serde(skip)]
    runs: Vec<u32>,
}

/// What is stored of a tape.
#[derive(Deserialize)]
struct Content {
    instructions: Vec<Instruction>,
    results: Vec<u32>,
}

impl From<Content> for Tape {
    fn from(Content { instructions, results }: Content) -> Self {
        Self::new(instructions, results)
    }
}

impl Tape {
    /// Instructions in their order, and the registers that hold the results afterwards.
    pub fn new(instructions: Vec<Instruction>, results: Vec<u32>) -> Self {
        let alike = instructions.chunk_by(|a, b| a.operation == b.operation);
        let runs = alike.map(|run| run.len() as u32).collect();
        Self { instructions, results, runs }
    }

    /// Executed in order.
    pub fn instructions(&self) -> &[Instruction] {
        &self.instructions
    }
}

/// `target = operation(a, b, c)`; operands that an operation does not use are 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instruction {
    /// What to do.
    pub operation: Operation,
    /// Register written.
    pub target: u32,
    /// First operand.
    pub a: u32,
    /// Second operand.
    pub b: u32,
    /// Third operand; for `SinCos` the register that receives the cosine.
    pub c: u32,
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
}
