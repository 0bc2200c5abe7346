//! One step of Radau IIA of order 5 at a time, for q'' = a(t, q, q'), without memory of the problem.
//!
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd edition (1996), section IV.8: simplified Newton iterations in
//! the coordinates in which the inverse of the method's matrix is block diagonal, one real and one complex block. Since q' = v, both are reduced
//! from 2 n to n unknowns: of (mu - J) (x, y) = (r, s) with y = mu x - r there remains
//! (mu^2 - mu a_v - a_q) x = s + (mu - a_v) r.
//!
//! The caller owns the policy: which step to try, what to do with a rejected one, when a Jacobian is too old.

// The digits are those of the source, so that they can be compared with it.
#![allow(clippy::excessive_precision)]

use nalgebra::Complex;

use super::dense::Lu;
use super::each_stage::EachStage;
use super::explicit::Derivative;
use crate::series::lane::{self, Lane, ZERO, splat};

/// Order of the polynomial that the dense output is.
pub(super) const DENSE_ORDER: usize = 5;
/// Newton iterations.
const ITERATIONS: i32 = 10;
/// Iterations that reduce their step by less do not converge.
const DIVERGING: f64 = 0.99;
/// Iterations that are only rounding are so many times its estimate at most, and at least this share of the one before.
const ROUGH: f64 = 10.0;
const STALLING: f64 = 0.5;
/// The second iteration may be larger than the first by this factor.
const BULGE: f64 = 2.0;
const SQRT_6: f64 = 2.449_489_742_783_178;
/// Nodes.
pub(super) const NODES: [f64; 3] = [(4.0 - SQRT_6) / 10.0, (4.0 + SQRT_6) / 10.0, 1.0];
/// The slope at the start of the cubic through zero at the start and the stages.
const SLOPE: [f64; 3] = [(13.0 + 7.0 * SQRT_6) / 3.0, (13.0 - 7.0 * SQRT_6) / 3.0, 1.0 / 3.0];
/// Eigenvalues of the inverse of the method's matrix: the real one, and one of the complex pair.
const REAL: f64 = 3.637_834_252_744_495_7;
const COMPLEX: Complex<f64> = Complex::new(2.681_082_873_627_752, 3.050_430_199_247_41);
/// Its eigenvectors: z = FROM w, w = INTO z.
const FROM_ROWS: [[f64; 3]; 3] = [
    [0.091_232_394_870_892_94, -0.141_255_295_020_954_2, -0.030_029_194_105_147_424],
    [0.241_717_932_707_107, 0.204_129_352_293_8, 0.382_942_112_757_261_94],
    [0.966_048_182_615_092_9, 1.0, 0.0],
];
const INTO_ROWS: [[f64; 3]; 3] = [
    [4.325_579_890_063_155, 0.339_199_251_815_809_9, 0.541_770_539_935_874_9],
    [-4.178_718_591_551_905, -0.327_682_820_761_062_4, 0.476_623_554_500_550_45],
    [-0.502_872_634_945_786_9, 2.571_926_949_855_605_4, -0.596_039_204_828_224_9],
];
const BLOCKS: [[f64; 3]; 3] = [[REAL, 0.0, 0.0], [0.0, COMPLEX.re, -COMPLEX.im], [0.0, COMPLEX.im, COMPLEX.re]];
const INVERSE_ROWS: [[f64; 3]; 3] = product(&product(&FROM_ROWS, &BLOCKS), &INTO_ROWS);
/// By columns: the eigenvectors, the inverse of the method's matrix and its square.
const FROM: [Lane; 3] = columns(&FROM_ROWS);
const INTO: [Lane; 3] = columns(&INTO_ROWS);
const INVERSE: [Lane; 3] = columns(&INVERSE_ROWS);
const SQUARE: [Lane; 3] = columns(&product(&INVERSE_ROWS, &INVERSE_ROWS));
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
        for iteration in 1..=ITERATIONS {
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
            let left = ITERATIONS - iteration;
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

    /// Error of the step just solved, in units of the tolerances: accept up to 1. The embedded method of order 3, filtered so that stiff parts
    /// do not count for more than they are; `again` filters twice, at the price of an evaluation, if it is large.
    pub fn error(
        &mut self,
        f: &mut impl Derivative,
        (time, y, h): (f64, &[f64], f64),
        tolerances: &[f64],
        again: bool,
    ) -> f64 {
        for i in 0..2 * self.n {
            let slope: f64 = SLOPE.iter().zip(&self.stages[i]).map(|(factor, stage)| factor * stage).sum();
            self.rest[i] = -slope / h;
            self.point[i] = self.first[i] + self.rest[i];
        }
        let mut size = self.filter(h, tolerances);
        let large = size >= 1.0;
        if again && large {
            add(y, &self.error, &mut self.point);
            f.evaluate(time, &self.point, &mut self.error);
            add(&self.error, &self.rest, &mut self.point);
            size = self.filter(h, tolerances);
        }
        size
    }

    /// The last error in units of the tolerances, of what `change` leaves of it: nothing else goes into the dense output either.
    pub fn filtered_error(&mut self, tolerances: &[f64], change: impl FnOnce(&mut [f64])) -> f64 {
        change(&mut self.error);
        self.size(tolerances)
    }

    /// Takes the point for an error.
    fn filter(&mut self, h: f64, tolerances: &[f64]) -> f64 {
        self.solve_real(REAL / h);
        self.error.copy_from_slice(&self.point);
        self.size(tolerances)
    }

    /// The error in units of the tolerances.
    fn size(&self, tolerances: &[f64]) -> f64 {
        let squares = self.error.iter().zip(tolerances).map(|(error, tolerance)| (error / tolerance).powi(2));
        (squares.sum::<f64>() / (2 * self.n).max(1) as f64).sqrt()
    }

    /// The motion along the step as a polynomial of time since its start: v of degree 4 through the stages, with the filtered slope at the start;
    /// q is its integral, which ends where the step ends. Row k holds the coefficients of power k of q.
    pub fn dense(&self, y: &[f64], h: f64, dense: &mut [f64]) {
        let n = self.n;
        let [c1, c2, _] = NODES;
        for i in 0..n {
            let [z1, z2, z3, _] = self.stages[n + i];
            let first = z1 / c1;
            let (middle, last) = ((z2 - z1) / (c2 - c1), (z3 - z2) / (1.0 - c2));
            let second = (middle - first) / c2;
            let third = (last - middle) / (1.0 - c1) - second;
            let fourth = -REAL * self.error[n + i] / (c1 * c2);
            // Products of theta, theta - c1, theta - c2, theta - 1, expanded.
            let (sum, product) = (c1 + c2, c1 * c2);
            let powers = [
                first - c1 * second + product * (third - fourth),
                second - sum * third + (sum + product) * fourth,
                third - (1.0 + sum) * fourth,
                fourth,
            ];
            dense[i] = y[i];
            dense[n + i] = y[n + i];
            let mut unit = 1.0;
            for (k, power) in powers.into_iter().enumerate() {
                unit *= h;
                dense[(k + 2) * n + i] = power / (unit * (k + 2) as f64);
            }
        }
    }
}

