//! The course of a rope or band over pulleys, as across variables: its straight parts, and the drums on which it ends.

use super::{CircleTangent, Coupling, CouplingTerm, Port, RNode, System, TNode};
use crate::expr::Expr;
use crate::model::{CourseValue, Part, Station};

/// The straight parts of a course: between which points, and on which tangents of the circles there.
pub(crate) fn spans(part: &Part, stations: &[Station], system: &mut System) -> Vec<([TNode; 2], CircleTangent)> {
    let pairs = stations.windows(2).enumerate();
    let of = |(number, pair): (usize, &[Station])| {
        let ends = [&pair[0], &pair[1]].map(|station| system.t_node(station.at));
        let [first, second] = [&pair[0], &pair[1]].map(|station| system.value(&station.radius));
        let difference = system.arena.subtract(second, first);
        let reference = system.course_value(part.owner, CourseValue::Turn(number)).unwrap_or(Expr::ZERO);
        (ends, CircleTangent { difference, reference })
    };
    pairs.map(of).collect()
}

/// The drums of a course that turn, each with its angle against the ground and the sign of what that adds to the length.
pub(crate) fn drums<'s>(stations: &'s [Station], system: &System) -> Vec<(&'s Station, [RNode; 2], f64)> {
    let ends = [(stations.first(), -1.0), (stations.last(), 1.0)];
    let drums = ends.into_iter().filter_map(|(station, sign)| Some((station?, sign)));
    let turning = drums.filter(|(station, _)| station.is_drum && station.at.body().is_some());
    let angle = |station: &Station| [system.r_node(None), system.r_node(station.at.body())];
    turning.map(|(station, sign)| (station, angle(station), sign)).collect()
}

/// The length of what runs over pulleys: with the radii R of neighbours and the direction phi of the straight part between them each is L - (R_2 - R_1) phi, so that all together have the
/// arcs R (phi_out - phi_in). What is on drums at the start does not count.
pub(crate) fn length(part: &Part, system: &mut System) -> Option<Coupling> {
    let terms = terms(part, &part.stations()?, system, |_| 1.0);
    let wound = system.course_value(part.owner, CourseValue::Wound);
    Some(Coupling { terms, offset: wound.unwrap_or(Expr::ZERO) })
}

/// Half of the length behind a pulley less half of that before it, against the body of the pulley.
pub(crate) fn slip(part: &Part, number: usize, system: &mut System) -> Option<Coupling> {
    let stations = part.stations()?;
    let pulley = stations.get(number + 1)?;
    let mut terms = terms(part, &stations, system, |span| if span <= number { -0.5 } else { 0.5 });
    if pulley.at.body().is_some() {
        let radius = system.value(&pulley.radius);
        let port = Port::Angle([system.r_node(None), system.r_node(pulley.at.body())]);
        terms.push(CouplingTerm { factor: system.arena.negate(radius), port });
    }
    Some(Coupling { terms, offset: Expr::ZERO })
}

/// The straight parts and drums, each times its factor: that of a drum is its neighbour's.
fn terms(part: &Part, stations: &[Station], system: &mut System, factor: impl Fn(usize) -> f64) -> Vec<CouplingTerm> {
    let mut terms = Vec::new();
    for (number, (ends, tangent)) in spans(part, stations, system).into_iter().enumerate() {
        terms.push(CouplingTerm { factor: system.arena.constant(factor(number)), port: Port::Span(ends, tangent) });
    }
    let last = stations.len().saturating_sub(2);
    for (station, angle, sign) in drums(stations, system) {
        let neighbour = factor(if sign < 0.0 { 0 } else { last });
        let (radius, sign) = (system.value(&station.radius), system.arena.constant(sign * neighbour));
        terms.push(CouplingTerm { factor: system.arena.multiply(sign, radius), port: Port::Angle(angle) });
    }
    terms
}
