//! One step of Radau IIA of order 5 at a time, for q'' = a(t, q, q'), without memory of the problem.
//!
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd edition (1996), section IV.8: simplified Newton iterations in
//! the coordinates in which the inverse of the method's matrix is block diagonal, one real and one complex block. Since q' = v, both are reduced
//! from 2 n to n unknowns: of (mu - J) (x, y) = (r, s) with y = mu x - r there remains
//! (mu^2 - mu a_v - a_q) x = s + (mu - a_v) r.
//!
//! The caller owns the policy: which step to try, what to do with a rejected one, when a Jacobian is too old.

mod coefficients;
mod newton;
mod output;
#[cfg(test)]
mod tests;

use nalgebra::Complex;

use crate::integrator::right_hand_side::Derivative;
use crate::linalg::dense::Lu;
use crate::linalg::lane;
use crate::linalg::lane::{Lane, ZERO, splat};
use coefficients::{COMPLEX, FROM, INTO, INVERSE, SQUARE, nodes};
use newton::EachStage;

pub(super) use coefficients::DENSE_ORDER;
pub(super) use coefficients::{NODES, REAL, turn};
pub(super) use output::evaluate;

/// Newton iterations.
const MOST_ITERATIONS: i32 = 10;
/// Iterations that reduce their step by less do not converge.
const DIVERGING: f64 = 0.99;
/// Iterations that are only rounding are so many times its estimate at most, and at least this share of the one before.
const ROUGH: f64 = 10.0;
const STALLING: f64 = 0.5;
/// The second iteration may be larger than the first by this factor.
const BULGE: f64 = 2.0;
/// With so few coordinates each stage has its own Jacobian: that costs less than the iterations it saves.
const FEW: usize = 8;

/// A derivative that can be evaluated at the three nodes at once.
pub(super) trait Nodes: Derivative {
    /// Writes f(t, y) at three times; each lane holds the values of one component there, the last one twice.
    fn evaluate_nodes(&mut self, times: [f64; 3], points: &[Lane], derivatives: &mut [Lane]);

    /// The same, and the derivatives of the accelerations by q, then by v, row by row.
    fn differentiate_nodes(
        &mut self,
        times: [f64; 3],
        points: &[Lane],
        derivatives: &mut [Lane],
        jacobians: &mut [Lane],
    );
}

/// Storage for a step.
#[derive(Clone, Debug, Default)]
pub(super) struct Radau {
    n: usize,
    /// Derivatives of the accelerations by q, then by v, row by row.
    jacobian: Vec<f64>,
    real: Lu,
    complex: Lu<Complex<f64>>,
    each: Option<EachStage>,
    /// The step that the factors are for; 0 if there are none.
    factored: f64,
    /// The derivative at the start of the step.
    first: Vec<f64>,
    /// Stages less the start, side by side (the last one twice), and in the coordinates of the eigenvectors.
    stages: Vec<Lane>,
    turned: Vec<Lane>,
    /// The stages themselves, and the derivatives there.
    points: Vec<Lane>,
    slopes: Vec<Lane>,
    point: Vec<f64>,
    pair: Vec<Complex<f64>>,
    /// The error, and what it is without its first term.
    error: Vec<f64>,
    rest: Vec<f64>,
}

/// How the stages were found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Newton {
    /// After so many iterations, each of which reduced the step of the one before to this fraction.
    Converged { iterations: i32, contraction: f64 },
    /// Not at all; a step shorter by this factor may do.
    Failed { shorter: f64 },
}

impl Radau {
    /// Storage for n coordinates.
    pub fn new(n: usize) -> Self {
        Self::with(n, n <= FEW)
    }

    fn with(n: usize, few: bool) -> Self {
        let vector = || vec![0.0; 2 * n];
        let lanes = || vec![ZERO; 2 * n];
        Self {
            n,
            jacobian: vec![0.0; 2 * n * n],
            real: Lu::new(n),
            complex: Lu::new(if few { 0 } else { n }),
            each: few.then(|| EachStage::new(n)),
            factored: 0.0,
            first: vector(),
            stages: lanes(),
            turned: lanes(),
            points: lanes(),
            slopes: lanes(),
            point: vector(),
            pair: vec![Complex::default(); 2 * n],
            error: vector(),
            rest: vector(),
        }
    }

    /// Derivatives of the accelerations by q and by v, row by row, to be written.
    pub fn jacobian_mut(&mut self) -> (&mut [f64], &mut [f64]) {
        self.factored = 0.0;
        self.jacobian.split_at_mut(self.n * self.n)
    }

