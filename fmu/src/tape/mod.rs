//! Straight-line programs over a register file of `f64`.

mod interpreter;
mod lanes;
mod operations;
mod series;
mod tangent;

use serde::{Deserialize, Serialize};

pub(crate) use lanes::{DIRECTIONS, Lanes};
pub use operations::Operation;
pub use series::{ORDER, Series};

/// A straight-line program: no branch, no loop, no memory but the registers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tape {
    /// Executed in order.
    pub instructions: Vec<Instruction>,
    /// Registers that hold the results afterwards.
    pub results: Vec<u32>,
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
