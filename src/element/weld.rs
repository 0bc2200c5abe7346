//! Weld: r = 0 and the angle is held. A revolute joint in the translational graph, a prismatic one in the rotational.

use super::{
    Angle, Direction, Element, Force, Known, Origin, RotationalRow, System, Torque, TranslationalRow, table2, table3,
};
use crate::mechanism::{Dimension, Formula, JointId};

pub(super) fn element(system: &mut System, id: JointId, angle: &Formula) -> Element {
    let joint = &system.mechanism.joints[id.0];
    let plane = system.mechanism.dimension == Dimension::Two;
    let angle = system.value(angle);
    Element {
        label: system.label("w"),
        name: joint.name.clone(),
        origin: Origin::Joint(id),
        coupling: None,
        translation: Some(TranslationalRow {
            ends: joint.between.map(|place| system.t_node(place)),
            priority: table2::REVOLUTE,
            known: Known::Zero,
            motion: Vec::new(),
            reaction: if plane { vec![Direction::X, Direction::Y] } else { vec![Direction::X] },
            through: Force::None,
        }),
        rotation: plane.then(|| RotationalRow {
            ends: joint.between.map(|place| system.r_node(place.body())),
            priority: table3::PRISMATIC,
            angle: Angle::Constant(angle),
            through: Torque::None,
        }),
    }
}
