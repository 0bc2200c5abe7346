//! Sums of products of the coefficients of series, of one motion or of several at once: what a new order of a law takes.

use crate::linalg::number::Number;
use crate::program::arm_form::ORDERS;

/// Makes a polynomial in t, so many coefficients of each order side by side, one in t - dt.
pub(super) fn move_start(polynomial: &mut [f64], count: usize, dt: f64) {
    let orders = polynomial.len() / count;
    for first in 0..orders.saturating_sub(1) {
        for order in (first..orders - 1).rev() {
            let (lower, higher) = polynomial[order * count..][..2 * count].split_at_mut(count);
            lower.iter_mut().zip(higher).for_each(|(lower, higher)| *lower += dt * *higher);
        }
    }
}

/// sum a_j b_(k-j), the newest coefficients last, so that the others do not wait for them.
#[inline(always)]
pub(super) fn convolution<N: Number>(a: &[N; ORDERS], b: &[N; ORDERS], k: usize) -> N {
    if k == 0 {
        return a[0] * b[0];
    }
    (dot(&a[1..k], &b[1..k]) + a[0] * b[k]) + a[k] * b[0]
}

/// sum of the products of one end of a with the other end of b, in two sums that do not wait for each other.
#[inline(always)]
fn dot<N: Number>(a: &[N], b: &[N]) -> N {
    let count = a.len().min(b.len());
    let (a, b) = (&a[..count], &b[..count]);
    let (mut even, mut odd, mut j) = (N::ZERO, N::ZERO, 0);
    while j + 1 < count {
        even += a[j] * b[count - 1 - j];
        odd += a[j + 1] * b[count - 2 - j];
        j += 2;
    }
    if j < count {
        even += a[j] * b[count - 1 - j];
    }
    even + odd
}

/// The k-th coefficient of a^2.
#[inline(always)]
pub(super) fn square<N: Number>(a: &[N], k: usize) -> N {
    inner_square(a, k) + if k == 0 { a[0] * a[0] } else { (a[0] * a[k]).times(2.0) }
}

/// The k-th coefficient of a^2 without the terms of a_k.
#[inline(always)]
pub(super) fn inner_square<N: Number>(a: &[N], k: usize) -> N {
    if k < 2 {
        return N::ZERO;
    }
    let half = k.div_ceil(2);
    let middle = if k.is_multiple_of(2) { a[k / 2] * a[k / 2] } else { N::ZERO };
    dot(&a[1..half], &a[k + 1 - half..k]).times(2.0) + middle
}

/// sum of b_j q_(k-j) over 1 <= j <= k
#[inline(always)]
pub(super) fn tail<N: Number>(b: &[N], q: &[N], k: usize) -> N {
    if k == 0 { N::ZERO } else { dot(&b[1..k], &q[1..k]) + b[k] * q[0] }
}

/// sum of j a_j b_(k-j) over 1 <= j <= k
#[inline(always)]
pub(super) fn weighted<N: Number>(a: &[N], b: &[N], k: usize) -> N {
    weighted_up_to(k, a, b, k)
}

/// The sum of j a_j b_(k-j) over 1 <= j <= k, where a has no coefficients beyond a degree.
#[inline(always)]
pub(super) fn weighted_up_to<N: Number>(degree: usize, a: &[N], b: &[N], k: usize) -> N {
    let count = degree.min(k);
    weighted_dot(&a[1..=count], &b[k - count..k])
}

/// The same without j = k.
#[inline(always)]
pub(super) fn weighted_tail<N: Number>(a: &[N], b: &[N], k: usize) -> N {
    if k == 0 { N::ZERO } else { weighted_dot(&a[1..k], &b[1..k]) }
}

#[inline(always)]
fn weighted_dot<N: Number>(a: &[N], b: &[N]) -> N {
    let count = a.len().min(b.len());
    let (a, b) = (&a[..count], &b[..count]);
    let (mut sum, mut j) = (N::ZERO, 0);
    while j < count {
        sum += (a[j] * b[count - 1 - j]).times((j + 1) as f64);
        j += 1;
    }
    sum
}

/// Order k of u = a^p above 0: a u' = p u a'
#[inline(always)]
pub(super) fn power<N: Number>(a: &[N], u: &[N], exponent: N, k: usize) -> N {
    let (n, exponent) = (N::all(k as f64), exponent + N::all(1.0));
    let (mut sum, mut j) = (N::ZERO, 1);
    while j <= k {
        sum += (exponent.times(j as f64) - n) * (a[j] * u[k - j]);
        j += 1;
    }
    sum.over(n * a[0])
}
