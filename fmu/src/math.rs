//! Elementary functions with the same bits on every platform.
//!
//! `+ - * /` and the square root are correctly rounded by IEEE 754; everything else comes from here or from the `libm` crate, never
//! from the platform's C library.

/// 2 / pi.
pub(crate) const TWO_OVER_PI: f64 = core::f64::consts::FRAC_2_PI;
/// 1.5 * 2^52: adding it rounds to the nearest integer, whose low bits are then the low bits of the sum.
pub(crate) const ROUND: f64 = 6_755_399_441_055_744.0;
/// pi/2 in three parts. The first two have 33 significant bits, so that their products with the multiple (under 2^17) are exact.
pub(crate) const HALF_PI: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    f64::from_bits(0x3BA3_198A_2E03_7073),
];
/// Beyond this the three-part reduction is no longer exact enough.
pub(crate) const REDUCTION_LIMIT: f64 = 1.0e5;

/// Taylor-like coefficients of (sin y - y) / y^3 in y^2, from fdlibm `k_sin.c` (Sun Microsystems, 1993).
pub(crate) const SINE: [f64; 6] = [
    f64::from_bits(0xBFC5_5555_5555_5549),
    f64::from_bits(0x3F81_1111_1110_F8A6),
    f64::from_bits(0xBF2A_01A0_19C1_61D5),
    f64::from_bits(0x3EC7_1DE3_57B1_FE7D),
    f64::from_bits(0xBE5A_E5E6_8A2B_9CEB),
    f64::from_bits(0x3DE5_D93A_5ACF_D57C),
];
/// Coefficients of (cos y - 1 + y^2/2) / y^4 in y^2, from fdlibm `k_cos.c` (Sun Microsystems, 1993).
pub(crate) const COSINE: [f64; 6] = [
    f64::from_bits(0x3FA5_5555_5555_554C),
    f64::from_bits(0xBF56_C16C_16C1_5177),
    f64::from_bits(0x3EFA_01A0_19CB_1590),
    f64::from_bits(0xBE92_7E4F_809C_52AD),
    f64::from_bits(0x3E21_EE9E_BDB4_B1C4),
    f64::from_bits(0xBDA8_FAE9_BE88_38D4),
];

/// The value of a polynomial, whose coefficients begin with the constant one (Horner's scheme).
pub(crate) fn horner(coefficients: &[f64], at: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * at + coefficient)
}

/// sin x and cos x, each within 0.8 units in the last place.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    // The comparison is false for NaN too.
    if x.abs() < REDUCTION_LIMIT { reduced_sin_cos(x) } else { libm::sincos(x) }
}

#[inline]
fn reduced_sin_cos(x: f64) -> (f64, f64) {
    let rounded = x * TWO_OVER_PI + ROUND;
    let quadrant = rounded.to_bits();
    let multiple = rounded - ROUND;

    // Cody and Waite: y + tail = x - multiple * pi/2, to about twice the working precision.
    let first = x - multiple * HALF_PI[0];
    let product = multiple * HALF_PI[1];
    let second = first - product;
    let lost = (first - second) - product;
    let correction = lost - multiple * HALF_PI[2];
    let y = second + correction;
    let tail = (second - y) + correction;

    let (sine, cosine) = kernels(y, tail);
    let (s, c) = if quadrant & 1 == 0 { (sine, cosine) } else { (cosine, sine) };
    let s = if quadrant & 2 == 0 { s } else { -s };
    let c = if quadrant.wrapping_add(1) & 2 == 0 { c } else { -c };
    (s, c)
}

/// sin and cos of y + tail for |y| up to pi/4.
#[inline]
fn kernels(y: f64, tail: f64) -> (f64, f64) {
    let z = y * y;
    let cube = z * y;
    let high = SINE[1] + z * (SINE[2] + z * (SINE[3] + z * (SINE[4] + z * SINE[5])));
    let sine = y - ((z * (0.5 * tail - cube * high) - tail) - cube * SINE[0]);

    let high = z * (COSINE[0] + z * (COSINE[1] + z * (COSINE[2] + z * (COSINE[3] + z * (COSINE[4] + z * COSINE[5])))));
    let half = 0.5 * z;
    let leading = 1.0 - half;
    let cosine = leading + (((1.0 - leading) - half) + (z * high - y * tail));
    (sine, cosine)
}

/// -1, 0 or 1; NaN stays NaN.
#[inline]
pub fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        x
    }
}

/// The smaller; NaN if either is NaN (unlike [`f64::min`], which hides it).
#[inline]
pub fn minimum(a: f64, b: f64) -> f64 {
    if a < b || a.is_nan() { a } else { b }
}

