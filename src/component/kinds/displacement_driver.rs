//! Displacement driver (R): prescribes s(t) of a joint that slides. It lies beside the joint, holds the direction of the axis, and
//! as a branch makes the whole displacement r = s(t) u known (the joint's own loop equation is then empty).

use crate::component::frame::anywhere;
use crate::component::key::{Form, Key};
use crate::component::{Component, Icon};
use crate::expr::Expr;
use crate::model::Motion::Given;
use crate::model::measure::{ACCELERATION, LENGTH, VELOCITY};
use crate::model::{Formula, JointId, KeyValue, Part, Quantity as Q};
use crate::network::{Direction, Force, Known, Rows, System, TranslationalRow, table2};
use crate::scene::{Driver, Motion};

pub(crate) const DISPLACEMENT_DRIVER: Component = Component {
    about: "slides a prismatic joint",
    equations: "r = s(t) u",
    keys: &[
        Key::one_of("joint", Form::Joint, "`joint = \"JOINT\"` slides along this joint"),
        Key::required(
            "displacement",
            Form::Motion([LENGTH, VELOCITY, ACCELERATION]),
            "the motion",
            "give the motion: `displacement = \"0.1*sin(2*t)\"`",
        ),
    ],
    variables: &[Q::Force],
    reactions: &[Q::Force],
    ..Component::driver("displacement", rows, anywhere, |_| Icon::Push)
};

fn rows(part: &Part, system: &mut System) -> Rows {
    let signal = system.signal(part);
    let joint = part.joint().map(|joint| &system.mechanism.joints[joint.0]);
    let axis = joint.map(|joint| joint.vector("axis"));
    let axis = axis.map_or([Expr::ZERO; 2], |axis| system.values(&axis));
    let first = part.between[0].body();
    let row = TranslationalRow {
        ends: part.between.map(|place| system.t_node(place)),
        priority: table2::POSITION_DRIVER,
        known: Known::Along(first, axis, signal),
        motion: Vec::new(),
        reaction: vec![Direction::Fixed(first, axis)],
        through: Force::None,
        armature: Expr::ZERO,
    };
    Rows { letter: "R", translation: Some(row), ..Rows::default() }
}

impl Driver {
    /// The displacement of a prismatic joint.
    pub fn displacement(joint: &str, motion: impl Into<Motion>) -> Driver {
        Driver::new().set("joint", joint).set("displacement", motion.into())
    }
}

impl Part {
    /// A driver that slides a joint; [`crate::model::Mechanism::driven`] puts it in.
    pub fn displacement_driver(name: &str, (id, joint): (JointId, &Part), motion: Formula) -> Part {
        let values = vec![("joint", KeyValue::Joint(id)), ("displacement", KeyValue::Motion(Given(motion)))];
        DISPLACEMENT_DRIVER.part(name, joint.between, values)
    }
}
