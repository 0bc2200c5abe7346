//! Spring, damper, actuator (F): point -> point, a force along the line through them.

use super::force::free_motion;
use super::{Element, Force, Known, Origin, System, TranslationalRow, table2};
use crate::mechanism::{BinaryOperator, Dimension, Formula, LoadId, Owner, Place, Quantity, Variable};

/// `force` pushes the points apart. In one dimension it acts on the second point along +x.
pub(super) fn element(system: &mut System, id: LoadId, between: [Place; 2], force: Formula) -> Element {
    let name = &system.mechanism.loads[id.0].name;
    let plane = system.mechanism.dimension == Dimension::Two;
    let through = if plane { Force::Line(force) } else { Force::World([force, Formula::Number(0.0)]) };
    Element {
        label: system.label("F"),
        name: name.clone(),
        origin: Origin::Load(id),
        translation: Some(TranslationalRow {
            ends: between.map(|place| system.t_node(place)),
            priority: table2::FORCE,
            known: Known::Zero,
            motion: free_motion(name, system.mechanism.dimension),
            reaction: Vec::new(),
            through,
        }),
        rotation: None,
    }
}

/// The linear law -k (x - x0) - c v of a spring (or torsion spring), which pushes apart (or turns on) its second end.
pub(super) fn linear_law(
    id: LoadId,
    [x, v]: [Quantity; 2],
    stiffness: &Formula,
    free: &Formula,
    damping: &Formula,
) -> Formula {
    let own = |quantity| Formula::Variable(Variable { owner: Owner::Load(id), quantity });
    let binary = |op, a, b| Formula::Binary(op, Box::new([a, b]));
    let stretch = binary(BinaryOperator::Subtract, own(x), free.clone());
    let spring = binary(BinaryOperator::Multiply, stiffness.clone(), stretch);
    let damper = binary(BinaryOperator::Multiply, damping.clone(), own(v));
    Formula::Negate(Box::new(binary(BinaryOperator::Add, spring, damper)))
}