/// The larger; NaN if either is NaN.
#[inline]
pub fn maximum(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// 1 - tanh^2 a without the cancellation.
#[inline(always)]
pub(crate) fn steepness(a: f64) -> f64 {
    let share = libm::exp(-2.0 * a.abs());
    4.0 * share / ((1.0 + share) * (1.0 + share))
}

/// log2 x within 0.001, for a positive normal number; the cubic meets the logarithm at both ends of a binade.
#[inline]
pub fn rough_log2(x: f64) -> f64 {
    if x.is_nan() || x < f64::MIN_POSITIVE || x == f64::INFINITY {
        return libm::log2(x);
    }
    rough_log2_of_normal(x)
}

/// The same of a positive number that is neither subnormal nor infinite.
#[inline(always)]
pub fn rough_log2_of_normal(x: f64) -> f64 {
    const FRACTION: u64 = (1 << 52) - 1;
    /// 2^52, whose last bits count ones.
    const ONES: f64 = 4_503_599_627_370_496.0;
    let bits = x.to_bits();
    let exponent = f64::from_bits(bits >> 52 | ONES.to_bits()) - (ONES + 1023.0);
    let m = f64::from_bits(bits & FRACTION | 1.0f64.to_bits());
    exponent + (-2.156_849_51 + m * (3.048_970_60 + m * (-1.048_969_25 + m * 0.156_848_16)))
}

/// 2^x within 0.014 %.
#[inline]
pub fn rough_exp2(x: f64) -> f64 {
    let whole = libm::floor(x);
    if x.is_nan() || whole.abs() >= 1000.0 {
        return libm::exp2(x);
    }
    let f = x - whole;
    let power = f64::from_bits(((whole as i64 + 1023) as u64) << 52);
    power * (1.0 + f * (0.695_856_85 + f * (0.224_998_18 + f * 0.079_144_97)))
}

/// The golden section, (sqrt 5 - 1)/2.
pub const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Where a function with one peak between two places is largest, and its value there, by golden sections.
pub fn largest_between([mut from, mut to]: [f64; 2], sections: usize, mut value: impl FnMut(f64) -> f64) -> (f64, f64) {
    let (mut left, mut right) = (to - GOLDEN * (to - from), from + GOLDEN * (to - from));
    let (mut at_left, mut at_right) = (value(left), value(right));
    for _ in 0..sections {
        if at_left > at_right {
            (to, right, at_right) = (right, left, at_left);
            left = to - GOLDEN * (to - from);
            at_left = value(left);
        } else {
            (from, left, at_left) = (left, right, at_right);
            right = from + GOLDEN * (to - from);
            at_right = value(right);
        }
    }
    if at_left > at_right { (left, at_left) } else { (right, at_right) }
}

/// SplitMix64 (Steele, Lea, Flood 2014): random enough for disturbances, and the same everywhere.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Between -1 and 1.
    pub fn symmetric(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Between 0 and 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rough_powers_are_near_the_fine_ones() {
        let values = (-4000..4000).map(|i| f64::from(i) * 0.137);
        for x in values {
            let power = libm::exp2(x);
            assert!((rough_exp2(x) / power - 1.0).abs() < 1.4e-4, "{x}");
            assert!((rough_log2(power) - x).abs() < 1e-3, "{x}");
        }
        assert_eq!(rough_log2(0.0), f64::NEG_INFINITY);
        assert!(rough_log2(f64::NAN).is_nan() && rough_exp2(f64::NAN).is_nan());
        assert_eq!((rough_exp2(f64::NEG_INFINITY), rough_exp2(f64::INFINITY)), (0.0, f64::INFINITY));
    }

    /// Unevaluated sum of two doubles, about 106 bits: the reference of these tests.
    #[derive(Clone, Copy)]
    struct Double(f64, f64);

    impl Double {
        fn sum(a: f64, b: f64) -> Self {
            let s = a + b;
            let t = s - a;
            Self(s, (a - (s - t)) + (b - t))
        }
        fn product(a: f64, b: f64) -> Self {
            let p = a * b;
            Self(p, a.mul_add(b, -p))
        }
        fn add(self, other: Self) -> Self {
            let s = Self::sum(self.0, other.0);
            let t = Self::sum(self.1, other.1);
            let u = Self::sum(s.0, s.1 + t.0);
            Self::sum(u.0, u.1 + t.1)
        }
        fn multiply(self, other: Self) -> Self {
            let p = Self::product(self.0, other.0);
            Self::sum(p.0, p.1 + (self.0 * other.1 + self.1 * other.0))
        }
        fn divide(self, divisor: f64) -> Self {
            let q = self.0 / divisor;
            let r = self.add(Self::product(-q, divisor));
            Self::sum(q, (r.0 + r.1) / divisor)
        }
        fn negate(self) -> Self {
            Self(-self.0, -self.1)
        }
    }

    /// pi/2 to more than 200 bits, as a sum of doubles.
    const HALF_PI_PARTS: [f64; 4] =
        [core::f64::consts::FRAC_PI_2, 6.123233995736766e-17, -1.4973849048591698e-33, 5.562271104316826e-50];

    fn reference(x: f64) -> (Double, Double) {
        let multiple = (x / core::f64::consts::FRAC_PI_2).round();
        let mut y = Double(x, 0.0);
        for part in HALF_PI_PARTS {
            y = y.add(Double::product(-multiple, part));
        }
        let square = y.multiply(y).negate();
        let (mut sine, mut cosine) = (y, Double(1.0, 0.0));
        let (mut sine_term, mut cosine_term) = (y, Double(1.0, 0.0));
        for k in 1..20 {
            let k = 2.0 * f64::from(k);
            cosine_term = cosine_term.multiply(square).divide(k * (k - 1.0));
            sine_term = sine_term.multiply(square).divide(k * (k + 1.0));
            cosine = cosine.add(cosine_term);
            sine = sine.add(sine_term);
        }
        match multiple.rem_euclid(4.0) as i64 {
            0 => (sine, cosine),
            1 => (cosine, sine.negate()),
            2 => (sine.negate(), cosine.negate()),
            _ => (cosine.negate(), sine),
        }
    }

    fn ulps(found: f64, exact: Double) -> f64 {
        let spacing = found.abs().next_up() - found.abs();
        ((found - exact.0) - exact.1).abs() / spacing
    }

    /// Angles that matter: small, near multiples of pi/2, and spread over the range of the reduction.
    fn angles() -> Vec<f64> {
        let mut angles = vec![1e-300, 1e-9, 0.1, 1.0];
        for k in 1..400 {
            let multiple = f64::from(k * k) * core::f64::consts::FRAC_PI_4;
            angles.extend([multiple.next_down(), multiple, multiple.next_up()]);
        }
        let mut seed = 1_u64;
        for _ in 0..200_000 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let unit = (seed >> 11) as f64 / (1_u64 << 53) as f64;
            angles.push(unit * 10.0);
            angles.push(unit * 99_999.0);
        }
        angles.retain(|x| x.abs() < REDUCTION_LIMIT);
        angles
    }

    #[test]
    fn sine_and_cosine_are_within_0_8_ulp() {
        let mut worst: f64 = 0.0;
        for x in angles() {
            let (s, c) = sin_cos(x);
            let (exact_s, exact_c) = reference(x);
            worst = worst.max(ulps(s, exact_s)).max(ulps(c, exact_c));
        }
        assert!(worst <= 0.8, "{worst} ulp");
    }

    #[test]
    fn sine_is_odd_and_cosine_is_even_bit_for_bit() {
        for x in angles() {
            let (s, c) = sin_cos(x);
            let (minus_s, minus_c) = sin_cos(-x);
            assert_eq!((s.to_bits(), c.to_bits()), ((-minus_s).to_bits(), minus_c.to_bits()), "{x}");
        }
    }

    #[test]
    fn both_branches_agree_where_they_meet() {
        let below = REDUCTION_LIMIT.next_down();
        let ((s, c), (exact_s, exact_c)) = (libm::sincos(below), sin_cos(below));
        assert!((s - exact_s).abs() <= 1e-15 && (c - exact_c).abs() <= 1e-15);
        assert_eq!(sin_cos(1e300), libm::sincos(1e300));
        assert!(sin_cos(f64::NAN).0.is_nan() && sin_cos(f64::INFINITY).1.is_nan());
    }

    #[test]
    fn signs_and_extremes_keep_nan() {
        assert_eq!([sign(-3.0), sign(0.0), sign(2.0)], [-1.0, 0.0, 1.0]);
        assert_eq!((minimum(1.0, 2.0), maximum(1.0, 2.0)), (1.0, 2.0));
        for (a, b) in [(f64::NAN, 1.0), (1.0, f64::NAN)] {
            assert!(minimum(a, b).is_nan() && maximum(a, b).is_nan());
        }
        assert!(sign(f64::NAN).is_nan());
    }
}
