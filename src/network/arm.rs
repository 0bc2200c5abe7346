//! Rigid arm (r): a vector fixed in a body, mass centre -> point; r = R(theta) r' (Eq. 2). A ground vector (R) is the arm
//! of the ground. Both are always branches of the translational tree.

use super::graph::TNode;
use super::{Element, Force, Known, Origin, System, TranslationalRow, table2};
use crate::expr::Expr;
use crate::model::{BodyId, Place};

pub(crate) fn of_body(system: &mut System, body: BodyId, point: usize) -> Element {
    let known = Known::Fixed(Some(body), system.values(&system.mechanism.clone().bodies[body.0].points[point].at));
    let name = system.mechanism.place_name(Place::Point(body, point));
    let ends = [Place::Centre(body), Place::Point(body, point)].map(|place| system.t_node(place));
    arm(system.label("r", ""), name, Origin::Arm(body, point), ends, known)
}

pub(crate) fn of_ground(system: &mut System, point: usize) -> Element {
    let known = Known::Fixed(None, system.values(&system.mechanism.clone().ground[point].at));
    let ends = [TNode::DATUM, system.t_node(Place::Ground(point))];
    let name = system.mechanism.place_name(Place::Ground(point));
    arm(system.label("R", ""), name, Origin::GroundVector(point), ends, known)
}

fn arm(label: String, name: String, origin: Origin, ends: [TNode; 2], known: Known) -> Element {
    let (priority, motion, reaction, through) = (table2::ARM, Vec::new(), Vec::new(), Force::None);
    let row = TranslationalRow { ends, priority, known, motion, reaction, through, armature: Expr::ZERO };
    Element { label, name, origin, translation: Some(row), rotation: None, coupling: None, closed: None, slip: None }
}
