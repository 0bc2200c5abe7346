//! Pin in slot (p): a slide, r = s u, that leaves the angle free, T = 0. A prismatic joint in the translational graph, a revolute
//! one in the rotational.

use super::{Angle, CoordinateName, Element, Origin, RotationalRow, System, Torque, slide, table3};
use crate::mechanism::{Formula, Friction, JointId};

pub(super) fn element(
    system: &mut System,
    id: JointId,
    axis: &[Formula; 2],
    damping: &Formula,
    friction: Option<&Friction>,
) -> Element {
    let joint = &system.mechanism.joints[id.0];
    Element {
        label: system.label("p"),
        name: joint.name.clone(),
        origin: Origin::Joint(id),
        coupling: None,
        translation: Some(slide::row(system, id, axis, damping, friction)),
        rotation: Some(RotationalRow {
            ends: joint.between.map(|place| system.r_node(place.body())),
            priority: table3::REVOLUTE,
            angle: Angle::Free(CoordinateName::new(&joint.name, ["angle", "omega", "alpha"])),
            through: Torque::None,
        }),
    }
}
