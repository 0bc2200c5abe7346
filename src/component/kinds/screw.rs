//! Screw (c): s = lead theta / (2 pi) + displacement, with s along an axis fixed in the carrier and theta the angle that the spindle,
//! the first body, turns against the carrier. The reaction is the force on the nut; the spindle gets -lead/(2 pi) times as much torque.

use super::rack;
use crate::component::frame::Placed;
use crate::component::key::{
    AT, AXIS_OF_CARRIER, BODY_AND_POINT, CARRIER_POINT, DISPLACEMENT, ENGAGED, Form, Key, Record,
};
use crate::component::{Component, Icon, IconStroke, Rubs, limits};
use crate::expr::{Expr, Function, Unary};
use crate::model::measure::{FORCE, LENGTH, VELOCITY};
use crate::model::{Captured, Formula, Friction, Part, Pressed, Quantity as Q, Range};
use crate::network::{Coupling, CouplingTerm, Rows, System};
use crate::scene::{Joint, Quantity, Vector, constant};

pub(crate) const SCREW: Component = Component {
    about: "a spindle, the first body, whose turning moves a nut, the second point, along an axis of the carrier",
    equations: "s = lead theta/(2 pi) + displacement",
    keys: &[
        Key::required("between", Form::BodyAndPoint, "the spindle and a point of the nut", BODY_AND_POINT),
        CARRIER_POINT,
        AXIS_OF_CARRIER,
        Key::required(
            "lead",
            Form::Constant(LENGTH, Range::NotZero),
            "how far the nut moves in one turn; negative for a left-hand thread",
            "give how far the nut moves in one turn: `lead = \"5 mm\"`",
        ),
        DISPLACEMENT,
        Key::optional(
            "friction",
            Form::Record(Record::Friction([FORCE, VELOCITY], Pressed::Reaction(Q::Force))),
            "friction of a square thread at `radius`, along its helix",
        ),
        ENGAGED,
        AT,
        limits::PLAY_OF_SLIDE,
    ],
    variables: &[Q::Force, Q::Torque, Q::Impulse, Q::Mode, Q::Sliding],
    rubs: Some(Rubs { along: thread_slide, pressed: Pressed::Reaction(Q::Force), law }),
    reactions: &[Q::Force, Q::Torque],
    captures: &[Captured::Key("displacement", |part, mechanism| {
        Some(mechanism.slid_apart(part, part.key("lead") / Formula::Number(std::f64::consts::TAU)))
    })],
    engaging: &[Q::Engaged, Q::Impulse, Q::LostEnergy],
    gaps: limits::gaps,
    relation,
    undriven: ["a screw", "name the joint in which the spindle turns or the nut slides"],
    ..Component::joint("screw", rows, placed, |_| Icon::Line(thread))
};

/// Lead by turn at the radius of the thread: the slope of its helix.
fn slope(part: &Part) -> Formula {
    let radius = part.friction().and_then(|friction| friction.radius.clone()).unwrap_or(Formula::Number(1.0));
    part.key("lead") / (Formula::Number(std::f64::consts::TAU) * radius)
}

/// One by the cosine of the slope of the helix.
fn secant(part: &Part) -> Formula {
    let square = slope(part) * slope(part);
    constant::apply(Function::One(Unary::Sqrt), vec![Formula::Number(1.0) + square])
}

/// The way along the helix: s sin + radius theta cos of its slope.
fn thread_slide(part: &Part, system: &mut System) -> Option<Coupling> {
    let radius = part.friction().and_then(|friction| friction.radius.clone()).unwrap_or(Formula::Number(1.0));
    let factors = [slope(part) / secant(part), radius / secant(part)].map(|factor| system.value(&factor));
    let terms = rack::slide_by_turn(system, part, |_| Expr::ZERO).terms;
    let terms = terms.into_iter().zip(factors).map(|(term, factor)| CouplingTerm { factor, port: term.port }).collect();
    Some(Coupling { terms, offset: Expr::ZERO })
}

/// What presses on the thread is the force on the nut by the cosine of its slope.
fn law(part: &Part) -> Option<Friction> {
    let friction = part.friction()?;
    Some(Friction { mu: friction.mu.clone() * secant(part), ..friction.clone() })
}

fn placed(placed: &mut Placed<'_>) {
    let lead = placed.part.key("lead");
    rack::place_slide(placed, "lead", lead / Formula::Number(std::f64::consts::TAU));
}

fn rows(part: &Part, system: &mut System) -> Rows {
    Rows { letter: "c", coupling: limits::always(part, || relation(part, system)), ..Rows::default() }
}

fn relation(part: &Part, system: &mut System) -> Option<Coupling> {
    let per_radian = |system: &mut System| {
        let lead = system.value(part.formula("lead"));
        let turn = system.arena.constant(std::f64::consts::TAU);
        system.arena.divide(lead, turn)
    };
    Some(rack::slide_by_turn(system, part, per_radian))
}

/// A spindle with its thread, from its bearing to the nut.
fn thread(length: f64) -> Vec<IconStroke> {
    let turns = length.round().clamp(4.0, 40.0);
    let pitch = length / turns;
    let flank = |turn: usize| {
        let at = pitch * (turn as f64 + 0.5);
        IconStroke::open(vec![[at - 0.3 * pitch, -0.8], [at + 0.3 * pitch, 0.8]])
    };
    let edges = [-0.8, 0.8].map(|side| IconStroke::open(vec![[0.0, side], [length, side]]));
    edges.into_iter().chain((0..turns as usize).map(flank)).collect()
}

impl Joint {
    /// A spindle, the first body, that moves a nut, the second point, along an axis in the carrier's frame by `lead` in each turn.
    pub fn screw(spindle: &str, nut: &str, axis: impl Into<Vector>, lead: impl Into<Quantity>) -> Joint {
        Joint::new("screw", spindle, nut).set("axis", axis.into()).set("lead", lead.into())
    }
}
