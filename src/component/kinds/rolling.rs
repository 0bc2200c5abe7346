//! Disc that rolls on a line without slip (o): r = s u + radius n, from the line's point to the disc's centre, with u along the line
//! and n = k x u fixed in the first body; and s + radius theta = displacement. On the right of the line n and radius theta have the other sign. The normal force is the reaction of the edge,
//! the tangential force that of the coupling: with the torque radius x force it acts at the contact.

use crate::component::frame::{Placed, sum, times};
use crate::component::key::{AXIS, BETWEEN_POINTS, DISPLACEMENT, Form, Key, Record};
use crate::component::{Component, Icon, Rubs};
use crate::expr::Expr;
use crate::model::measure::{FORCE, LENGTH, VELOCITY};
use crate::model::{Part, Pressed, Quantity as Q, Range};
use crate::network::{
    Coupling, CouplingTerm, Direction, Force, Known, Port, RotationalRow, Rows, System, TranslationalRow, table2,
};
use crate::scene::constant::negate;
use crate::scene::{Joint, Quantity, Vector};

/// Where a disc can be, seen along its line; the first by default.
const SIDES: [&str; 2] = ["left", "right"];

pub(crate) const ROLLING: Component = Component {
    about: "a disc about the second point that rolls without slip on one side of a line of the first body",
    equations: "r = s u + radius n, s + radius theta = displacement",
    keys: &[
        BETWEEN_POINTS,
        AXIS,
        Key::required(
            "radius",
            Form::Constant(LENGTH, Range::Positive),
            "the radius of the disc",
            "give the radius of the disc: `radius = \"0.2 m\"`",
        ),
        DISPLACEMENT,
        Key::optional(
            "friction",
            Form::Record(Record::Friction([FORCE, VELOCITY], Pressed::Guide { holds_angle: false })),
            "the Coulomb friction of the contact: with it the disc may slip; if absent, it does not slip",
        ),
        Key::optional(
            "side",
            Form::Choice(&SIDES, "a disc rolls on the `left` or the `right` of its line"),
            "on which side of the line the disc rolls, seen along the axis",
        ),
    ],
    variables: &[Q::S, Q::V, Q::A, Q::Angle, Q::Omega, Q::Alpha, Q::Fn, Q::Ft, Q::Mode, Q::Sliding],
    rubs: Rubs::joint(Pressed::Guide { holds_angle: false }, |part, system| Some(relation(part, system))),
    reactions: &[Q::Fn, Q::Ft],
    pose: &[Q::S, Q::Angle],
    undriven: ["a rolling disc", "give `angle = ...` instead of `displacement`: the disc's angle moves its centre"],
    drivers: &["angle"],
    ..Component::joint("rolling", rows, placed, icon)
};

/// In a mirror the disc is on the other side of its line, where it turns the other way as it rolls.
fn placed(placed: &mut Placed<'_>) {
    placed.axis("axis", placed.part.between[0]);
    placed.side("side", SIDES);
    let radius = placed.part.key("radius");
    let radius = if is_on_the_right(placed.part) { negate(radius) } else { radius };
    let turned = times(radius, placed.turned.clone());
    placed.number("displacement", |_, displacement| sum(displacement, turned));
}

fn rows(part: &Part, system: &mut System) -> Rows {
    let [ux, uy] = system.values(&part.vector("axis"));
    let radius = system.value(part.formula("radius"));
    let normal = match is_on_the_right(part) {
        true => [uy, system.arena.negate(ux)],
        false => [system.arena.negate(uy), ux],
    };
    let height = normal.map(|component| system.arena.multiply(radius, component));
    let first = part.between[0].body();
    let along = Direction::Fixed(first, [ux, uy]);
    let slide = part.between.map(|place| system.t_node(place));
    let turn = RotationalRow::free(system, part);
    let coupling = part.friction().is_none().then(|| relation(part, system));
    Rows {
        letter: "o",
        translation: Some(TranslationalRow {
            ends: slide,
            priority: table2::PRISMATIC,
            known: Known::Fixed(first, height),
            motion: vec![(along, part.owner.motion(Q::SLIDE))],
            reaction: vec![Direction::Fixed(first, normal)],
            through: Force::None,
            armature: Expr::ZERO,
        }),
        rotation: Some(turn),
        coupling,
        ..Rows::default()
    }
}

/// s + radius theta = displacement: what a disc that slides does not hold.
fn relation(part: &Part, system: &mut System) -> Coupling {
    let axis = system.values(&part.vector("axis"));
    let (radius, offset) = (system.value(part.formula("radius")), system.value(part.formula("displacement")));
    let slide = part.between.map(|place| system.t_node(place));
    let turn = part.bodies().map(|body| system.r_node(body));
    let factor = if is_on_the_right(part) { system.arena.negate(radius) } else { radius };
    let terms = vec![
        CouplingTerm { factor: Expr::ONE, port: Port::Along(slide, Direction::Fixed(part.between[0].body(), axis)) },
        CouplingTerm { factor, port: Port::Angle(turn) },
    ];
    Coupling { terms, offset }
}

fn is_on_the_right(part: &Part) -> bool {
    part.choice("side") == Some(SIDES[1])
}

fn icon(part: &Part) -> Icon {
    let axis = part.vector("axis");
    // Seen the other way along the line it is on the left.
    let axis = if is_on_the_right(part) { axis.map(negate) } else { axis };
    Icon::Rolling { axis, radius: part.formula("radius").clone() }
}

impl Joint {
    /// A disc about the second point that rolls on the left of a line through the first point, without slip.
    pub fn rolling(first: &str, second: &str, axis: impl Into<Vector>, radius: impl Into<Quantity>) -> Joint {
        Joint::new("rolling", first, second).set("axis", axis.into()).set("radius", radius.into())
    }
}
