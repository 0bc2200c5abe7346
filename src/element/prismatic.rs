//! Prismatic joint (s): a slide, r = s u, that holds the angle.

use super::{Angle, Element, Origin, RotationalRow, System, Torque, slide, table3};
use crate::mechanism::{Formula, Friction, JointId};

pub(super) fn element(
    system: &mut System,
    id: JointId,
    axis: &[Formula; 2],
    angle: &Formula,
    damping: &Formula,
    friction: Option<&Friction>,
) -> Element {
    let translation = slide::row(system, id, axis, damping, friction);
    let angle = system.value(angle);
    let joint = &system.mechanism.joints[id.0];
    Element {
        label: system.label("s"),
        name: joint.name.clone(),
        origin: Origin::Joint(id),
        coupling: None,
        translation: Some(translation),
        rotation: Some(RotationalRow {
            ends: joint.between.map(|place| system.r_node(place.body())),
            priority: table3::PRISMATIC,
            angle: Angle::Constant(angle),
            through: Torque::None,
        }),
    }
}
