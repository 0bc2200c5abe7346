//! Torsion spring and damper (T) between two bodies.

use std::f64::consts::PI;

use super::spring::{self, SIDE};
use crate::component::frame::Placed;
use crate::component::key::{BETWEEN_BODIES, Form, Key};
use crate::component::{Component, Icon, IconStroke, Room, torsion};
use crate::model::measure::{ANGLE, CUBIC_TORSION_STIFFNESS, TORSION_DAMPING, TORSION_STIFFNESS};
use crate::model::{Quantity as Q, Range};
use crate::scene::{Load, Quantity};

pub(crate) const TORSION_SPRING: Component = Component {
    about: "a spring and damper that resists turning",
    equations: "T = -stiffness x - cubic x^3 - damping x', x = theta - angle",
    keys: &[
        BETWEEN_BODIES,
        Key::required(
            "stiffness",
            Form::Constant(TORSION_STIFFNESS, Range::Any),
            "the stiffness",
            "give the stiffness [N.m/rad]: `stiffness = 4`; 0 makes it a damper",
        ),
        Key::optional("angle", Form::Constant(ANGLE, Range::Any), "the free angle"),
        Key::optional("damping", Form::Constant(TORSION_DAMPING, Range::Any), "the damping coefficient"),
        Key::optional("cubic", Form::Constant(CUBIC_TORSION_STIFFNESS, Range::Any), "the cubic stiffness"),
        SIDE,
    ],
    variables: &[Q::Angle, Q::Omega, Q::Torque],
    pose: &[Q::Angle, Q::Torque],
    room: Room::Turning,
    law: |part| Some(spring::law(part, "angle", [Q::Angle, Q::Omega])),
    energy: |part| Some(spring::energy(part, "angle", Q::Angle)),
    ..Component::load("torsion_spring", torsion::rows, placed, |_| Icon::Round(coil))
};

fn placed(placed: &mut Placed<'_>) {
    placed.angle("angle");
    placed.exchange("side", ["above", "below"]);
}

/// A spiral around the joint.
fn coil() -> Vec<IconStroke> {
    vec![IconStroke::arc([1.4, 4.0], [0.0, 5.0 * PI])]
}

impl Load {
    /// A spring that resists turning.
    pub fn torsion_spring(first: &str, second: &str, stiffness: impl Into<Quantity>) -> Load {
        Load::new("torsion_spring").set("between", [first, second]).set("stiffness", stiffness.into())
    }
}
