//! A graph with its tree, the edges of couplings among the chords.

use std::collections::{BTreeSet, HashMap};

use cotree::component::{CoupledEdge, System};
use cotree::graph::{ElementId, LinearGraph, Node, Topology, Tree as SpanningTree};

use crate::document::Piece;
use crate::name::Name;
use crate::tree::Tree;

/// A row of a cutset or circuit matrix: labels of edges with their signs.
pub type TopologyRow = Vec<(String, i8)>;

#[derive(Clone, Debug)]
pub struct Edge<D> {
    pub label: String,
    pub element: ElementId,
    pub ends: [Node<D>; 2],
    pub is_term: bool,
}

#[derive(Clone, Debug)]
pub struct View<D> {
    /// Short names of the nodes, the datum's first.
    pub nodes: Vec<String>,
    pub branches: Vec<Edge<D>>,
    pub chords: Vec<Edge<D>>,
    topology: Topology<D>,
}

impl<D> View<D> {
    pub fn new(
        system: &System,
        graph: &LinearGraph<D>,
        tree: &SpanningTree<D>,
        coupled: Vec<CoupledEdge<D>>,
        nodes: Vec<String>,
    ) -> Self {
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
        View { nodes, branches, chords, topology }
    }

    /// Elements in their order, then the terms of couplings.
    pub fn edges(&self) -> Vec<&Edge<D>> {
        let mut edges: Vec<&Edge<D>> = self.branches.iter().chain(&self.chords).collect();
        edges.sort_by_key(|edge| (edge.is_term, edge.element));
        edges
    }

    /// The nodes of an element; those of each term of a coupling behind the term's label.
    pub fn ends(&self, element: ElementId) -> Piece {
        let edges: Vec<&Edge<D>> = self.edges().into_iter().filter(|edge| edge.element == element).collect();
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

    /// The chord that an element is itself.
    pub fn chord(&self, element: ElementId) -> Option<&Edge<D>> {
        self.chords.iter().find(|chord| !chord.is_term && chord.element == element)
    }

    /// The row of \[B\] of a chord.
    pub fn circuit(&self, chord: &Edge<D>) -> TopologyRow {
        let row = self.topology.circuit_between(chord.ends);
        let label = |element: ElementId| self.branches.iter().find(|branch| branch.element == element);
        row.into_iter().filter_map(|(element, sign)| Some((label(element)?.label.clone(), sign))).collect()
    }

    /// The path along branches that a chord's displacement equals: minus its circuit.
    pub fn path(&self, chord: &Edge<D>) -> TopologyRow {
        self.circuit(chord).into_iter().map(|(label, sign)| (label, -sign)).collect()
    }

    /// The nodes along the tree from the first node of a chord to its second.
    pub fn walk(&self, chord: &Edge<D>) -> Vec<usize> {
        let edges = self.topology.outward().map(|(node, parent, ..)| (node.index(), parent.index()));
        let before: HashMap<usize, usize> = edges.collect();
        let [mut walk, mut back] = chord.ends.map(|end| {
            let nodes = std::iter::successors(Some(end.index()), |node| before.get(node).copied());
            nodes.collect::<Vec<usize>>()
        });
        // Both lead to the datum: what they share beyond the node where they meet is no part of the walk.
        while let ([.., a, _], [.., b, _]) = (walk.as_slice(), back.as_slice())
            && a == b
        {
            walk.pop();
            back.pop();
        }
        walk.extend(back.into_iter().rev().skip(1));
        walk
    }

    /// The rows of \[A\], one for each branch.
    pub fn cutsets(&self) -> Vec<TopologyRow> {
        let circuits: Vec<TopologyRow> = self.chords.iter().map(|chord| self.circuit(chord)).collect();
        let sign =
            |row: &TopologyRow, branch: &Edge<D>| row.iter().find(|(label, _)| *label == branch.label).map(|(_, s)| -s);
        let row = |branch: &Edge<D>| {
            let signs = self.chords.iter().zip(&circuits);
            signs.filter_map(|(chord, circuit)| Some((chord.label.clone(), sign(circuit, branch)?))).collect()
        };
        self.branches.iter().map(row).collect()
    }

    /// The nodes that a branch holds to the datum, and +1 if it points towards them.
    pub fn beyond(&self, branch: &Edge<D>) -> (BTreeSet<usize>, i8) {
        let (mut nodes, mut towards) = (BTreeSet::new(), 1);
        for (node, parent, own, sign) in self.topology.outward() {
            if own == branch.element {
                towards = sign;
            }
            if own == branch.element || nodes.contains(&parent.index()) {
                nodes.insert(node.index());
            }
        }
        (nodes, towards)
    }

    /// The edges between the nodes beyond a branch and the rest, with their signs; the branch has +1. Found from the nodes, not from circuits.
    pub fn cut(&self, branch: &Edge<D>) -> TopologyRow {
        let (inside, towards) = self.beyond(branch);
        let sign = |edge: &Edge<D>| {
            let [from, to] = edge.ends.map(|node| i8::from(inside.contains(&node.index())));
            towards * (to - from)
        };
        let signs = self.edges().into_iter().map(|edge| (edge.label.clone(), sign(edge)));
        signs.filter(|(_, sign)| *sign != 0).collect()
    }

    /// The edges with both ends among some nodes.
    pub fn inside(&self, nodes: &BTreeSet<usize>) -> Vec<&str> {
        let both = |edge: &&Edge<D>| edge.ends.iter().all(|node| nodes.contains(&node.index()));
        self.edges().into_iter().filter(both).map(|edge| edge.label.as_str()).collect()
    }

    /// Is the product of all cutsets, found from the nodes, with all circuits zero?
    pub fn is_orthogonal(&self) -> bool {
        let cuts: Vec<TopologyRow> = self.branches.iter().map(|branch| self.cut(branch)).collect();
        self.chords.iter().all(|chord| {
            let circuit: Vec<(String, i8)> =
                self.circuit(chord).into_iter().chain([(chord.label.clone(), 1)]).collect();
            cuts.iter().all(|cut| {
                let product = circuit.iter().map(|(label, sign)| {
                    sign * cut.iter().find(|(own, _)| own == label).map_or(0, |(_, other)| *other)
                });
                product.sum::<i8>() == 0
            })
        })
    }
}

/// From a node to a node.
fn arrow() -> Tree {
    Tree::Name(Name::word("->"))
}
