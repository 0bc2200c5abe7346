//! Rigid arm (r): a vector fixed in a body, mass centre -> point; r = R(theta) r' (Eq. 2). A ground vector (R) is the arm
//! of the ground. Both are always branches of the translational tree.

use super::{Element, Force, Known, Origin, System, TranslationalRow, table2};
use crate::graph::TNode;
use crate::mechanism::{BodyId, Place};

pub(super) fn of_body(system: &mut System, body: BodyId, point: usize) -> Element {
    let owner = &system.mechanism.bodies[body.0];
    let at = system.values(&owner.points[point].at);
    Element {
        label: system.label("r", ""),
        name: format!("{}.{}", owner.name, owner.points[point].name),
        origin: Origin::Arm(body, point),
        coupling: None,
        translation: Some(TranslationalRow {
            ends: [system.t_node(Place::Centre(body)), system.t_node(Place::Point(body, point))],
            priority: table2::ARM,
            known: Known::Fixed(Some(body), at),
            motion: Vec::new(),
            reaction: Vec::new(),
            through: Force::None,
        }),
        rotation: None,
    }
}

pub(super) fn of_ground(system: &mut System, point: usize) -> Element {
    let owner = &system.mechanism.ground[point];
    let at = system.values(&owner.at);
    Element {
        label: system.label("R", ""),
        name: format!("ground.{}", owner.name),
        origin: Origin::GroundVector(point),
        coupling: None,
        translation: Some(TranslationalRow {
            ends: [TNode::DATUM, system.t_node(Place::Ground(point))],
            priority: table2::ARM,
            known: Known::Fixed(None, at),
            motion: Vec::new(),
            reaction: Vec::new(),
            through: Force::None,
        }),
        rotation: None,
    }
}
