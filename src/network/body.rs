//! The element of a rigid body (m): datum -> mass centre; F = -m a, T = -I alpha - sum r x F (Eqs 5, 6).

use super::{
    Angle, Direction, Element, Force, Known, Origin, RNode, RotationalRow, System, TNode, Torque, TranslationalRow,
    table2, table3,
};
use crate::expr::Expr;
use crate::model::{BodyId, Dimension, Owner, Place, Quantity};

/// The element of a body, with its edges in both graphs.
pub(super) fn element(system: &mut System, id: BodyId) -> Element {
    let name = &system.mechanism.clone().bodies[id.0].name;
    let plane = system.mechanism.dimension == Dimension::Two;
    let owner = Owner::Place(Place::Centre(id));
    let mut motion = vec![(Direction::X, owner.motion(Quantity::ALONG_X))];
    if plane {
        motion.push((Direction::Y, owner.motion(Quantity::ALONG_Y)));
    }
    let has_arms = system.used.range(Place::Point(id, 0)..=Place::Point(id, usize::MAX)).next().is_some();
    Element {
        label: system.label("m", name),
        name: name.clone(),
        origin: Origin::Body(id),
        coupling: None,
        closed: None,
        slip: None,
        translation: Some(TranslationalRow {
            ends: [TNode::DATUM, system.t_node(Place::Centre(id))],
            priority: table2::BODY,
            known: Known::Zero,
            motion,
            reaction: Vec::new(),
            through: Force::Inertia(id),
            armature: Expr::ZERO,
        }),
        rotation: plane.then(|| RotationalRow {
            ends: [RNode::DATUM, system.r_node(Some(id))],
            priority: if has_arms { table3::BODY_WITH_ARMS } else { table3::BODY },
            angle: Angle::Free(owner.motion(Quantity::TURN)),
            through: Torque::Inertia(id),
            armature: Expr::ZERO,
        }),
    }
}
