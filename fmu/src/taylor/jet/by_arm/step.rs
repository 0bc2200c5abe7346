//! The motion at the end of a step.

use super::super::step::FACTORS;
use super::ByArm;
use crate::linalg::number::{Elementary, Number};
use crate::program::arm_form::MAX_ORDER;

impl<N: Elementary> ByArm<N> {
    #[inline(always)]
    pub(super) fn evaluate_any(&mut self, order: usize, step: N, motion: &mut [N]) {
        let square = step * step;
        for index in 0..self.unknowns.len() {
            let arm = &mut self.arms[self.unknowns[index]];
            arm.end = derivatives(&arm.value[..order.min(MAX_ORDER) + 1], step, square);
        }
        let (q, v) = motion.split_at_mut(self.reads.len());
        for ((q, v), read) in q.iter_mut().zip(v).zip(&self.reads) {
            *q = read.value_in(|arm| self.arms[arm].end[0]);
            *v = read.value_in(|arm| self.arms[arm].end[1]);
        }
    }
}

/// One term more of the value and its first two derivatives, by Horner's rule in the square of the step.
#[inline(always)]
fn more<N: Number>([value, rate, second]: [N; 3], coefficient: N, k: usize, square: N) -> [N; 3] {
    let [first, next] = FACTORS[k].map(N::all);
    let slope = coefficient * first;
    [coefficient + value * square, slope + rate * square, slope * next + second * square]
}

/// Value and first two derivatives of a polynomial, even and odd terms apart.
#[inline(always)]
fn derivatives<N: Number>(coefficients: &[N], step: N, square: N) -> [N; 3] {
    let (mut even, mut odd) = ([N::ZERO; 3], [N::ZERO; 3]);
    let mut k = coefficients.len() - 1;
    if k >= 2 && k.is_multiple_of(2) {
        even = more(even, coefficients[k], k, square);
        k -= 1;
    }
    // Two at a time: their sums stay in registers.
    while k >= 3 {
        odd = more(odd, coefficients[k], k, square);
        even = more(even, coefficients[k - 1], k - 1, square);
        k -= 2;
    }
    let first = coefficients[1];
    [
        coefficients[0] + even[0] * square + (first + odd[0] * square) * step,
        first + odd[1] * square + even[1] * step,
        even[2] + odd[2] * step,
    ]
}
