//! Belt or chain (b) over two pulleys: radius_b theta_b = +-radius_a theta_a, both angles relative to the carrier, minus if the belt is
//! crossed. It does not stretch, and slips only if it has `friction`. The reaction is the torque on the second pulley.

use super::gear;
use crate::component::frame::Placed;
use crate::component::key::{AT, BETWEEN_WHEELS, CARRIER_BODY, ENGAGED, Form, Key, Record};
use crate::component::{Component, Icon, Rubs, limits};
use crate::expr::{Function, Unary};
use crate::model::measure::{ANGLE, ANGULAR_VELOCITY, LENGTH, TORQUE};
use crate::model::{Captured, Formula, Friction, Part, Pressed, Quantity as Q, Range, turned_apart};
use crate::network::{Coupling, Rows, System};
use crate::scene::{Joint, Quantity};

pub(crate) const BELT: Component = Component {
    about: "a belt or chain over two pulleys on a carrier",
    equations: "theta_b = +-(first_radius/second_radius) theta_a + angle",
    keys: &[
        BETWEEN_WHEELS,
        CARRIER_BODY,
        Key::required(
            "first_radius",
            Form::Constant(LENGTH, Range::Positive),
            "the radius of the first pulley",
            "give the radius of the first pulley: `first_radius = \"40 mm\"`",
        ),
        Key::required(
            "second_radius",
            Form::Constant(LENGTH, Range::Positive),
            "the radius of the second pulley",
            "give the radius of the second pulley: `second_radius = \"120 mm\"`",
        ),
        Key::optional(
            "run",
            Form::Choice(
                &["open", "crossed"],
                "a belt runs \"open\" or \"crossed\": then the pulleys turn against each other",
            ),
            "whether the belt is open or crossed",
        ),
        Key::optional(
            "angle",
            Form::Constant(ANGLE, Range::Any),
            "the second pulley's angle where the first's is zero",
        ),
        Key::optional(
            "friction",
            Form::Record(Record::Friction([TORQUE, ANGULAR_VELOCITY], Pressed::Belt)),
            "the torque on the second pulley at which the belt slips, or what it follows from: coefficient of friction, the smaller angle of wrap, mean tension; if absent, the belt does not slip",
        ),
        ENGAGED,
        AT,
        limits::PLAY_OF_ANGLE,
    ],
    variables: &[Q::Torque, Q::AngularImpulse, Q::Mode, Q::Sliding],
    rubs: Some(Rubs { along: relation, pressed: Pressed::Belt, law }),
    reactions: &[Q::Torque],
    captures: &[Captured::Key("angle", |part, _| Some(turned_apart(part, ratio(part))))],
    engaging: &[Q::Engaged, Q::AngularImpulse, Q::LostEnergy],
    gaps: limits::gaps,
    relation,
    undriven: ["a belt", "name the joint in which a pulley turns"],
    ..Component::joint("belt", rows, placed, icon)
};

fn placed(placed: &mut Placed<'_>) {
    let ratio = ratio(placed.part);
    gear::place_wheels(placed, ratio);
}

/// The turns of the second pulley for one of the first.
fn ratio(part: &Part) -> Formula {
    let [first, second] = ["first_radius", "second_radius"].map(|key| part.key(key));
    let open = first / second;
    if is_crossed(part) { -open } else { open }
}

fn rows(part: &Part, system: &mut System) -> Rows {
    let coupling = limits::always(part, || relation(part, system)).filter(|_| part.friction().is_none());
    Rows { letter: "b", coupling, ..Rows::default() }
}

/// theta_b -+ (first_radius / second_radius) theta_a = angle: what a belt that slips does not hold.
fn relation(part: &Part, system: &mut System) -> Option<Coupling> {
    let radii = ["first_radius", "second_radius"].map(|key| system.value(part.formula(key)));
    let open = system.arena.divide(radii[0], radii[1]);
    let ratio = if is_crossed(part) { system.arena.negate(open) } else { open };
    Some(gear::wheels(system, part, ratio, part.formula("angle")))
}

/// T1 = T2 exp(mu wrap) where the belt slips (Euler and Eytelwein), so that with the mean tension P the difference T1 - T2 is 2 P tanh(mu wrap/2).
fn law(part: &Part) -> Option<Friction> {
    let friction = part.friction().filter(|friction| friction.sticks())?;
    let Some([wrap, pretension]) = friction.belt.clone() else { return Some(friction.clone()) };
    let half = friction.mu.clone() * wrap / Formula::Number(2.0);
    let share = Formula::Call(Function::One(Unary::Tanh), vec![half]);
    let coulomb = Formula::Number(2.0) * pretension * part.key("second_radius") * share;
    Some(Friction { ratio: friction.ratio.clone(), ..Friction::of_level(coulomb, Formula::Number(1.0)) })
}

fn icon(part: &Part) -> Icon {
    let radii = ["first_radius", "second_radius"].map(|key| part.formula(key).clone());
    Icon::Band { carrier: part.place("carrier").body(), radii, crossed: is_crossed(part) }
}

fn is_crossed(part: &Part) -> bool {
    part.choice("run") == Some("crossed")
}

impl Joint {
    /// An open belt or chain over two pulleys.
    pub fn belt(first: &str, second: &str, radii: [impl Into<Quantity>; 2]) -> Joint {
        let [first_radius, second_radius] = radii.map(Into::into);
        Joint::new("belt", first, second).set("first_radius", first_radius).set("second_radius", second_radius)
    }

    /// Lets a belt cross: the pulleys turn against each other.
    #[must_use]
    pub fn crossed(self) -> Joint {
        self.set("run", "crossed")
    }
}
