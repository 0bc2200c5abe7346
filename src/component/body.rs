//! Rigid body (m): datum -> mass centre; F = -m a, T = -I alpha - sum r x F (Eqs 5, 6).

use super::{
    Angle, CoordinateName, Direction, Element, Force, Known, Origin, RotationalRow, System, Torque, TranslationalRow,
    table2, table3,
};
use crate::graph::{RNode, TNode};
use crate::mechanism::measure::{INERTIA, LENGTH, MASS};
use crate::mechanism::{BodyId, Dimension, Place, Quantity as Q};
use crate::scene::key::{Form, Key, Range};

/// What it is and its terminal equations, for the reference.
pub(super) const ABOUT: [&str; 2] = ["a rigid body", "F = -m (a - g), T = -I alpha - sum r x F"];

/// The keys of a body.
pub(crate) const KEYS: &[Key] = &[
    Key::default("mass", Form::Constant(MASS, Range::NotNegative), "its mass", "that of the shape"),
    Key::default(
        "inertia",
        Form::Constant(INERTIA, Range::NotNegative),
        "its moment of inertia about the mass centre",
        "that of the shape",
    ),
    Key::default(
        "com",
        Form::ConstantVector(LENGTH),
        "its mass centre in the frame of the points",
        "that of the shape, or the origin",
    ),
    Key::default("gravity", Form::Switch, "whether gravity acts on it", "`true`"),
    Key::default("points", Form::NamedPoints, "its points, in a frame that is fixed in it", "none"),
    Key::default("shape", Form::Shape, "a uniform [shape](#shapes) in the frame of the points", "none"),
];

/// Its variables.
pub const VARIABLES: &[Q] = &[Q::X, Q::Y, Q::Angle, Q::Vx, Q::Vy, Q::Omega, Q::Ax, Q::Ay, Q::Alpha];

/// Those of its points.
pub const POINT_VARIABLES: &[Q] = &[Q::X, Q::Y, Q::Vx, Q::Vy, Q::Ax, Q::Ay];

pub(super) fn element(system: &mut System, id: BodyId) -> Element {
    let name = &system.mechanism.clone().bodies[id.0].name;
    let plane = system.mechanism.dimension == Dimension::Two;
    let mut motion = vec![(Direction::X, CoordinateName::new(name, ["x", "vx", "ax"]))];
    if plane {
        motion.push((Direction::Y, CoordinateName::new(name, ["y", "vy", "ay"])));
    }
    let has_arms = system.used.range(Place::Point(id, 0)..=Place::Point(id, usize::MAX)).next().is_some();
    Element {
        label: system.label("m", name),
        name: name.clone(),
        origin: Origin::Body(id),
        coupling: None,
        translation: Some(TranslationalRow {
            ends: [TNode::DATUM, system.t_node(Place::Centre(id))],
            priority: table2::BODY,
            known: Known::Zero,
            motion,
            reaction: Vec::new(),
            through: Force::Inertia(id),
        }),
        rotation: plane.then(|| RotationalRow {
            ends: [RNode::DATUM, system.r_node(Some(id))],
            priority: if has_arms { table3::BODY_WITH_ARMS } else { table3::BODY },
            angle: Angle::Free(CoordinateName::new(name, ["angle", "omega", "alpha"])),
            through: Torque::Inertia(id),
        }),
    }
}
