//! Torsion actuator (T): a torque law in the angle and rate between two bodies.

use crate::component::frame::Placed;
use crate::component::key::{BETWEEN_BODIES, Form, Key};
use crate::component::{Component, Icon, Room, torsion};
use crate::model::Quantity as Q;
use crate::model::measure::TORQUE;
use crate::scene::{Load, Quantity};

pub(crate) const TORSION_ACTUATOR: Component = Component {
    about: "a torque law between two bodies",
    equations: "T = torque(angle, omega, ...)",
    keys: &[
        BETWEEN_BODIES,
        Key::required("torque", Form::Law(TORQUE), "the law", "give the law: `torque = \"-c*omega\"`"),
    ],
    variables: &[Q::Angle, Q::Omega, Q::Torque],
    law_variables: &[Q::Angle, Q::Omega, Q::Alpha],
    pose: &[Q::Angle, Q::Torque],
    room: Room::Turning,
    law: |part| Some(part.key("torque")),
    ..Component::load("torsion_actuator", torsion::rows, placed, |_| Icon::Turn)
};

fn placed(placed: &mut Placed<'_>) {
    placed.sign("torque");
}

impl Load {
    /// A torque law between two bodies.
    pub fn torsion_actuator(first: &str, second: &str, torque: impl Into<Quantity>) -> Load {
        Load::new("torsion_actuator").set("between", [first, second]).set("torque", torque.into())
    }
}
