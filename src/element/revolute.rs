//! Revolute joint (h): r = 0, T = -c omega.

use super::{
    Angle, CoordinateName, Direction, Element, Force, Known, Origin, RotationalRow, System, Torque, TranslationalRow,
    table2, table3,
};
use crate::expr::Expr;
use crate::mechanism::{Formula, JointId};

pub(super) fn element(system: &mut System, id: JointId, damping: &Formula) -> Element {
    let joint = &system.mechanism.joints[id.0];
    let damping = system.value(damping);
    Element {
        label: system.label("h"),
        name: joint.name.clone(),
        origin: Origin::Joint(id),
        translation: Some(TranslationalRow {
            ends: joint.between.map(|place| system.t_node(place)),
            priority: table2::REVOLUTE,
            known: Known::Zero,
            motion: Vec::new(),
            reaction: vec![Direction::X, Direction::Y],
            through: Force::None,
        }),
        rotation: Some(RotationalRow {
            ends: joint.between.map(|place| system.r_node(place.body())),
            priority: table3::REVOLUTE,
            angle: Angle::Free(CoordinateName::new(&joint.name, ["angle", "omega", "alpha"])),
            through: if damping == Expr::ZERO { Torque::None } else { Torque::Damping(damping) },
        }),
    }
}
