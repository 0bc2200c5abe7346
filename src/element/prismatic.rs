//! Prismatic joint (s): r = s u with u fixed in the first body, F . u resists (Eqs 3, 4); the angle is held.

use super::{
    Angle, CoordinateName, Direction, Element, Force, Known, Origin, Resistance, RotationalRow, System, Torque,
    TranslationalRow, table2, table3,
};
use crate::mechanism::{Formula, Friction, JointId};

pub(super) fn element(
    system: &mut System,
    id: JointId,
    axis: &[Formula; 2],
    angle: &Formula,
    damping: &Formula,
    friction: Option<&Friction>,
) -> Element {
    let joint = &system.mechanism.joints[id.0];
    let [ux, uy] = system.values(axis);
    let normal = [system.arena.negate(uy), ux];
    let angle = system.value(angle);
    let resistance = Resistance::new(system, damping, friction);
    let first = joint.between[0].body();
    Element {
        label: system.label("s"),
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
            priority: table3::PRISMATIC,
            angle: Angle::Constant(angle),
            through: Torque::None,
        }),
    }
}
