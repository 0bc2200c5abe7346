//! Constant-force spring (F): a pre-stressed strip that unrolls from a drum pulls its ends together with the same force at any length.

use crate::component::course::{ENDS, OVER, placed};
use crate::component::key::{Form, Key};
use crate::component::{Component, Icon, IconStroke, line};
use crate::model::measure::FORCE;
use crate::model::{Quantity as Q, Range};
use crate::scene::{Load, Quantity};

pub(crate) const CONSTANT_FORCE: Component = Component {
    about: "a spring that pulls two points together with the same force at any length",
    equations: "F = -pull",
    keys: &[
        ENDS,
        Key::required(
            "pull",
            Form::Constant(FORCE, Range::Any),
            "the force that pulls the points together",
            "give the force that pulls the points together [N]: `pull = 20`",
        ),
        OVER,
    ],
    variables: &[Q::Length, Q::Rate, Q::Force],
    pose: &[Q::Length, Q::Force],
    pulls: true,
    law: |part| Some(-part.key("pull")),
    energy: |part| Some(part.key("pull") * part.variable(Q::Length)),
    ..Component::load(
        "constant_force_spring",
        |part, system| line::rows(system, part, "k"),
        placed,
        |_| Icon::Line(drum),
    )
};

/// A strip that unrolls from a spiral at the first point.
fn drum(length: f64) -> Vec<IconStroke> {
    let radius = (0.3 * length).min(2.4);
    let turns = |step: i32| {
        let share = f64::from(step) / 60.0;
        let (angle, reach) = (5.0 * std::f64::consts::PI * share, radius * (0.15 + 0.85 * share));
        let (sine, cosine) = libm::sincos(angle);
        [reach * sine, reach * cosine]
    };
    let mut strip: Vec<[f64; 2]> = (0..=60).map(turns).collect();
    strip.push([length, 0.0]);
    vec![IconStroke::open(strip)]
}

impl Load {
    /// A spring that pulls two points together with the same force at any length.
    pub fn constant_force_spring(first: &str, second: &str, pull: impl Into<Quantity>) -> Load {
        Load::new("constant_force_spring").set("between", [first, second]).set("pull", pull.into())
    }
}