    /// How fast anything can change at most, judging by the rows of the Jacobian \[1/s\]. Each coordinate counts in units of its scale.
    pub fn rate(&self, scale: impl Fn(usize) -> f64) -> f64 {
        let n = self.n;
        let (by_q, by_v) = self.jacobian.split_at(n * n);
        let norm = |matrix: &[f64]| {
            let rows = matrix.chunks_exact(n.max(1)).enumerate();
            let sums = rows.map(|(i, row)| {
                row.iter().enumerate().map(|(j, entry)| entry.abs() * scale(j) / scale(i)).sum::<f64>()
            });
            sums.fold(0.0, f64::max)
        };
        norm(by_q).sqrt().max(norm(by_v))
    }

    /// Evaluates the derivative at the start of a step.
    pub fn begin(&mut self, f: &mut impl Derivative, time: f64, y: &[f64]) {
        f.evaluate(time, y, &mut self.first);
    }

    /// The derivative at the start of the step.
    pub fn first(&self) -> &[f64] {
        &self.first
    }

    /// The step that the factors are for.
    pub fn factored(&self) -> f64 {
        self.factored
    }

    /// Has each stage its own Jacobian?
    pub fn has_each(&self) -> bool {
        self.each.is_some()
    }

    /// Takes Jacobians at the guessed stages, the last one as that of the whole step, and factors what the step needs; false if a matrix is singular.
    pub fn linearise(&mut self, f: &mut impl Nodes, (time, y, h): (f64, &[f64], f64)) -> bool {
        self.place(y);
        let Some(each) = &mut self.each else { return false };
        f.differentiate_nodes(nodes(time, h), &self.points, &mut self.slopes, each.jacobians());
        self.jacobian.iter_mut().zip(each.jacobians()).for_each(|(place, stages)| *place = stages[2]);
        let regular = each.factor(h, &INVERSE, &SQUARE);
        self.factor(h) && regular
    }

    /// Time, q and v where the last stage was last evaluated.
    pub fn last_stage(&self, (time, h): (f64, f64), place: &mut [f64]) {
        place[0] = nodes(time, h)[2];
        place[1..].iter_mut().zip(&self.points).for_each(|(place, point)| *place = point[2]);
    }

    /// The stages themselves.
    fn place(&mut self, y: &[f64]) {
        let stages = y.iter().zip(&self.stages);
        self.points.iter_mut().zip(stages).for_each(|(point, (y, stage))| *point = lane::add(splat(*y), *stage));
    }

    /// Factors the matrices for a step; false if one is singular.
    pub fn factor(&mut self, h: f64) -> bool {
        let n = self.n;
        let (by_q, by_v) = self.jacobian.split_at(n * n);
        let (mu, nu) = (REAL / h, COMPLEX / h);
        for (place, (q, v)) in self.real.matrix().iter_mut().zip(by_q.iter().zip(by_v)) {
            *place = -(mu * v) - q;
        }
        self.real.add_to_diagonal(mu * mu);
        if self.each.is_some() {
            let regular = self.real.factor(0.0).is_ok();
            self.factored = if regular { h } else { 0.0 };
            return regular;
        }
        for (place, (q, v)) in self.complex.matrix().iter_mut().zip(by_q.iter().zip(by_v)) {
            *place = -(nu * *v) - *q;
        }
        self.complex.add_to_diagonal(nu * nu);
        // Rows differ by the stiffness of what they describe: only a pivot of zero is singular.
        let regular = self.real.factor(0.0).is_ok() && self.complex.factor(0.0).is_ok();
        self.factored = if regular { h } else { 0.0 };
        regular
    }

    /// Takes the start itself as the first guess of the stages.
    pub fn guess_nothing(&mut self) {
        self.stages.fill(ZERO);
        self.turned.fill(ZERO);
    }

    /// Takes the first guess of the stages from elsewhere: `at` writes the motion at a node.
    pub fn guess(&mut self, y: &[f64], mut at: impl FnMut(f64, &mut [f64])) {
        for (place, node) in NODES.into_iter().enumerate() {
            at(node, &mut self.point);
            let values = self.point.iter().zip(y);
            self.stages.iter_mut().zip(values).for_each(|(stage, (value, y))| stage[place] = value - y);
        }
        for (turned, stage) in self.turned.iter_mut().zip(&mut self.stages) {
            stage[3] = stage[2];
            *turned = turn(&INTO, *stage);
        }
    }

