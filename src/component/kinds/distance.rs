//! Distance link (d): a massless rod, |r| = length. The reaction pushes its ends apart.

use crate::component::frame::anywhere;
use crate::component::key::{AT, BETWEEN_POINTS, ENGAGED, Form, Key};
use crate::component::{Component, Icon};
use crate::expr::Expr;
use crate::model::measure::LENGTH;
use crate::model::{Captured, Part, Quantity as Q, Range};
use crate::network::{Coupling, CouplingTerm, Port, Rows, System};
use crate::scene::{Joint, Quantity};

pub(crate) const DISTANCE: Component = Component {
    about: "a massless rod between two points",
    equations: "|r| = length",
    keys: &[
        BETWEEN_POINTS,
        Key::captured(
            "length",
            Form::Constant(LENGTH, Range::Positive),
            "the length of the rod",
            "give the length of the rod: `length = \"0.5 m\"`",
        ),
        ENGAGED,
        AT,
    ],
    variables: &[Q::Force],
    reactions: &[Q::Force],
    captures: &[Captured::Key("length", |part, mechanism| Some(mechanism.distance(part)))],
    engaging: &[Q::Engaged, Q::Impulse, Q::Length, Q::LostEnergy],
    undriven: ["a distance link", "its length is constant; a driver with `position` moves a point"],
    ..Component::joint("distance", rows, anywhere, |_| Icon::Link)
};

fn rows(part: &Part, system: &mut System) -> Rows {
    let port = Port::Length(part.between.map(|place| system.t_node(place)));
    let offset = system.value(part.formula("length"));
    let coupling = Coupling { terms: vec![CouplingTerm { factor: Expr::ONE, port }], offset };
    Rows { letter: "d", coupling: Some(coupling), ..Rows::default() }
}

impl Joint {
    /// A massless rod between two points.
    pub fn distance(first: &str, second: &str, length: impl Into<Quantity>) -> Joint {
        Joint::new("distance", first, second).set("length", length.into())
    }
}
