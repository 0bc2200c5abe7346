//! Relations that the joints of a mechanism imply without saying so: a bar that two parallel guides of its own length keep level cannot turn, though no gradient of a loop
//! equation forbids it. Each is a coupling between the ground and the bodies concerned, a chord in every tree, and so an equation of its own.

use super::graph::{RNode, TNode};
use super::{Coupling, CouplingTerm, Direction, Port, System};
use crate::diagnostic::Span;
use crate::model::{BodyId, Mechanism, Place};

/// What of a body, in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImpliedMeasure {
    Angle,
    X,
    Y,
}

/// sum of factor x (what of a body) = offset.
#[derive(Clone, Debug)]
pub struct Implied {
    /// In the names of the scene, such as `beam.angle` or `upper.angle - lower.angle`.
    pub name: String,
    /// At least one.
    pub terms: Vec<(f64, BodyId, ImpliedMeasure)>,
    /// SI.
    pub offset: f64,
}

impl Implied {
    pub(crate) fn coupling(&self, system: &mut System) -> Coupling {
        let term = |&(factor, body, measured): &(f64, BodyId, ImpliedMeasure)| {
            let points = [TNode::DATUM, system.t_node(Place::Centre(body))];
            let port = match measured {
                ImpliedMeasure::Angle => Port::Angle([RNode::DATUM, system.r_node(Some(body))]),
                ImpliedMeasure::X => Port::Along(points, Direction::X),
                ImpliedMeasure::Y => Port::Along(points, Direction::Y),
            };
            (factor, port)
        };
        let terms: Vec<(f64, Port)> = self.terms.iter().map(term).collect();
        let mut constant = |value: f64| system.arena.constant(value);
        let offset = constant(self.offset);
        Coupling {
            terms: terms.into_iter().map(|(factor, port)| CouplingTerm { factor: constant(factor), port }).collect(),
            offset,
        }
    }

    /// Where its first body is in the scene.
    pub(crate) fn span(&self, mechanism: &Mechanism) -> Span {
        self.terms.first().map_or_else(Span::default, |(_, body, _)| mechanism.bodies[body.0].span)
    }
}