    /// Solves for the stages of a step with the factors, and with the slopes at the guess if it was linearised there, until an iteration is no larger than `goal`, in units of the tolerances. Iterations that are
    /// not much larger than `noise` and do not shrink any more are rounding.
    pub fn solve(
        &mut self,
        f: &mut impl Nodes,
        (time, y, h): (f64, &[f64], f64),
        tolerances: &[f64],
        [goal, noise]: [f64; 2],
    ) -> Newton {
        let (mut before, mut ratio_before, mut rate) = (0.0, 1.0, 0.0);
        for iteration in 1..=MOST_ITERATIONS {
            if iteration > 1 || self.each.is_none() {
                self.place(y);
                f.evaluate_nodes(nodes(time, h), &self.points, &mut self.slopes);
            }
            let size = match &mut self.each {
                Some(each) => each.iterate(&self.slopes, &mut self.stages, tolerances),
                None => self.iterate(h, tolerances),
            };
            if !size.is_finite() {
                return Newton::Failed { shorter: 0.5 };
            }
            if iteration > 1 {
                let ratio = size / before;
                // Stiff springs that turn make the second iteration large: it corrects what the first one, along the tangent, missed.
                rate = if iteration <= 3 { ratio } else { (ratio * ratio_before).sqrt() };
                ratio_before = ratio;
            }
            let stalled = iteration > 2 && size <= ROUGH * noise && size >= STALLING * before;
            if size <= goal || stalled {
                return Newton::Converged { iterations: iteration, contraction: rate };
            }
            let diverging = if iteration == 2 { rate >= BULGE } else { rate >= DIVERGING };
            if diverging {
                return Newton::Failed { shorter: 0.5 };
            }
            let left = MOST_ITERATIONS - iteration;
            let expected = size * power(rate, left) / goal;
            if iteration > 2 && expected >= 1.0 {
                return Newton::Failed { shorter: 0.8 * libm::pow(expected.min(20.0), -1.0 / f64::from(4 + left)) };
            }
            before = size.max(f64::MIN_POSITIVE);
        }
        Newton::Failed { shorter: 0.5 }
    }

    /// One iteration; returns its size in units of the tolerances.
    fn iterate(&mut self, h: f64, tolerances: &[f64]) -> f64 {
        let (mu, nu) = (REAL / h, COMPLEX / h);
        let mut squares = 0.0;
        for i in 0..2 * self.n {
            let [first, second, third, _] = turn(&INTO, self.slopes[i]);
            let turned = self.turned[i];
            self.point[i] = first - mu * turned[0];
            self.pair[i] = Complex::new(second, third) - nu * Complex::new(turned[1], turned[2]);
        }
        self.solve_real(mu);
        self.solve_pair(nu);
        for (i, tolerance) in tolerances.iter().enumerate() {
            let step = [self.point[i], self.pair[i].re, self.pair[i].im, 0.0];
            self.turned[i] = lane::add(self.turned[i], step);
            self.stages[i] = turn(&FROM, self.turned[i]);
            let [a, b, c, _] = step.map(|step| step / tolerance);
            squares += a * a + (b * b + c * c);
        }
        (squares / (6 * self.n).max(1) as f64).sqrt()
    }

    /// point = (mu - J)^-1 point
    fn solve_real(&mut self, mu: f64) {
        let n = self.n;
        let (x, y) = self.point.split_at_mut(n);
        let by_v = &self.jacobian[n * n..];
        for (i, row) in by_v.chunks_exact(n.max(1)).enumerate() {
            let damped: f64 = row.iter().zip(&*x).map(|(entry, r)| entry * r).sum();
            y[i] += mu * x[i] - damped;
        }
        self.real.solve(y);
        for (x, y) in x.iter_mut().zip(y) {
            let r = *x;
            *x = *y;
            *y = mu * *x - r;
        }
    }

    /// pair = (nu - J)^-1 pair
    fn solve_pair(&mut self, nu: Complex<f64>) {
        let n = self.n;
        let (x, y) = self.pair.split_at_mut(n);
        let by_v = &self.jacobian[n * n..];
        for (i, row) in by_v.chunks_exact(n.max(1)).enumerate() {
            let damped: Complex<f64> = row.iter().zip(&*x).map(|(entry, r)| r * *entry).sum();
            y[i] += nu * x[i] - damped;
        }
        self.complex.solve(y);
        for (x, y) in x.iter_mut().zip(y) {
            let r = *x;
            *x = *y;
            *y = nu * *x - r;
        }
    }

    /// The change of q that takes away a surplus of the accelerations, if that is stiff springs': (mu^2 - mu a_v - a_q)^-1, with the factors of a
    /// step.
    pub fn correct(&self, surplus: &mut [f64]) {
        self.real.solve(surplus);
    }

    /// Takes out of a change of q what would stretch stiff springs. Accelerations keep the loops closed whatever the springs do, so this leaves alone
    /// how far a change closes them.
    pub fn relax(&self, change: &mut [f64]) {
        let mu = REAL / self.factored;
        change.iter_mut().for_each(|value| *value *= mu * mu);
        self.real.solve(change);
    }

    /// The end of the step.
    pub fn end(&self, y: &[f64], next: &mut [f64]) {
        next.iter_mut().zip(y.iter().zip(&self.stages)).for_each(|(next, (y, stage))| *next = y + stage[2]);
    }
}

/// A whole power, by products.
fn power(base: f64, exponent: i32) -> f64 {
    (0..exponent).fold(1.0, |power, _| power * base)
}
