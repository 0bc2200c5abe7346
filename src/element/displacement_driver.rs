//! Displacement driver: prescribes s(t) of a prismatic joint. It lies beside the joint, holds the direction of the axis, and
//! as a branch makes the whole displacement r = s(t) u known (the joint's own loop equation is then empty).

use super::{Direction, Element, Force, Known, Origin, System, TranslationalRow, table2};
use crate::mechanism::{DriverId, Formula, JointId, Motion};

pub(super) fn element(
    system: &mut System,
    id: DriverId,
    joint: JointId,
    axis: &[Formula; 2],
    motion: &Motion,
) -> Element {
    let signal = system.signal(id, motion);
    let between = system.mechanism.joints[joint.0].between;
    let axis = system.values(axis);
    let first = between[0].body();
    Element {
        label: system.label("R"),
        name: system.mechanism.drivers[id.0].name.clone(),
        origin: Origin::Driver(id),
        coupling: None,
        translation: Some(TranslationalRow {
            ends: between.map(|place| system.t_node(place)),
            priority: table2::POSITION_DRIVER,
            known: Known::Along(first, axis, signal),
            motion: Vec::new(),
            reaction: vec![Direction::Fixed(first, axis)],
            through: Force::None,
        }),
        rotation: None,
    }
}
