//! Linear damper (F, on a line d as in the paper's Fig. 5): a force against the rate of the distance between two points.

use crate::component::course::{ENDS, OVER, placed};
use crate::component::key::{Form, Key};
use crate::component::{Component, Icon, IconStroke, line};
use crate::model::measure::DAMPING;
use crate::model::{Quantity as Q, Range};
use crate::scene::{Load, Quantity};

pub(crate) const DAMPER: Component = Component {
    about: "a damper along the line between two points",
    equations: "F = -damping |r|'",
    keys: &[
        ENDS,
        Key::required(
            "damping",
            Form::Constant(DAMPING, Range::Any),
            "the damping coefficient",
            "give the damping coefficient [N.s/m]: `damping = 20`",
        ),
        OVER,
    ],
    variables: &[Q::Length, Q::Rate, Q::Force],
    pose: &[Q::Length, Q::Force],
    pulls: true,
    law: |part| Some(-(part.key("damping") * part.variable(Q::Rate))),
    ..Component::load("damper", |part, system| line::rows(system, part, "d"), placed, |_| Icon::Line(dashpot))
};

/// A piston in an open cylinder.
fn dashpot(length: f64) -> Vec<IconStroke> {
    let half = (0.2 * length).min(3.5);
    let (low, high, piston) = (0.5 * length - half, 0.5 * length + half, 0.5 * length + 0.2 * half);
    vec![
        IconStroke::open(vec![[0.0, 0.0], [low, 0.0]]),
        IconStroke::open(vec![[high, 1.6], [low, 1.6], [low, -1.6], [high, -1.6]]),
        IconStroke::open(vec![[piston, 1.2], [piston, -1.2]]),
        IconStroke::open(vec![[piston, 0.0], [length, 0.0]]),
    ]
}

impl Load {
    /// A damper between two points.
    pub fn damper(first: &str, second: &str, damping: impl Into<Quantity>) -> Load {
        Load::new("damper").set("between", [first, second]).set("damping", damping.into())
    }
}
