//! Lock (l): the angle between two bodies, or the displacement of a prismatic joint, is held: a detent, a latch, a holding brake.

use crate::component::frame::Placed;
use crate::component::key::{AT, ENGAGED, Form, Key};
use crate::component::{Component, Icon, IconStroke};
use crate::model::measure::{ANGLE, LENGTH};
use crate::model::{Captured, Mechanism, Part, Quantity as Q, Range, relative_angle};
use crate::network::{Coupling, Direction, Port, Rows, System};
use crate::scene::Joint;

pub(crate) const LOCK: Component = Component {
    about: "a detent, latch or holding brake: one motion is held",
    equations: "theta = angle, or s = displacement",
    keys: &[
        Key::one_of("joint", Form::Joint, "`joint = \"JOINT\"` holds the motion of this joint"),
        Key::one_of(
            "between",
            Form::Bodies,
            "`between = [\"BODY\", \"BODY\"]` holds the angle of the second body against the first",
        ),
        Key::default(
            "angle",
            Form::Constant(ANGLE, Range::Any),
            "the angle that it holds, if it is engaged at the start or in its named pose",
            "0; an event engages it at any angle",
        ),
        Key::default(
            "displacement",
            Form::Constant(LENGTH, Range::Any),
            "the displacement that it holds of a prismatic joint, likewise",
            "0; an event engages it at any displacement",
        ),
        ENGAGED,
        AT,
    ],
    variables: &[Q::Torque, Q::Force],
    reactions: &[Q::Torque, Q::Force],
    captures: &[
        Captured::Key("angle", |part, mechanism| match slide(part, mechanism) {
            None => relative_angle(part, mechanism),
            Some(_) => None,
        }),
        Captured::Key("displacement", |part, mechanism| Some(slide(part, mechanism)?.variable(Q::S))),
    ],
    engaging: &[Q::Engaged, Q::AngularImpulse, Q::Impulse, Q::LostEnergy],
    undriven: ["a lock", "name the joint whose motion it holds"],
    ..Component::joint("lock", rows, placed, |_| Icon::Round(pawl))
};

fn placed(placed: &mut Placed<'_>) {
    placed.angle("angle");
}

/// The prismatic joint that it locks, if it locks one.
fn slide<'m>(part: &Part, mechanism: &'m Mechanism) -> Option<&'m Part> {
    let joint = mechanism.joints.get(part.joint()?.0)?;
    (!joint.is_angular() && joint.component().drivers == ["displacement"]).then_some(joint)
}

fn rows(part: &Part, system: &mut System) -> Rows {
    let mechanism = system.mechanism.clone();
    let (port, offset) = match slide(part, &mechanism) {
        None => (Port::Angle(part.bodies().map(|body| system.r_node(body))), "angle"),
        Some(joint) => {
            let axis = Direction::Fixed(joint.between[0].body(), system.values(&joint.vector("axis")));
            (Port::Along(joint.between.map(|place| system.t_node(place)), axis), "displacement")
        }
    };
    let offset = system.value(part.formula(offset));
    Rows { letter: "l", coupling: Some(Coupling { offset, ..Coupling::of(port) }), ..Rows::default() }
}

/// A pawl on a wheel.
fn pawl() -> Vec<IconStroke> {
    vec![IconStroke::arc([2.2, 2.2], [-0.6, 0.6]), IconStroke::open(vec![[2.2, 0.0], [3.0, 0.0]])]
}

impl Joint {
    /// A lock of the angle between two bodies.
    pub fn lock(first: &str, second: &str) -> Joint {
        Joint::new("lock", first, second)
    }
}
