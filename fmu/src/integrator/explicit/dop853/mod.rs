//! One step of DOP853 at a time, without memory of the problem.
//!
//! The caller owns the policy: which step to try, what to do with a rejected one, when to ask for dense output.

mod coefficients;

use crate::integrator::right_hand_side::Derivative;
use coefficients::{DENSE, DENSE_ROWS, DENSE_STAGES, ERROR_5, NODES, ORDER, STAGE, STAGES, StageRow, WEIGHTS_3};

/// Safety factor of the step size.
const EXPLICIT_SAFETY: f64 = 0.8;
/// Steps grow and shrink by no more than this factor.
const EXPLICIT_GROWTH: f64 = 3.0;

/// Storage for the stages of a step.
#[derive(Clone, Debug)]
pub struct Dop853 {
    size: usize,
    stages: Vec<f64>,
    sum: Vec<f64>,
    point: Vec<f64>,
}

impl Dop853 {
    /// Storage for y of that size.
    pub fn new(size: usize) -> Self {
        Self { size, stages: vec![0.0; DENSE_STAGES * size], sum: vec![0.0; size], point: vec![0.0; size] }
    }

    /// Length of a dense output for y of that size: y at the start, then the rows.
    pub fn dense_length(size: usize) -> usize {
        (1 + DENSE_ROWS) * size
    }

    /// The derivative at the start of the step.
    pub fn first(&self) -> &[f64] {
        &self.stages[..self.size]
    }

    /// Evaluates the derivative at the start of a step.
    pub fn begin(&mut self, f: &mut impl Derivative, time: f64, y: &[f64]) {
        f.evaluate(time, y, &mut self.stages[..self.size]);
    }

    /// Tries a step from y; its end is written to `next`.
    pub fn attempt(&mut self, f: &mut impl Derivative, time: f64, y: &[f64], h: f64, next: &mut [f64]) {
        for stage in 1..STAGES - 1 {
            self.evaluate_stage(f, stage, time, y, h);
        }
        self.combine(STAGE[STAGES - 1]);
        advance(y, h, &self.sum, next);
    }

    fn evaluate_stage(&mut self, f: &mut impl Derivative, stage: usize, time: f64, y: &[f64], h: f64) {
        self.combine(STAGE[stage]);
        advance(y, h, &self.sum, &mut self.point);
        f.evaluate(time + NODES[stage] * h, &self.point, &mut self.stages[stage * self.size..][..self.size]);
    }

    /// sum = the row's combination of the stages.
    fn combine(&mut self, row: StageRow) {
        combine(&self.stages, row, &mut self.sum);
    }

    /// Error of the step just tried, in units of the tolerances: accept up to 1. NaN if a stage is not finite.
    pub fn error(&mut self, h: f64, tolerances: &[f64]) -> f64 {
        let mean_square = |values: &[f64]| {
            let squares = values.iter().zip(tolerances).map(|(value, tolerance)| (value / tolerance).powi(2));
            squares.sum::<f64>() / values.len().max(1) as f64
        };
        self.combine(ERROR_5);
        let fifth = mean_square(&self.sum);
        combine(&self.stages, WEIGHTS_3, &mut self.point);
        combine(&self.stages, STAGE[STAGES - 1], &mut self.sum);
        self.sum.iter_mut().zip(&self.point).for_each(|(eighth, third)| *eighth -= third);
        let third = mean_square(&self.sum);
        // Hairer, Norsett, Wanner (1993), Eq. (II.10.17): err5 * err5 / sqrt(err5^2 + 0.01 err3^2), of order 7.
        let denominator = fifth + 0.01 * third;
        if denominator == 0.0 { 0.0 } else { h.abs() * fifth / denominator.sqrt() }
    }

    /// Evaluates the derivative at the end of an accepted step.
    pub fn finish(&mut self, f: &mut impl Derivative, time: f64, next: &[f64]) {
        f.evaluate(time, next, &mut self.stages[(STAGES - 1) * self.size..][..self.size]);
    }

