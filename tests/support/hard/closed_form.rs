//! Motion from closed-form kinematics: every body's pose as a function of a few free coordinates, d'Alembert's principle, and Gragg's
//! extrapolation method. No loop equations, no multipliers, no method of the product: a reference for its results.

use nalgebra::{DMatrix, DVector};

use crate::support::jet::Jet;

/// x, y of the mass centre, cosine and sine of the angle.
pub type Pose = [Jet; 4];

/// A mechanism whose bodies' poses are known functions of its free coordinates.
pub struct ClosedForm<P, F> {
    /// Mass and inertia of each body.
    pub inertias: Vec<[f64; 2]>,
    pub pose: P,
    /// Generalised forces besides gravity, from time, coordinates and rates.
    pub force: F,
    pub gravity: f64,
}

/// Coordinates and rates.
pub type State = [Vec<f64>; 2];

/// What a body does: x, y, angle (between -pi and pi), and their rates.
pub type Motion = [f64; 6];

impl<P: Fn(&[Jet]) -> Vec<Pose>, F: Fn(f64, &[f64], &[f64]) -> Vec<f64>> ClosedForm<P, F> {
    /// First and second derivatives (x, y, angle) of each body's pose along a line through the coordinates.
    fn along(&self, q: &[f64], direction: &[f64]) -> Vec<[[f64; 3]; 2]> {
        let line: Vec<Jet> = q.iter().zip(direction).map(|(&q, &rate)| Jet([q, rate, 0.0])).collect();
        let turn = |c: Jet, s: Jet, order: usize| c.0[0] * s.0[order] - s.0[0] * c.0[order];
        let rates = |&[x, y, c, s]: &Pose| [1, 2].map(|order| [x.0[order], y.0[order], turn(c, s, order)]);
        (self.pose)(&line).iter().map(rates).collect()
    }

