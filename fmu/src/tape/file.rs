//! The register file that a tape runs over.

/// Registers of a small file: it has exactly so many, and needs no comparison for each access.
pub(crate) const FEW_REGISTERS: usize = 256;

/// Registers by their numbers, which must have been checked before.
pub(super) trait File {
    fn get(&self, register: u32) -> f64;
    fn set(&mut self, register: u32, value: f64);
}

impl File for [f64; FEW_REGISTERS] {
    #[inline(always)]
    fn get(&self, register: u32) -> f64 {
        self[register as usize % FEW_REGISTERS]
    }

    #[inline(always)]
    fn set(&mut self, register: u32, value: f64) {
        self[register as usize % FEW_REGISTERS] = value;
    }
}

impl File for [f64] {
    #[inline(always)]
    fn get(&self, register: u32) -> f64 {
        self[register as usize]
    }

    #[inline(always)]
    fn set(&mut self, register: u32, value: f64) {
        self[register as usize] = value;
    }
}
