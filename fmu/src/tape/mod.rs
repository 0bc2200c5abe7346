//! Straight-line programs over a register file of `f64`.

mod interpreter;
mod lanes;
mod series;
mod tangent;

use serde::{Deserialize, Serialize};

pub(crate) use lanes::{DIRECTIONS, Lanes};
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

/// What an instruction does. No fused multiply-add: every operation rounds once, so that results have the same bits everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Operation {
    /// a + b
    Add,
    /// a - b
    Subtract,
    /// a * b
    Multiply,
    /// a / b
    Divide,
    /// -a
    Negate,
    /// a * b + c, rounded twice
    MultiplyAdd,
    /// sqrt a
    SquareRoot,
    /// |a|
    Absolute,
    /// target = sin a, register c = cos a
    SinCos,
    /// tan a
    Tangent,
    /// asin a
    ArcSine,
    /// acos a
    ArcCosine,
    /// atan a
    ArcTangent,
    /// atan2(a, b)
    ArcTangent2,
    /// e^a
    Exponential,
    /// ln a
    Logarithm,
    /// tanh a
    HyperbolicTangent,
    /// a^b
    Power,
    /// -1, 0 or 1
    Sign,
    /// largest integer not above a
    Floor,
    /// the smaller
    Minimum,
    /// the larger
    Maximum,
    /// 1 if a < b, else 0
    Less,
    /// 1 if a <= b, else 0
    LessEqual,
    /// b if a is not 0, else c
    Select,
    /// a, unchanged
    Copy,
}

#[cfg(test)]
impl Operation {
    /// Every one of them.
    const ALL: [Self; 26] = [
        Self::Add,
        Self::Subtract,
        Self::Multiply,
        Self::Divide,
        Self::Negate,
        Self::MultiplyAdd,
        Self::SquareRoot,
        Self::Absolute,
        Self::SinCos,
        Self::Tangent,
        Self::ArcSine,
        Self::ArcCosine,
        Self::ArcTangent,
        Self::ArcTangent2,
        Self::Exponential,
        Self::Logarithm,
        Self::HyperbolicTangent,
        Self::Power,
        Self::Sign,
        Self::Floor,
        Self::Minimum,
        Self::Maximum,
        Self::Less,
        Self::LessEqual,
        Self::Select,
        Self::Copy,
    ];
}
