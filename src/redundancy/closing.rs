//! Back onto all loop equations at once, redundant or not, also where their solution is a double root.
//!
//! Gauss-Newton steps of least norm, damped by the square of what is left (Yamashita and Fukushima 2001). A loop equation that restricts in second order only has a
//! double root there, towards which steps halve; a doubled one reaches it.

use cotree_fmu::constraints::poses::Loops;
use cotree_fmu::linalg::least_squares::ResidualFunction;
use cotree_fmu::linalg::sparse::{Factors, SparseRow, product_with_transposed};
use cotree_fmu::math;

/// Most steps: what halves from 0.3 on is rounding after fifty.
const ITERATIONS: usize = 60;
/// Residuals of this size are rounding.
const ROUNDING: f64 = 1e-15;
/// Steps of this size move nothing.
const IDLE: f64 = 1e-11;
/// Longest step, for each unknown.
const REACH: f64 = 0.3;
/// Bounds of the damping: rounding of J J^T, and what keeps far steps short.
const DAMPING: [f64; 2] = [1e-13, 1e-2];
/// Ratios of the lengths of two steps in a row between which they halve.
const HALVING: std::ops::Range<f64> = 0.4..0.6;

/// Moves x onto the loop equations, with as little movement as serves; returns the largest residual that is left, relative to the scales.
pub(super) fn close(loops: &mut Loops, x: &mut Vec<f64>) -> f64 {
    let (mut r, mut trial_r) = (Vec::new(), Vec::new());
    loops.residuals(x, &mut r);
    let mut last = None;
    for _ in 0..ITERATIONS {
        let before = norm(&r);
        // Written so that NaN ends the search.
        let open = before > ROUNDING;
        let Some(mut step) = open.then(|| step(&loops.rows(x), &r, before, x.len())).flatten() else { break };
        let longest = REACH * (x.len() as f64).sqrt();
        let share = (longest / norm(&step)).min(1.0);
        step.iter_mut().for_each(|entry| *entry *= share);
        let size = norm(&step);
        let halves = last.is_some_and(|last: f64| HALVING.contains(&(size / last)));
        let shares = if halves { [2.0, 1.0, 0.25] } else { [1.0, 0.25, 0.06] };
        let better = shares.into_iter().find_map(|share| {
            let trial: Vec<f64> = x.iter().zip(&step).map(|(x, step)| x + share * step).collect();
            loops.residuals(&trial, &mut trial_r);
            (norm(&trial_r) < before).then_some((share, trial))
        });
        let Some((share, trial)) = better else { break };
        *x = trial;
        std::mem::swap(&mut r, &mut trial_r);
        last = (share == 1.0).then_some(size);
        if size < IDLE {
            break;
        }
    }
    loops.residuals(x, &mut r);
    r.iter().fold(0.0, |largest, r| math::maximum(largest, r.abs()))
}

/// -J^T (J J^T + damping)^-1 r, refined once.
fn step(rows: &[SparseRow], r: &[f64], size: f64, unknowns: usize) -> Option<Vec<f64>> {
    let product = product_with_transposed(rows);
    let largest = product.iter().enumerate().filter_map(|(index, row)| row.get(&index).copied()).fold(1.0, f64::max);
    let [least, most] = DAMPING;
    let factors = factors(&product, (size * size).clamp(least, most) * largest)?;
    let mut rest: Vec<f64> = r.iter().map(|r| -r).collect();
    let mut total = vec![0.0; unknowns];
    for _ in 0..2 {
        let mut weights = rest.clone();
        factors.solve(&mut weights);
        let mut part = vec![0.0; unknowns];
        for (row, weight) in rows.iter().zip(&weights) {
            row.iter().for_each(|(&column, value)| part[column] += value * weight);
        }
        for (row, rest) in rows.iter().zip(&mut rest) {
            *rest -= row.iter().map(|(&column, value)| value * part[column]).sum::<f64>();
        }
        total.iter_mut().zip(part).for_each(|(total, part)| *total += part);
    }
    total.iter().all(|entry| entry.is_finite()).then_some(total)
}

/// With more damping where rounding makes a pivot negative.
fn factors(product: &[SparseRow], mut damping: f64) -> Option<Factors> {
    /// The last damping is ten thousand times the first.
    const TRIES: usize = 3;
    for _ in 0..TRIES {
        let mut damped = product.to_vec();
        for (index, row) in damped.iter_mut().enumerate() {
            *row.entry(index).or_default() += damping;
        }
        if let Some(factors) = Factors::new(damped) {
            return Some(factors);
        }
        damping *= 100.0;
    }
    None
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}
