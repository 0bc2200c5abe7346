//! What the motion must be, by a method that shares nothing with the product.

use std::f64::consts::TAU;

/// Values of variables at some times.
#[derive(Clone, Debug, Default)]
pub struct Reference {
    pub names: Vec<String>,
    /// Ascending [s].
    pub times: Vec<f64>,
    /// For each time, one value for each name. Angles are compared but for full turns.
    pub values: Vec<Vec<f64>>,
}

impl Reference {
    /// The largest error of any variable at one of the times, relative to the variable's largest value or to 1 [SI units].
    pub fn error(&self, index: usize, found: &[f64]) -> f64 {
        let error = |(k, name): (usize, &String)| {
            let largest = self.values.iter().fold(1.0, |largest: f64, row| largest.max(row[k].abs()));
            let mut off = found[k] - self.values[index][k];
            if name.ends_with(".angle") {
                off -= TAU * (off / TAU).round();
            }
            // What is not a number is infinitely wrong.
            if off.is_nan() { f64::INFINITY } else { off.abs() / largest }
        };
        self.names.iter().enumerate().map(error).fold(0.0, f64::max)
    }
}
