//! Numbers of twice the precision: unevaluated sums of two.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// high + low, where |low| is at most half a unit in the last place of high.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twofold {
    pub high: f64,
    low: f64,
}

/// a + b and what rounding leaves of it, where a is the larger.
fn quick_sum(a: f64, b: f64) -> Twofold {
    let high = a + b;
    Twofold { high, low: b - (high - a) }
}

/// a + b and what rounding leaves of it (Knuth).
fn two_sum(a: f64, b: f64) -> Twofold {
    let high = a + b;
    let part = high - a;
    Twofold { high, low: (a - (high - part)) + (b - part) }
}

impl From<f64> for Twofold {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Twofold {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, low) = (two_sum(self.high, other.high), two_sum(self.low, other.low));
        let sum = quick_sum(high.high, high.low + low.high);
        quick_sum(sum.high, sum.low + low.low)
    }
}

impl Neg for Twofold {
    type Output = Self;

    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Twofold {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Twofold {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        let rest = self.high.mul_add(other.high, -high);
        quick_sum(high, rest + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Twofold {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * first.into();
        let second = rest.high / other.high;
        let rest = rest - other * second.into();
        quick_sum(first, second) + (rest.high / other.high).into()
    }
}

/// Halvings of an angle before its series, and the terms of that.
const HALVINGS: i32 = 6;
const TERMS: u32 = 24;

impl Twofold {
    /// Cosine and sine, by their series and the double angle.
    pub fn cosine_and_sine(self) -> [Self; 2] {
        let small = self * 2.0_f64.powi(-HALVINGS).into();
        let (mut term, mut sums) = (Self::from(1.0), [Self::from(1.0), Self::default()]);
        for k in 1..TERMS {
            term = term * small / f64::from(k).into();
            let signed = if k % 4 < 2 { term } else { -term };
            sums[k as usize % 2] = sums[k as usize % 2] + signed;
        }
        let [mut c, mut s] = sums;
        for _ in 0..HALVINGS {
            (c, s) = (c * c - s * s, (s + s) * c);
        }
        [c, s]
    }
}
