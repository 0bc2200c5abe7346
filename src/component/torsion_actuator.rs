//! Torsion actuator (T): a torque law in the angle and rate between two bodies.

use super::key::{BETWEEN_BODIES, Form, Key};
use super::{Component, Facts, Icon, Room, Rows, System, torsion};
use crate::mechanism::measure::TORQUE;
use crate::mechanism::{Part, Quantity as Q};
use crate::scene::{Load, Quantity};

pub(super) struct TorsionActuator;

const FACTS: Facts = Facts {
    about: "a torque law between two bodies",
    equations: "T = torque(angle, omega, ...)",
    keys: &[
        BETWEEN_BODIES,
        Key::required("torque", Form::Law(TORQUE), "the law", "give the law: `torque = \"-c*omega\"`"),
    ],
    variables: &[Q::Angle, Q::Omega, Q::Torque],
    own: &[Q::Angle, Q::Omega],
    pose: &[Q::Angle, Q::Torque],
    room: Room::Turning,
    ..Facts::load("torsion_actuator")
};

impl Component for TorsionActuator {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn rows(&self, part: &Part, system: &mut System) -> Rows {
        torsion::rows(system, part)
    }

    fn law(&self, _part: &Part) -> Option<String> {
        Some("torque".to_string())
    }

    fn icon(&self, _part: &Part) -> Icon {
        Icon::Turn
    }
}

impl Load {
    /// A torque law between two bodies.
    pub fn torsion_actuator(first: &str, second: &str, torque: impl Into<Quantity>) -> Load {
        Load::new("torsion_actuator").set("between", [first, second]).set("torque", torque.into())
    }
}
