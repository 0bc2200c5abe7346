//! Where the law of a cam jumps or has a corner within the turn: at its switches, and where a root, a pole or an arc bends without one.

use std::f64::consts::TAU;

use super::profile::{SAME, Sample};
use crate::component::Profile;

/// At so many angles a turn is looked at.
const STEPS: usize = 720;
/// An interval is looked at closely if the slope changes by so many times what it changes by on both sides.
const BENDS: f64 = 10.0;
/// Halvings of an interval: to 1e-15 of a turn.
const HALVINGS: usize = 40;
/// A jump is above this share of the largest value, or slope.
const JUMP: f64 = 1e-6;

/// A law that is not smooth at an angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Break {
    pub angle: f64,
    /// The law and its slope on both sides.
    pub sides: [[f64; 2]; 2],
    /// Is it the law itself that jumps? Else its slope.
    pub is_jump: bool,
}

/// All breaks within the turn, by their angles.
pub(super) fn breaks(profile: &Profile) -> Vec<Break> {
    let samples: Vec<Sample> = (0..=STEPS).map(|step| profile.sample(TAU * step as f64 / STEPS as f64)).collect();
    let largest = [0, 1].map(|order| profile.turn().map(|own| own.law[order].abs()).fold(f64::MIN_POSITIVE, f64::max));
    let change = |step: usize| (samples[step + 1].law[1] - samples[step].law[1]).abs();
    let suspect = |step: &usize| {
        let neighbours = [step.checked_sub(2), Some(step + 2).filter(|after| *after < STEPS)];
        let around = neighbours.into_iter().flatten().map(change).fold(0.0, f64::max);
        let way = TAU / STEPS as f64;
        let bends = change(*step) > BENDS * around && change(*step) > JUMP * largest[1];
        bends || unexplained(&samples[*step], &samples[step + 1]) > way * around + JUMP * largest[0]
    };
    let steps: Vec<usize> = (0..STEPS).filter(suspect).collect();
    let bends = steps.into_iter().filter_map(|step| sharpest(profile, [samples[step], samples[step + 1]], largest));
    let switches = profile.switches.iter().map(|sides| sides.map(|angle| profile.sample(angle)));
    let mut all: Vec<Break> = bends.chain(switches.filter_map(|sides| between(sides, largest))).collect();
    all.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    all.dedup_by(|a, b| a.angle - b.angle < SAME);
    all
}

/// The change of the law between two angles beyond what its slopes there make of it.
fn unexplained(one: &Sample, other: &Sample) -> f64 {
    let way = other.angle - one.angle;
    (other.law[0] - one.law[0] - 0.5 * way * (one.law[1] + other.law[1])).abs()
}

/// The break between two angles, by halving; none if the law is smooth where it turns most.
fn sharpest(profile: &Profile, [mut low, mut high]: [Sample; 2], largest: [f64; 2]) -> Option<Break> {
    let turns = |one: &Sample, other: &Sample| {
        unexplained(one, other) / largest[0] + (other.law[1] - one.law[1]).abs() / largest[1]
    };
    for _ in 0..HALVINGS {
        let middle = profile.sample(0.5 * (low.angle + high.angle));
        *(if turns(&low, &middle) > turns(&middle, &high) { &mut high } else { &mut low }) = middle;
    }
    between([low, high], largest)
}

/// The break between two angles next to each other, if there is one.
fn between([low, high]: [Sample; 2], largest: [f64; 2]) -> Option<Break> {
    let jumps = |order: usize| (high.law[order] - low.law[order]).abs() > JUMP * largest[order];
    let sides = [low, high].map(|sample| [sample.law[0], sample.law[1]]);
    (jumps(0) || jumps(1)).then(|| Break { angle: high.angle, sides, is_jump: jumps(0) })
}
