//! Gear pair (g): theta_b = ratio theta_a + angle, both angles relative to the carrier. The reaction is the torque on b; a gets
//! -ratio times as much and the carrier the rest.

use super::{Coupling, Element, Origin, Port, System, Term};
use crate::expr::Expr;
use crate::mechanism::{BodyId, Formula, JointId};

pub(super) fn element(
    system: &mut System,
    id: JointId,
    carrier: Option<BodyId>,
    ratio: &Formula,
    angle: &Formula,
) -> Element {
    let joint = &system.mechanism.joints[id.0];
    let carrier = system.r_node(carrier);
    let [first, second] = joint.between.map(|place| system.r_node(place.body()));
    let ratio = system.value(ratio);
    let minus_ratio = system.arena.negate(ratio);
    Element {
        label: system.label("g"),
        name: joint.name.clone(),
        origin: Origin::Joint(id),
        translation: None,
        rotation: None,
        coupling: Some(Coupling {
            terms: vec![
                Term { factor: Expr::ONE, port: Port::Angle([carrier, second]) },
                Term { factor: minus_ratio, port: Port::Angle([carrier, first]) },
            ],
            offset: system.value(angle),
        }),
    }
}
