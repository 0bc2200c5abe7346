//! Pseudorandom numbers with a fixed seed.

use std::f64::consts::TAU;

use crate::{Point, polar};

/// Source: G. Steele, D. Lea, C. Flood, *Fast splittable pseudorandom number generators* (SplitMix64), 2014.
#[derive(Clone, Debug)]
pub struct RandomNumbers(u64);

impl RandomNumbers {
    /// Numbers that begin from a seed.
    pub fn new(seed: u64) -> RandomNumbers {
        RandomNumbers(seed)
    }

    /// The next integer.
    pub fn integer(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Even between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.integer() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A choice of so many.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.between(0.0, count as f64)) as usize).min(count.saturating_sub(1))
    }

    /// With normal distribution, mean 0 and deviation 1 in both directions (Box and Muller).
    pub fn normal(&mut self) -> Point {
        let radius = (-2.0 * self.between(1e-300, 1.0).ln()).sqrt();
        polar(radius, self.between(0.0, TAU))
    }
}
