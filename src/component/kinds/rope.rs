//! Rope (y): a massless thread between two points, |r| <= length. It pulls and never pushes; slack, its force is zero. Where it becomes taut it takes the ends along, and they come back with the
//! share `restitution` of the speed with which they went apart.

use crate::component::frame::anywhere;
use crate::component::key::{BETWEEN_POINTS, Form, Key};
use crate::component::{Component, Icon, IconStroke};
use crate::model::measure::{LENGTH, NUMBER};
use crate::model::{GapLaw, Mechanism, Part, Quantity as Q, Range};
use crate::network::{Coupling, Port, Rows, System};
use crate::scene::{Joint, Quantity};

pub(crate) const ROPE: Component = Component {
    about: "a massless rope between two points: a unilateral constraint that pulls and never pushes",
    equations: "|r| <= length, force <= 0",
    keys: &[
        BETWEEN_POINTS,
        Key::required(
            "length",
            Form::Constant(LENGTH, Range::Positive),
            "the length of the rope",
            "give the length of the rope: `length = \"0.5 m\"`",
        ),
        Key::optional(
            "restitution",
            Form::Constant(NUMBER, Range::Share),
            "the coefficient of restitution when it becomes taut",
        ),
    ],
    variables: &[Q::Gap, Q::Force, Q::StopForce, Q::Impulse, Q::Mode],
    undriven: ["a rope", "a driver with `position` moves a point"],
    gaps,
    relation,
    ..Component::joint("rope", |_, _| Rows { letter: "y", ..Rows::default() }, anywhere, |_| Icon::Line(thread))
};

/// A thread.
fn thread(length: f64) -> Vec<IconStroke> {
    vec![IconStroke::open(vec![[0.0, 0.0], [length, 0.0]])]
}

fn gaps(part: &Part, _: &Mechanism) -> Vec<GapLaw> {
    vec![GapLaw {
        word: "max",
        sign: -1.0,
        bound: part.key("length"),
        restitution: part.key("restitution"),
        of_rate: false,
    }]
}

/// |r|
fn relation(part: &Part, system: &mut System) -> Option<Coupling> {
    let ends = part.between.map(|place| system.t_node(place));
    Some(Coupling::of(Port::Length(ends)))
}

impl Joint {
    /// A massless thread between two points, no longer than this.
    pub fn rope(first: &str, second: &str, length: impl Into<Quantity>) -> Joint {
        Joint::new("rope", first, second).set("length", length.into())
    }
}