    /// The derivative at the end of the step.
    pub fn last(&self) -> &[f64] {
        &self.stages[(STAGES - 1) * self.size..][..self.size]
    }

    /// Makes the end of this step the start of the next one.
    pub fn roll(&mut self) {
        self.stages.copy_within((STAGES - 1) * self.size..STAGES * self.size, 0);
    }

    /// Three more stages and the dense output of the step from y to next, after [`Dop853::finish`].
    pub fn dense(&mut self, f: &mut impl Derivative, time: f64, y: &[f64], h: f64, next: &[f64], dense: &mut [f64]) {
        for stage in STAGES..DENSE_STAGES {
            self.evaluate_stage(f, stage, time, y, h);
        }
        let size = self.size;
        let (start, rows) = dense.split_at_mut(size);
        start.copy_from_slice(y);
        for i in 0..size {
            let difference = next[i] - y[i];
            let (first, last) = (h * self.stages[i], h * self.stages[(STAGES - 1) * size + i]);
            rows[i] = difference;
            rows[size + i] = first - difference;
            rows[2 * size + i] = 2.0 * difference - (first + last);
        }
        for (row, place) in DENSE.into_iter().zip(rows[3 * size..DENSE_ROWS * size].chunks_exact_mut(size.max(1))) {
            combine(&self.stages, row, place);
            place.iter_mut().for_each(|value| *value *= h);
        }
    }

    /// A first step size: Hairer, Norsett, Wanner (1993), section II.4, after [`Dop853::begin`].
    pub fn starting_step(&mut self, f: &mut impl Derivative, time: f64, y: &[f64], tolerances: &[f64]) -> f64 {
        let norm = |values: &[f64]| {
            let squares = values.iter().zip(tolerances).map(|(value, tolerance)| (value / tolerance).powi(2));
            (squares.sum::<f64>() / values.len().max(1) as f64).sqrt()
        };
        let (size, slope) = (norm(y), norm(self.first()));
        let guess = if size < 1e-5 || slope < 1e-5 { 1e-6 } else { 0.01 * size / slope };
        advance(y, guess, &self.stages[..self.size], &mut self.point);
        f.evaluate(time + guess, &self.point, &mut self.sum);
        let change = self.sum.iter_mut().zip(&self.stages[..self.size]);
        change.for_each(|(after, before)| *after -= before);
        let curvature = norm(&self.sum) / guess;
        let steepest = slope.max(curvature);
        let step = if steepest <= 1e-15 { (1e-3 * guess).max(1e-6) } else { libm::pow(0.01 / steepest, 1.0 / ORDER) };
        // Written so that NaN falls back to the guess.
        if step < 100.0 * guess { step } else { 100.0 * guess }
    }
}

/// y at the fraction `theta` of the step that made the dense output.
pub fn interpolate(dense: &[f64], theta: f64, y: &mut [f64]) {
    let size = y.len();
    let rest = 1.0 - theta;
    for (i, place) in y.iter_mut().enumerate() {
        let row = |k: usize| dense[(1 + k) * size + i];
        let upper = row(3) + theta * (row(4) + rest * (row(5) + theta * row(6)));
        *place = dense[i] + theta * (row(0) + rest * (row(1) + theta * (row(2) + rest * upper)));
    }
}

/// The derivative by `theta` of one component of what [`interpolate`] yields.
pub fn slope(dense: &[f64], theta: f64, size: usize, component: usize) -> f64 {
    let rest = 1.0 - theta;
    let (mut value, mut slope) = (0.0, 0.0);
    // y = rows with factors theta, 1 - theta, theta, .. between them, from the inside.
    for k in (0..=DENSE_ROWS).rev() {
        let (factor, change) = if k % 2 == 0 { (theta, 1.0) } else { (rest, -1.0) };
        slope = change * value + factor * slope;
        value = dense[k * size + component] + factor * value;
    }
    slope
}

