//! External force (F): datum -> point; F = F(r, v, t).

use super::{CoordinateName, Direction, Element, Force, Known, Origin, System, TranslationalRow, table2};
use crate::graph::TNode;
use crate::mechanism::{Dimension, Formula, LoadId, Place};

pub(super) fn element(system: &mut System, id: LoadId, on: Place, vector: &[Formula; 2], in_body: bool) -> Element {
    let name = &system.mechanism.loads[id.0].name;
    let through = match on.body() {
        Some(body) if in_body => Force::InBody(body, vector.clone()),
        _ => Force::World(vector.clone()),
    };
    Element {
        label: system.label("F"),
        name: name.clone(),
        origin: Origin::Load(id),
        coupling: None,
        translation: Some(TranslationalRow {
            ends: [TNode::DATUM, system.t_node(on)],
            priority: table2::FORCE,
            known: Known::Zero,
            motion: free_motion(name, system.mechanism.dimension),
            reaction: Vec::new(),
            through,
        }),
        rotation: None,
    }
}

/// A force holds nothing: as a branch, its displacement is a pair of coordinates (one in one dimension).
pub(super) fn free_motion(name: &str, dimension: Dimension) -> Vec<(Direction, CoordinateName)> {
    match dimension {
        Dimension::One => vec![(Direction::X, CoordinateName::new(name, ["length", "rate", "acceleration"]))],
        Dimension::Two => vec![
            (Direction::X, CoordinateName::new(name, ["x", "vx", "ax"])),
            (Direction::Y, CoordinateName::new(name, ["y", "vy", "ay"])),
        ],
    }
}
