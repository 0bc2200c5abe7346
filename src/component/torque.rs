//! External torque (T): body -> body; T = T(theta, omega, t).

use super::key::{Form, Key};
use super::{Component, Facts, Icon, Room, Rows, System, torsion};
use crate::mechanism::measure::TORQUE;
use crate::mechanism::{Part, Quantity as Q};
use crate::scene::{Load, Quantity};

pub(super) struct AppliedTorque;

const FACTS: Facts = Facts {
    about: "a torque on the second body, its opposite on the first",
    equations: "T = value",
    keys: &[
        Key::one_of("on", Form::Body, "`on = \"crank\"` turns a body"),
        Key::one_of("between", Form::Bodies, "`between = [\"rod\", \"crank\"]` turns the second against the first"),
        Key::required("value", Form::Law(TORQUE), "the torque", "give the torque [N.m]: `value = \"tau\"`"),
    ],
    variables: &[Q::Torque],
    room: Room::Turning,
    ..Facts::load("torque")
};

impl Component for AppliedTorque {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn rows(&self, part: &Part, system: &mut System) -> Rows {
        torsion::rows(system, part)
    }

    fn law(&self, _part: &Part) -> Option<String> {
        Some("value".to_string())
    }

    fn icon(&self, _part: &Part) -> Icon {
        Icon::Turn
    }
}

impl Load {
    /// A torque on the second body, its opposite on the first.
    pub fn torque(first: &str, second: &str, value: impl Into<Quantity>) -> Load {
        Load::new("torque").set("between", [first, second]).set("value", value.into())
    }
}
