//! Position driver (R): r = r(t), from the ground to a point.

use super::{Direction, Element, Force, Known, Origin, System, TranslationalRow, table2};
use crate::graph::TNode;
use crate::mechanism::{Dimension, DriverId, Formula, Motion, Place};

pub(super) fn element(system: &mut System, id: DriverId, on: Place, position: &[Formula; 2]) -> Element {
    let signals = position.each_ref().map(|component| system.signal(id, &Motion::Given(component.clone())));
    let plane = system.mechanism.dimension == Dimension::Two;
    Element {
        label: system.label("R"),
        name: system.mechanism.drivers[id.0].name.clone(),
        origin: Origin::Driver(id),
        coupling: None,
        translation: Some(TranslationalRow {
            ends: [TNode::DATUM, system.t_node(on)],
            priority: table2::POSITION_DRIVER,
            known: Known::Given(signals),
            motion: Vec::new(),
            reaction: if plane { vec![Direction::X, Direction::Y] } else { vec![Direction::X] },
            through: Force::None,
        }),
        rotation: None,
    }
}
