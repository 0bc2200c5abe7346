//! Gear pair (g): theta_b = ratio theta_a + angle, both angles relative to the carrier. The reaction is the torque on b; a gets
//! -ratio times as much and the carrier the rest. With `backlash` the relation may be off by half of the play either way.

use crate::component::frame::{Placed, minus, sum, times};
use crate::component::key::{AT, BETWEEN_WHEELS, CARRIER_BODY, ENGAGED, Form, Key, Record};
use crate::component::{Component, Icon, Rubs, limits};
use crate::expr::{Expr, Function, Unary};
use crate::model::measure::{ANGLE, ANGULAR_VELOCITY, NUMBER, TORQUE};
use crate::model::{Captured, Formula, Friction, Part, Pressed, Quantity as Q, Range, turned_apart};
use crate::network::{Coupling, CouplingTerm, Port, Rows, System};
use crate::scene::{Joint, Quantity, constant};

pub(crate) const GEAR: Component = Component {
    about: "two wheels on a carrier that turn in a constant ratio",
    equations: "theta_b = ratio theta_a + angle",
    keys: &[
        BETWEEN_WHEELS,
        CARRIER_BODY,
        Key::required(
            "ratio",
            Form::Constant(NUMBER, Range::NotZero),
            "the second wheel's turns for one of the first; negative for external teeth",
            "give the second wheel's turns for one of the first: `ratio = -0.5`, negative for external teeth",
        ),
        Key::optional("angle", Form::Constant(ANGLE, Range::Any), "the second wheel's angle where the first's is zero"),
        Key::optional(
            "friction",
            Form::Record(Record::Friction([TORQUE, ANGULAR_VELOCITY], Pressed::Reaction(Q::Torque))),
            "friction of the mesh: `mu` is its torque on the first wheel per torque of the mesh; from 1 on it is self-locking",
        ),
        ENGAGED,
        AT,
        limits::PLAY_OF_ANGLE,
    ],
    variables: &[Q::Torque, Q::AngularImpulse, Q::Mode, Q::Sliding],
    rubs: Some(Rubs { along: first_turn, pressed: Pressed::Reaction(Q::Torque), law }),
    reactions: &[Q::Torque],
    captures: &[Captured::Key("angle", |part, _| Some(turned_apart(part, part.key("ratio"))))],
    engaging: &[Q::Engaged, Q::AngularImpulse, Q::LostEnergy],
    gaps: limits::gaps,
    relation,
    undriven: ["a gear pair or rack", "name the joint in which a wheel turns or the rack slides"],
    ..Component::joint("gear", rows, placed, |part| Icon::Gears {
        ratio: part.formula("ratio").clone(),
        carrier: part.place("carrier").body(),
    })
};

/// The first wheel's angle against the carrier, along which the mesh rubs.
pub(crate) fn first_turn(part: &Part, system: &mut System) -> Option<Coupling> {
    let turn = [part.place("carrier").body(), part.between[0].body()].map(|body| system.r_node(body));
    Some(Coupling::of(Port::Angle(turn)))
}

/// The torque of the mesh on the first wheel is ratio times that on the second, which is the reaction.
fn law(part: &Part) -> Option<Friction> {
    let friction = part.friction()?;
    let ratio = constant::apply(Function::One(Unary::Abs), vec![part.key("ratio")]);
    Some(Friction { mu: friction.mu.clone() * ratio, ..friction.clone() })
}

fn placed(placed: &mut Placed<'_>) {
    let ratio = placed.part.key("ratio");
    place_wheels(placed, ratio);
}

/// With the angles of both wheels against the carrier, the constant between them changes.
pub(crate) fn place_wheels(placed: &mut Placed<'_>, ratio: Formula) {
    let [of_first, of_second] = [0, 1].map(|wheel| placed.turned_on_carrier(wheel));
    let turned = minus(of_second, times(ratio, of_first));
    placed.number("angle", |frame, angle| sum(frame.signed(angle), turned));
}

fn rows(part: &Part, system: &mut System) -> Rows {
    Rows { letter: "g", coupling: limits::always(part, || relation(part, system)), ..Rows::default() }
}

fn relation(part: &Part, system: &mut System) -> Option<Coupling> {
    let ratio = system.value(part.formula("ratio"));
    Some(wheels(system, part, ratio, part.formula("angle")))
}

/// theta_b - ratio theta_a = offset, both angles relative to the carrier.
pub(crate) fn wheels(system: &mut System, part: &Part, ratio: Expr, offset: &Formula) -> Coupling {
    let carrier = system.r_node(part.place("carrier").body());
    let [first, second] = part.bodies().map(|body| system.r_node(body));
    let minus_ratio = system.arena.negate(ratio);
    let terms = vec![
        CouplingTerm { factor: Expr::ONE, port: Port::Angle([carrier, second]) },
        CouplingTerm { factor: minus_ratio, port: Port::Angle([carrier, first]) },
    ];
    Coupling { terms, offset: system.value(offset) }
}

impl Joint {
    /// Two wheels that turn in a constant ratio.
    pub fn gear(first: &str, second: &str, ratio: impl Into<Quantity>) -> Joint {
        Joint::new("gear", first, second).set("ratio", ratio.into())
    }
}
