//! Where the law of a cam jumps or has a corner within the turn: at its switches, and where a root, a pole or an arc bends without one.

use std::f64::consts::TAU;

use super::profile::SAME;
use crate::component::Profile;
use crate::laws::rough::{RoughPlace, Roughness};

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
    let spot = |angle: f64| RoughPlace { at: angle, value: law(profile, angle) };
    let spots: Vec<RoughPlace> = (0..=STEPS).map(|step| spot(TAU * step as f64 / STEPS as f64)).collect();
    let largest =
        [0, 1].map(|order| profile.turn().map(|sample| sample.law[order].abs()).fold(f64::MIN_POSITIVE, f64::max));
    let rough = Roughness { bends: BENDS, least: JUMP, halvings: HALVINGS, largest };
    let sharpest = |step: usize| rough.sharpest([spots[step], spots[step + 1]], |angle| law(profile, angle));
    let bends = rough.steps(&spots).into_iter().filter_map(|step| between(sharpest(step), largest));
    let switches = profile.switches.iter().map(|sides| sides.map(spot));
    let mut all: Vec<Break> = bends.chain(switches.filter_map(|sides| between(sides, largest))).collect();
    all.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    all.dedup_by(|a, b| a.angle - b.angle < SAME);
    all
}

/// The law and its slope.
fn law(profile: &Profile, angle: f64) -> [f64; 2] {
    let [law, slope, ..] = profile.sample(angle).law;
    [law, slope]
}

/// The break between two angles next to each other, if there is one.
fn between([low, high]: [RoughPlace; 2], largest: [f64; 2]) -> Option<Break> {
    let jumps = |order: usize| (high.value[order] - low.value[order]).abs() > JUMP * largest[order];
    let sides = [low.value, high.value];
    (jumps(0) || jumps(1)).then(|| Break { angle: high.at, sides, is_jump: jumps(0) })
}
