//! A sampled motion, and the distance of two motions.

/// A variable that stays below this [SI units] is compared by its absolute error.
const SMALL: f64 = 1e-6;

#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// One row for each variable, with a value for each time.
    pub values: Vec<Vec<f64>>,
}

impl Trajectory {
    pub fn of(variables: usize) -> Self {
        Self { values: vec![Vec::new(); variables] }
    }

    /// The largest error of any variable at any time, relative to the variable's largest value.
    pub fn distance(&self, exact: &Self) -> f64 {
        let rows = self.values.iter().zip(&exact.values).map(|(values, exact)| {
            let largest = exact.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
            let scale = if largest > SMALL { largest } else { 1.0 };
            values.iter().zip(exact).map(|(value, exact)| (value - exact).abs() / scale).fold(0.0, f64::max)
        });
        rows.fold(0.0, f64::max)
    }

    /// Times at which a variable is largest or smallest, by the parabola through three neighbours; `times` are those of the values.
    pub fn extrema(&self, times: &[f64]) -> Vec<f64> {
        let of_row = |row: &Vec<f64>| {
            let inner = 1..times.len().min(row.len()).saturating_sub(1);
            let at = |k: usize| {
                let (before, after) = (times[k] - times[k - 1], times[k + 1] - times[k]);
                let [left, right] = [(row[k] - row[k - 1]) / before, (row[k + 1] - row[k]) / after];
                // Where the slope between the middles of the two intervals is zero.
                let share = left / (left - right);
                let found = times[k] - 0.5 * before + share * 0.5 * (before + after);
                (left * right < 0.0 && found.is_finite()).then_some(found)
            };
            inner.filter_map(at).collect::<Vec<f64>>()
        };
        self.values.iter().flat_map(of_row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_relative_to_the_largest_value() {
        let exact = Trajectory { values: vec![vec![100.0, -200.0], vec![0.0, 1e-9]] };
        let near = Trajectory { values: vec![vec![100.0, -198.0], vec![0.0, 1e-9]] };
        assert_eq!(near.distance(&exact), 0.01);
        let far = Trajectory { values: vec![vec![100.0, -200.0], vec![0.0, 1e-9 + 0.5]] };
        assert!((far.distance(&exact) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn extrema_of_a_sine_are_found_between_the_samples() {
        let times: Vec<f64> = (0..40).map(|k| 0.1 * f64::from(k)).collect();
        let sine = Trajectory { values: vec![times.iter().map(|t| t.sin()).collect()] };
        let found = sine.extrema(&times);
        assert_eq!(found.len(), 1);
        assert!((found[0] - std::f64::consts::FRAC_PI_2).abs() < 1e-3, "{found:?}");
    }
}
