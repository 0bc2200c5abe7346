//! A graph with its tree, the edges of couplings among the chords.

use crate::component::{CoupledEdge, System};
use crate::graph::{ElementId, LinearGraph, Node, Topology, Tree};

/// A row of a cutset or circuit matrix: labels of edges with their signs.
pub type Row = Vec<(String, i8)>;

#[derive(Clone, Debug)]
pub struct Edge<D> {
    pub label: String,
    pub element: ElementId,
    pub ends: [Node<D>; 2],
    pub is_term: bool,
}

#[derive(Clone, Debug)]
pub struct View<D> {
    /// The user's names of the nodes, the datum's first.
    pub nodes: Vec<String>,
    pub branches: Vec<Edge<D>>,
    pub chords: Vec<Edge<D>>,
    topology: Topology<D>,
}

impl<D> View<D> {
    pub fn new(system: &System, graph: &LinearGraph<D>, tree: &Tree<D>, coupled: Vec<CoupledEdge<D>>) -> Self {
        let topology = Topology::new(graph, tree);
        let edge = |&element: &ElementId| Edge {
            label: system.element(element).label.clone(),
            element,
            ends: topology.ends(element),
            is_term: false,
        };
        let branches = tree.branches.iter().map(edge).collect();
        let own: Vec<Edge<D>> = tree.chords.iter().map(edge).collect();
        let terms = coupled.into_iter().map(|own| Edge {
            label: own.label,
            element: own.element,
            ends: own.ends,
            is_term: true,
        });
        let chords = own.into_iter().chain(terms).collect();
        View { nodes: graph.node_names().map(str::to_owned).collect(), branches, chords, topology }
    }

    /// Elements in their order, then the terms of couplings.
    pub fn edges(&self) -> Vec<&Edge<D>> {
        let mut edges: Vec<&Edge<D>> = self.branches.iter().chain(&self.chords).collect();
        edges.sort_by_key(|edge| (edge.is_term, edge.element));
        edges
    }

    /// The row of \[B\] of a chord.
    pub fn circuit(&self, chord: &Edge<D>) -> Row {
        let row = self.topology.circuit_between(chord.ends);
        let label = |element: ElementId| self.branches.iter().find(|branch| branch.element == element);
        row.into_iter().filter_map(|(element, sign)| Some((label(element)?.label.clone(), sign))).collect()
    }

    /// The path along branches that a chord's displacement equals: minus its circuit.
    pub fn path(&self, chord: &Edge<D>) -> Row {
        self.circuit(chord).into_iter().map(|(label, sign)| (label, -sign)).collect()
    }

    /// The rows of \[A\], one for each branch.
    pub fn cutsets(&self) -> Vec<Row> {
        let circuits: Vec<Row> = self.chords.iter().map(|chord| self.circuit(chord)).collect();
        let sign = |row: &Row, branch: &Edge<D>| row.iter().find(|(label, _)| *label == branch.label).map(|(_, s)| -s);
        let row = |branch: &Edge<D>| {
            let signs = self.chords.iter().zip(&circuits);
            signs.filter_map(|(chord, circuit)| Some((chord.label.clone(), sign(circuit, branch)?))).collect()
        };
        self.branches.iter().map(row).collect()
    }
}
