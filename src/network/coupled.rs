//! The terms of couplings as edges of the linear graphs: chords that no tree takes. A term between the nodes of its own element's
//! edge (a rolling disc) is that edge.

use super::graph::{ElementId, Node, RNode, Rotation, Translation};
use super::{Coupling, Curve, Element, Port, System};

/// A term of a coupling as an edge of one graph.
#[derive(Clone, Debug)]
pub struct CoupledEdge<D> {
    /// The element's label, with a letter if it has several edges in this graph.
    pub label: String,
    /// The coupling.
    pub element: ElementId,
    pub term: usize,
    /// From, to.
    pub ends: [Node<D>; 2],
}

impl System {
    /// The function that an element couples by, and between which bodies.
    pub fn curve(&self, id: ElementId) -> Option<([RNode; 2], Curve)> {
        self.element(id).coupling.as_ref().and_then(Coupling::curve)
    }

    /// The edges of couplings between points.
    pub fn coupled_points(&self) -> Vec<CoupledEdge<Translation>> {
        self.coupled_edges(|element, port| match port {
            Port::Along(ends, _)
            | Port::Length(ends)
            | Port::Heading(ends)
            | Port::Span(ends, _)
            | Port::Feature(ends, ..)
                if element.translation.is_none() =>
            {
                Some(ends)
            }
            _ => None,
        })
    }

    /// The edges of couplings between bodies.
    pub fn coupled_bodies(&self) -> Vec<CoupledEdge<Rotation>> {
        self.coupled_edges(|element, port| match port {
            Port::Angle(ends) | Port::Curve(ends, _) if element.rotation.is_none() => Some(ends),
            _ => None,
        })
    }

    fn coupled_edges<D>(&self, ends: impl Fn(&Element, Port) -> Option<[Node<D>; 2]>) -> Vec<CoupledEdge<D>> {
        let edges = self.elements.iter().enumerate().flat_map(|(index, element)| {
            let terms = element.coupling.iter().flat_map(|coupling| &coupling.terms).enumerate();
            let found: Vec<_> = terms.filter_map(|(term, data)| Some((term, ends(element, data.port)?))).collect();
            let several = found.len() > 1;
            let label = move |number: usize| {
                let letter = if several { letter(number) } else { String::new() };
                format!("{}{letter}", element.label)
            };
            let labels = (0..found.len()).map(label);
            let edge = move |(label, (term, ends))| CoupledEdge { label, element: ElementId(index), term, ends };
            labels.zip(found).map(edge).collect::<Vec<_>>()
        });
        edges.collect()
    }
}

/// a, b, ..., z, then aa, ab, ...
fn letter(number: usize) -> String {
    let last = char::from(b'a' + (number % 26) as u8);
    if number < 26 { last.to_string() } else { format!("{}{last}", letter(number / 26 - 1)) }
}
