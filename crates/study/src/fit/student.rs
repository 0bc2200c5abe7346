//! Student's distribution.

/// With more degrees of freedom than this the expansion about the normal distribution is exact to rounding of what is printed.
const MANY: usize = 400;
/// The normal distribution has 95 % within so many standard deviations.
pub const NORMAL: f64 = 1.959_963_984_540_054;
/// Halvings of an interval.
const HALVINGS: usize = 80;

/// Within so many standard errors of the mean are 95 % of all values.
pub fn limits_95(degrees: usize) -> f64 {
    if degrees > MANY {
        return expanded(degrees as f64);
    }
    let (mut low, mut high) = (NORMAL, 13.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if within(middle, degrees) < 0.95 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The probability between -t and t (Abramowitz and Stegun, 26.7.3 and 26.7.4).
fn within(t: f64, degrees: usize) -> f64 {
    let angle = (t / (degrees as f64).sqrt()).atan();
    let (sine, cosine) = angle.sin_cos();
    let is_odd = degrees % 2 == 1;
    let mut term = if is_odd { cosine } else { 1.0 };
    let mut sum = 0.0;
    for index in (if is_odd { 1 } else { 0 }..degrees.saturating_sub(1)).step_by(2) {
        sum += term;
        term *= cosine * cosine * (index + 1) as f64 / (index + 2) as f64;
    }
    if is_odd { std::f64::consts::FRAC_2_PI * (angle + sine * sum) } else { sine * sum }
}

/// Abramowitz and Stegun, 26.7.5.
fn expanded(degrees: f64) -> f64 {
    let x = NORMAL;
    let first = (x.powi(3) + x) / 4.0;
    let second = (5.0 * x.powi(5) + 16.0 * x.powi(3) + 3.0 * x) / 96.0;
    let third = (3.0 * x.powi(7) + 19.0 * x.powi(5) + 17.0 * x.powi(3) - 15.0 * x) / 384.0;
    x + first / degrees + second / degrees.powi(2) + third / degrees.powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun, table 26.10, with more digits by R's qt(0.975, n).
    #[test]
    fn limits_are_those_of_the_tables() {
        for (degrees, limit) in [
            (1, 12.706_204_736_4),
            (2, 4.302_652_729_9),
            (3, 3.182_446_305_3),
            (5, 2.570_581_835_6),
            (10, 2.228_138_851_9),
            (30, 2.042_272_456_3),
            (100, 1.983_971_518_5),
            (1000, 1.962_339_080_8),
        ] {
            assert!((limits_95(degrees) - limit).abs() < 1e-9, "{degrees}: {:.12}", limits_95(degrees));
        }
        assert!((limits_95(MANY) - expanded(MANY as f64)).abs() < 1e-9);
    }
}
