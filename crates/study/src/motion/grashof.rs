//! Which kind of four-bar a mechanism is, if it is one (Grashof; Norton, *Design of Machinery*).

use cotree::model::{JointId, Mechanism, Part, Place, Unit, Units};
use cotree::scene::constant::evaluate;
use cotree::typeset::rounded;

/// Lengths that differ by less than this share are equal.
const EQUAL: f64 = 1e-9;

/// The class of a four-bar with its input, with its lengths in these units; none if the mechanism is another.
pub fn class(mechanism: &Mechanism, input: JointId, units: &Units) -> Option<String> {
    let is_pin = |joint: &&Part| joint.component().name == PIN;
    if mechanism.bodies.len() != 3 || mechanism.joints.len() != 4 || !mechanism.joints.iter().all(|j| is_pin(&j)) {
        return None;
    }
    let crank = mechanism.joints[input.0].bodies().into_iter().flatten().next()?;
    // Ground, crank, coupler, rocker: a ring in which each has two pins.
    let link = |body| -> Option<f64> {
        let ends: Vec<Place> =
            mechanism.joints.iter().flat_map(|joint| joint.between).filter(|place| place.body() == body).collect();
        let [a, b] = ends[..] else { return None };
        let [a, b] = [at(mechanism, a), at(mechanism, b)];
        Some((a[0] - b[0]).hypot(a[1] - b[1]))
    };
    let joined = |a, b| mechanism.joints.iter().any(|joint| joint.bodies() == [a, b] || joint.bodies() == [b, a]);
    let bodies = (0..3).map(cotree::model::BodyId).filter(|body| *body != crank);
    let (rocker, coupler): (Vec<_>, Vec<_>) = bodies.partition(|body| joined(Some(*body), None));
    let ([rocker], [coupler]) = (&rocker[..], &coupler[..]) else { return None };
    let lengths = [link(None)?, link(Some(crank))?, link(Some(*coupler))?, link(Some(*rocker))?];
    Some(named(lengths, units))
}

/// The component of a pin joint.
const PIN: &str = "revolute";

fn at(mechanism: &Mechanism, place: Place) -> [f64; 2] {
    let parameters = mechanism.parameter_values();
    let value = |point: &cotree::model::Point| point.at.each_ref().map(|component| evaluate(component, &parameters));
    match place {
        Place::Origin | Place::Centre(_) => [0.0, 0.0],
        Place::Ground(point) => value(&mechanism.ground[point]),
        Place::Point(body, point) => value(&mechanism.bodies[body.0].points[point]),
    }
}

/// Ground, input, coupler, output.
fn named(lengths: [f64; 4], units: &Units) -> String {
    let mut sorted = lengths;
    sorted.sort_by(f64::total_cmp);
    let [s, p, q, l] = sorted;
    let excess = (s + l) - (p + q);
    let [ground, input, coupler, _] = lengths;
    let unit = units.of(&Unit::length());
    let [a, b, c, d] = lengths.map(|length| rounded(length / unit.factor, 6));
    let sizes = format!("ground {a}, input {b}, coupler {c}, output {d} {}", unit.name);
    let class = match s {
        _ if excess.abs() <= EQUAL * l => "change point: shortest + longest = the other two",
        _ if excess > 0.0 => "triple rocker (not Grashof: shortest + longest > the other two)",
        s if s == ground => "double crank (Grashof, the ground is the shortest)",
        s if s == coupler => "double rocker (Grashof, the coupler is the shortest)",
        s if s == input => "crank-rocker (Grashof, the input is the shortest)",
        _ => "rocker-crank (Grashof, the output is the shortest)",
    };
    format!("{class}; {sizes}")
}

#[cfg(test)]
mod tests {
    use super::named;
    use cotree::model::Units;

    #[test]
    fn classes_are_those_of_grashof() {
        for (lengths, class) in [
            ([0.1, 0.04, 0.12, 0.08], "crank-rocker"),
            ([0.04, 0.1, 0.12, 0.08], "double crank"),
            ([0.1, 0.12, 0.04, 0.08], "double rocker"),
            ([0.3, 0.1, 0.3, 0.1], "change point"),
            ([0.1, 0.08, 0.06, 0.05], "triple rocker"),
        ] {
            let text = named(lengths, &Units::default());
            assert!(text.starts_with(class), "{lengths:?}: {text}");
        }
    }
}
