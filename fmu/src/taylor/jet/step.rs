//! What a step needs of the series: how far it reaches, and the motion at its end.

use super::{Coefficient, Jet, Shape};
use crate::linalg::lane::{Lane, WIDTH, ZERO, add, by_width, larger, largest, multiply, plus, splat, subtract};
use crate::linalg::number::Number;
use crate::math;
use crate::program::arm_form::CoordinatePlace;
use crate::program::arm_form::MAX_ORDER;

/// Where the value of a coordinate lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Read {
    place: usize,
    /// The angle that it is counted from.
    from: Option<usize>,
    reversed: bool,
}

impl Read {
    pub(super) fn new(shape: &Shape, place: CoordinatePlace) -> Self {
        match place {
            CoordinatePlace::Displacement { arm } => Read { place: shape.place(arm), from: None, reversed: false },
            CoordinatePlace::Angle { arm, parent, reversed } => {
                Read { place: arm as usize, from: parent.map(|parent| parent as usize), reversed }
            }
        }
    }

    /// Of the unknown that it is.
    pub(super) fn place(&self) -> usize {
        self.place
    }

    #[inline(always)]
    fn value<N: Number>(self, values: &[N]) -> N {
        let value = values[self.place] - self.from.map_or(N::ZERO, |place| values[place]);
        if self.reversed { -value } else { value }
    }
}

#[expect(private_bounds, reason = "there are two kinds of numbers")]
impl<N: Coefficient, const L: usize> Jet<N, L> {
    /// Coefficients of the coordinates.
    pub fn coordinates(&self, order: usize, values: &mut [N]) {
        read(&self.reads, self.values[order * self.shape.all()..].as_flattened(), values);
    }

    by_width! {
        /// q and v along a polynomial, dt after its start; the accelerations there are kept for [`Jet::defect`].
        pub fn evaluate[N: Coefficient, const L: usize](&mut self: Jet<N, L>, polynomial: &[N], order: usize, dt: N, motion: &mut [N]) = evaluate_any
    }

    #[inline(always)]
    pub(super) fn evaluate_any(&mut self, polynomial: &[N], order: usize, dt: N, motion: &mut [N]) {
        let all = self.shape.all();
        let (coefficients, _) = polynomial.as_chunks::<L>();
        for lane in 0..all {
            let [value, rate, second] = derivatives(&coefficients[lane..], all, order, dt);
            (self.end[0][lane], self.end[1][lane], self.end[2][lane]) = (value, rate, second);
        }
        let (q, v) = motion.split_at_mut(self.reads.len());
        read(&self.reads, self.end[0].as_flattened(), q);
        read(&self.reads, self.end[1].as_flattened(), v);
    }

    /// What counts of each unknown: the reciprocal of its rate, or of the least that counts relative to itself.
    pub(super) fn weigh(&mut self) {
        let all = self.shape.all();
        let rates = &self.values[all..];
        for ((weights, scale), rates) in self.weights.iter_mut().zip(&self.scales).zip(rates) {
            for (weight, rate) in weights.iter_mut().zip(rates) {
                *weight = 1.0 / math::maximum(self.least_rate * scale, rate.value().abs());
            }
        }
    }
}

/// Coordinates from unknowns.
fn read<N: Number>(reads: &[Read], from: &[N], values: &mut [N]) {
    for (value, read) in values.iter_mut().zip(reads) {
        *value = read.value(from);
    }
}

