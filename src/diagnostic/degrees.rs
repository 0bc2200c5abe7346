//! Angles without a unit that are usual numbers of degrees: read in radians, as all bare angles are, they would be many turns.

use super::fault::Fault;
use super::span::Span;
use std::f64::consts::TAU;

/// Fewer radians than this are meant often enough.
const LEAST: f64 = 10.0;

/// Is an angle a usual number of degrees?
pub(crate) fn is_usual(angle: f64) -> bool {
    angle.abs() >= LEAST && (angle % 5.0 == 0.0 || angle % 22.5 == 0.0)
}

/// The angle of a list or column by which all of them look like degrees: a usual one, or the largest where all are whole.
pub fn among(angles: &[f64]) -> Option<f64> {
    let largest =
        angles.iter().copied().filter(|angle| angle.is_finite()).max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let are_whole = || angles.iter().all(|angle| angle.fract() == 0.0 || angle.is_nan());
    let usual = angles.iter().copied().find(|angle| is_usual(*angle));
    usual.or((largest.abs() >= LEAST && are_whole()).then_some(largest))
}

/// Warns of such an angle.
pub(crate) fn warning(what: &str, angle: f64, span: Span) -> Fault {
    let help = format!("write `\"{angle} deg\"` for degrees, or `\"{angle} rad\"` for radians");
    of(what, angle, span).help(help)
}

/// Warns of such angles in a column, which is called so in its first line.
pub fn of_column(what: &str, name: &str, angle: f64, span: Span) -> Fault {
    let help = format!("write `{name} [deg]` in the first line for degrees, or `{name} [rad]` for radians");
    of(what, angle, span).help(help)
}

fn of(what: &str, angle: f64, span: Span) -> Fault {
    let message = format!("{what} is {angle} radians, {:.1} turns", angle / TAU);
    Fault::warning("scene::degrees", message, span).label("degrees?")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_are_usual_numbers_and_radians_are_not() {
        assert!([30.0, -45.0, 22.5, 360.0].into_iter().all(is_usual));
        assert!(![0.0, 1.0, 5.0, 3.0 * TAU, 12.566].into_iter().any(is_usual));
    }

    #[test]
    fn a_column_is_judged_as_a_whole() {
        assert_eq!(among(&[0.0, 30.0, 60.0]), Some(30.0));
        assert_eq!(among(&[0.0, 12.0, 24.0]), Some(24.0));
        assert_eq!(among(&[0.0, TAU, 2.0 * TAU]), None);
        assert_eq!(among(&[0.0, 1.0, 2.0]), None);
        assert_eq!(among(&[]), None);
    }
}