/// The next step size by the error of the last one.
pub fn next_step(h: f64, error: f64, rejected: bool) -> f64 {
    let most = if rejected { 1.0 } else { EXPLICIT_GROWTH };
    let least = 1.0 / EXPLICIT_GROWTH;
    let factor = EXPLICIT_SAFETY * libm::pow(error, -1.0 / ORDER);
    // The error may be 0 (infinite factor) or not finite (shrink).
    h * if factor > least { factor.min(most) } else { least }
}

fn combine(stages: &[f64], row: StageRow, sum: &mut [f64]) {
    let size = sum.len();
    sum.fill(0.0);
    for &(stage, coefficient) in row {
        for (sum, value) in sum.iter_mut().zip(&stages[stage * size..][..size]) {
            *sum += coefficient * value;
        }
    }
}

fn advance(y: &[f64], h: f64, slope: &[f64], place: &mut [f64]) {
    for ((place, y), slope) in place.iter_mut().zip(y).zip(slope) {
        *place = y + h * slope;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Row of a method as a full vector.
    fn full(row: StageRow) -> [f64; DENSE_STAGES] {
        let mut values = [0.0; DENSE_STAGES];
        row.iter().for_each(|&(stage, coefficient)| values[stage] = coefficient);
        values
    }

    /// Elementary weights of all rooted trees up to some order, as (order, density, vector over the stages): a tree is a product of
    /// branches; its vector is the product of A applied to the vectors of the branches.
    fn trees(orders: usize) -> Vec<(usize, f64, [f64; DENSE_STAGES])> {
        let apply = |v: &[f64; DENSE_STAGES]| std::array::from_fn(|i| STAGE[i].iter().map(|&(j, a)| a * v[j]).sum());
        let mut trees = vec![(1, 1.0, [1.0; DENSE_STAGES])];
        let mut branches: Vec<(usize, f64, [f64; DENSE_STAGES])> = Vec::new();
        for order in 2..=orders {
            for (o, gamma, vector) in trees.iter().filter(|tree| tree.0 == order - 1) {
                branches.push((*o, *gamma, apply(vector)));
            }
            // Multisets of branches with order - 1 vertices in all.
            let mut partial = vec![(0_usize, 0_usize, 1.0, [1.0; DENSE_STAGES])];
            while let Some((least, vertices, gamma, vector)) = partial.pop() {
                if vertices == order - 1 {
                    trees.push((order, gamma * order as f64, vector));
                    continue;
                }
                for (index, branch) in branches.iter().enumerate().skip(least) {
                    if vertices + branch.0 < order {
                        let product = std::array::from_fn(|i| vector[i] * branch.2[i]);
                        partial.push((index, vertices + branch.0, gamma * branch.1, product));
                    }
                }
            }
        }
        trees
    }

    #[test]
    fn order_conditions_hold_for_all_rooted_trees() {
        let trees = trees(8);
        let counts: Vec<usize> = (1..=8).map(|order| trees.iter().filter(|tree| tree.0 == order).count()).collect();
        assert_eq!(counts, [1, 1, 2, 4, 9, 20, 48, 115]);
        let (weights, error, third) = (full(STAGE[STAGES - 1]), full(ERROR_5), full(WEIGHTS_3));
        for (order, gamma, vector) in trees {
            let sum = |row: &[f64]| row.iter().zip(vector).map(|(b, phi)| b * phi).sum::<f64>();
            assert!((sum(&weights) - 1.0 / gamma).abs() < 2e-14, "order {order}, {gamma}");
            assert!(order > 5 || sum(&error).abs() < 2e-14, "embedded order 5, {order}");
            assert!(order > 3 || (sum(&third) - 1.0 / gamma).abs() < 2e-14, "embedded order 3, {order}");
        }
        for stage in 0..DENSE_STAGES {
            let sum: f64 = STAGE[stage].iter().map(|&(_, a)| a).sum();
            assert!((sum - NODES[stage]).abs() < 1e-14);
        }
    }

    /// y'' = -y with y = (position, rate), and a nonautonomous part with a known solution.
    fn problem(time: f64, y: &[f64], derivative: &mut [f64]) {
        derivative[0] = y[1];
        derivative[1] = -y[0];
        derivative[2] = y[2] * time.cos();
    }

    fn exact(time: f64) -> [f64; 3] {
        [time.cos(), -time.sin(), time.sin().exp()]
    }

    /// Largest error at the end and between the steps, over [0, 3].
    fn run(steps: u32) -> [f64; 2] {
        let mut method = Dop853::new(3);
        let (mut y, mut next) = (exact(0.0).to_vec(), vec![0.0; 3]);
        let mut dense = vec![0.0; Dop853::dense_length(3)];
        let h = 3.0 / f64::from(steps);
        let difference = |y: &[f64], time: f64| {
            y.iter().zip(exact(time)).fold(0.0, |worst: f64, (y, exact)| worst.max((y - exact).abs()))
        };
        let mut between: f64 = 0.0;
        for step in 0..steps {
            let time = f64::from(step) * h;
            method.begin(&mut problem, time, &y);
            method.attempt(&mut problem, time, &y, h, &mut next);
            method.finish(&mut problem, time + h, &next);
            method.dense(&mut problem, time, &y, h, &next, &mut dense);
            std::mem::swap(&mut y, &mut next);
            let mut point = [0.0; 3];
            for theta in [0.15, 0.5, 0.8] {
                interpolate(&dense, theta, &mut point);
                between = between.max(difference(&point, time + theta * h));
            }
        }
        [difference(&y, 3.0), between]
    }

    #[test]
    fn converges_with_order_8_and_dense_output_with_order_7() {
        let (coarse, fine) = (run(4), run(8));
        let order = |i: usize| (coarse[i] / fine[i]).log2();
        assert!(order(0) > 7.6, "order {} of {coarse:?}", order(0));
        assert!(order(1) > 7.0, "dense order {} of {coarse:?}", order(1));
    }

    #[test]
    fn the_slope_is_that_of_the_dense_output() {
        let dense: Vec<f64> = (0..Dop853::dense_length(2)).map(|k| f64::from(k as u32).sin()).collect();
        let value = |theta: f64, component: usize| {
            let mut y = [0.0; 2];
            interpolate(&dense, theta, &mut y);
            y[component]
        };
        for theta in [0.0, 0.2, 0.7, 1.0] {
            for component in 0..2 {
                let difference = (value(theta + 1e-5, component) - value(theta - 1e-5, component)) / 2e-5;
                assert!((slope(&dense, theta, 2, component) - difference).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn the_error_estimate_is_of_order_8_in_the_step() {
        let estimate = |h: f64| {
            let mut method = Dop853::new(3);
            let mut next = vec![0.0; 3];
            method.begin(&mut problem, 0.3, &exact(0.3));
            method.attempt(&mut problem, 0.3, &exact(0.3), h, &mut next);
            method.error(h, &[1.0; 3])
        };
        let order = (estimate(0.8) / estimate(0.4)).log2();
        assert!((7.0..9.5).contains(&order), "{order}");
    }

    #[test]
    fn step_sizes_stay_within_their_limits() {
        assert_eq!(next_step(1.0, 0.0, false), EXPLICIT_GROWTH);
        assert_eq!(next_step(1.0, 0.0, true), 1.0);
        assert_eq!(next_step(1.0, f64::NAN, false), 1.0 / EXPLICIT_GROWTH);
        assert_eq!(next_step(1.0, f64::INFINITY, false), 1.0 / EXPLICIT_GROWTH);
        let mut method = Dop853::new(3);
        method.begin(&mut problem, 0.0, &exact(0.0));
        let step = method.starting_step(&mut problem, 0.0, &exact(0.0), &[1e-8; 3]);
        assert!((1e-4..1.0).contains(&step), "{step}");
    }
}
