//! Brake and clutch (q): dry friction between two bodies, of a level that a law gives. It holds them together, or slips against its level.

use crate::component::frame::Placed;
use crate::component::key::{BETWEEN_BODIES, Form, Key};
use crate::component::{Component, Icon, IconStroke, Room, Rubs, limits};
use crate::model::measure::{NUMBER, TORQUE};
use crate::model::{Friction, KeyValue, Part, Pressed, Quantity as Q, Range};
use crate::network::{Rows, System};
use crate::scene::{Joint, Quantity};

pub(crate) const BRAKE: Component = Component {
    about: "a brake between two bodies, most often the ground and a wheel",
    undriven: ["a brake", "name the joint in which the wheel turns"],
    ..of("brake")
};

pub(crate) const CLUTCH: Component = Component {
    about: "a clutch between two bodies",
    undriven: ["a clutch", "name the joint in which a shaft turns"],
    ..of("clutch")
};

const KEYS: &[Key] = &[
    BETWEEN_BODIES,
    Key::required(
        "level",
        Form::Law(TORQUE),
        "the friction torque limit: the torque while it slips",
        "give the friction torque limit: `level = \"12 N.m\"`, or a law such as `level = \"if(t > 1, 12, 0)\"`",
    ),
    Key::default(
        "static",
        Form::Constant(NUMBER, Range::FromOne),
        "ratio of the static to the kinetic friction torque limit",
        "1",
    ),
];

const fn of(name: &'static str) -> Component {
    Component {
        equations: "omega = 0 while |T| <= static*level, else T = -level sign(omega)",
        keys: KEYS,
        variables: &[Q::Angle, Q::Omega, Q::Alpha, Q::Torque, Q::Mode, Q::Sliding],
        room: Room::Turning,
        rubs: Some(Rubs { along: limits::angle, pressed: Pressed::Nothing, law }),
        ..Component::joint(name, rows, placed, |_| Icon::Round(shoes))
    }
}

fn placed(_: &mut Placed<'_>) {}

/// Two shoes on a drum.
fn shoes() -> Vec<IconStroke> {
    const HALF: f64 = 0.9;
    let shoe = |middle: f64| {
        let [from, to] = [middle - HALF, middle + HALF];
        [[2.0, 2.0], [2.7, 2.7]].map(|radii| IconStroke::arc(radii, [from, to]))
    };
    [0.0, std::f64::consts::PI].into_iter().flat_map(shoe).collect()
}

fn rows(_: &Part, _: &mut System) -> Rows {
    Rows { letter: "q", ..Rows::default() }
}

fn law(part: &Part) -> Option<Friction> {
    let ratio = match part.value("static") {
        Some(KeyValue::Formula(ratio)) => ratio.clone(),
        _ => crate::model::Formula::Number(1.0),
    };
    Some(Friction::of_level(part.key("level"), ratio))
}

impl Joint {
    /// A brake of a level [N.m] between two bodies.
    pub fn brake(first: &str, second: &str, level: impl Into<Quantity>) -> Joint {
        Joint::new("brake", first, second).set("level", level.into())
    }

    /// A clutch of a level [N.m] between two bodies.
    pub fn clutch(first: &str, second: &str, level: impl Into<Quantity>) -> Joint {
        Joint::new("clutch", first, second).set("level", level.into())
    }
}