    /// Projected on the free coordinates, forces and inertia forces of all bodies are in balance.
    fn accelerations(&self, t: f64, [q, v]: [&[f64]; 2]) -> Vec<f64> {
        let n = q.len();
        let unit = |k: usize| (0..n).map(|i| if i == k { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
        let columns: Vec<_> = (0..n).map(|k| self.along(q, &unit(k))).collect();
        let bias = self.along(q, v);
        let mut mass = DMatrix::zeros(n, n);
        let mut right = DVector::from_vec((self.force)(t, q, v));
        for (body, &[m, inertia]) in self.inertias.iter().enumerate() {
            let (weights, [_, bias]) = ([m, m, inertia], bias[body]);
            let bias = [bias[0], bias[1] + self.gravity, bias[2]];
            for (j, column) in columns.iter().enumerate() {
                let [column, _] = column[body];
                right[j] -= (0..3).map(|i| column[i] * weights[i] * bias[i]).sum::<f64>();
                for (k, other) in columns.iter().enumerate() {
                    mass[(j, k)] += (0..3).map(|i| column[i] * weights[i] * other[body][0][i]).sum::<f64>();
                }
            }
        }
        mass.lu().solve(&right).expect("every free coordinate moves a mass").as_slice().to_vec()
    }

    /// The state at each of the times, which ascend; forces do not jump.
    pub fn states(&self, start: State, times: &[f64]) -> Vec<State> {
        let n = start[0].len();
        let rates = |t: f64, y: &[f64]| {
            let (q, v) = y.split_at(n);
            [v, &self.accelerations(t, [q, v])].concat()
        };
        let (mut time, mut y) = (0.0, start.concat());
        let mut state = |&target: &f64| {
            y = extrapolate(&rates, [time, target], &y);
            time = target;
            [y[..n].to_vec(), y[n..].to_vec()]
        };
        times.iter().map(&mut state).collect()
    }

    /// What a body does in a state.
    pub fn motion(&self, body: usize, [q, v]: &State) -> Motion {
        let still: Vec<Jet> = q.iter().map(|&q| Jet::constant(q)).collect();
        let [x, y, c, s] = (self.pose)(&still)[body].map(|jet| jet.0[0]);
        let [vx, vy, omega] = self.along(q, v)[body][0];
        [x, y, s.atan2(c), vx, vy, omega]
    }
}

/// Columns of the extrapolation table: order 18.
const COLUMNS: usize = 9;
/// Wanted error of a step, relative.
const TOLERANCE: f64 = 1e-14;
/// Rounding errors of a step are less than so many times that.
const NOISE: f64 = 1e3;
/// A step that is right makes the next one so much longer at least: where all that is left of the error are rounding errors, it says nothing about the length.
const LONGER: f64 = 1.2;

/// Gragg's method with steps n = 2, 4, 6, ... and extrapolation in h^2 (Hairer, Norsett & Wanner I, II.9).
pub fn extrapolate(rates: &impl Fn(f64, &[f64]) -> Vec<f64>, [start, end]: [f64; 2], from: &[f64]) -> Vec<f64> {
    let (mut t, mut y) = (start, from.to_vec());
    let mut h = (end - start).min(1e-2);
    let mut rejected = f64::INFINITY;
    while t < end {
        let last = t + h >= end * (1.0 - 1e-15);
        let step = if last { end - t } else { h };
        let (next, error) = try_step(rates, t, &y, step);
        // A shorter step whose small error is not much smaller has rounding errors only.
        let noise = error < NOISE && error > 0.1 * rejected;
        let factor = (0.8 * error.max(1e-20).powf(-1.0 / (2.0 * COLUMNS as f64 - 1.0))).clamp(0.2, 3.0);
        if error <= 1.0 || noise {
            t = if last { end } else { t + step };
            y = next;
            rejected = f64::INFINITY;
            // A step of noise follows one that was rejected for it, and shorter by half.
            h = step * if noise { 4.0 } else { factor.max(LONGER) };
        } else {
            rejected = error;
            h = step * factor.min(0.5);
        }
    }
    y
}

/// The state a step later, and its error in units of what is wanted.
fn try_step(rates: &impl Fn(f64, &[f64]) -> Vec<f64>, t: f64, y: &[f64], step: f64) -> (Vec<f64>, f64) {
    let mut row: Vec<Vec<f64>> = Vec::new();
    for j in 0..COLUMNS {
        let mut column = midpoint(rates, t, y, step, 2 * (j + 1));
        let mut next = Vec::new();
        for (k, above) in row.iter().enumerate() {
            let ratio = ((j + 1) as f64 / (j - k) as f64).powi(2) - 1.0;
            let better = column.iter().zip(above).map(|(a, b)| a + (a - b) / ratio).collect();
            next.push(std::mem::replace(&mut column, better));
        }
        next.push(column);
        row = next;
    }
    let [best, other] = [&row[COLUMNS - 1], &row[COLUMNS - 2]];
    let error = |(a, b): (&f64, &f64)| {
        let error = (a - b).abs() / (TOLERANCE * a.abs().max(1.0));
        // What is not a number is infinitely wrong.
        if error.is_nan() { f64::INFINITY } else { error }
    };
    (best.clone(), best.iter().zip(other).map(error).fold(0.0, f64::max))
}

/// With a last evaluation at the end of the step (Gragg's smoothing): what is steep there would be leapt over otherwise.
fn midpoint(rates: &impl Fn(f64, &[f64]) -> Vec<f64>, t: f64, y: &[f64], step: f64, count: usize) -> Vec<f64> {
    let h = step / count as f64;
    let plus = |y: &[f64], f: &[f64], h: f64| y.iter().zip(f).map(|(y, f)| y + h * f).collect::<Vec<f64>>();
    let (mut before, mut now) = (y.to_vec(), plus(y, &rates(t, y), h));
    for k in 1..count {
        let next = plus(&before, &rates(t + k as f64 * h, &now), 2.0 * h);
        before = std::mem::replace(&mut now, next);
    }
    let from_before = plus(&before, &rates(t + step, &now), h);
    now.iter().zip(&from_before).map(|(a, b)| 0.5 * (a + b)).collect()
}
