//! Revolute joint (h): r = 0, T resists.

use super::{
    Angle, CoordinateName, Direction, Element, Force, Known, Origin, Resistance, RotationalRow, System, Torque,
    TranslationalRow, table2, table3,
};
use crate::mechanism::{Formula, Friction, JointId};

pub(super) fn element(system: &mut System, id: JointId, damping: &Formula, friction: Option<&Friction>) -> Element {
    let joint = &system.mechanism.joints[id.0];
    let resistance = Resistance::new(system, damping, friction);
    Element {
        label: system.label("h"),
        name: joint.name.clone(),
        origin: Origin::Joint(id),
        coupling: None,
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
            through: resistance.map_or(Torque::None, Torque::Resistance),
        }),
    }
}
