//! External torque (T): body -> body; T = T(theta, omega, t).

use crate::component::frame::Placed;
use crate::component::key::{Form, Key};
use crate::component::{Component, Icon, Room, torsion};
use crate::model::measure::TORQUE;
use crate::model::{BodyId, Formula, KeyValue, Part, Place, Quantity as Q};
use crate::scene::{Load, Quantity};

pub(crate) const APPLIED_TORQUE: Component = Component {
    about: "a torque on the second body, its opposite on the first",
    equations: "T = value",
    keys: &[
        Key::one_of("on", Form::Body, "`on = \"BODY\"` turns a body"),
        Key::one_of("between", Form::Bodies, "`between = [\"BODY\", \"BODY\"]` turns the second against the first"),
        Key::required("value", Form::Law(TORQUE), "the torque", "give the torque [N.m]: `value = \"2 N.m\"`"),
    ],
    variables: &[Q::Torque],
    pose: &[Q::Torque],
    room: Room::Turning,
    law: |part| Some(part.key("value")),
    ..Component::load("torque", torsion::rows, placed, |_| Icon::Turn)
};

fn placed(placed: &mut Placed<'_>) {
    placed.sign("value");
}

impl Load {
    /// A torque on the second body, its opposite on the first.
    pub fn torque(first: &str, second: &str, value: impl Into<Quantity>) -> Load {
        Load::new("torque").set("between", [first, second]).set("value", value.into())
    }
}

impl Part {
    /// A torque on a body, against the ground; [`crate::model::Mechanism::loaded`] puts it in.
    pub fn applied_torque(name: &str, body: BodyId, value: Formula) -> Part {
        APPLIED_TORQUE.part(name, [Place::Origin, Place::Centre(body)], vec![("value", KeyValue::Formula(value))])
    }
}
