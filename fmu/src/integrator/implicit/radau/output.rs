//! What a solved step gives: its error, and the motion along it.

use super::coefficients::{DENSE_ORDER, NODES, REAL, SLOPE};
use super::{Derivative, Radau};

impl Radau {
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
pub fn evaluate(dense: &[f64], dt: f64, motion: &mut [f64]) {
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
