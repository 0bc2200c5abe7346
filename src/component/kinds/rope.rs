//! Rope (y): a massless thread between two points, |r| <= length. It pulls and never pushes; slack, its force is zero. Where it becomes taut it takes the ends along, and they come back with the
//! share `restitution` of the speed with which they went apart.

use crate::component::course::{ENDS, OVER, placed};
use crate::component::key::{Form, Key};
use crate::component::{Component, Icon, IconStroke, Rubs};
use crate::model::measure::{LENGTH, NUMBER};
use crate::model::{CourseValue, Formula, Friction, GapLaw, Mechanism, Part, Pressed, Quantity as Q, Range};
use crate::network::{Coupling, Port, Rows, System, course};
use crate::scene::{Joint, Quantity};

pub(crate) const ROPE: Component = Component {
    about: "a massless rope between two points: a unilateral constraint that pulls and never pushes",
    equations: "|r| <= length, force <= 0",
    keys: &[
        ENDS,
        OVER,
        Key::required_alone(
            "length",
            Form::Constant(LENGTH, Range::Positive),
            "the length of the rope; a rope over pulleys or onto a drum without it is taut at the start",
            "give the length of the rope: `length = \"0.5 m\"`",
        ),
        Key::optional(
            "restitution",
            Form::Constant(NUMBER, Range::Share),
            "the coefficient of restitution when it becomes taut",
        ),
    ],
    variables: &[Q::Gap, Q::Force, Q::StopForce, Q::Impulse, Q::Mode, Q::Sliding],
    undriven: ["a rope", "a driver with `position` moves a point"],
    gaps,
    relation,
    rubs: Some(Rubs { along: slip, pressed: Pressed::Contact, law: friction }),
    ..Component::joint("rope", |_, _| Rows { letter: "y", ..Rows::default() }, placed, |_| Icon::Line(thread))
};

/// A thread.
fn thread(length: f64) -> Vec<IconStroke> {
    vec![IconStroke::open(vec![[0.0, 0.0], [length, 0.0]])]
}

fn gaps(part: &Part, mechanism: &Mechanism) -> Vec<GapLaw> {
    let at_start = mechanism.course_value(part.owner, CourseValue::Length);
    vec![GapLaw {
        word: "max",
        sign: -1.0,
        bound: at_start.map_or_else(|| part.key("length"), Formula::Discrete),
        restitution: part.key("restitution"),
        of_rate: false,
    }]
}

/// The friction on the pulley that has some.
fn friction(part: &Part) -> Option<Friction> {
    let mu = part.course()?.over.iter().find_map(|pulley| pulley.mu.clone())?;
    Some(Friction { mu, ..Friction::of_level(Formula::Number(0.0), Formula::Number(1.0)) })
}

/// Half of what the rope behind the pulley with friction is longer than before it: its rate is the speed at which the rope slides on the pulley, and its reaction the difference of both tensions.
fn slip(part: &Part, system: &mut System) -> Option<Coupling> {
    let number = part.course()?.over.iter().position(|pulley| pulley.mu.is_some())?;
    course::slip(part, number, system)
}

/// |r|, or the length over the pulleys.
fn relation(part: &Part, system: &mut System) -> Option<Coupling> {
    if let Some(length) = course::length(part, system) {
        return Some(length);
    }
    let ends = part.between.map(|place| system.t_node(place));
    Some(Coupling::of(Port::Length(ends)))
}

impl Joint {
    /// A massless thread between two points, no longer than this.
    pub fn rope(first: &str, second: &str, length: impl Into<Quantity>) -> Joint {
        Joint::new("rope", first, second).set("length", length.into())
    }
}
