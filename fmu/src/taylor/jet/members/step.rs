//! What a step of several motions needs of their series: how far it reaches, and the motions at its end.

use super::super::step::{FACTORS, RECIPROCALS, rough_log2};
use super::Members;
use crate::linalg::lane::{Lane, WIDTH, by_width, splat};
use crate::linalg::many::{Elementary, Many, Number};
use crate::math;
use crate::program::arm_form::MAX_ORDER;

impl Members<Many> {
    by_width! {
        /// As [`super::Jet::reach`].
        pub fn reach(&self: Members<Many>, order: usize, tolerance: f64, derivative: usize) -> Lane = reach_any
    }

    #[inline(always)]
    fn reach_any(&self, order: usize, tolerance: f64, derivative: usize) -> Lane {
        let last = order.min(MAX_ORDER);
        let share = math::rough_log2(tolerance) / (order - derivative) as f64;
        let mut least = splat(f64::INFINITY);
        for i in 0..WIDTH {
            let k = last.saturating_sub(i).max(2.min(last));
            let factor = if derivative == 1 { k as f64 } else { 1.0 };
            let logarithms = rough_log2(self.size(k).times(factor).0);
            for (least, logarithm) in least.iter_mut().zip(logarithms) {
                *least = math::minimum(*least, share - logarithm * RECIPROCALS[k - derivative]);
            }
        }
        least.map(math::rough_exp2)
    }

    /// The largest coefficient of one order, relative to what counts of rates.
    #[inline(always)]
    fn size(&self, order: usize) -> Many {
        let mut worst = Many::ZERO;
        for &arm in &self.unknowns {
            let arm = &self.arms[arm];
            worst = worst.larger(arm.value[order] * arm.weight);
        }
        worst
    }

    by_width! {
        /// The motions, each so long after the start of its step; the accelerations there are kept for [`Members::defect`].
        pub(crate) fn evaluate(&mut self: Members<Many>, order: usize, dt: Many, motion: &mut [Many]) = evaluate_any
    }

    /// As [`super::Jet::defect`].
    pub fn defect(&self, order: usize, dt: Lane) -> Lane {
        let mut worst = Many::ZERO;
        for &arm in &self.unknowns {
            let arm = &self.arms[arm];
            worst = worst.larger((arm.end[2] - (arm.value[2] + arm.value[2])) * arm.weight);
        }
        (worst * Many(dt)).times(1.0 / order as f64).0
    }
}

impl<N: Elementary> Members<N> {
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
