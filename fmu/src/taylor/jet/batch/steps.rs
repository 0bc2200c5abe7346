//! How long the steps of four motions may be.

use super::MEMBERS;
use crate::linalg::number::Number;
use crate::linalg::quad::Quad;
use crate::math;
use crate::program::arm_form::MAX_ORDER;
use crate::taylor::jet::Jet;
use crate::taylor::jet::step::{RECIPROCALS, rough_log2};

/// What the lengths of steps depend on besides the series.
#[derive(Debug)]
pub(super) struct Steps {
    /// What one step of each motion may be wrong by.
    pub tolerances: [f64; MEMBERS],
    /// The least rates that count relative to themselves, in scales a second.
    pub least_rates: Quad,
    /// What counts of each unknown.
    weights: Vec<Quad>,
    /// The steps that the tolerances on rates permit with the last series; no numbers if these are none.
    pub lengths: Quad,
}

impl Steps {
    /// Storage for a series.
    pub fn new(series: &Jet<Quad, 1>) -> Self {
        let weights = vec![Quad::ZERO; series.shape.all()];
        Self { tolerances: [0.0; MEMBERS], least_rates: Quad::ZERO, weights, lengths: Quad::ZERO }
    }

    /// [`Jet::reach`] of rates.
    #[inline(always)]
    pub fn find_lengths(&mut self, series: &Jet<Quad, 1>, order: usize) {
        let all = series.shape.all();
        for ((weight, [rate]), scale) in self.weights.iter_mut().zip(&series.values[all..]).zip(&series.scales) {
            let least = self.least_rates.times(*scale).with(rate.map(f64::abs), math::maximum);
            *weight = Quad::all(1.0).over(least);
        }
        let last = order.min(MAX_ORDER);
        let mut bounds = [Quad::ZERO; 4];
        for (i, bound) in bounds.iter_mut().enumerate() {
            let k = last.saturating_sub(i).max(2.min(last));
            let mut size = Quad::ZERO;
            for ([value], weight) in series.values[k * all..][..all].iter().zip(&self.weights) {
                size = size.larger(*value * *weight);
            }
            *bound = Quad::of(rough_log2(size.times(k as f64).numbers())).times(RECIPROCALS[k - 1]);
        }
        for member in 0..MEMBERS {
            let share = math::rough_log2(self.tolerances[member]) / (order - 1) as f64;
            let [a, b, c, d] = bounds.map(|bound| share - bound.get(member));
            let least = math::minimum(math::minimum(a, b), math::minimum(c, d));
            self.lengths.set(member, math::rough_exp2(least));
        }
    }
}