/// q and v of a dense output, so long after the start of the step.
pub(super) fn evaluate(dense: &[f64], dt: f64, motion: &mut [f64]) {
    let n = motion.len() / 2;
    let (q, v) = motion.split_at_mut(n);
    q.fill(0.0);
    v.fill(0.0);
    for coefficients in dense[..(DENSE_ORDER + 1) * n].chunks_exact(n.max(1)).rev() {
        for ((q, v), coefficient) in q.iter_mut().zip(v.iter_mut()).zip(coefficients) {
            *v = *v * dt + *q;
            *q = *q * dt + coefficient;
        }
    }
}

fn add(a: &[f64], b: &[f64], sum: &mut [f64]) {
    sum.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum = a + b);
}

/// Times of the nodes of a step.
fn nodes(time: f64, h: f64) -> [f64; 3] {
    NODES.map(|node| time + node * h)
}

/// A whole power, by products.
fn power(base: f64, exponent: i32) -> f64 {
    (0..exponent).fold(1.0, |power, _| power * base)
}

/// The columns of a matrix, with the last row twice.
const fn columns(rows: &[[f64; 3]; 3]) -> [Lane; 3] {
    let [first, second, third] = rows;
    [
        [first[0], second[0], third[0], third[0]],
        [first[1], second[1], third[1], third[1]],
        [first[2], second[2], third[2], third[2]],
    ]
}

const fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut product = [[0.0; 3]; 3];
    let mut place = 0;
    while place < 9 {
        let (row, column) = (place / 3, place % 3);
        product[row][column] = a[row][0] * b[0][column] + a[row][1] * b[1][column] + a[row][2] * b[2][column];
        place += 1;
    }
    product
}

/// A matrix, by columns, times the first three numbers of a lane.
#[inline(always)]
pub(super) fn turn(matrix: &[Lane; 3], from: Lane) -> Lane {
    let sum = lane::multiply(matrix[0], splat(from[0]));
    lane::plus(lane::plus(sum, matrix[1], splat(from[1])), matrix[2], splat(from[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One node after the other.
    impl<F: FnMut(f64, &[f64], &mut [f64])> Nodes for F {
        fn evaluate_nodes(&mut self, times: [f64; 3], points: &[Lane], derivatives: &mut [Lane]) {
            for (place, time) in times.into_iter().enumerate() {
                let point: Vec<f64> = points.iter().map(|lane| lane[place]).collect();
                let mut derivative = vec![0.0; point.len()];
                self(time, &point, &mut derivative);
                derivatives.iter_mut().zip(derivative).for_each(|(lane, value)| lane[place] = value);
            }
        }

        /// By differences.
        fn differentiate_nodes(
            &mut self,
            times: [f64; 3],
            points: &[Lane],
            derivatives: &mut [Lane],
            jacobians: &mut [Lane],
        ) {
            let n = points.len() / 2;
            for direction in 0..2 * n {
                let [mut above, mut below] = [points.to_vec(), points.to_vec()];
                let [mut over, mut under] = [vec![ZERO; 2 * n], vec![ZERO; 2 * n]];
                above[direction] = lane::add(points[direction], splat(1e-6));
                below[direction] = lane::add(points[direction], splat(-1e-6));
                self.evaluate_nodes(times, &above, &mut over);
                self.evaluate_nodes(times, &below, &mut under);
                for row in 0..n {
                    let slope = lane::subtract(over[n + row], under[n + row]).map(|difference| difference / 2e-6);
                    jacobians[direction / n * n * n + row * n + direction % n] = slope;
                }
            }
            self.evaluate_nodes(times, points, derivatives);
        }
    }

    /// Two coupled oscillators with q = (sin t, cos 2 t), driven so that this is a solution; the Jacobian is exact.
    fn problem(time: f64, y: &[f64], derivative: &mut [f64]) {
        let exact = exact(time);
        derivative[0] = y[2];
        derivative[1] = y[3];
        derivative[2] =
            -exact[0] - 3.0 * (y[0].powi(2) - exact[0].powi(2)) - (y[1] - exact[1]) - 0.5 * (y[2] - exact[2]);
        derivative[3] = -4.0 * exact[1] + (y[0] - exact[0]) - 2.0 * (y[1] * y[3] - exact[1] * exact[3]);
    }

    fn exact(time: f64) -> [f64; 4] {
        [time.sin(), (2.0 * time).cos(), time.cos(), -2.0 * (2.0 * time).sin()]
    }

    fn jacobian(radau: &mut Radau, y: &[f64]) {
        let (by_q, by_v) = radau.jacobian_mut();
        by_q.copy_from_slice(&[-6.0 * y[0], -1.0, 1.0, -2.0 * y[3]]);
        by_v.copy_from_slice(&[-0.5, 0.0, 0.0, -2.0 * y[1]]);
    }

    /// Largest errors at the end of [0, 2] and between the steps, and the last error estimate.
    fn run(steps: u32, each: bool) -> [f64; 3] {
        let mut radau = Radau::with(2, each);
        let h = 2.0 / f64::from(steps);
        let (mut y, mut next, mut dense) = (exact(0.0).to_vec(), vec![0.0; 4], vec![0.0; 2 * (DENSE_ORDER + 1)]);
        let worst = |y: &[f64], time: f64| y.iter().zip(exact(time)).fold(0.0, |w: f64, (y, e)| w.max((y - e).abs()));
        let [mut between, mut estimate] = [0.0_f64; 2];
        for step in 0..steps {
            let time = f64::from(step) * h;
            radau.begin(&mut problem, time, &y);
            radau.guess_nothing();
            if each {
                assert!(radau.linearise(&mut problem, (time, &y, h)));
            } else {
                jacobian(&mut radau, &y);
                assert!(radau.factor(h));
            }
            let newton = radau.solve(&mut problem, (time, &y, h), &[1.0; 4], [1e-13, 0.0]);
            assert!(matches!(newton, Newton::Converged { .. }), "{newton:?}");
            estimate = radau.error(&mut problem, (time, &y, h), &[1.0; 4], false);
            radau.end(&y, &mut next);
            radau.dense(&y, h, &mut dense);
            let mut point = [0.0; 4];
            for theta in [0.3, 0.8, 1.0] {
                evaluate(&dense, theta * h, &mut point);
                if theta == 1.0 {
                    assert!(point.iter().zip(&next).all(|(a, b)| (a - b).abs() < 1e-12), "{point:?} {next:?}");
                } else {
                    between = between.max(worst(&point, time + theta * h));
                }
            }
            std::mem::swap(&mut y, &mut next);
        }
        [worst(&y, 2.0), between, estimate]
    }

    #[test]
    fn converges_with_order_5_its_dense_output_and_its_estimate_with_order_4() {
        for each in [false, true] {
            let (coarse, fine) = (run(40, each), run(80, each));
            let order = |i: usize| (coarse[i] / fine[i]).log2();
            assert!((4.6..5.6).contains(&order(0)), "order {} of {coarse:?}", order(0));
            assert!((3.7..4.7).contains(&order(1)), "dense order {} of {coarse:?}", order(1));
            assert!((3.5..4.5).contains(&order(2)), "estimate {} of {coarse:?}", order(2));
        }
    }

    /// q'' = -1e6 (q - cos t) - 2e3 (q' + sin t) - cos t: the solution is cos t plus a transient that is gone at once.
    #[test]
    fn stiff_transients_are_damped_in_a_step_and_slow_motion_is_followed() {
        let mut f = |t: f64, y: &[f64], d: &mut [f64]| {
            d[0] = y[1];
            d[1] = -1e6 * (y[0] - t.cos()) - 2e3 * (y[1] + t.sin()) - t.cos();
        };
        let (mut radau, mut y, mut next) = (Radau::with(1, false), vec![1.0 + 1e-3, 0.0], vec![0.0; 2]);
        let h = 0.1;
        for step in 0..20 {
            let (by_q, by_v) = radau.jacobian_mut();
            (by_q[0], by_v[0]) = (-1e6, -2e3);
            assert!(radau.factor(h));
            let time = f64::from(step) * h;
            radau.begin(&mut f, time, &y);
            radau.guess_nothing();
            // The problem is linear: the second iteration has nothing left to do.
            let newton = radau.solve(&mut f, (time, &y, h), &[1.0; 2], [1e-9, 0.0]);
            assert!(matches!(newton, Newton::Converged { iterations: 1 | 2, .. }), "{newton:?}");
            radau.end(&y, &mut next);
            std::mem::swap(&mut y, &mut next);
        }
        assert!((y[0] - 2.0_f64.cos()).abs() < 1e-7, "{y:?}");
        assert!((y[1] + 2.0_f64.sin()).abs() < 1e-4, "{y:?}");
    }

    #[test]
    fn a_step_that_is_no_number_fails() {
        let mut f = |_: f64, _: &[f64], d: &mut [f64]| d.fill(f64::NAN);
        let mut radau = Radau::with(1, false);
        radau.jacobian_mut();
        assert!(radau.factor(0.1));
        let newton = radau.solve(&mut f, (0.0, &[0.0, 0.0], 0.1), &[1.0; 2], [1e-9, 0.0]);
        assert_eq!(newton, Newton::Failed { shorter: 0.5 });
    }
}
