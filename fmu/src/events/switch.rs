//! Laws in pieces: which piece holds, and until when.
//!
//! A switching function chooses between series: one while it is positive, one while it is negative, one while it is zero, as it is where the sides of a
//! comparison are equal for long. Along a step the choice stays, so that every series is analytic; the step ends where a switching function changes its sign.

use serde::{Deserialize, Serialize};

use super::bernstein::Bernstein;
use crate::math;
use crate::program::arm_form::MAX_ORDER;

/// Where a switching function is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SwitchSign {
    /// It is positive.
    Above,
    /// It is zero.
    Equal,
    /// It is negative.
    Below,
}

impl SwitchSign {
    /// Of a value; one that is no number makes every comparison false.
    pub fn of(value: f64) -> Self {
        if value > 0.0 {
            Self::Above
        } else if value == 0.0 {
            Self::Equal
        } else {
            Self::Below
        }
    }
}

/// Choices that are known beforehand, as at the end of a piece, where the switching function itself is zero. One bit for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Choices {
    /// Which are known.
    pub known: u64,
    /// Which switching functions count as positive.
    pub positive: u64,
    /// Which count as zero.
    pub equal: u64,
    /// Which have been taken back at once: once more, and the motion is pushed to and fro.
    pub reversed: u64,
}

impl Choices {
    /// The choice of one switch, if it is known.
    pub fn get(self, switch: u32) -> Option<SwitchSign> {
        let bit = 1_u64.checked_shl(switch)?;
        let side = match (self.positive & bit != 0, self.equal & bit != 0) {
            (true, _) => SwitchSign::Above,
            (false, true) => SwitchSign::Equal,
            (false, false) => SwitchSign::Below,
        };
        (self.known & bit != 0).then_some(side)
    }

    /// Makes a choice known.
    pub fn set(&mut self, switch: u32, side: SwitchSign) {
        let bit = 1_u64.checked_shl(switch).unwrap_or(0);
        let with = |bits: u64, is: bool| if is { bits | bit } else { bits & !bit };
        self.known |= bit;
        self.positive = with(self.positive, side == SwitchSign::Above);
        self.equal = with(self.equal, side == SwitchSign::Equal);
    }

    /// These without some.
    pub fn without(self, bits: u64) -> Self {
        let Self { known, positive, equal, reversed } = self;
        Self { known: known & !bits, positive: positive & !bits, equal: equal & !bits, reversed }
    }

    /// These, but for the ones that later ones replace.
    pub fn then(self, later: Self) -> Self {
        Self {
            known: self.known | later.known,
            positive: self.positive & !later.known | later.positive,
            equal: self.equal & !later.known | later.equal,
            reversed: self.reversed | self.known & later.known | later.reversed,
        }
    }
}

/// Where these are taken, in steps: before the last terms spoil them.
const VALUES: [f64; 4] = [0.0, 0.2, 0.4, 0.6];
/// A step in which it is not known is made shorter by this factor, so many times at most.
const UNKNOWN_CUT: f64 = 0.8;
const SHORTENINGS: usize = 200;

/// How far within h a polynomial is known that goes on with terms like its last ones: these are no larger than a share of its values. Where it is zero is
/// known to about this share of h.
pub(crate) fn known(polynomial: &[f64], mut h: f64, share: f64) -> f64 {
    let [.., before, last] = *polynomial else { return h };
    for _ in 0..SHORTENINGS {
        let value = |place: &f64| polynomial.iter().rev().fold(0.0, |sum, term| sum * (place * h) + term).abs();
        let largest = VALUES.iter().map(value).fold(0.0, f64::max);
        let power = (2..polynomial.len()).fold(1.0, |power, _| power * h);
        let unknown = math::maximum((before * power).abs(), (last * power * h).abs());
        // What begins at zero, or where its series is none, is left to the search for the zero.
        if unknown <= share * largest || !unknown.is_finite() || largest == 0.0 {
            break;
        }
        h *= UNKNOWN_CUT;
    }
    h
}

/// Shortest part of the interval in which a zero is sought.
const SHORTEST_BRACKET: f64 = 1e-14;

