//! Collocation at the nodes of Radau IIA, the last of which is the end of the step: nodes, and integrals of the polynomials through the nodes (Hairer and Wanner, *Solving Ordinary
//! Differential Equations II*, IV.5). What is stiff dies out in a step, however long.

use std::sync::LazyLock;

use nalgebra::{DMatrix, DVector};

/// How many nodes: the order is twice that less one.
pub const NODES: usize = 16;

/// The rule on the interval 0..1.
#[derive(Clone, Debug)]
pub struct Rule {
    /// Nodes, ascending.
    pub nodes: DVector<f64>,
    /// Of each node's polynomial from 0 up to each node.
    pub integrals: DMatrix<f64>,
    /// The triangle that stands for them in a sweep from node to node: what is stiff settles in a few sweeps (Weiser, *BIT Numer. Math.* 55, 2015).
    pub sweep: DMatrix<f64>,
    /// From values at the nodes to coefficients of shifted Legendre polynomials.
    coefficients: DMatrix<f64>,
}

impl Rule {
    /// The one of all motions.
    pub fn shared() -> &'static Self {
        static RULE: LazyLock<Rule> = LazyLock::new(Rule::new);
        &RULE
    }

    fn new() -> Self {
        let pairs: Vec<(f64, f64)> = (0..NODES).map(node).collect();
        let nodes = DVector::from_iterator(NODES, pairs.iter().map(|(node, _)| *node));
        let weights = DVector::from_iterator(NODES, pairs.iter().map(|(_, weight)| *weight));
        // The rule is exact for the products of these polynomials: up to degree 2 NODES - 2.
        let coefficients = DMatrix::from_fn(NODES, NODES, |degree, node| {
            (2 * degree + 1) as f64 * weights[node] * legendre(2.0 * nodes[node] - 1.0)[degree]
        });
        let integrals = DMatrix::from_fn(NODES, NODES, |row, degree| integral(nodes[row], degree)) * &coefficients;
        Rule { nodes, sweep: sweep(&integrals), integrals, coefficients }
    }

    /// Integrals of each node's polynomial from 0 up to a place.
    pub fn up_to(&self, place: f64) -> DVector<f64> {
        self.coefficients.tr_mul(&DVector::from_fn(NODES, |degree, _| integral(place, degree)))
    }

    /// The share that each node's value has in the last two coefficients of the expansion.
    pub fn tail(&self) -> DMatrix<f64> {
        self.coefficients.rows(NODES - 2, 2).into_owned()
    }
}

/// Legendre polynomials up to the degree of the rule and one more.
fn legendre(x: f64) -> [f64; NODES + 1] {
    let mut values = [1.0; NODES + 1];
    values[1] = x;
    for n in 1..NODES {
        values[n + 1] = ((2 * n + 1) as f64 * x * values[n] - n as f64 * values[n - 1]) / (n + 1) as f64;
    }
    values
}

/// Integral of a shifted Legendre polynomial from 0 up to a place.
fn integral(place: f64, degree: usize) -> f64 {
    if degree == 0 {
        return place;
    }
    let values = legendre(2.0 * place - 1.0);
    0.5 * (values[degree + 1] - values[degree - 1]) / (2 * degree + 1) as f64
}

/// A node and its weight: the end, and zeros of P_n - P_(n-1) by Newton's method from those of Jacobi's polynomials far from the ends.
fn node(index: usize) -> (f64, f64) {
    let n = NODES as f64;
    if index == NODES - 1 {
        return (1.0, 1.0 / (n * n));
    }
    let mut x = (std::f64::consts::PI * (n - 0.75 - index as f64) / n).cos();
    let mut before = 0.0;
    for _ in 0..20 {
        let values = legendre(x);
        let [second, first, last] = [2, 1, 0].map(|less| values[NODES - less]);
        let slope = (n * (x * last - first) - (n - 1.0) * (x * first - second)) / (x * x - 1.0);
        x -= (last - first) / slope;
        before = first;
    }
    (0.5 * (1.0 + x), 0.5 * (1.0 + x) / (n * n * before * before))
}

/// The transpose of the upper triangle U of Q^T = L U.
fn sweep(integrals: &DMatrix<f64>) -> DMatrix<f64> {
    let mut upper = integrals.transpose();
    for pivot in 0..NODES {
        for row in pivot + 1..NODES {
            let share = upper[(row, pivot)] / upper[(pivot, pivot)];
            for column in pivot..NODES {
                upper[(row, column)] -= share * upper[(pivot, column)];
            }
        }
    }
    upper.upper_triangle().transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_integrated_exactly() {
        let rule = Rule::new();
        for power in 0..NODES {
            let values = rule.nodes.map(|t| t.powi(power as i32));
            let exact = |t: f64| t.powi(power as i32 + 1) / (power + 1) as f64;
            for (row, &t) in rule.nodes.iter().enumerate() {
                assert!((rule.integrals.row(row).tr_dot(&values) - exact(t)).abs() < 1e-14, "{power}");
            }
            for t in [0.0, 0.3, 1.0] {
                assert!((rule.up_to(t).dot(&values) - exact(t)).abs() < 1e-14, "{power}");
            }
        }
        assert!(rule.nodes.as_slice().is_sorted());
    }
}
