//! What is wrong with a cam: joints that are not those of a cam, a law that does not close, a follower that misses, undercut.

use std::f64::consts::TAU;

use super::breaks::{Break, breaks};
use crate::component::Profile;
use crate::diagnostic::Fault;
use crate::model::{Mechanism, Part, Unit};
use crate::typeset::without_zeros;

const SMOOTH: &str = "let it rise over an angle: `lift*cycloidal((angle - from)/rise)`, `poly345`";

pub(super) fn check(part: &Part, mechanism: &Mechanism) -> Vec<Fault> {
    let called = format!("joint `{}`", part.name);
    if part.value("face").is_some() && part.value("roller").is_some() {
        let message = format!("{called} has both `roller` and `face`");
        let fault = Fault::new("scene::cam_contact", message, part.span).label("only one of them can touch");
        return vec![
            fault.help("keep `roller` for a round follower, or `face` for a flat one; a knife edge has neither"),
        ];
    }
    if part.limits().is_some() && part.choice("closure") == Some("form") {
        let message =
            format!("{called} is `unilateral`, but `closure = \"form\"` guides its follower in both directions");
        let fault = Fault::new("scene::cam_contact", message, part.span).label("cannot lift off");
        return vec![fault.help("leave out one of the two")];
    }
    let profile = match Profile::of(part, mechanism, &mechanism.parameter_values()) {
        Ok(profile) => profile,
        Err((key, why, help)) => {
            let message = format!("`{key}` of {called} {why}");
            return vec![Fault::new("scene::cam_joint", message, part.span).label("not mounted as a cam").help(help)];
        }
    };
    let breaks = breaks(&profile);
    let fault = open(&profile, part, mechanism).or_else(|| jump(&breaks, &profile, part, mechanism));
    let fault = fault.or_else(|| out_of_reach(&profile, part, mechanism));
    let fault = fault.or_else(|| undercut(&profile, part, mechanism));
    fault.into_iter().chain(corner(&breaks, part, mechanism)).chain(needless_side(&profile, part)).collect()
}

/// A follower that slides has no side.
fn needless_side(profile: &Profile, part: &Part) -> Option<Fault> {
    let is_needless = !profile.turning && part.choice("side").is_some();
    let message = format!("`side` of joint `{}` has no effect on a follower that slides", part.name);
    is_needless.then(|| Fault::warning("scene::unused", message, part.span).label("not used").help("remove it"))
}

/// A length or an angle in the scene's units.
fn shown(mechanism: &Mechanism, value: f64, unit: Unit) -> String {
    let unit = mechanism.units.of(&unit);
    let number = format!("{:.6}", value / unit.factor);
    format!("{} {}", without_zeros(&number), unit.name)
}

/// After a turn the follower must be where it was, and as fast.
fn open(profile: &Profile, part: &Part, mechanism: &Mechanism) -> Option<Fault> {
    let [first, last] = [0.0, TAU].map(|angle| profile.sample(angle).law);
    let scale = profile.turn().map(|sample| sample.law[0].abs()).fold(1e-9, f64::max);
    let apart = |order: usize| (last[order] - first[order]).abs() > 1e-6 * scale;
    let unit = || if profile.turning { Unit::angle() } else { Unit::length() };
    let what = if apart(0) {
        let [from, to] = [first, last].map(|law| shown(mechanism, law[0], unit()));
        format!("is {from} at the start of a turn but {to} at its end")
    } else if apart(1) {
        "has different slopes at the start and the end of a turn".to_string()
    } else {
        return None;
    };
    let message = format!("`law` of joint `{}` {what}", part.name);
    let help = "let it return to its start: `lift*(cycloidal(angle/rise) - cycloidal((angle - back)/rise))`, `periodic_spline`, or functions of sin(angle) and cos(angle)";
    Some(Fault::new("scene::cam_law", message, part.span).label("does not close").help(help))
}

/// A follower cannot jump.
fn jump(breaks: &[Break], profile: &Profile, part: &Part, mechanism: &Mechanism) -> Option<Fault> {
    let first = breaks.iter().find(|kink| kink.is_jump)?;
    let unit = || if profile.turning { Unit::angle() } else { Unit::length() };
    let [from, to] = first.sides.map(|side| shown(mechanism, side[0], unit()));
    let at = shown(mechanism, first.angle, Unit::angle());
    let message = format!("`law` of joint `{}` is discontinuous at {at}: it jumps from {from} to {to}", part.name);
    Some(Fault::new("scene::cam_law", message, part.span).label("jumps").help(format!("{SMOOTH}, or a spline")))
}

/// A follower whose speed jumps can be computed, but no profile with a radius of curvature moves it so.
fn corner(breaks: &[Break], part: &Part, mechanism: &Mechanism) -> Option<Fault> {
    let mut corners = breaks.iter().filter(|kink| !kink.is_jump);
    let first = corners.next()?;
    let at = shown(mechanism, first.angle, Unit::angle());
    let more = match corners.count() {
        0 => String::new(),
        more => format!(", as at {more} more"),
    };
    let [from, to] = first.sides.map(|side| without_zeros(&format!("{:.6}", side[1])).to_owned());
    let message = format!(
        "`law` of joint `{}` has a corner at {at}{more}: its slope is discontinuous, from {from} to {to} (SI, per radian)",
        part.name
    );
    let help = format!(
        "{SMOOTH}, or a spline; at a corner the follower is hit, and radii of curvature and undercut leave it out"
    );
    Some(Fault::warning("scene::cam_law", message, part.span).label("not smooth").help(help))
}

/// The follower must meet its base circle, and its normal force must move it everywhere.
fn out_of_reach(profile: &Profile, part: &Part, mechanism: &Mechanism) -> Option<Fault> {
    let missed = profile.missed()?;
    let at = shown(mechanism, missed.angle, Unit::angle());
    let message = format!("the follower of joint `{}` cannot touch its cam at {at}", part.name);
    let help = "change `base`, the follower's point, the direction of `face` or the rise, so that the base circle with the roller touches the follower and the contact can push it";
    Some(Fault::new("scene::cam_contact", message, part.span).label("misses the cam").help(help))
}

fn undercut(profile: &Profile, part: &Part, mechanism: &Mechanism) -> Option<Fault> {
    let worst = profile.least(|sample| sample.excess);
    if worst.excess > 0.0 {
        return None;
    }
    let length = |value: f64| shown(mechanism, value, Unit::length());
    let (radius, needed) = match profile.roller {
        Some(roller) => (1.0 / worst.pitch, format!("more than the roller's {}", length(roller))),
        None => (worst.excess, "above zero".to_string()),
    };
    let curve = if profile.roller.is_some() { "pitch curve" } else { "profile" };
    let message = format!(
        "the profile of joint `{}` is undercut: at {} the radius of curvature of the {curve} is {}, but must be {needed}",
        part.name,
        shown(mechanism, worst.angle, Unit::angle()),
        length(radius),
    );
    let mut ways =
        vec![format!("make `base` larger than {} (`cotree motion` computes how large)", length(profile.base))];
    ways.extend(profile.roller.map(|_| "take a smaller roller".to_string()));
    ways.push("let the follower rise over a larger angle".to_string());
    let help = format!("{}; such a cam cannot be made, though its motion is that of the law", ways.join(", or "));
    Some(Fault::warning("scene::cam_undercut", message, part.span).label("undercut").help(help))
}
