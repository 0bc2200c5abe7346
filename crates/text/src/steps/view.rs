//! The record of a graph and its tree in letters.

use std::collections::BTreeSet;

use cotree::component::{Element, System};
use cotree::equations::{Edge, Record, Row};
use cotree::graph::{ElementId, LinearGraph, Node, Topology, Tree as SpanningTree};

use super::projection::Rows;
use crate::document::Piece;
use crate::name::Name;
use crate::tree::Tree;

#[derive(Clone, Debug)]
pub struct View<D> {
    /// Short names of the nodes, the datum's first.
    pub nodes: Vec<String>,
    pub edges: Vec<Edge<D>>,
    /// A row for each branch, which is its first edge.
    pub cutsets: Vec<Row>,
    /// A row for each chord, which is its first edge.
    pub circuits: Vec<Row>,
    topology: Topology<D>,
}

impl<D> View<D> {
    pub fn new(record: Record<D>, graph: &LinearGraph<D>, tree: &SpanningTree<D>, nodes: Vec<String>) -> Self {
        let Record { edges, cutsets, circuits } = record;
        View { nodes, edges, cutsets, circuits, topology: Topology::new(graph, tree) }
    }

    /// The branch or chord of a row.
    pub fn own(&self, row: &Row) -> &Edge<D> {
        &self.edges[row[0].0]
    }

    /// The labels of a row's edges, its own first.
    pub fn labels(&self, row: &Row) -> Vec<&str> {
        row.iter().map(|&(place, _)| self.edges[place].label.as_str()).collect()
    }

    /// The terms of a row's sum, which is zero.
    pub fn terms(&self, row: &[(usize, i8)], letter: impl Fn(&str) -> Tree) -> Vec<(bool, Tree)> {
        row.iter().map(|&(place, sign)| (sign < 0, letter(&self.edges[place].label))).collect()
    }

    /// The variable of a row's own edge by those of the others.
    pub fn by_others(&self, row: &Row, letter: impl Fn(&str) -> Tree) -> (Tree, Tree) {
        let others = self.terms(&row[1..], &letter).into_iter().map(|(minus, tree)| (!minus, tree));
        (letter(&self.own(row).label), Tree::sum(others.collect()))
    }

    /// Some rows as equations.
    pub fn balances<'r>(&self, rows: impl IntoIterator<Item = &'r Row>, letter: impl Fn(&str) -> Tree) -> Rows {
        rows.into_iter().map(|row| (Tree::sum(self.terms(row, &letter)), Tree::zero())).collect()
    }

    /// The nodes of an element; those of each term of a coupling behind the term's label.
    pub fn ends(&self, element: ElementId) -> Piece {
        let edges: Vec<&Edge<D>> = self.edges.iter().filter(|edge| edge.element == element).collect();
        let mut pieces = Vec::new();
        for edge in &edges {
            let [a, b] = edge.ends.map(|node| self.nodes[node.index()].as_str());
            let label = if edges.len() > 1 { format!("{}: ", edge.label) } else { String::new() };
            pieces.push(Piece::words(format!("{}{label}{a} ", if pieces.is_empty() { "" } else { ", " })));
            pieces.push(Piece::Math(arrow()));
            pieces.push(Piece::words(format!(" {b}")));
        }
        if pieces.is_empty() { Piece::words("-") } else { Piece::Row(pieces) }
    }

    /// The label of a term of a coupling.
    pub fn term(&self, element: ElementId, term: usize) -> Option<&str> {
        let own = self.edges.iter().find(|edge| (edge.element, edge.term) == (element, Some(term)));
        own.map(|edge| edge.label.as_str())
    }

    /// The circuit of the chord that an element is itself.
    pub fn circuit(&self, element: ElementId) -> Option<&Row> {
        let is_own = |edge: &Edge<D>| edge.element == element && edge.term.is_none();
        self.circuits.iter().find(|row| is_own(self.own(row)))
    }

    /// The circuits of chords that are elements of some kind.
    pub fn elements<'v>(
        &'v self,
        system: &'v System,
        is_one: impl Fn(&Element) -> bool + 'v,
    ) -> impl Iterator<Item = &'v Row> {
        let own = |row: &Row| Some(self.own(row)).filter(|chord| chord.term.is_none());
        self.circuits.iter().filter(move |row| own(row).is_some_and(|chord| is_one(system.element(chord.element))))
    }

    /// The across variables of the terms of couplings.
    pub fn of_terms(&self, letter: impl Fn(&str) -> Tree) -> impl Iterator<Item = (Tree, Tree)> {
        let terms = self.circuits.iter().filter(|row| self.own(row).term.is_some());
        terms.map(move |row| self.by_others(row, &letter))
    }

    /// The nodes along a circuit, from the first node of its chord to the second.
    pub fn walk(&self, circuit: &Row) -> Vec<usize> {
        let mut left: Vec<[usize; 2]> =
            circuit[1..].iter().map(|&(edge, _)| self.edges[edge].ends.map(Node::index)).collect();
        let mut walk = vec![self.own(circuit).ends[0].index()];
        while let Some(next) = left.iter().position(|ends| walk.last().is_some_and(|at| ends.contains(at))) {
            let [a, b] = left.swap_remove(next);
            walk.push(if walk.last() == Some(&a) { b } else { a });
        }
        walk
    }

    /// The nodes that a branch holds to the datum.
    pub fn beyond(&self, branch: &Edge<D>) -> BTreeSet<usize> {
        let mut nodes = BTreeSet::new();
        for (node, parent, own, _) in self.topology.outward() {
            if own == branch.element || nodes.contains(&parent.index()) {
                nodes.insert(node.index());
            }
        }
        nodes
    }

    /// The edges with both ends among some nodes.
    pub fn inside(&self, nodes: &BTreeSet<usize>) -> Vec<&str> {
        let both = |edge: &&Edge<D>| edge.ends.iter().all(|node| nodes.contains(&node.index()));
        self.edges.iter().filter(both).map(|edge| edge.label.as_str()).collect()
    }

    /// Is the product of all cutsets, found from the nodes, with all circuits zero?
    pub fn is_orthogonal(&self) -> bool {
        let product =
            |cut: &Row, circuit: &Row| -> i8 { circuit.iter().map(|&(edge, sign)| sign * sign_of(cut, edge)).sum() };
        self.circuits.iter().all(|circuit| self.cutsets.iter().all(|cut| product(cut, circuit) == 0))
    }
}

/// The sign of an edge in a row.
pub fn sign_of(row: &Row, edge: usize) -> i8 {
    row.iter().find(|(own, _)| *own == edge).map_or(0, |(_, sign)| *sign)
}

/// From a node to a node.
fn arrow() -> Tree {
    Tree::Name(Name::word("->"))
}
