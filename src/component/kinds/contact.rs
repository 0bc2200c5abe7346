//! Contact (k): a point, or a disc about it, on the left of a line of the first body: n.r >= radius, with n = k x u across the line. It presses and never pulls:
//! fn >= 0, and fn = 0 while it is open. Impacts follow Newton's law: it leaves with the share `restitution` of the speed with which it came.

use crate::component::frame::Placed;
use crate::component::key::{AXIS, BETWEEN_POINTS, Form, Key};
use crate::component::{Component, Icon, Rubs};
use crate::expr::Expr;
use crate::model::measure::{FORCE, LENGTH, NUMBER, VELOCITY};
use crate::model::{OneSided, Part, Pressed, Quantity as Q, Range};
use crate::network::{Direction, Port, Rows, System, Term};
use crate::scene::{Joint, Vector};

/// Where the point can be, seen along the line; the first by default.
const SIDES: [&str; 2] = ["left", "right"];

pub(crate) const CONTACT: Component = Component {
    about: "a point, or a disc about it, that stays on one side of a line of the first body",
    equations: "n.r >= radius, fn >= 0",
    keys: &[
        BETWEEN_POINTS,
        AXIS,
        Key::optional(
            "radius",
            Form::Constant(LENGTH, Range::NotNegative),
            "the radius of a disc about the second point",
        ),
        Key::optional("friction", Form::Friction([FORCE, VELOCITY], Pressed::Contact), "dry friction along the line"),
        Key::optional(
            "restitution",
            Form::Constant(NUMBER, Range::Share),
            "the share of the speed with which it rebounds",
        ),
        Key::optional(
            "side",
            Form::Choice(&SIDES, "a point stays on the `left` or the `right` of its line"),
            "on which side of the line the point stays, seen along the axis",
        ),
    ],
    variables: &[Q::Gap, Q::S, Q::V, Q::A, Q::Fn, Q::Ft, Q::Impulse, Q::Mode, Q::Sliding],
    reactions: &[],
    undriven: ["a contact", "a driver moves a joint that guides"],
    one_sided,
    across,
    rubs: Rubs::joint(Pressed::Contact, slip),
    ..Component::joint("contact", rows, placed, |part| Icon::Rolling {
        axis: part.vector("axis"),
        radius: part.formula("radius").clone(),
    })
};

/// In a mirror the point is on the other side of its line.
fn placed(placed: &mut Placed<'_>) {
    placed.axis("axis", placed.part.between[0]);
    placed.side("side", SIDES);
}

fn rows(_: &Part, _: &mut System) -> Rows {
    Rows { letter: "k", ..Rows::default() }
}

fn one_sided(part: &Part) -> Vec<OneSided> {
    let (bound, restitution) = (part.key("radius"), part.key("restitution"));
    vec![OneSided { word: "", sign: 1.0, bound, restitution }]
}

/// n.r
fn across(part: &Part, system: &mut System) -> Vec<Term> {
    let [ux, uy] = system.values(&part.vector("axis"));
    let normal = match part.choice("side") == Some(SIDES[1]) {
        true => [uy, system.arena.negate(ux)],
        false => [system.arena.negate(uy), ux],
    };
    let ends = part.between.map(|place| system.t_node(place));
    vec![Term { factor: Expr::ONE, port: Port::Along(ends, Direction::Fixed(part.between[0].body(), normal)) }]
}

/// s + radius theta: where the disc touches, as [`super::rolling`] has it. On the right of the line radius theta has the other sign.
fn slip(part: &Part, system: &mut System) -> Vec<Term> {
    let along = Direction::Fixed(part.between[0].body(), system.values(&part.vector("axis")));
    let slide = Term { factor: Expr::ONE, port: Port::Along(part.between.map(|place| system.t_node(place)), along) };
    let radius = system.value(part.formula("radius"));
    if radius == Expr::ZERO {
        return vec![slide];
    }
    let factor = if part.choice("side") == Some(SIDES[1]) { system.arena.negate(radius) } else { radius };
    vec![slide, Term { factor, port: Port::Angle(part.bodies().map(|body| system.r_node(body))) }]
}

impl Joint {
    /// A point, the second, that stays on the left of a line through the first point.
    pub fn contact(first: &str, second: &str, axis: impl Into<Vector>) -> Joint {
        Joint::new("contact", first, second).set("axis", axis.into())
    }
}
