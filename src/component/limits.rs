//! Limits of what a joint leaves free: stops at either end, with a restitution.

use super::key::{Form, Key};
use crate::expr::Expr;
use crate::model::measure::{ANGLE, LENGTH};
use crate::model::{OneSided, Part};
use crate::network::{Direction, Port, System, Term};

pub(super) const OF_ANGLE: Key = Key::optional("limits", Form::Limits(ANGLE), "stops at the ends of its motion");
pub(super) const OF_SLIDE: Key = Key::optional("limits", Form::Limits(LENGTH), "stops at the ends of its motion");

/// What the limits of a joint hold.
pub(super) fn one_sided(part: &Part) -> Vec<OneSided> {
    part.limits().map(|limits| limits.one_sided()).unwrap_or_default()
}

/// The angle of a joint.
pub(super) fn angle(part: &Part, system: &mut System) -> Vec<Term> {
    let ends = part.bodies().map(|body| system.r_node(body));
    vec![Term { factor: Expr::ONE, port: Port::Angle(ends) }]
}

/// The displacement of a joint along its axis.
pub(super) fn slide(part: &Part, system: &mut System) -> Vec<Term> {
    let along = Direction::Fixed(part.between[0].body(), system.values(&part.vector("axis")));
    let ends = part.between.map(|place| system.t_node(place));
    vec![Term { factor: Expr::ONE, port: Port::Along(ends, along) }]
}
