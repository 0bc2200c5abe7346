//! When what is positive at the beginning of a step falls below zero, from its polynomial.
//!
//! Bernstein coefficients bound a polynomial, and their changes of sign the number of its roots (see [`crate::events::bernstein`]). So parts of the step without a root are left out by a few additions, and what is found is the first root. The polynomial is a truncated series: what it
//! may be wrong by is measured in each part, and a part counts only where the answer is the same for all functions so near to it.

use super::onset::{CHECKS, INTERPOLATION_ERROR};
use crate::events::bernstein::Bernstein;
use crate::machine::ROUNDING;
use crate::math::{maximum, minimum};
use crate::program::arm_form::MAX_ORDER;

/// A step, or a part of one, is halved so often at most where it does not show what happens in it, as where a law jumps.
pub(crate) const DEEPEST: i32 = 20;

/// What a function does in the unit interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Descent {
    /// It stays positive.
    None,
    /// It falls below zero for the first time between these places, at which it is positive and negative.
    Between([f64; 2]),
    /// It comes so near to zero that its polynomial does not tell.
    Unknown,
}

/// Looks through the unit interval. `error` is what the polynomial is wrong by at a place.
pub(crate) fn first(polynomial: &[f64], mut error: impl FnMut(f64) -> f64) -> Descent {
    let size: f64 = polynomial.iter().map(|coefficient| coefficient.abs()).sum();
    let Some(degree) = polynomial.len().checked_sub(1).filter(|degree| *degree <= MAX_ORDER) else {
        return Descent::Unknown;
    };
    // The last coefficients are often none: a fall is a parabola.
    let (mut degree, mut rest) = (degree, 0.0);
    while degree > 1 && rest + polynomial[degree].abs() <= 0.5 * ROUNDING * size {
        rest += polynomial[degree].abs();
        degree -= 1;
    }
    let polynomial = &polynomial[..=degree];
    let whole = [0.0, 1.0];
    let margin = margin(whole, size, &mut error);
    // Mostly it is so far from zero that no signs are needed.
    if 2.0 * polynomial[0] - size > margin {
        return Descent::None;
    }
    let falls: f64 = polynomial[1..].iter().map(|coefficient| minimum(*coefficient, 0.0)).sum();
    if polynomial[0] + falls > margin {
        return Descent::None;
    }
    let Some(mut bernstein) = Bernstein::of(polynomial) else { return Descent::Unknown };
    search(&mut bernstein, whole, margin, 0, &mut |part| self::margin(part, size, &mut error))
}

/// What the polynomial may be wrong by in a part of the interval: ten times as much as at two places of it, and rounding errors.
fn margin([from, to]: [f64; 2], size: f64, error: &mut impl FnMut(f64) -> f64) -> f64 {
    let errors = [CHECKS[1], 1.0].map(|share| error(from + share * (to - from)));
    maximum(errors[0], errors[1]) / INTERPOLATION_ERROR + ROUNDING * size
}

/// Looks through a part, by its Bernstein coefficients. Its margin holds in both halves, which may have smaller ones.
fn search(
    b: &mut Bernstein,
    part: [f64; 2],
    margin: f64,
    depth: i32,
    margin_of: &mut impl FnMut([f64; 2]) -> f64,
) -> Descent {
    let mut found = judge(b.coefficients(), part, margin);
    let mut margin = margin;
    if found == Descent::Unknown && depth > 0 {
        margin = minimum(margin, margin_of(part));
        found = judge(b.coefficients(), part, margin);
    }
    if found != Descent::Unknown || depth == DEEPEST {
        return found;
    }
    let (mut right, middle) = (b.halve(), 0.5 * (part[0] + part[1]));
    match search(b, [part[0], middle], margin, depth + 1, margin_of) {
        Descent::None => search(&mut right, [middle, part[1]], margin, depth + 1, margin_of),
        found => found,
    }
}

