//! What the trees make of both graphs, as data to be printed: which edges the cutset of each branch cuts, and which the circuit of each chord
//! passes. The cutsets come from the transformation that gives \[M\] and {Q} their forces, with a load of one in each chord.

use std::collections::{BTreeSet, HashMap};

use super::dynamics::chord_transformation;
use super::form::LinearForm;
use super::{Equations, couplings};
use crate::expr::{Arena, Expr, ExprNode as Operation, Symbol};
use crate::model::BodyId;
use crate::network::{
    CoupledEdge, Element, ElementId, LinearGraph, Node, OutwardNode, Port, Rotation, System, Topology, Translation,
    TranslationalRow, Tree,
};

/// An edge of a graph: an element's own, or a term of a coupling, which is a chord in every tree.
#[derive(Clone, Debug)]
pub struct Edge<D> {
    pub label: String,
    pub element: ElementId,
    pub term: Option<usize>,
    /// From, to.
    pub ends: [Node<D>; 2],
    /// The body that its displacement turns with, whose torque has its r x F (Eq. 6).
    pub carrier: Option<BodyId>,
}

/// Edges by their places, with their signs. The first is the branch or chord to which the row belongs, with +1.
pub type EdgeRow = Vec<(usize, i8)>;

/// One graph with its tree.
#[derive(Clone, Debug)]
pub struct GraphRecord<D> {
    /// Elements in their order, then the terms of couplings.
    pub edges: Vec<Edge<D>>,
    /// \[1 | A\] (Eq. 8), a row for each branch: the sum of the through variables is zero.
    pub cutsets: Vec<EdgeRow>,
    /// \[B | 1\] (Eq. 12), a row for each chord: the sum of the across variables is zero.
    pub circuits: Vec<EdgeRow>,
    topology: Topology<D>,
}

impl Equations {
    /// What Steps 1 and 2 take from the graphs.
    pub fn record(&self) -> (GraphRecord<Translation>, GraphRecord<Rotation>) {
        let (system, trees, (translation, rotation)) = (&self.system, &self.trees, self.topologies());
        (
            GraphRecord::new(system, (&system.translation, &trees.translation, translation), system.coupled_points()),
            GraphRecord::new(system, (&system.rotation, &trees.rotation, rotation), system.coupled_bodies()),
        )
    }
}

impl<D> GraphRecord<D> {
    fn new(
        system: &System,
        (graph, tree, topology): (&LinearGraph<D>, &Tree<D>, Topology<D>),
        terms: Vec<CoupledEdge<D>>,
    ) -> Self {
        let edge = |label: &str, element, term, ends| {
            let (label, carrier) = (label.to_owned(), carrier(system.element(element), term));
            Edge { label, element, term, ends, carrier }
        };
        let of_elements = graph.edges().map(|(id, ends)| edge(&system.element(id).label, id, None, ends));
        let mut edges: Vec<Edge<D>> = of_elements.collect();
        let places: HashMap<ElementId, usize> = edges.iter().map(|edge| edge.element).zip(0..).collect();
        let mut chords: Vec<usize> = tree.chords.iter().map(|chord| places[chord]).collect();
        chords.extend(edges.len()..edges.len() + terms.len());
        edges.extend(terms.iter().map(|term| edge(&term.label, term.element, Some(term.term), term.ends)));
        let circuit = |&chord: &usize| {
            let branches = topology.circuit_between(edges[chord].ends).into_iter();
            std::iter::once((chord, 1)).chain(branches.map(|(branch, sign)| (places[&branch], sign))).collect()
        };
        let circuits = chords.iter().map(circuit).collect();
        let cutsets = cutsets((tree, &topology), &places, &edges, &chords);
        GraphRecord { edges, cutsets, circuits, topology }
    }

    /// The branch or chord of a row.
    pub fn edge_of(&self, row: &EdgeRow) -> &Edge<D> {
        &self.edges[row[0].0]
    }

    /// The cutset of a branch.
    pub fn cutset(&self, branch: ElementId) -> Option<&EdgeRow> {
        self.cutsets.iter().find(|row| self.edge_of(row).element == branch)
    }

    /// The circuit of the chord that an element is itself.
    pub fn circuit(&self, chord: ElementId) -> Option<&EdgeRow> {
        let is_own = |edge: &Edge<D>| edge.element == chord && edge.term.is_none();
        self.circuits.iter().find(|row| is_own(self.edge_of(row)))
    }

    /// The nodes that a branch holds to the datum.
    pub fn beyond(&self, branch: ElementId) -> BTreeSet<usize> {
        let mut nodes = BTreeSet::new();
        for OutwardNode { node, parent, branch: edge, .. } in self.topology.outward() {
            if edge == branch || nodes.contains(&parent.index()) {
                nodes.insert(node.index());
            }
        }
        nodes
    }
}

/// The branches' through variables for a load of one in each chord, which has the load's place among the edges as its key.
fn cutsets<D>(
    (tree, topology): (&Tree<D>, &Topology<D>),
    places: &HashMap<ElementId, usize>,
    edges: &[Edge<D>],
    chords: &[usize],
) -> Vec<EdgeRow> {
    let arena = &mut Arena::default();
    let (mut through, mut coupled) = (HashMap::new(), HashMap::new());
    for &chord in chords {
        let (edge, load) = (&edges[chord], arena.symbol(Symbol::Reaction(chord)));
        let load = LinearForm::term(arena, load, &Expr::ONE);
        match edge.term {
            None => drop(through.insert(edge.element, load)),
            Some(_) => couplings::add(arena, &mut coupled, edge.ends.map(Node::index), &load),
        }
    }
    chord_transformation(arena, tree, topology, &coupled, &mut through);
    let row = |branch: &ElementId| {
        let others = through[branch].terms().filter_map(|(load, &factor)| match arena.node(load) {
            Operation::Symbol(Symbol::Reaction(chord)) => Some((chord, if factor == Expr::ONE { -1 } else { 1 })),
            _ => None,
        });
        std::iter::once((places[branch], 1)).chain(others).collect()
    };
    tree.branches.iter().map(row).collect()
}

/// The body that an edge of the translational graph turns with.
fn carrier(element: &Element, term: Option<usize>) -> Option<BodyId> {
    let Some(term) = term else { return element.translation.as_ref().and_then(TranslationalRow::carrier) };
    match element.coupling.as_ref()?.terms.get(term)?.port {
        Port::Along(_, direction) => direction.carrier(),
        Port::Feature(_, body, _) => body,
        Port::Angle(_) | Port::Length(_) | Port::Heading(_) | Port::Span(..) | Port::Curve(..) => None,
    }
}
