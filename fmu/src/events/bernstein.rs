//! Polynomials in the unit interval by Bernstein coefficients: a polynomial lies in their convex hull, and has no more roots there than these have changes of sign (Farouki, *Comput. Aided Geom. Design*
//! 29, 2012, sections 3 and 7).

use crate::linalg::lane::{Lane, WIDTH, add, by_width, times};
use crate::program::arm_form::{MAX_ORDER, ORDERS};

/// Whole lanes, and one beyond them, which a lane is added from.
const ROOM: usize = ORDERS.next_multiple_of(WIDTH) + WIDTH;

/// The coefficients of a polynomial, with zeros behind them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bernstein {
    degree: usize,
    all: [f64; ROOM],
}

impl Bernstein {
    /// The polynomial of these coefficients of powers: b_j is the sum over i <= j of binomial(j, i)/binomial(n, i) a_i. None without coefficients, or for a degree above the highest order of a series.
    pub fn of(polynomial: &[f64]) -> Option<Self> {
        let degree = polynomial.len().checked_sub(1).filter(|degree| *degree <= MAX_ORDER)?;
        let mut all = [0.0; ROOM];
        let b = &mut all[..=degree];
        b.copy_from_slice(polynomial);
        let mut binomial = 1.0;
        for (i, place) in b.iter_mut().enumerate() {
            *place /= binomial;
            binomial *= (degree - i) as f64 / (i + 1) as f64;
        }
        for round in 0..degree {
            for j in (round + 1..=degree).rev() {
                b[j] += b[j - 1];
            }
        }
        Some(Self { degree, all })
    }

    pub fn coefficients(&self) -> &[f64] {
        &self.all[..=self.degree]
    }

    by_width! {
        /// Leaves the first half of the interval here and returns the second one, by de Casteljau's algorithm. (A search keeps one of them at each depth, not three: stacks may be small.)
        pub fn halve(&mut self: Bernstein) -> Bernstein = halve_any
    }

    #[inline(always)]
    fn halve_any(&mut self) -> Self {
        let degree = self.degree.min(MAX_ORDER);
        let mut right = Self { degree, all: [0.0; ROOM] };
        let mut level = self.all;
        for k in 0..=degree {
            (self.all[k], right.all[degree - k]) = (level[0], level[degree - k]);
            // What comes of the numbers behind this level is not read.
            for lane in 0..(degree - k).div_ceil(WIDTH) {
                let place = &mut level[WIDTH * lane..][..WIDTH + 1];
                let [first, second] = [0, 1].map(|from| -> Lane { [0, 1, 2, 3].map(|i| place[from + i]) });
                place[..WIDTH].copy_from_slice(&times(0.5, add(first, second)));
            }
        }
        right
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Random, horner};

    /// Both halves have the values of the polynomial at their ends, and its coefficients are those of 1 and s.
    #[test]
    fn halves_are_the_same_polynomial() {
        assert!(Bernstein::of(&[]).is_none() && Bernstein::of(&[0.0; ORDERS + 1]).is_none());
        assert_eq!(Bernstein::of(&[1.0, 0.0, 0.0]).map(|b| b.coefficients().to_vec()), Some(vec![1.0; 3]));
        assert_eq!(Bernstein::of(&[0.0, 1.0, 0.0]).map(|b| b.coefficients().to_vec()), Some(vec![0.0, 0.5, 1.0]));
        let mut random = Random::new(5);
        for count in 1..=ORDERS {
            let polynomial: Vec<f64> = (0..count).map(|_| random.unit() - 0.5).collect();
            let mut left = Bernstein::of(&polynomial).unwrap();
            let right = left.halve();
            let ends = [left, right].map(|half| [half.coefficients()[0], half.coefficients()[count - 1]]);
            let expected = [[0.0, 0.5], [0.5, 1.0]].map(|ends| ends.map(|s| horner(&polynomial, s)));
            for (value, expected) in ends.as_flattened().iter().zip(expected.as_flattened()) {
                assert!((value - expected).abs() < 1e-12, "{count}: {value} {expected}");
            }
            // The middle of the left half, by its own halves.
            let quarter = left.halve().coefficients()[0];
            assert!((quarter - horner(&polynomial, 0.25)).abs() < 1e-12, "{count}");
        }
    }
}