/// What all functions do that differ from the polynomial by less than a margin. It may fall through both edges of the margin once only.
fn judge(b: &[f64], part: [f64; 2], margin: f64) -> Descent {
    if b.iter().all(|value| *value > margin) {
        return Descent::None;
    }
    let falls = |level: f64| {
        let mut above = b.iter().skip_while(|value| **value > level);
        above.all(|value| *value < level)
    };
    let [begin, .., end] = *b else { return Descent::Unknown };
    if begin > margin && end < -margin && falls(margin) && falls(-margin) {
        Descent::Between(part)
    } else {
        Descent::Unknown
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Random, horner};

    fn of(polynomial: &[f64]) -> Descent {
        first(polynomial, |_| 0.0)
    }

    /// The product of (root - s).
    fn with_roots(roots: &[f64]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |product, root| {
            let mut next = vec![0.0; product.len() + 1];
            for (k, coefficient) in product.iter().enumerate() {
                next[k] += root * coefficient;
                next[k + 1] -= coefficient;
            }
            next
        })
    }

    #[test]
    fn falls_and_flights_are_distinguished() {
        assert_eq!(of(&[1.0]), Descent::None);
        assert_eq!(of(&[]), Descent::Unknown);
        assert_eq!(of(&[1.0, -0.5]), Descent::None);
        assert_eq!(of(&[1.0, -2.0]), Descent::Between([0.0, 1.0]));
        assert_eq!(of(&[1.0, f64::NAN]), Descent::Unknown);
        assert_eq!(first(&[1.0, -0.5], |_| f64::NAN), Descent::Unknown);
        // (1/4 + 1e-4) - s + s^2 comes near to zero, and does not reach it.
        assert_eq!(of(&[0.25 + 1e-4, -1.0, 1.0]), Descent::None);
        // By no more than the polynomial is wrong.
        assert_eq!(first(&[0.25 + 1e-4, -1.0, 1.0], |_| 1e-4), Descent::Unknown);
        // A touch.
        assert_eq!(of(&[0.25, -1.0, 1.0]), Descent::Unknown);
        // Below zero for a moment only.
        let Descent::Between([from, to]) = of(&[0.25 - 1e-8, -1.0, 1.0]) else { panic!() };
        assert!(from < 0.4999 && to > 0.4999 && to < 0.5001, "{from} {to}");
    }

    /// Random polynomials with known roots: the place is about the first one, and nothing is said to be positive that is not.
    #[test]
    fn the_first_root_of_random_polynomials_is_between_the_places() {
        let mut random = Random::new(11);
        let (mut found, mut unknown) = (0, 0);
        for round in 0..4000 {
            let roots: Vec<f64> = (0..1 + round % 9).map(|_| 1.5 * random.unit()).collect();
            // Positive at the beginning, as long as all roots are.
            let polynomial = with_roots(&roots);
            let least = roots.iter().fold(f64::INFINITY, |least, root| least.min(*root));
            match of(&polynomial) {
                Descent::None => assert!(least > 1.0 - 1e-9, "{roots:?}"),
                Descent::Between([from, to]) => {
                    assert!(from < least && least < to, "{roots:?}: {from} {to}");
                    assert!(horner(&polynomial, from) > 0.0 && horner(&polynomial, to) < 0.0, "{roots:?}");
                    found += 1;
                }
                Descent::Unknown => unknown += 1,
            }
        }
        assert!(found > 2500 && unknown < 80, "{found} {unknown}");
    }

    /// Against dense sampling, where the polynomial is wrong by up to a margin that is measured.
    #[test]
    fn what_is_wrong_by_as_much_as_is_measured_is_found_or_unknown() {
        let mut random = Random::new(12);
        let (mut found, mut none) = (0, 0);
        for _ in 0..2000 {
            let mut polynomial: Vec<f64> = (0..8).map(|_| random.symmetric()).collect();
            polynomial[0] = 0.3 * random.unit();
            // The remainder of the series.
            let rest = 1e-3 * random.symmetric();
            let function = |s: f64| horner(&polynomial, s) + rest * s.powi(8);
            let falls = (0..=20_000).map(|k| f64::from(k) / 20_000.0).find(|&s| function(s) < 0.0);
            match first(&polynomial, |s| (rest * s.powi(8)).abs()) {
                Descent::None => {
                    assert_eq!(falls, None, "{polynomial:?}");
                    none += 1;
                }
                Descent::Between([from, to]) => {
                    let first = falls.unwrap();
                    assert!(from < first && first < to + 1e-4 && function(from) > 0.0 && function(to) < 0.0);
                    found += 1;
                }
                Descent::Unknown => {}
            }
        }
        assert!(found > 500 && none > 200, "{found} {none}");
    }
}
