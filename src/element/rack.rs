//! Rack and pinion (k): s = radius theta + displacement, with s along an axis fixed in the carrier and theta the pinion's angle
//! relative to the carrier. The reaction is the force on the rack; the pinion gets -radius times as much torque.

use super::{Coupling, Direction, Element, Origin, Port, System, Term};
use crate::expr::Expr;
use crate::mechanism::{Formula, JointId, Place};

pub(super) fn element(
    system: &mut System,
    id: JointId,
    carrier: Place,
    axis: &[Formula; 2],
    radius: &Formula,
    displacement: &Formula,
) -> Element {
    let joint = &system.mechanism.joints[id.0];
    let [pinion, rack] = joint.between;
    let along = Direction::Fixed(carrier.body(), system.values(axis));
    let slide = [carrier, rack].map(|place| system.t_node(place));
    let turn = [carrier, pinion].map(|place| system.r_node(place.body()));
    let radius = system.value(radius);
    let minus_radius = system.arena.negate(radius);
    Element {
        label: system.label("k"),
        name: joint.name.clone(),
        origin: Origin::Joint(id),
        translation: None,
        rotation: None,
        coupling: Some(Coupling {
            terms: vec![
                Term { factor: Expr::ONE, port: Port::Along(slide, along) },
                Term { factor: minus_radius, port: Port::Angle(turn) },
            ],
            offset: system.value(displacement),
        }),
    }
}
