//! The translational row of what slides along an axis: r = s u with u fixed in the first body, F . u resists (Eqs 3, 4).

use super::{CoordinateName, Direction, Force, Known, Resistance, System, TranslationalRow, table2};
use crate::mechanism::{Formula, Friction, JointId};

pub(super) fn row(
    system: &mut System,
    id: JointId,
    axis: &[Formula; 2],
    damping: &Formula,
    friction: Option<&Friction>,
) -> TranslationalRow {
    let joint = &system.mechanism.joints[id.0];
    let [ux, uy] = system.values(axis);
    let normal = [system.arena.negate(uy), ux];
    let resistance = Resistance::new(system, damping, friction);
    let first = joint.between[0].body();
    TranslationalRow {
        ends: joint.between.map(|place| system.t_node(place)),
        priority: table2::PRISMATIC,
        known: Known::Zero,
        motion: vec![(Direction::Fixed(first, [ux, uy]), CoordinateName::new(&joint.name, ["s", "v", "a"]))],
        reaction: vec![Direction::Fixed(first, normal)],
        through: resistance.map_or(Force::None, Force::Resistance),
    }
}
