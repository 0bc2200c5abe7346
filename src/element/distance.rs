//! Distance link (d): a massless rod, |r| = length. The reaction pushes its ends apart.

use super::{Coupling, Element, Origin, Port, System, Term};
use crate::expr::Expr;
use crate::mechanism::{Formula, JointId};

pub(super) fn element(system: &mut System, id: JointId, length: &Formula) -> Element {
    let joint = &system.mechanism.joints[id.0];
    let ends = joint.between.map(|place| system.t_node(place));
    Element {
        label: system.label("d"),
        name: joint.name.clone(),
        origin: Origin::Joint(id),
        translation: None,
        rotation: None,
        coupling: Some(Coupling {
            terms: vec![Term { factor: Expr::ONE, port: Port::Length(ends) }],
            offset: system.value(length),
        }),
    }
}
