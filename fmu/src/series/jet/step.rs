//! What a step needs of the series: how far it reaches, and the motion at its end.

use super::{Jet, Shape};
use crate::math;
use crate::series::MAX_ORDER;
use crate::series::form::{ArmForm, Place};
use crate::series::lane::{Lane, WIDTH, ZERO, add, by_width, larger, largest, multiply, plus, splat, subtract};

/// Coefficients that the reach follows from, beside the last one: some vanish by symmetry.
const WINDOW: usize = 3;

/// Where the value of a coordinate lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Read {
    place: usize,
    /// The angle that it is counted from.
    from: Option<usize>,
    reversed: bool,
}

impl Read {
    pub(super) fn new(shape: &Shape, place: Place) -> Self {
        match place {
            Place::Displacement { arm } => Read { place: shape.place(arm), from: None, reversed: false },
            Place::Angle { arm, parent, reversed } => {
                Read { place: arm as usize, from: parent.map(|parent| parent as usize), reversed }
            }
        }
    }

    #[inline(always)]
    fn value(self, values: &[f64]) -> f64 {
        let value = values[self.place] - self.from.map_or(0.0, |from| values[from]);
        if self.reversed { -value } else { value }
    }
}

impl Jet {
    /// Numbers in a polynomial of the highest order.
    pub fn room(form: &ArmForm) -> usize {
        (MAX_ORDER + 1) * Shape::new(form).all() * WIDTH
    }

    /// The polynomial of all unknowns, by orders.
    pub fn polynomial(&self, order: usize) -> &[f64] {
        self.values[..(order + 1) * self.shape.all()].as_flattened()
    }

    /// Coefficients of the coordinates.
    pub fn coordinates(&self, order: usize, values: &mut [f64]) {
        self.read(self.values[order * self.shape.all()..].as_flattened(), values);
    }

    fn read(&self, from: &[f64], values: &mut [f64]) {
        for (value, read) in values.iter_mut().zip(&self.reads) {
            *value = read.value(from);
        }
    }

    by_width! {
        /// q and v along a polynomial, dt after its start; the accelerations there are kept for [`Jet::defect`].
        pub fn evaluate(&mut self: Jet, polynomial: &[f64], order: usize, dt: f64, motion: &mut [f64]) = evaluate_any
    }

    #[inline(always)]
    fn evaluate_any(&mut self, polynomial: &[f64], order: usize, dt: f64, motion: &mut [f64]) {
        let all = self.shape.all();
        let (coefficients, _) = polynomial.as_chunks::<WIDTH>();
        for lane in 0..all {
            for (end, value) in self.end.iter_mut().zip(derivatives(&coefficients[lane..], all, order, dt)) {
                end[lane] = value;
            }
        }
        let (q, v) = motion.split_at_mut(self.reads.len());
        self.read(self.end[0].as_flattened(), q);
        self.read(self.end[1].as_flattened(), v);
    }

    /// By how much the rates at the end of a step are wrong, judging by its accelerations there, as last evaluated, and those of the
    /// series that begins there.
    pub fn defect(&self, order: usize, dt: f64) -> f64 {
        let all = self.shape.all();
        let mut worst = ZERO;
        for ((end, new), weight) in self.end[2].iter().zip(&self.values[2 * all..]).zip(&self.weights) {
            let error = multiply(subtract(*end, add(*new, *new)), *weight);
            worst = larger(worst, error);
        }
        largest(worst) * dt / order as f64
    }

    /// What counts of each unknown: the reciprocal of its scale a second, or of its rate if that is larger.
    pub(super) fn weigh(&mut self) {
        let all = self.shape.all();
        let rates = &self.values[all..];
        for ((weights, scales), rates) in self.weights.iter_mut().zip(&self.scales).zip(rates) {
            for ((weight, scale), rate) in weights.iter_mut().zip(scales).zip(rates) {
                *weight = 1.0 / math::maximum(*scale, rate.abs());
            }
        }
    }

    /// The largest coefficient of one order, relative to what counts of rates.
    #[inline(always)]
    pub fn size(&self, order: usize) -> f64 {
        let all = self.shape.all();
        let coefficients = self.values[order * all..].iter().zip(&self.weights);
        largest(coefficients.fold(ZERO, |worst, (value, weight)| larger(worst, multiply(*value, *weight))))
    }

    by_width! {
        /// The step that a tolerance on rates (`derivative` 1) or positions (0) permits if the coefficients shrink as the last ones do:
        /// rho tol^(1/p) (Jorba and Zou, 2005).
        pub fn reach(&mut self: Jet, order: usize, tolerance: f64, derivative: usize) -> f64 = reach_any
    }

    #[inline(always)]
    fn reach_any(&mut self, order: usize, tolerance: f64, derivative: usize) -> f64 {
        let first = order.saturating_sub(WINDOW).max(2);
        let share = math::rough_log2(tolerance) / (order - derivative) as f64;
        let mut reach = f64::INFINITY;
        for k in first..=order {
            let factor = if derivative == 1 { k as f64 } else { 1.0 };
            let bound = share - math::rough_log2(factor * self.size(k)) / (k - derivative) as f64;
            reach = math::minimum(reach, bound);
        }
        math::rough_exp2(reach)
    }
}

/// Value and first two derivatives of one lane of a polynomial, even and odd terms apart so that they do not wait for each other.
#[inline(always)]
fn derivatives(coefficients: &[Lane], stride: usize, order: usize, dt: f64) -> [Lane; 3] {
    let (mut even, mut odd) = ([ZERO; 3], [ZERO; 3]);
    let (step, square) = (splat(dt), splat(dt * dt));
    for k in (2..=order).rev() {
        let value = coefficients[k * stride];
        let rate = multiply(value, splat(k as f64));
        let second = multiply(rate, splat(k as f64 - 1.0));
        let sums = if k % 2 == 0 { &mut even } else { &mut odd };
        *sums = [plus(value, sums[0], square), plus(rate, sums[1], square), plus(second, sums[2], square)];
    }
    let first = coefficients[stride];
    let (value, rate) = (plus(first, odd[0], square), plus(first, odd[1], square));
    let even_value = plus(coefficients[0], even[0], square);
    [plus(even_value, value, step), plus(rate, even[1], step), plus(even[2], odd[2], step)]
}
