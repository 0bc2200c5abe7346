//! External force (F): datum -> point; F = F(r, v, t).

use crate::component::frame::{Placed, ZERO};
use crate::component::key::{Form, Key, ON_POINT, TWO_COMPONENTS};
use crate::component::{Component, Icon};
use crate::model::measure::FORCE;
use crate::model::{BodyId, Formula, KeyValue, Part, Place, Quantity as Q};
use crate::network::{Force, Rows, System, TNode, TranslationalRow};
use crate::scene::{Load, Vector};

pub(crate) const APPLIED_FORCE: Component = Component {
    about: "a force on a point",
    equations: "F = vector",
    keys: &[
        ON_POINT,
        Key::required("vector", Form::Vector(FORCE), "the components", TWO_COMPONENTS),
        Key::optional(
            "frame",
            Form::Choice(&["world", "body"], "`frame` is \"world\" (the default) or \"body\""),
            "whose axes the components are along",
        ),
    ],
    variables: &[Q::Fx, Q::Fy],
    pose: &[Q::Fx, Q::Fy],
    ..Component::load("force", rows, placed, |part| Icon::Arrow {
        vector: part.vector("vector"),
        in_body: in_body(part),
    })
};

/// In the world's axes it keeps them on a body that carries the part, so the part must not be turned against that.
fn placed(placed: &mut Placed<'_>) {
    let frame = placed.frame;
    if in_body(placed.part) {
        placed.vector("vector", |force| frame.mirrored(force));
    } else if frame.on.is_some() && (frame.mirror || frame.angle != ZERO) {
        let why = "its components, which are in the world's axes";
        placed.refuse("vector", why, "give the force in the body's frame: `frame = \"body\"`");
    } else {
        placed.vector("vector", |force| frame.direction(force));
    }
}

fn rows(part: &Part, system: &mut System) -> Rows {
    let on = part.between[1];
    let through = match on.body() {
        Some(body) if in_body(part) => Force::InBody(body, part.vector("vector")),
        _ => Force::World(part.vector("vector")),
    };
    let ends = [TNode::DATUM, system.t_node(on)];
    let row = TranslationalRow::force(system, part, ends, through);
    Rows { letter: "F", translation: Some(row), ..Rows::default() }
}

fn in_body(part: &Part) -> bool {
    part.choice("frame") == Some("body")
}

impl Load {
    /// A force on a point, in the world frame.
    pub fn force(on: &str, vector: impl Into<Vector>) -> Load {
        Load::new("force").set("on", on).set("vector", vector.into())
    }

    /// A force on a point, in the body's frame.
    pub fn body_force(on: &str, vector: impl Into<Vector>) -> Load {
        Load::force(on, vector).set("frame", "body")
    }
}

impl Part {
    /// A force on the mass centre of a body; [`crate::model::Mechanism::loaded`] puts it in.
    pub fn applied_force(name: &str, body: BodyId, vector: [Formula; 2]) -> Part {
        APPLIED_FORCE.part(name, [Place::Origin, Place::Centre(body)], vec![("vector", KeyValue::Vector(vector))])
    }
}
