//! Actuator (F): a force law in the distance between two points and its rate.

use crate::component::course::{ENDS, OVER, placed};
use crate::component::key::{Form, Key};
use crate::component::{Component, Icon, IconStroke, line};
use crate::model::Quantity as Q;
use crate::model::measure::FORCE;
use crate::scene::{Load, Quantity};

pub(crate) const ACTUATOR: Component = Component {
    about: "a force law along the line between two points",
    equations: "F = force(length, rate, ...)",
    keys: &[
        ENDS,
        Key::required(
            "force",
            Form::Law(FORCE),
            "the law; positive pushes the points apart",
            "give the law: `force = \"-k*(length - l0)\"`",
        ),
        OVER,
    ],
    variables: &[Q::Length, Q::Rate, Q::Force],
    law_variables: &[Q::Length, Q::Rate],
    pose: &[Q::Length, Q::Force],
    law: |part| Some(part.key("force")),
    ..Component::load("actuator", |part, system| line::rows(system, part, "F"), placed, |_| Icon::Line(cylinder))
};

/// A cylinder with a piston on a rod.
pub(crate) fn cylinder(length: f64) -> Vec<IconStroke> {
    let (low, high) = (0.2 * length, 0.65 * length);
    let piston = 0.5 * (low + high);
    vec![
        IconStroke::open(vec![[0.0, 0.0], [low, 0.0]]),
        IconStroke { points: vec![[low, -1.5], [high, -1.5], [high, 1.5], [low, 1.5]], closed: true },
        IconStroke::open(vec![[piston, -1.5], [piston, 1.5]]),
        IconStroke::open(vec![[piston, 0.0], [length, 0.0]]),
    ]
}

impl Load {
    /// A force law between two points.
    pub fn actuator(first: &str, second: &str, force: impl Into<Quantity>) -> Load {
        Load::new("actuator").set("between", [first, second]).set("force", force.into())
    }
}
