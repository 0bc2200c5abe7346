//! Rack and pinion (k): s = radius theta + displacement, with s along an axis fixed in the carrier and theta the pinion's angle
//! relative to the carrier. The reaction is the force on the rack; the pinion gets -radius times as much torque.

use crate::component::frame::{Placed, minus, times};
use crate::component::key::{AT, AXIS_OF_CARRIER, BODY_AND_POINT, CARRIER_POINT, DISPLACEMENT, ENGAGED, Form, Key};
use crate::component::{Component, Icon, limits};
use crate::expr::Expr;
use crate::model::measure::LENGTH;
use crate::model::{Captured, Formula, Part, Quantity as Q, Range};
use crate::network::{Coupling, CouplingTerm, Direction, Port, Rows, System};
use crate::scene::{Joint, Quantity, Vector};

pub(crate) const RACK: Component = Component {
    about: "a pinion, the first body, that moves the second point along an axis of the carrier",
    equations: "s = radius theta + displacement",
    keys: &[
        Key::required("between", Form::BodyAndPoint, "the pinion and a point of the rack", BODY_AND_POINT),
        CARRIER_POINT,
        AXIS_OF_CARRIER,
        Key::required(
            "radius",
            Form::Constant(LENGTH, Range::NotZero),
            "the radius of the pinion; negative if the rack goes back when the pinion turns forward",
            "give the radius of the pinion: `radius = \"30 mm\"`",
        ),
        DISPLACEMENT,
        ENGAGED,
        AT,
        limits::PLAY_OF_SLIDE,
    ],
    variables: &[Q::Force, Q::Torque, Q::Impulse, Q::Mode],
    reactions: &[Q::Force, Q::Torque],
    captures: &[Captured::Key("displacement", |part, mechanism| Some(mechanism.slid_apart(part, part.key("radius"))))],
    engaging: &[Q::Engaged, Q::Impulse, Q::LostEnergy],
    gaps: limits::gaps,
    relation,
    undriven: ["a gear pair or rack", "name the joint in which a wheel turns or the rack slides"],
    ..Component::joint("rack", rows, placed, |part| Icon::Rack {
        carrier: part.place("carrier"),
        axis: part.vector("axis"),
        radius: part.formula("radius").clone(),
    })
};

fn placed(placed: &mut Placed<'_>) {
    let radius = placed.part.key("radius");
    place_slide(placed, "radius", radius);
}

/// In a mirror the teeth or the thread of a slide are on the other side: its factor gets the other sign. What the turn of the part adds to the angle, the
/// displacement at the angle zero takes back.
pub(crate) fn place_slide(placed: &mut Placed<'_>, key: &'static str, factor: Formula) {
    placed.axis("axis", placed.part.place("carrier"));
    placed.sign(key);
    let turned = times(placed.frame.signed(factor), placed.turned_on_carrier(0));
    placed.number("displacement", |_, displacement| minus(displacement, turned));
}

fn rows(part: &Part, system: &mut System) -> Rows {
    Rows { letter: "k", coupling: limits::always(part, || relation(part, system)), ..Rows::default() }
}

fn relation(part: &Part, system: &mut System) -> Option<Coupling> {
    Some(slide_by_turn(system, part, |system| system.value(part.formula("radius"))))
}

/// s - factor theta = displacement: the second point slides along an axis of the carrier while the first body turns against it.
pub(crate) fn slide_by_turn(system: &mut System, part: &Part, factor: impl Fn(&mut System) -> Expr) -> Coupling {
    let [first, second] = part.between;
    let carrier = part.place("carrier");
    let along = Direction::Fixed(carrier.body(), system.values(&part.vector("axis")));
    let slide = [carrier, second].map(|place| system.t_node(place));
    let turn = [carrier, first].map(|place| system.r_node(place.body()));
    let factor = factor(system);
    let minus_factor = system.arena.negate(factor);
    let terms = vec![
        CouplingTerm { factor: Expr::ONE, port: Port::Along(slide, along) },
        CouplingTerm { factor: minus_factor, port: Port::Angle(turn) },
    ];
    Coupling { terms, offset: system.value(part.formula("displacement")) }
}

impl Joint {
    /// A pinion, the first body, that moves a rack, the second point, along an axis in the carrier's frame.
    pub fn rack(pinion: &str, rack: &str, axis: impl Into<Vector>, radius: impl Into<Quantity>) -> Joint {
        Joint::new("rack", pinion, rack).set("axis", axis.into()).set("radius", radius.into())
    }
}
