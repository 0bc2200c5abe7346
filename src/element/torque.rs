//! External torque, torsion spring and actuator (T): body -> body; T = T(theta, omega, t).

use super::{Angle, CoordinateName, Element, Origin, RotationalRow, System, Torque, table3};
use crate::mechanism::{BodyId, Formula, LoadId};

pub(super) fn element(system: &mut System, id: LoadId, between: [Option<BodyId>; 2], law: Formula) -> Element {
    let name = &system.mechanism.loads[id.0].name;
    Element {
        label: system.label("T"),
        name: name.clone(),
        origin: Origin::Load(id),
        coupling: None,
        translation: None,
        rotation: Some(RotationalRow {
            ends: between.map(|body| system.r_node(body)),
            priority: table3::TORQUE,
            angle: Angle::Free(CoordinateName::new(name, ["angle", "omega", "alpha"])),
            through: Torque::Law(law),
        }),
    }
}