/// The first time in (0, h) from which a polynomial is negative that begins positive; one that begins at most at zero counts as beginning
/// at zero. By Bernstein coefficients: a polynomial lies in their convex hull, so that no zero is missed.
pub(crate) fn first_fall(polynomial: &[f64], h: f64) -> Option<f64> {
    let mut scaled = [0.0; MAX_ORDER + 1];
    let scaled = scaled.get_mut(..polynomial.len())?;
    let mut power = 1.0;
    for (place, coefficient) in scaled.iter_mut().zip(polynomial) {
        *place = coefficient * power;
        power *= h;
    }
    let begin = scaled.first_mut()?;
    *begin = begin.max(0.0);
    search(&mut Bernstein::of(scaled)?, 0.0, 1.0).map(|share| share * h)
}

/// The same on a part of the unit interval.
fn search(b: &mut Bernstein, from: f64, length: f64) -> Option<f64> {
    if b.coefficients().iter().all(|value| *value >= 0.0) {
        return None;
    }
    if length < SHORTEST_BRACKET {
        return Some(from);
    }
    let (mut right, half) = (b.halve(), 0.5 * length);
    search(b, from, half).or_else(|| search(&mut right, from + half, half))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_fall_is_found() {
        // (1 - t)(2 - t)(3 - t)
        let cubic = [6.0, -11.0, 6.0, -1.0];
        assert!((first_fall(&cubic, 5.0).unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(first_fall(&cubic, 0.9), None);
        // From zero upwards, and down again at 2.
        assert!((first_fall(&[0.0, 2.0, -1.0], 3.0).unwrap() - 2.0).abs() < 1e-12);
        assert!((first_fall(&[-1e-17, 2.0, -1.0], 3.0).unwrap() - 2.0).abs() < 1e-12);
        // Downwards at once.
        assert!(first_fall(&[0.0, -1.0], 1.0).unwrap() < 1e-12);
        // Two zeros close together, which end points do not show.
        assert!((first_fall(&[0.25 - 1e-8, -1.0, 1.0], 1.0).unwrap() - 0.4999).abs() < 1e-9);
        // A touch is no change of sign.
        assert_eq!(first_fall(&[0.25 + 1e-12, -1.0, 1.0], 1.0), None);
        assert_eq!(first_fall(&[1.0], 1.0), None);
        assert_eq!(first_fall(&[], 1.0), None);
    }

    /// The series of sin 100 t, which is no sine far from where it begins.
    #[test]
    fn a_switching_function_is_known_as_far_as_its_last_terms_are_small() {
        let mut sine = [0.0; 20];
        let mut term = 1.0;
        for (order, place) in sine.iter_mut().enumerate() {
            *place = [0.0, term, 0.0, -term][order % 4];
            term *= 100.0 / (order + 1) as f64;
        }
        let h = known(&sine, 1.0, 0.01);
        assert!((0.04..0.08).contains(&h), "{h}");
        let value = sine.iter().rev().fold(0.0, |sum, term| sum * h + term);
        assert!((value - (100.0 * h).sin()).abs() < 0.02, "{h}: {value}");
        for polynomial in [&[][..], &[1.0], &[1.0, -2.0, 0.0, 0.0], &[0.0, 0.0], &[f64::NAN, 1.0, f64::INFINITY]] {
            assert_eq!(known(polynomial, 3.0, 0.01), 3.0, "{polynomial:?}");
        }
    }

    #[test]
    fn choices_are_remembered() {
        let mut choices = Choices::default();
        assert_eq!(choices.get(3), None);
        choices.set(3, SwitchSign::Above);
        choices.set(5, SwitchSign::Equal);
        choices.set(63, SwitchSign::Below);
        assert_eq!(
            [3, 5, 63, 4, 64].map(|switch| choices.get(switch)),
            [Some(SwitchSign::Above), Some(SwitchSign::Equal), Some(SwitchSign::Below), None, None]
        );
        choices.set(5, SwitchSign::Above);
        assert_eq!(choices.get(5), Some(SwitchSign::Above));
        assert_eq!(choices.without(1 << 5).get(5), None);
        assert_eq!(
            [0.1, -0.0, -0.1, f64::NAN].map(SwitchSign::of),
            [SwitchSign::Above, SwitchSign::Equal, SwitchSign::Below, SwitchSign::Below]
        );
        let later = Choices { known: 0b110, positive: 0b010, equal: 0b100, reversed: 0 };
        let both = Choices { known: 0b1101, positive: 0b1100, equal: 0b0001, reversed: 0 }.then(later);
        assert_eq!(both, Choices { known: 0b1111, positive: 0b1010, equal: 0b0101, reversed: 0b100 });
        assert_eq!(both.then(later), Choices { reversed: 0b110, ..both });
    }
}
