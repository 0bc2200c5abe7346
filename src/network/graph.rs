//! Linear graphs, their spanning trees, and the exact integer matrices of cutsets and circuits (McPhee 1998, section 2).

use std::marker::PhantomData;

use petgraph::graph::{DiGraph, EdgeIndex, NodeIndex};
use petgraph::unionfind::UnionFind;

/// The translational graph: nodes are points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Translation;

/// The rotational graph: nodes are bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rotation;

/// Index of an element; an element is an edge in one or both graphs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ElementId(pub usize);

/// Node of the graph of kind `D`. A node of one graph cannot be used in the other.
#[derive(Debug)]
pub struct Node<D>(usize, PhantomData<D>);

pub type TNode = Node<Translation>;
pub type RNode = Node<Rotation>;

impl<D> Node<D> {
    pub const DATUM: Self = Node(0, PhantomData);

    /// Its place among the nodes; the datum is 0.
    pub fn index(self) -> usize {
        self.0
    }
}

impl<D> Clone for Node<D> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<D> Copy for Node<D> {}
impl<D> PartialEq for Node<D> {
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}
impl<D> Eq for Node<D> {}

/// A directed graph: an edge for each element, from a to b; its across variable is that of b minus that of a.
#[derive(Clone, Debug)]
pub struct LinearGraph<D> {
    graph: DiGraph<String, ElementId>,
    kind: PhantomData<D>,
}

impl<D> Default for LinearGraph<D> {
    fn default() -> Self {
        let mut graph = DiGraph::new();
        graph.add_node("ground".to_string());
        LinearGraph { graph, kind: PhantomData }
    }
}

impl<D> LinearGraph<D> {
    pub fn add_node(&mut self, name: impl Into<String>) -> Node<D> {
        Node(self.graph.add_node(name.into()).index(), PhantomData)
    }

    pub fn add_edge(&mut self, element: ElementId, [a, b]: [Node<D>; 2]) {
        self.graph.add_edge(NodeIndex::new(a.0), NodeIndex::new(b.0), element);
    }

    pub fn nodes(&self) -> usize {
        self.graph.node_count()
    }

    pub fn node_name(&self, node: Node<D>) -> &str {
        &self.graph[NodeIndex::new(node.0)]
    }

    /// The user's names of all nodes, the datum's first.
    pub fn node_names(&self) -> impl Iterator<Item = &str> {
        self.graph.node_weights().map(String::as_str)
    }

    /// The elements and their nodes, in the order in which they were added.
    pub fn edges(&self) -> impl Iterator<Item = (ElementId, [Node<D>; 2])> + '_ {
        self.graph.edge_indices().map(|edge| (self.graph[edge], self.ends(edge)))
    }

    /// Kruskal's algorithm: accepts the edges in the given order if they connect two components.
    pub fn tree(&self, order: impl IntoIterator<Item = ElementId>) -> Tree<D> {
        let ends: std::collections::HashMap<ElementId, [Node<D>; 2]> = self.edges().collect();
        let mut classes = UnionFind::<usize>::new(self.nodes());
        let branches = order
            .into_iter()
            .filter(|element| ends.get(element).is_some_and(|[a, b]| classes.union(a.0, b.0)))
            .collect();
        self.tree_of(branches)
    }

    /// The tree with exactly these branches, whether they span or not.
    pub fn tree_of(&self, branches: Vec<ElementId>) -> Tree<D> {
        let chosen: std::collections::HashSet<ElementId> = branches.iter().copied().collect();
        let chords = self.edges().map(|(element, _)| element).filter(|element| !chosen.contains(element)).collect();
        Tree { branches, chords, kind: PhantomData }
    }

    /// Names of the nodes that the branches do not connect to the datum.
    pub fn unreached(&self, branches: &[ElementId]) -> Vec<&str> {
        let chosen: std::collections::HashSet<ElementId> = branches.iter().copied().collect();
        let mut classes = UnionFind::<usize>::new(self.nodes());
        for (element, [a, b]) in self.edges() {
            if chosen.contains(&element) {
                classes.union(a.0, b.0);
            }
        }
        (1..self.nodes()).filter(|&n| !classes.equiv(0, n)).map(|n| self.node_name(Node(n, PhantomData))).collect()
    }

    fn ends(&self, edge: EdgeIndex) -> [Node<D>; 2] {
        // Every edge index of a petgraph graph has endpoints; the datum stands in for the impossible case.
        let (a, b) = self.graph.edge_endpoints(edge).unwrap_or_default();
        [Node(a.index(), PhantomData), Node(b.index(), PhantomData)]
    }
}

/// A spanning tree: branches in the order of the branch coordinates, and the chords that are left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tree<D> {
    pub branches: Vec<ElementId>,
    pub chords: Vec<ElementId>,
    kind: PhantomData<D>,
}
