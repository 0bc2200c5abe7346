//! Limits of what a joint leaves free, or of what its relation may be off by: stops at either end, with a restitution.

use super::key::{Form, Key, Record};
use crate::model::measure::{ANGLE, LENGTH};
use crate::model::{GapLaw, Mechanism, Part};
use crate::network::{Coupling, Direction, Port, System};

pub(super) const OF_ANGLE: Key =
    Key::optional("limits", Form::Record(Record::Limits(ANGLE)), "hard stops at the ends of its motion");
pub(super) const OF_SLIDE: Key =
    Key::optional("limits", Form::Record(Record::Limits(LENGTH)), "hard stops at the ends of its motion");
pub(super) const PLAY_OF_ANGLE: Key = Key::optional(
    "backlash",
    Form::Record(Record::Play(ANGLE)),
    "backlash of the second wheel against the first, with a coefficient of restitution",
);
pub(super) const PLAY_OF_SLIDE: Key = Key::optional(
    "backlash",
    Form::Record(Record::Play(LENGTH)),
    "backlash of the displacement, with a coefficient of restitution",
);

/// What the limits of a joint hold.
pub(super) fn gaps(part: &Part, _: &Mechanism) -> Vec<GapLaw> {
    part.limits().map(|limits| limits.gaps()).unwrap_or_default()
}

/// The relation of a joint that imposes it always; one that has limits may be off as far as those say.
pub(super) fn always(part: &Part, relation: impl FnOnce() -> Option<Coupling>) -> Option<Coupling> {
    if part.limits().is_some() { None } else { relation() }
}

/// The angle of a joint.
pub(super) fn angle(part: &Part, system: &mut System) -> Option<Coupling> {
    Some(Coupling::of(Port::Angle(part.bodies().map(|body| system.r_node(body)))))
}

/// The displacement of a joint along its axis.
pub(super) fn slide(part: &Part, system: &mut System) -> Option<Coupling> {
    let along = Direction::Fixed(part.between[0].body(), system.values(&part.vector("axis")));
    let ends = part.between.map(|place| system.t_node(place));
    Some(Coupling::of(Port::Along(ends, along)))
}
