//! Pin in slot (p): a slide, r = s u, that leaves the angle free, T = 0. A prismatic joint in the translational graph, a revolute
//! one in the rotational.

use crate::component::frame::Placed;
use crate::component::key::{AT, AXIS, BETWEEN_POINTS, ENGAGED};
use crate::component::{Component, Icon, Rubs, limits, slide};
use crate::model::{Captured, Part, Pressed, Quantity as Q};
use crate::network::{RotationalRow, Rows, System};
use crate::scene::{Joint, Vector};

pub(crate) const SLOT: Component = Component {
    about: "a pin that slides along a line of the first body and turns freely",
    equations: "r = s u, F u = -damping v - friction - armature a, T = 0",
    keys: &[BETWEEN_POINTS, AXIS, slide::DAMPING, slide::FRICTION, slide::ARMATURE, limits::OF_SLIDE, ENGAGED, AT],
    variables: &[
        Q::S,
        Q::V,
        Q::A,
        Q::Angle,
        Q::Omega,
        Q::Alpha,
        Q::Fn,
        Q::Force,
        Q::StopForce,
        Q::Impulse,
        Q::Mode,
        Q::Sliding,
    ],
    reactions: &[Q::Fn],
    captures: &[Captured::Normal],
    engaging: &[Q::Engaged, Q::Impulse, Q::LostEnergy],
    pose: &[Q::S, Q::Angle],
    undriven: ["a slot", "give `displacement = ...` or `angle = ...`"],
    drivers: &["angle", "displacement"],
    gaps: limits::gaps,
    relation: limits::slide,
    rubs: Rubs::joint(Pressed::Guide { holds_angle: false }, limits::slide),
    ..Component::joint("slot", rows, placed, |part| Icon::Slot(part.vector("axis")))
};

fn placed(placed: &mut Placed<'_>) {
    placed.axis("axis", placed.part.between[0]);
}

fn rows(part: &Part, system: &mut System) -> Rows {
    let translation = Some(slide::row(system, part));
    Rows { letter: "p", translation, rotation: Some(RotationalRow::free(system, part)), ..Rows::default() }
}

impl Joint {
    /// A pin, the second point, in a slot along an axis in the first body's frame.
    pub fn slot(first: &str, second: &str, axis: impl Into<Vector>) -> Joint {
        Joint::new("slot", first, second).set("axis", axis.into())
    }
}
