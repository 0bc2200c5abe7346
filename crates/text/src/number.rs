//! Numbers as short decimals, simple fractions and multiples of pi.

use std::f64::consts::PI;

/// A positive number as whole / whole x pi^power, or as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WrittenNumber {
    Decimal(f64),
    /// over / under x pi^power
    Fraction {
        over: u32,
        under: u32,
        pi: i32,
    },
}

/// Denominators of angles in degrees and revolutions per minute, and of simple fractions.
const DENOMINATORS: [u32; 12] = [1, 2, 3, 4, 6, 7, 9, 11, 12, 18, 30, 180];

/// Finds the shortest way to write a positive number that agrees with it in 15 digits.
pub fn written(value: f64) -> WrittenNumber {
    let rounded = rounded(value);
    if digits(rounded) <= 8 || !value.is_finite() {
        return WrittenNumber::Decimal(rounded);
    }
    for pi in [0, 1, 2] {
        let scaled = value / PI.powi(pi);
        for under in DENOMINATORS {
            let over = (scaled * f64::from(under)).round();
            let close = (scaled * f64::from(under) - over).abs() <= 2e-15 * over;
            let simple = (1.0..=3600.0).contains(&over) && (pi > 0 || over <= 100.0);
            if close && simple {
                return WrittenNumber::Fraction { over: over as u32, under, pi };
            }
        }
    }
    WrittenNumber::Decimal(rounded)
}

/// The shortest decimal number that agrees in 15 digits if it is shorter, or in 14 if it is much shorter: what rounding errors
/// of a few operations leave.
pub fn rounded(value: f64) -> f64 {
    let long = digits(value);
    if long <= 14 {
        return value; // both roundings leave it as it is
    }
    let near = format!("{value:.14e}").parse().unwrap_or(value);
    let nearer = format!("{value:.13e}").parse().unwrap_or(value);
    match long {
        long if digits(nearer) + 7 <= long => nearer,
        long if digits(near) + 3 <= long => near,
        _ => value,
    }
}

/// A number in decimal notation, or scientific if that is shorter.
pub fn decimal(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e7).contains(&size) { format!("{value:e}") } else { format!("{value}") }
}

/// Significant digits of the shortest decimal form.
fn digits(value: f64) -> usize {
    format!("{value:e}").split('e').next().map_or(0, |mantissa| mantissa.bytes().filter(u8::is_ascii_digit).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_errors_of_the_last_digit_go() {
        assert_eq!(rounded(0.1 + 0.2), 0.3);
        assert_eq!(rounded(24.525000000000002), 24.525);
        assert_eq!(rounded(0.0006002800000000006), 0.00060028);
        assert_eq!(rounded(0.0416667), 0.0416667);
        assert_eq!(rounded(PI), PI);
        let sixth = 1.0 / 6.0;
        assert_eq!(rounded(sixth), sixth);
    }

    #[test]
    fn multiples_of_pi_and_simple_fractions_are_found() {
        assert_eq!(written(4.0 * PI), WrittenNumber::Fraction { over: 4, under: 1, pi: 1 });
        assert_eq!(written(16.0 * PI * PI), WrittenNumber::Fraction { over: 16, under: 1, pi: 2 });
        assert_eq!(written(70.0_f64.to_radians()), WrittenNumber::Fraction { over: 7, under: 18, pi: 1 });
        assert_eq!(written(1450.0 * PI / 30.0), WrittenNumber::Fraction { over: 145, under: 3, pi: 1 });
        assert_eq!(written(2.0 / 3.0), WrittenNumber::Fraction { over: 2, under: 3, pi: 0 });
        assert_eq!(written(0.4356), WrittenNumber::Decimal(0.4356));
        assert_eq!(written(std::f64::consts::E), WrittenNumber::Decimal(std::f64::consts::E));
        assert_eq!(written(f64::INFINITY), WrittenNumber::Decimal(f64::INFINITY));
    }

    #[test]
    fn what_is_written_agrees_to_fifteen_digits() {
        let mut value = 1.234e-6;
        while value < 1e9 {
            let read: f64 = decimal(rounded(value)).parse().unwrap();
            assert!((read - value).abs() <= 6e-14 * value);
            value *= 1.0137;
        }
    }
}
