//! Spring, damper, actuator (F): point -> point, a force along the line through them.

use super::force::free_motion;
use super::{Element, Force, Known, Origin, System, TranslationalRow, table2};
use crate::mechanism::{Dimension, Formula, LoadId, Place, SpringLaw};

/// The letter of a spring: on a line those of the paper's Fig. 5, k for springs and d for dampers.
pub(super) fn letter(law: &SpringLaw, dimension: Dimension) -> &'static str {
    let is_zero = |formula: &Formula| matches!(formula, Formula::Number(0.0));
    match dimension {
        Dimension::Two => "F",
        Dimension::One if is_zero(&law.stiffness) && is_zero(&law.cubic) => "d",
        Dimension::One => "k",
    }
}

/// `force` pushes the points apart. In one dimension it acts on the second point along +x.
pub(super) fn element(system: &mut System, id: LoadId, between: [Place; 2], force: Formula, letter: &str) -> Element {
    let name = &system.mechanism.loads[id.0].name;
    let plane = system.mechanism.dimension == Dimension::Two;
    let through = if plane { Force::Line(force) } else { Force::World([force, Formula::Number(0.0)]) };
    Element {
        label: system.label(letter),
        name: name.clone(),
        origin: Origin::Load(id),
        coupling: None,
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