impl Jet {
    /// One coordinate along a polynomial.
    pub fn coordinate(&self, polynomial: &[f64], order: usize, index: usize, coefficients: &mut [f64]) {
        let (read, count) = (self.reads[index], self.shape.places());
        let orders = 0..(order + 1).min(coefficients.len());
        match read.from {
            None if !read.reversed => {
                orders.for_each(|k| coefficients[k] = polynomial[k * count + read.place]);
            }
            _ => orders.for_each(|k| coefficients[k] = read.value(&polynomial[k * count..])),
        }
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

    /// The accelerations of the coordinates at the end of a step, as last evaluated.
    pub fn accelerations_at_end(&self, accelerations: &mut [f64]) {
        read(&self.reads, self.end[2].as_flattened(), accelerations);
    }

    /// The largest coefficient of one order, relative to what counts of rates.
    #[inline(always)]
    pub fn size(&self, order: usize) -> f64 {
        let all = self.shape.all();
        let (values, weights) = (&self.values[order * all..][..all], &self.weights[..all]);
        let mut worst = ZERO;
        for lane in 0..all {
            worst = larger(worst, multiply(values[lane], weights[lane]));
        }
        largest(worst)
    }

    by_width! {
        /// The step that a tolerance on rates (`derivative` 1) or positions (0) permits if the coefficients shrink as the last ones do:
        /// rho tol^(1/p) (Jorba and Zou, 2005). Four of them count: some vanish by symmetry.
        pub fn reach(&mut self: Jet, order: usize, tolerance: f64, derivative: usize) -> f64 = reach_any
    }

    #[inline(always)]
    fn reach_any(&mut self, order: usize, tolerance: f64, derivative: usize) -> f64 {
        if derivative == 1
            && let Some(length) = self.found.length(order, tolerance)
        {
            return length;
        }
        let last = order.min(MAX_ORDER);
        let share = math::rough_log2(tolerance) / (order - derivative) as f64;
        // Short series have fewer orders than there are places: the last one then counts more than once.
        let (mut sizes, mut counts) = ([0.0; WIDTH], [0.0; WIDTH]);
        for i in 0..WIDTH {
            let k = last.saturating_sub(i).max(2.min(last));
            let factor = if derivative == 1 { k as f64 } else { 1.0 };
            (sizes[i], counts[i]) = (factor * self.size(k), RECIPROCALS[k - derivative]);
        }
        let bounds = subtract(splat(share), multiply(rough_log2(sizes), counts));
        let pairs = [math::minimum(bounds[0], bounds[1]), math::minimum(bounds[2], bounds[3])];
        math::rough_exp2(math::minimum(pairs[0], pairs[1]))
    }
}

/// 1 / k
pub(super) const RECIPROCALS: [f64; MAX_ORDER + 1] = {
    let mut table = [0.0; MAX_ORDER + 1];
    let mut k = 1;
    while k <= MAX_ORDER {
        table[k] = 1.0 / k as f64;
        k += 1;
    }
    table
};

/// Four logarithms with the bits of [`math::rough_log2`].
#[inline(always)]
pub(super) fn rough_log2(x: Lane) -> Lane {
    let least = math::minimum(math::minimum(x[0], x[1]), math::minimum(x[2], x[3]));
    // Written so that NaN is not normal.
    let normal = least >= f64::MIN_POSITIVE && largest(x) < f64::INFINITY;
    if !normal {
        return [math::rough_log2(x[0]), math::rough_log2(x[1]), math::rough_log2(x[2]), math::rough_log2(x[3])];
    }
    let mut result = ZERO;
    for i in 0..WIDTH {
        result[i] = math::rough_log2_of_normal(x[i]);
    }
    result
}

/// k and k - 1.
pub(super) const FACTORS: [[f64; 2]; MAX_ORDER + 1] = {
    let mut table = [[0.0; 2]; MAX_ORDER + 1];
    let mut k = 1;
    while k <= MAX_ORDER {
        table[k] = [k as f64, k as f64 - 1.0];
        k += 1;
    }
    table
};

/// One term more of the value and its first two derivatives, by Horner's rule in the square of the step.
#[inline(always)]
fn more<N: Number, const L: usize>(
    sums: [Lane<N, L>; 3],
    value: Lane<N, L>,
    k: usize,
    square: Lane<N, L>,
) -> [Lane<N, L>; 3] {
    let [first, second] = FACTORS[k];
    let rate = multiply(value, splat(N::all(first)));
    let second = multiply(rate, splat(N::all(second)));
    [plus(value, sums[0], square), plus(rate, sums[1], square), plus(second, sums[2], square)]
}

/// Value and first two derivatives of one lane of a polynomial, even and odd terms apart so that they do not wait for each other.
#[inline(always)]
fn derivatives<N: Number, const L: usize>(
    coefficients: &[Lane<N, L>],
    stride: usize,
    order: usize,
    dt: N,
) -> [Lane<N, L>; 3] {
    let zero = splat(N::ZERO);
    let (mut even, mut odd) = ([zero, zero, zero], [zero, zero, zero]);
    let (step, square) = (splat(dt), splat(dt * dt));
    let mut k = order.min(MAX_ORDER);
    if k >= 2 && k.is_multiple_of(2) {
        even = more(even, coefficients[k * stride], k, square);
        k -= 1;
    }
    // Two at a time: their sums stay in registers.
    while k >= 3 {
        odd = more(odd, coefficients[k * stride], k, square);
        even = more(even, coefficients[(k - 1) * stride], k - 1, square);
        k -= 2;
    }
    let first = coefficients[stride];
    let (value, rate) = (plus(first, odd[0], square), plus(first, odd[1], square));
    let even_value = plus(coefficients[0], even[0], square);
    [plus(even_value, value, step), plus(rate, even[1], step), plus(even[2], odd[2], step)]
}
