//! Linkages with a given swing or stroke and a given crank angle between the dead centres, with the best transmission angle.
//!
//! With a ground of one and `l` = coupler/crank: `(1+l) Z1 - Z2 = 1`, `(l-1) exp(i(phi-pi)) Z1 - exp(i psi) Z2 = 1`. The `l` with the best transmission
//! angle is a root of a cubic.
//!
//! Source: F. Freudenstein, E. J. F. Primrose, *The classical transmission angle problem*, Proc. Conf. Mechanisms, IMechE, 1973; F. Brodell, A. H. Soni,
//! *Design of the crank-rocker mechanism with unit time ratio*, J. Mechanisms 5, 1970, for half a turn.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::{Point, polar};

/// A crank-rocker or a slider-crank between its dead centres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Ground, crank, coupler, rocker; a slider-crank has its offset in place of the ground and no rocker \[m\], for a ground of one in the first case.
    pub lengths: [f64; 4],
    /// The smallest transmission angle of a whole turn \[rad\].
    pub transmission: f64,
}

/// Why there is no such linkage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoStroke {
    /// Turns, swings and strokes must be above zero and below a whole turn; a swing below half a turn.
    Range,
    /// At half a turn there is no best one: the shorter the crank, the better. Give the length of the crank.
    NoBest,
    /// No crank turns fully with this swing in this turn.
    NoCrank,
    /// The offset is too large for the stroke in this turn, or half a turn has an offset.
    Offset,
}

/// The four-bar of the family with `l` = coupler/crank, for a ground of one.
pub fn rocker_of(turn: f64, swing: f64, l: f64) -> [f64; 4] {
    let (one, back, swung) = (Point::new(1.0, 0.0), polar(l - 1.0, turn - PI), polar(1.0, swing));
    // Cramer's rule for Z1 and Z2.
    let below = back - swung * (1.0 + l);
    let (first, second) = ((one - swung) / below, (back - (1.0 + l)) / below);
    [1.0, first.norm(), l * first.norm(), second.norm()]
}

/// The smallest transmission angle of a crank-rocker, over a whole turn \[rad\]; zero if the crank does not turn.
pub fn smallest_transmission([ground, crank, coupler, rocker]: [f64; 4]) -> f64 {
    let angle = |side: f64| {
        let cosine = (coupler * coupler + rocker * rocker - side * side) / (2.0 * coupler * rocker);
        FRAC_PI_2 - (cosine.clamp(-1.0, 1.0).acos() - FRAC_PI_2).abs()
    };
    let shortest = coupler.min(rocker).min(ground);
    let longest = coupler.max(rocker).max(ground);
    if crank > shortest || crank + longest >= ground + coupler + rocker - longest {
        return 0.0;
    }
    angle((ground - crank).abs()).min(angle(ground + crank))
}

/// Half a turn, up to rounding of what people write.
const HALF: f64 = 1e-9;

/// The crank-rocker with a swing \[rad\] during a turn of the crank \[rad\] whose smallest transmission angle is the largest, for a ground of one.
///
/// # Errors
/// There is none.
pub fn rocker(turn: f64, swing: f64) -> Result<Stroke, NoStroke> {
    if !(turn > 0.0 && turn < TAU && swing > 0.0 && swing < PI) {
        return Err(NoStroke::Range);
    }
    if (turn - PI).abs() < HALF {
        return Err(NoStroke::NoBest);
    }
    let (t, u) = ((turn / 2.0).tan(), ((turn - swing) / 2.0).tan());
    let value = |q: f64| q * q * q + 2.0 * q * q - t * t * q - t * t * (1.0 + t * t) / (u * u);
    // One change of sign of the coefficients: one positive root.
    let (mut low, mut high) = (0.0, 1.0);
    while value(high) < 0.0 && high < 1e300 {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if value(middle) < 0.0 { low = middle } else { high = middle }
    }
    let lengths = rocker_of(turn, swing, (t * t / (0.5 * (low + high))).sqrt());
    let transmission = smallest_transmission(lengths);
    if transmission > 0.0 { Ok(Stroke { lengths, transmission }) } else { Err(NoStroke::NoCrank) }
}

/// The crank-rocker with a swing during half a turn whose crank has this share of the ground: there, ground^2 + crank^2 = coupler^2 + rocker^2.
///
/// # Errors
/// There is none.
pub fn central_rocker(swing: f64, crank: f64) -> Result<Stroke, NoStroke> {
    if !(swing > 0.0 && swing < PI && crank > 0.0) {
        return Err(NoStroke::Range);
    }
    let rocker = crank / (swing / 2.0).sin();
    let lengths = [1.0, crank, (1.0 + crank * crank - rocker * rocker).max(0.0).sqrt(), rocker];
    let transmission = smallest_transmission(lengths);
    if transmission > 0.0 { Ok(Stroke { lengths, transmission }) } else { Err(NoStroke::NoCrank) }
}

/// The slider-crank with a stroke \[m\] during a turn of the crank \[rad\]: that with the given offset \[m\], or that with the best transmission angle.
///
/// The crank turns `turn` from one dead centre to the other; of turns above and below half a turn the linkage is the same, with the crank turning the
/// other way.
///
/// # Errors
/// There is none.
pub fn slider(turn: f64, stroke: f64, offset: Option<f64>) -> Result<Stroke, NoStroke> {
    if !(turn > 0.0 && turn < TAU && stroke > 0.0 && offset.is_none_or(|offset| offset >= 0.0)) {
        return Err(NoStroke::Range);
    }
    let between = (turn - PI).abs();
    if between < HALF {
        return Err(if offset.is_some_and(|offset| offset > 0.0) { NoStroke::Offset } else { NoStroke::NoBest });
    }
    // Rod + crank and rod - crank are the sides of a triangle on the stroke whose height is the offset.
    let of = |offset: f64| {
        let difference = stroke * offset / between.sin();
        let sum = 0.5 * stroke * stroke + difference * between.cos();
        let [rod, crank] = [0.5 * (sum + difference), 0.5 * (sum - difference)].map(f64::sqrt);
        let sine = (crank + offset) / rod;
        let good = crank > 0.0 && rod - crank > offset;
        good.then(|| Stroke { lengths: [offset, crank, rod, f64::NAN], transmission: sine.acos() })
    };
    if let Some(offset) = offset {
        return of(offset).ok_or(NoStroke::Offset);
    }
    let largest = 0.5 * stroke / (between / 2.0).tan();
    let sine = |offset: f64| of(offset).map_or(1.0, |found| found.transmission.cos());
    let steps = 400;
    let at = |step: usize| largest * step as f64 / steps as f64;
    let best = (1..steps).min_by(|a, b| sine(at(*a)).total_cmp(&sine(at(*b)))).unwrap_or(1);
    let (mut low, mut high) = (at(best - 1), at(best + 1));
    for _ in 0..200 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if sine(a) < sine(b) { high = b } else { low = a }
    }
    of(0.5 * (low + high)).ok_or(NoStroke::NoCrank)
}

/// The in-line slider-crank with a stroke \[m\] during half a turn, with a rod of this length \[m\].
///
/// # Errors
/// There is none.
pub fn central_slider(stroke: f64, rod: f64) -> Result<Stroke, NoStroke> {
    let crank = 0.5 * stroke;
    if !(stroke > 0.0 && rod > 0.0) {
        return Err(NoStroke::Range);
    }
    if rod <= crank {
        return Err(NoStroke::NoCrank);
    }
    Ok(Stroke { lengths: [0.0, crank, rod, f64::NAN], transmission: (crank / rod).acos() })
}
