//! Design quantities of a cam: the peaks of its law, pressure angle, curvature, undercut, the width of a flat face (Norton, *Design of
//! Machinery*; VDI 2142, 2143).

use cotree::component::{Phase, Profile};
use cotree::model::Mechanism;
use serde::Serialize;

use super::samples::ValueAt;

/// A cam over one turn, by its own angle on its carrier; SI.
#[derive(Clone, Debug, Serialize)]
pub struct Cam {
    /// The joint.
    pub name: String,
    /// What touches it: `roller`, `knife edge` or `flat face`.
    pub follower: &'static str,
    /// Does the follower turn? Else it slides.
    pub turning: bool,
    /// Radius of the base circle \[m\].
    pub base: f64,
    /// Rises and returns with the peak coefficients of velocity, acceleration and jerk.
    pub phases: Vec<Phase>,
    /// The largest angle between the common normal and the direction in which the follower rises \[rad\].
    pub pressure_angle: ValueAt,
    /// The smallest radius of curvature of the profile where it is convex \[m\].
    pub convex_radius: Option<ValueAt>,
    /// That of the curve that the roller's centre draws \[m\].
    pub pitch_radius: Option<ValueAt>,
    /// The smallest radius of curvature of the profile where it is hollow \[m\].
    pub hollow_radius: Option<ValueAt>,
    pub undercut: bool,
    /// The smallest base circle without undercut, if this one is too small and a larger one helps \[m\].
    pub least_base: Option<f64>,
    /// How far a flat face touches from the follower's point, along the face: the least and the most \[m\].
    pub face: Option<[ValueAt; 2]>,
}

pub(super) fn cams(mechanism: &Mechanism) -> Vec<Cam> {
    mechanism.profiles(&mechanism.parameter_values()).iter().map(cam).collect()
}

fn cam(profile: &Profile) -> Cam {
    let steepest = profile.least(|sample| -sample.pressure.abs());
    let largest = |of: fn(f64) -> f64| {
        let at = profile.least(|sample| -of(sample.curvature));
        (of(at.curvature) > 0.0).then(|| ValueAt { input: at.angle, value: 1.0 / at.curvature.abs() })
    };
    let tightest = profile.least(|sample| -sample.pitch);
    let worst = profile.least(|sample| sample.excess);
    let undercut = worst.excess <= 0.0;
    let reach = |sign: f64| {
        let at = profile.least(|sample| sign * sample.reach);
        ValueAt { input: at.angle, value: at.reach }
    };
    Cam {
        name: profile.name.clone(),
        follower: match profile.roller {
            None => "flat face",
            Some(radius) if radius > 0.0 => "roller",
            Some(_) => "knife edge",
        },
        turning: profile.turning,
        base: profile.base,
        phases: profile.phases(),
        pressure_angle: ValueAt { input: steepest.angle, value: steepest.pressure },
        // An undercut profile has points and loops instead.
        convex_radius: largest(|curvature| curvature).filter(|_| !undercut),
        pitch_radius: profile
            .roller
            .filter(|radius| *radius > 0.0 && tightest.pitch > 0.0)
            .map(|_| ValueAt { input: tightest.angle, value: 1.0 / tightest.pitch }),
        hollow_radius: largest(|curvature| -curvature).filter(|_| !undercut),
        undercut,
        least_base: if undercut { profile.least_base() } else { None },
        face: profile.roller.is_none().then(|| [reach(1.0), reach(-1.0)]),
    }
}
