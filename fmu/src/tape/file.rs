//! The register file that a tape runs over.

use super::Instruction;
use super::field::{Field, Real};
use super::tangent::Tangent;
use super::uncertain::Uncertain;

/// Registers of a small file: it has exactly so many, and needs no comparison for each access.
pub(crate) const FEW_REGISTERS: usize = 256;

/// Registers by their numbers, which must have been checked before.
pub(super) trait File {
    type Value: Field;

    fn get(&self, register: u32) -> Self::Value;
    fn set(&mut self, register: u32, value: Self::Value);

    /// If both results go to one register, the first of them stays.
    #[inline(always)]
    fn run_sine_and_cosine(&mut self, instruction: &Instruction) {
        let [sine, cosine] = self.get(instruction.a).sine_and_cosine();
        self.set(instruction.c, cosine);
        self.set(instruction.target, sine);
    }
}

impl File for [f64; FEW_REGISTERS] {
    type Value = f64;

    #[inline(always)]
    fn get(&self, register: u32) -> f64 {
        self[register as usize % FEW_REGISTERS]
    }

    #[inline(always)]
    fn set(&mut self, register: u32, value: f64) {
        self[register as usize % FEW_REGISTERS] = value;
    }
}

impl<F: Field> File for [F] {
    type Value = F;

    #[inline(always)]
    fn get(&self, register: u32) -> F {
        self[register as usize]
    }

    #[inline(always)]
    fn set(&mut self, register: u32, value: F) {
        self[register as usize] = value;
    }
}

/// Values, and in a file beside it their derivatives.
pub(super) struct Beside<'a, V, const D: usize> {
    pub values: &'a mut [V],
    pub tangents: &'a mut [[V; D]],
}

impl<V: Real, const D: usize> File for Beside<'_, V, D> {
    type Value = Tangent<V, D>;

    #[inline(always)]
    fn get(&self, register: u32) -> Tangent<V, D> {
        Tangent { value: self.values[register as usize], along: self.tangents[register as usize] }
    }

    #[inline(always)]
    fn set(&mut self, register: u32, Tangent { value, along }: Tangent<V, D>) {
        self.values[register as usize] = value;
        self.tangents[register as usize] = along;
    }
}

/// Values, and in a file beside it by how much they may be wrong.
pub(super) struct WithErrors<'a> {
    pub values: &'a mut [f64],
    pub errors: &'a mut [f64],
}

impl File for WithErrors<'_> {
    type Value = Uncertain;

    #[inline(always)]
    fn get(&self, register: u32) -> Uncertain {
        Uncertain { value: self.values[register as usize], error: self.errors[register as usize] }
    }

    #[inline(always)]
    fn set(&mut self, register: u32, Uncertain { value, error }: Uncertain) {
        self.values[register as usize] = value;
        self.errors[register as usize] = error;
    }
}
