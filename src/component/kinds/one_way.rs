//! Freewheel (f): the second body turns against the first in one direction only, omega >= 0. Where it would turn back it is caught, and drives with a torque T >= 0 until that falls to zero. Being
//! caught is an impact without a rebound.

use crate::component::frame::Placed;
use crate::component::key::{BETWEEN_BODIES, Form, Key};
use crate::component::{Component, Icon, IconStroke, Room};
use crate::model::{Formula, GapLaw, Mechanism, Part, Quantity as Q};
use crate::network::{Coupling, Port, Rows, System};
use crate::scene::Joint;

/// The way in which the second body may turn; the first by default.
const WAYS: [&str; 2] = ["counterclockwise", "clockwise"];

pub(crate) const ONE_WAY: Component = Component {
    about: "a freewheel (one-way clutch) or ratchet: the second body turns against the first in one direction only",
    equations: "omega >= 0, T >= 0",
    keys: &[
        BETWEEN_BODIES,
        Key::optional(
            "direction",
            Form::Choice(&WAYS, "a freewheel turns \"counterclockwise\" or \"clockwise\""),
            "the direction in which the second body may turn against the first",
        ),
    ],
    variables: &[Q::Torque, Q::StopTorque, Q::AngularImpulse, Q::Mode],
    room: Room::Turning,
    undriven: ["a freewheel", "name the joint in which a body turns"],
    gaps,
    relation,
    ..Component::joint("one_way", |_, _| Rows { letter: "f", ..Rows::default() }, placed, |_| Icon::Round(ratchet))
};

/// In a mirror it turns the other way.
fn placed(placed: &mut Placed<'_>) {
    placed.side("direction", WAYS);
}

fn gaps(part: &Part, _: &Mechanism) -> Vec<GapLaw> {
    let sign = if part.choice("direction") == Some(WAYS[1]) { -1.0 } else { 1.0 };
    let zero = || Formula::Number(0.0);
    vec![GapLaw { word: "", sign, bound: zero(), restitution: zero(), of_rate: true }]
}

fn relation(part: &Part, system: &mut System) -> Option<Coupling> {
    Some(Coupling::of(Port::Angle(part.bodies().map(|body| system.r_node(body)))))
}

/// The teeth of a ratchet.
fn ratchet() -> Vec<IconStroke> {
    const TEETH: usize = 8;
    let tooth = |index: usize| {
        let [from, to] = [index, index + 1].map(|end| end as f64 * std::f64::consts::TAU / TEETH as f64);
        IconStroke::arc([2.6, 1.9], [from, to])
    };
    (0..TEETH).map(tooth).collect()
}

impl Joint {
    /// A freewheel: the second body turns counterclockwise against the first, never back.
    pub fn one_way(first: &str, second: &str) -> Joint {
        Joint::new("one_way", first, second)
    }
}
