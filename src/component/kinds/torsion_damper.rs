//! Rotational damper (T): a torque against the rate of the angle between two bodies.

use std::f64::consts::PI;

use crate::component::frame::anywhere;
use crate::component::key::{BETWEEN_BODIES, Form, Key};
use crate::component::{Component, Icon, IconStroke, Room, torsion};
use crate::model::measure::TORSION_DAMPING;
use crate::model::{Quantity as Q, Range};
use crate::scene::{Load, Quantity};

pub(crate) const TORSION_DAMPER: Component = Component {
    about: "a damper that resists turning",
    equations: "T = -damping theta'",
    keys: &[
        BETWEEN_BODIES,
        Key::required(
            "damping",
            Form::Constant(TORSION_DAMPING, Range::Any),
            "the damping coefficient",
            "give the damping coefficient [N.m.s]: `damping = 0.5`",
        ),
    ],
    variables: &[Q::Angle, Q::Omega, Q::Torque],
    pose: &[Q::Angle, Q::Torque],
    room: Room::Turning,
    law: |part| Some(-(part.key("damping") * part.variable(Q::Omega))),
    ..Component::load("torsion_damper", torsion::rows, anywhere, |_| Icon::Round(dashpot))
};

/// A piston in an open cylinder, bent around the joint.
fn dashpot() -> Vec<IconStroke> {
    let (closed, open, piston, end) = (1.1 * PI, 1.75 * PI, 1.5 * PI, 2.15 * PI);
    let radial = |radii: [f64; 2], angle: f64| IconStroke::arc(radii, [angle, angle]);
    vec![
        IconStroke::arc([4.4, 4.4], [closed, open]),
        IconStroke::arc([2.2, 2.2], [closed, open]),
        radial([2.2, 4.4], closed),
        IconStroke::arc([3.3, 3.3], [0.85 * PI, closed]),
        radial([2.5, 4.1], piston),
        IconStroke::arc([3.3, 3.3], [piston, end]),
    ]
}

impl Load {
    /// A damper that resists turning.
    pub fn torsion_damper(first: &str, second: &str, damping: impl Into<Quantity>) -> Load {
        Load::new("torsion_damper").set("between", [first, second]).set("damping", damping.into())
    }
}
