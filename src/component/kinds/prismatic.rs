//! Prismatic joint (s): a slide, r = s u, that holds the angle.

use crate::component::frame::Placed;
use crate::component::key::{ANGLE_BETWEEN, AT, AXIS, BETWEEN_POINTS, ENGAGED};
use crate::component::{Component, Icon, Room, Rubs, limits, slide};
use crate::model::{Captured, Part, Pressed, Quantity as Q, relative_angle};
use crate::network::{RotationalRow, Rows, System};
use crate::scene::{Joint, Scene, Vector};

pub(crate) const PRISMATIC: Component = Component {
    about: "sliding along an axis without turning",
    equations: "r = s u, theta = angle, F u = -damping v - friction - armature a",
    keys: &[
        BETWEEN_POINTS,
        AXIS,
        ANGLE_BETWEEN,
        slide::DAMPING,
        slide::FRICTION_OF_GUIDE,
        slide::ARMATURE,
        limits::OF_SLIDE,
        ENGAGED,
        AT,
    ],
    variables: &[Q::S, Q::V, Q::A, Q::Fn, Q::Force, Q::Torque, Q::StopForce, Q::Impulse, Q::Mode, Q::Sliding],
    reactions: &[Q::Fn, Q::Torque],
    captures: &[Captured::Normal, Captured::Key("angle", relative_angle)],
    engaging: &[Q::Engaged, Q::Impulse, Q::ImpulseTorque, Q::LostEnergy],
    pose: &[Q::S],
    room: Room::Needless("remove it: every mass slides along x anyway"),
    undriven: ["prismatic", "give `displacement = ...` instead of `angle`"],
    drivers: &["displacement"],
    gaps: limits::gaps,
    relation: limits::slide,
    rubs: Rubs::joint(Pressed::Guide { holds_angle: true }, limits::slide),
    ..Component::joint("prismatic", rows, placed, |part| Icon::Slider(part.vector("axis")))
};

/// The axis is the first body's, the angle the second's against it.
fn placed(placed: &mut Placed<'_>) {
    placed.axis("axis", placed.part.between[0]);
    placed.angle("angle");
}

fn rows(part: &Part, system: &mut System) -> Rows {
    let translation = slide::row(system, part);
    let angle = system.value(part.formula("angle"));
    let rotation = RotationalRow::held(system, part, angle);
    Rows { letter: "s", translation: Some(translation), rotation: Some(rotation), ..Rows::default() }
}

impl Joint {
    /// Sliding along an axis in the first body's frame.
    pub fn prismatic(first: &str, second: &str, axis: impl Into<Vector>) -> Joint {
        Joint::new("prismatic", first, second).set("axis", axis.into())
    }
}

impl Scene {
    /// Adds a prismatic joint between two points along an axis in the first body's frame.
    #[must_use]
    pub fn prismatic(self, name: &str, first: &str, second: &str, axis: impl Into<Vector>) -> Scene {
        self.joint(name, Joint::prismatic(first, second, axis))
    }
}
