//! Sine and cosine of several angles at once, with the bits of [`math::sin_cos`].

use super::lane::{Lane, add, by_width, multiply, plus, splat, subtract};
use crate::math::{self, COSINE, HALF_PI, REDUCTION_LIMIT, ROUND, SINE, TWO_OVER_PI};

/// cos x and sin x.
#[inline(always)]
pub(crate) fn cosine_and_sine<const L: usize>(x: Lane<f64, L>) -> [Lane<f64, L>; 2] {
    // Written so that NaN is not small.
    let small = x.iter().all(|x| x.abs() < REDUCTION_LIMIT);
    if !small {
        let both = x.map(math::sin_cos);
        return [both.map(|(_, cosine)| cosine), both.map(|(sine, _)| sine)];
    }
    let rounded = add(multiply(x, splat(TWO_OVER_PI)), splat(ROUND));
    let multiple = subtract(rounded, splat(ROUND));
    let first = subtract(x, multiply(multiple, splat(HALF_PI[0])));
    let product = multiply(multiple, splat(HALF_PI[1]));
    let second = subtract(first, product);
    let lost = subtract(subtract(first, second), product);
    let correction = subtract(lost, multiply(multiple, splat(HALF_PI[2])));
    let y = add(second, correction);
    let tail = add(subtract(second, y), correction);

    let [cosine, sine] = kernels(y, tail);
    let mut result = [[0.0; L]; 2];
    for i in 0..L {
        let quadrant = rounded[i].to_bits();
        let (even, odd) = if quadrant & 1 == 0 { (cosine[i], sine[i]) } else { (sine[i], cosine[i]) };
        result[0][i] = f64::from_bits(even.to_bits() ^ (quadrant.wrapping_add(1) & 2) << 62);
        result[1][i] = f64::from_bits(odd.to_bits() ^ (quadrant & 2) << 62);
    }
    result
}

/// Four angles.
pub(crate) struct Angles(pub Lane);

impl Angles {
    by_width! {
        /// Their cosines and sines, where the code around is not compiled for AVX2.
        pub(crate) fn cosines_and_sines(&self: Angles) -> [Lane; 2] = turned
    }

    #[inline(always)]
    fn turned(&self) -> [Lane; 2] {
        cosine_and_sine(self.0)
    }
}

/// cos and sin of y + tail for |y| up to pi/4.
#[inline(always)]
fn kernels<const L: usize>(y: Lane<f64, L>, tail: Lane<f64, L>) -> [Lane<f64, L>; 2] {
    let half = splat(0.5);
    let z = multiply(y, y);
    let cube = multiply(z, y);
    let high = polynomial(z, &SINE[1..]);
    let inner = subtract(multiply(half, tail), multiply(cube, high));
    let sine = subtract(multiply(z, inner), tail);
    let sine = subtract(y, subtract(sine, multiply(cube, splat(SINE[0]))));

    let high = multiply(z, polynomial(z, &COSINE));
    let small = multiply(half, z);
    let leading = subtract(splat(1.0), small);
    let rest = subtract(subtract(splat(1.0), leading), small);
    let end = subtract(multiply(z, high), multiply(y, tail));
    [add(leading, add(rest, end)), sine]
}

#[inline(always)]
fn polynomial<const L: usize>(z: Lane<f64, L>, coefficients: &[f64]) -> Lane<f64, L> {
    let mut rest = coefficients.iter().rev();
    let last = rest.next().map_or([0.0; L], |last| splat(*last));
    rest.fold(last, |sum, coefficient| plus(splat(*coefficient), z, sum))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_angles_turn_as_one_does() {
        let mut angles: Vec<f64> = (-4000..4000).map(|i| f64::from(i) * 0.377_31).collect();
        angles.extend([0.0, -0.0, 1e-300, 99_999.0, -1e5, 1e9, f64::NAN, f64::INFINITY]);
        for four in angles.windows(4) {
            let four = [four[0], four[1], four[2], four[3]];
            let [cosine, sine] = cosine_and_sine(four);
            for (i, x) in four.into_iter().enumerate() {
                let (s, c) = math::sin_cos(x);
                assert_eq!((sine[i].to_bits(), cosine[i].to_bits()), (s.to_bits(), c.to_bits()), "{x}");
            }
        }
    }
}
