//! Pin in slot (p): r = s u with u fixed in the first body, F . u = -c v, T = 0. A prismatic joint in the translational graph, a
//! revolute one in the rotational.

use super::{
    Angle, CoordinateName, Direction, Element, Force, Known, Origin, Resistance, RotationalRow, System, Torque,
    TranslationalRow, table2, table3,
};
use crate::mechanism::{Formula, Friction, JointId};

pub(super) fn element(
    system: &mut System,
    id: JointId,
    axis: &[Formula; 2],
    damping: &Formula,
    friction: Option<&Friction>,
) -> Element {
    let joint = &system.mechanism.joints[id.0];
    let [ux, uy] = system.values(axis);
    let normal = [system.arena.negate(uy), ux];
    let resistance = Resistance::new(system, damping, friction);
    let first = joint.between[0].body();
    Element {
        label: system.label("p"),
        name: joint.name.clone(),
        origin: Origin::Joint(id),
        coupling: None,
        translation: Some(TranslationalRow {
            ends: joint.between.map(|place| system.t_node(place)),
            priority: table2::PRISMATIC,
            known: Known::Zero,
            motion: vec![(Direction::Fixed(first, [ux, uy]), CoordinateName::new(&joint.name, ["s", "v", "a"]))],
            reaction: vec![Direction::Fixed(first, normal)],
            through: resistance.map_or(Force::None, Force::Resistance),
        }),
        rotation: Some(RotationalRow {
            ends: joint.between.map(|place| system.r_node(place.body())),
            priority: table3::REVOLUTE,
            angle: Angle::Free(CoordinateName::new(&joint.name, ["angle", "omega", "alpha"])),
            through: Torque::None,
        }),
    }
}
