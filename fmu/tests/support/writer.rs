//! Tapes written one operation after the other.

use cotree_fmu::program::{Layout, Program};
use cotree_fmu::tape::{Instruction, Operation, Tape};

/// Places reserved for constants.
const CONSTANTS: u32 = 32;

/// Writes tapes over one register file; scratch registers are never used twice.
pub struct Writer {
    layout: Layout,
    constants: Vec<f64>,
    next: u32,
    instructions: Vec<Instruction>,
}

impl Writer {
    pub fn new(layout: Layout) -> Self {
        let next = layout.constants() as u32 + CONSTANTS;
        Self { layout, constants: Vec::new(), next, instructions: Vec::new() }
    }

    pub fn constant(&mut self, value: f64) -> u32 {
        self.constants.push(value);
        assert!(self.constants.len() <= CONSTANTS as usize);
        self.layout.constants() as u32 + self.constants.len() as u32 - 1
    }

    pub fn op(&mut self, operation: Operation, a: u32, b: u32) -> u32 {
        self.next += 1;
        self.instructions.push(Instruction { operation, target: self.next - 1, a, b, c: 0 });
        self.next - 1
    }
    pub fn add(&mut self, a: u32, b: u32) -> u32 {
        self.op(Operation::Add, a, b)
    }
    pub fn sub(&mut self, a: u32, b: u32) -> u32 {
        self.op(Operation::Subtract, a, b)
    }
    pub fn mul(&mut self, a: u32, b: u32) -> u32 {
        self.op(Operation::Multiply, a, b)
    }
    pub fn div(&mut self, a: u32, b: u32) -> u32 {
        self.op(Operation::Divide, a, b)
    }
    pub fn neg(&mut self, a: u32) -> u32 {
        self.op(Operation::Negate, a, 0)
    }
    /// Sine and cosine.
    pub fn sin_cos(&mut self, a: u32) -> [u32; 2] {
        let (sine, cosine) = (self.next, self.next + 1);
        self.next += 2;
        self.instructions.push(Instruction { operation: Operation::SinCos, target: sine, a, b: 0, c: cosine });
        [sine, cosine]
    }
    /// Sum of products.
    pub fn dot(&mut self, pairs: &[(u32, u32)]) -> u32 {
        let products: Vec<u32> = pairs.iter().map(|&(a, b)| self.mul(a, b)).collect();
        products.into_iter().reduce(|sum, product| self.add(sum, product)).expect("at least one product")
    }
    /// Solves a symmetric definite or saddle-point system by elimination without pivoting.
    pub fn solve(&mut self, mut matrix: Vec<Vec<u32>>, mut right: Vec<u32>) -> Vec<u32> {
        let n = right.len();
        for k in 0..n {
            let pivot = matrix[k].clone();
            for i in k + 1..n {
                let factor = self.div(matrix[i][k], pivot[k]);
                for (entry, &above) in matrix[i].iter_mut().zip(&pivot).skip(k + 1) {
                    let product = self.mul(factor, above);
                    *entry = self.sub(*entry, product);
                }
                let product = self.mul(factor, right[k]);
                right[i] = self.sub(right[i], product);
            }
        }
        for k in (0..n).rev() {
            for j in k + 1..n {
                let product = self.mul(matrix[k][j], right[j]);
                right[k] = self.sub(right[k], product);
            }
            right[k] = self.div(right[k], matrix[k][k]);
        }
        right
    }
    pub fn tape(&mut self, results: Vec<u32>) -> Tape {
        Tape::new(std::mem::take(&mut self.instructions), results)
    }
    /// Completes a program.
    pub fn finish(mut self, mut program: Program) -> Program {
        self.constants.resize(CONSTANTS as usize, 0.0);
        program.constants = self.constants;
        program.registers = self.next;
        program
    }
}
