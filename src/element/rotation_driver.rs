//! Rotation driver (Theta): theta = theta(t).

use super::{Angle, Element, Origin, RotationalRow, System, Torque, table3};
use crate::mechanism::{BodyId, DriverId, Motion};

pub(super) fn element(system: &mut System, id: DriverId, between: [Option<BodyId>; 2], motion: &Motion) -> Element {
    let signal = system.signal(id, motion);
    Element {
        label: system.label("Theta"),
        name: system.mechanism.drivers[id.0].name.clone(),
        origin: Origin::Driver(id),
        coupling: None,
        translation: None,
        rotation: Some(RotationalRow {
            ends: between.map(|body| system.r_node(body)),
            priority: table3::ROTATION_DRIVER,
            angle: Angle::Given(signal),
            through: Torque::None,
        }),
    }
}
