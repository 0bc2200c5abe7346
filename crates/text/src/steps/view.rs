//! A graph and its tree with the letters of their edges.

use std::collections::BTreeSet;

use cotree::equations::{Edge, EdgeRow, GraphRecord};
use cotree::network::{Element, ElementId, Node, System};

use super::projection::Rows;
use crate::document::Piece;
use crate::name::Name;
use crate::tree::FormulaTree;

#[derive(Clone, Debug)]
pub struct GraphView<D> {
    /// Short names of the nodes, the datum's first.
    pub nodes: Vec<String>,
    pub record: GraphRecord<D>,
}

impl<D> GraphView<D> {
    /// The labels of a row's edges, its own first.
    pub fn labels(&self, row: &EdgeRow) -> Vec<&str> {
        row.iter().map(|&(place, _)| self.record.edges[place].label.as_str()).collect()
    }

    /// The terms of a row's sum, which is zero.
    pub fn terms(&self, row: &[(usize, i8)], letter: impl Fn(&str) -> FormulaTree) -> Vec<(bool, FormulaTree)> {
        row.iter().map(|&(place, sign)| (sign < 0, letter(&self.record.edges[place].label))).collect()
    }

    /// The variable of a row's own edge by those of the others.
    pub fn by_others(&self, row: &EdgeRow, letter: impl Fn(&str) -> FormulaTree) -> (FormulaTree, FormulaTree) {
        let others = self.terms(&row[1..], &letter).into_iter().map(|(minus, tree)| (!minus, tree));
        (letter(&self.record.edge_of(row).label), FormulaTree::sum(others.collect()))
    }

    /// Some rows as equations.
    pub fn balances<'r>(
        &self,
        rows: impl IntoIterator<Item = &'r EdgeRow>,
        letter: impl Fn(&str) -> FormulaTree,
    ) -> Rows {
        rows.into_iter().map(|row| (FormulaTree::sum(self.terms(row, &letter)), FormulaTree::zero())).collect()
    }

    /// The nodes of an element; those of each term of a coupling behind the term's label.
    pub fn ends(&self, element: ElementId) -> Piece {
        let edges: Vec<&Edge<D>> = self.record.edges.iter().filter(|edge| edge.element == element).collect();
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
        let found = self.record.edges.iter().find(|edge| (edge.element, edge.term) == (element, Some(term)));
        found.map(|edge| edge.label.as_str())
    }

    /// The circuits of chords that are elements of some kind.
    pub fn elements<'v>(
        &'v self,
        system: &'v System,
        is_one: impl Fn(&Element) -> bool + 'v,
    ) -> impl Iterator<Item = &'v EdgeRow> {
        let chord_of = |row: &EdgeRow| Some(self.record.edge_of(row)).filter(|chord| chord.term.is_none());
        self.record
            .circuits
            .iter()
            .filter(move |row| chord_of(row).is_some_and(|chord| is_one(system.element(chord.element))))
    }

    /// The across variables of the terms of couplings.
    pub fn of_terms(&self, letter: impl Fn(&str) -> FormulaTree) -> impl Iterator<Item = (FormulaTree, FormulaTree)> {
        let terms = self.record.circuits.iter().filter(|row| self.record.edge_of(row).term.is_some());
        terms.map(move |row| self.by_others(row, &letter))
    }

    /// The nodes along a circuit, from the first node of its chord to the second.
    pub fn walk(&self, circuit: &EdgeRow) -> Vec<usize> {
        let mut left: Vec<[usize; 2]> =
            circuit[1..].iter().map(|&(edge, _)| self.record.edges[edge].ends.map(Node::index)).collect();
        let mut walk = vec![self.record.edge_of(circuit).ends[0].index()];
        while let Some(next) = left.iter().position(|ends| walk.last().is_some_and(|at| ends.contains(at))) {
            let [a, b] = left.swap_remove(next);
            walk.push(if walk.last() == Some(&a) { b } else { a });
        }
        walk
    }

    /// The edges with both ends among some nodes.
    pub fn inside(&self, nodes: &BTreeSet<usize>) -> Vec<&str> {
        let both = |edge: &&Edge<D>| edge.ends.iter().all(|node| nodes.contains(&node.index()));
        self.record.edges.iter().filter(both).map(|edge| edge.label.as_str()).collect()
    }

    /// Is the product of all cutsets, found from the nodes, with all circuits zero?
    pub fn is_orthogonal(&self) -> bool {
        let product = |cut: &EdgeRow, circuit: &EdgeRow| -> i8 {
            circuit.iter().map(|&(edge, sign)| sign * sign_of(cut, edge)).sum()
        };
        self.record.circuits.iter().all(|circuit| self.record.cutsets.iter().all(|cut| product(cut, circuit) == 0))
    }
}

/// The sign of an edge in a row.
pub fn sign_of(row: &EdgeRow, edge: usize) -> i8 {
    row.iter().find(|(other, _)| *other == edge).map_or(0, |(_, sign)| *sign)
}

/// From a node to a node.
fn arrow() -> FormulaTree {
    FormulaTree::Name(Name::word("->"))
}
