//! Rotation driver (Theta): theta = theta(t).

use crate::component::frame::Placed;
use crate::component::key::{Form, Key};
use crate::component::{Component, Icon, Room};
use crate::model::Motion::Given;
use crate::model::measure::{ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY};
use crate::model::{Formula, JointId, KeyValue, Part, Quantity as Q};
use crate::network::{Angle, RotationalRow, Rows, System, table3};
use crate::scene::{Driver, Motion};

pub(crate) const ANGLE_DRIVER: Component = Component {
    about: "turns a revolute joint",
    equations: "theta = theta(t)",
    keys: &[
        Key::one_of("joint", Form::Joint, "`joint = \"JOINT\"` turns this joint"),
        Key::one_of(
            "between",
            Form::Bodies,
            "`between = [\"ground\", \"BODY\"]` turns the second body against the first",
        ),
        Key::required(
            "angle",
            Form::Motion([ANGLE, ANGULAR_VELOCITY, ANGULAR_ACCELERATION]),
            "the motion",
            "give the motion: `angle = \"0.4 + 4*pi*t\"`",
        ),
    ],
    variables: &[Q::Torque],
    reactions: &[Q::Torque],
    room: Room::Turning,
    ..Component::driver("angle", rows, placed, |_| Icon::Turn)
};

fn placed(placed: &mut Placed<'_>) {
    placed.motion("angle");
}

fn rows(part: &Part, system: &mut System) -> Rows {
    let angle = Angle::Given(system.signal(part));
    let row = RotationalRow { priority: table3::ROTATION_DRIVER, angle, ..RotationalRow::free(system, part) };
    Rows { letter: "Theta", rotation: Some(row), ..Rows::default() }
}

impl Driver {
    /// The angle of a revolute joint.
    pub fn angle(joint: &str, motion: impl Into<Motion>) -> Driver {
        Driver::new().set("joint", joint).set("angle", motion.into())
    }

    /// The angle of the second body relative to the first.
    pub fn angle_between(first: &str, second: &str, motion: impl Into<Motion>) -> Driver {
        Driver::new().set("between", [first, second]).set("angle", motion.into())
    }
}

impl Part {
    /// A driver that turns a joint; [`crate::model::Mechanism::driven`] puts it in.
    pub fn angle_driver(name: &str, (id, joint): (JointId, &Part), motion: Formula) -> Part {
        let values = vec![("joint", KeyValue::Joint(id)), ("angle", KeyValue::Motion(Given(motion)))];
        ANGLE_DRIVER.part(name, joint.between, values)
    }
}
