//! Laws of cams from 0 to 1 (VDI 2143; Norton, *Design of Machinery*): at rest at both ends, below and above they stay there. Each is given
//! with its slope; the argument is the part of the rise, 0 to 1.

use std::f64::consts::PI;

use super::Binary::LessEqual;
use super::term::ArenaTerm;

/// The part of the rise, held at its ends.
fn part(x: ArenaTerm<'_>) -> ArenaTerm<'_> {
    x.clamp(0.0, 1.0)
}

/// Simple harmonic: (1 - cos(pi c))/2. Its acceleration jumps at the ends.
pub fn harmonic([x]: [ArenaTerm<'_>; 1]) -> ArenaTerm<'_> {
    0.5 * (1.0 - (PI * part(x)).cos())
}

pub fn harmonic_slope(x: ArenaTerm<'_>) -> ArenaTerm<'_> {
    0.5 * PI * (PI * part(x)).sin()
}

/// Cycloidal (inclined sine): c - sin(2 pi c)/(2 pi).
pub fn cycloidal([x]: [ArenaTerm<'_>; 1]) -> ArenaTerm<'_> {
    part(x) - 0.5 / PI * (2.0 * PI * part(x)).sin()
}

pub fn cycloidal_slope(x: ArenaTerm<'_>) -> ArenaTerm<'_> {
    1.0 - (2.0 * PI * part(x)).cos()
}

/// 3-4-5 polynomial.
pub fn poly345([x]: [ArenaTerm<'_>; 1]) -> ArenaTerm<'_> {
    let c = part(x);
    c * c.square() * (10.0 - c * (15.0 - 6.0 * c))
}

pub fn poly345_slope(x: ArenaTerm<'_>) -> ArenaTerm<'_> {
    let c = part(x);
    30.0 * (c * (1.0 - c)).square()
}

/// 4-5-6-7 polynomial.
pub fn poly4567([x]: [ArenaTerm<'_>; 1]) -> ArenaTerm<'_> {
    let c = part(x);
    c.square().square() * (35.0 - c * (84.0 - c * (70.0 - 20.0 * c)))
}

pub fn poly4567_slope(x: ArenaTerm<'_>) -> ArenaTerm<'_> {
    let c = part(x);
    let both = c * (1.0 - c);
    140.0 * both * both.square()
}

/// Where the part is at most a bound the first, else the second.
fn up_to<'a>(c: ArenaTerm<'a>, bound: f64, first: ArenaTerm<'a>, second: ArenaTerm<'a>) -> ArenaTerm<'a> {
    c.and(LessEqual, c.number(bound)).select(first, second)
}

/// Modified sine: the peak of its acceleration is 4 pi^2/(4 + pi).
pub fn modified_sine([x]: [ArenaTerm<'_>; 1]) -> ArenaTerm<'_> {
    let peak = 4.0 * PI * PI / (4.0 + PI);
    let c = part(x);
    let middle = 0.25 / PI * c + c.number(0.5 / (PI * PI))
        - 9.0 / (16.0 * PI * PI) * (4.0 / 3.0 * PI * c + c.number(PI / 3.0)).sin();
    up_to(c, 0.125, peak * quick(c), up_to(c, 0.875, peak * middle, 1.0 - peak * quick(1.0 - c)))
}

pub fn modified_sine_slope(x: ArenaTerm<'_>) -> ArenaTerm<'_> {
    let peak = 4.0 * PI * PI / (4.0 + PI);
    let c = part(x);
    let middle = c.number(0.25 / PI) - 0.75 / PI * (4.0 / 3.0 * PI * c + c.number(PI / 3.0)).cos();
    up_to(c, 0.125, peak * quick_slope(c), up_to(c, 0.875, peak * middle, peak * quick_slope(1.0 - c)))
}

/// Modified trapezoid: the peak of its acceleration is 8 pi/(2 + pi).
pub fn modified_trapezoid([x]: [ArenaTerm<'_>; 1]) -> ArenaTerm<'_> {
    let peak = 8.0 * PI / (2.0 + PI);
    let c = part(x);
    let middle = (0.25 + 0.25 / PI) * c + (4.0 * PI * c).sin() * c.number(1.0 / (16.0 * PI * PI)) - c.number(0.0625);
    let rest = up_to(c, 0.875, 1.0 - peak * constant(1.0 - c), 1.0 - peak * quick(1.0 - c));
    let rest = up_to(c, 0.625, peak * middle, rest);
    up_to(c, 0.125, peak * quick(c), up_to(c, 0.375, peak * constant(c), rest))
}

pub fn modified_trapezoid_slope(x: ArenaTerm<'_>) -> ArenaTerm<'_> {
    let peak = 8.0 * PI / (2.0 + PI);
    let c = part(x);
    let middle = c.number(0.25 + 0.25 / PI) + 0.25 / PI * (4.0 * PI * c).cos();
    let rest = up_to(c, 0.875, peak * constant_slope(1.0 - c), peak * quick_slope(1.0 - c));
    let rest = up_to(c, 0.625, peak * middle, rest);
    up_to(c, 0.125, peak * quick_slope(c), up_to(c, 0.375, peak * constant_slope(c), rest))
}

/// The first eighth of both: c/(4 pi) - sin(4 pi c)/(16 pi^2).
fn quick(c: ArenaTerm<'_>) -> ArenaTerm<'_> {
    0.25 / PI * c - 1.0 / (16.0 * PI * PI) * (4.0 * PI * c).sin()
}

fn quick_slope(c: ArenaTerm<'_>) -> ArenaTerm<'_> {
    0.25 / PI * (1.0 - (4.0 * PI * c).cos())
}

/// Constant acceleration between 1/8 and 3/8.
fn constant(c: ArenaTerm<'_>) -> ArenaTerm<'_> {
    0.5 * c.square() + (0.25 / PI - 0.125) * c + c.number(1.0 / 128.0 - 1.0 / (16.0 * PI * PI))
}

fn constant_slope(c: ArenaTerm<'_>) -> ArenaTerm<'_> {
    c + c.number(0.25 / PI - 0.125)
}
