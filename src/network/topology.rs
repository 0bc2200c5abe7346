//! A graph with a spanning tree: paths, cutsets, circuits.

use std::collections::HashMap;

use super::{ElementId, LinearGraph, Node, Tree};

/// A row of a cutset or circuit matrix: the elements with their signs.
pub type SignedRow = Vec<(ElementId, i8)>;

/// A graph rooted at the datum through a spanning tree.
#[derive(Clone, Debug)]
pub struct Topology<D> {
    ends: HashMap<ElementId, [Node<D>; 2]>,
    /// For each node but the datum: the branch towards the datum, and +1 if that branch points away from the datum.
    up: Vec<Option<(Node<D>, ElementId, i8)>>,
    /// Nodes from the datum outwards: a node comes after its parent.
    outward: Vec<Node<D>>,
}

/// A node of a tree, seen from the datum.
pub struct OutwardNode<D> {
    pub node: Node<D>,
    /// The node before it.
    pub parent: Node<D>,
    /// Between both.
    pub branch: ElementId,
    /// +1 if the branch points outwards, else -1.
    pub sign: i8,
}

impl<D> Topology<D> {
    /// Roots the graph; the tree must span it.
    pub fn new(graph: &LinearGraph<D>, tree: &Tree<D>) -> Self {
        let ends: HashMap<_, _> = graph.edges().collect();
        let mut neighbours: Vec<Vec<(Node<D>, ElementId, i8)>> = (0..graph.nodes()).map(|_| Vec::new()).collect();
        for &branch in &tree.branches {
            let [a, b] = ends[&branch];
            neighbours[a.index()].push((b, branch, 1));
            neighbours[b.index()].push((a, branch, -1));
        }
        let mut up: Vec<Option<(Node<D>, ElementId, i8)>> = (0..graph.nodes()).map(|_| None).collect();
        let mut outward = vec![Node::DATUM];
        let mut next = 0;
        while let Some(&node) = outward.get(next) {
            next += 1;
            for &(child, branch, sign) in &neighbours[node.index()] {
                if child != Node::DATUM && up[child.index()].is_none() {
                    up[child.index()] = Some((node, branch, sign));
                    outward.push(child);
                }
            }
        }
        Topology { ends, up, outward }
    }

    pub fn ends(&self, element: ElementId) -> [Node<D>; 2] {
        self.ends[&element]
    }

    /// Nodes from the datum outwards, the datum left out.
    pub fn outward(&self) -> impl DoubleEndedIterator<Item = OutwardNode<D>> + '_ {
        self.outward.iter().filter_map(|&node| {
            let (parent, branch, sign) = self.up[node.index()]?;
            Some(OutwardNode { node, parent, branch, sign })
        })
    }

    /// The row of the circuit matrix \[B\] of one chord: {r}_c = -\[B\]{r}_b (Eq. 12).
    pub fn circuit(&self, chord: ElementId) -> SignedRow {
        self.circuit_between(self.ends(chord))
    }

    /// The row of a chord that is no edge of the graph.
    pub fn circuit_between(&self, [a, b]: [Node<D>; 2]) -> SignedRow {
        let mut row: HashMap<ElementId, i8> = HashMap::new();
        for (end, side) in [(b, -1), (a, 1)] {
            let mut node = end;
            while let Some((parent, branch, sign)) = self.up[node.index()] {
                *row.entry(branch).or_default() += side * sign;
                node = parent;
            }
        }
        let mut row: SignedRow = row.into_iter().filter(|&(_, sign)| sign != 0).collect();
        row.sort_unstable();
        row
    }

    /// The circuit matrix \[B\], a row for each chord.
    pub fn circuits(&self, tree: &Tree<D>) -> Vec<SignedRow> {
        tree.chords.iter().map(|&chord| self.circuit(chord)).collect()
    }

    /// The cutset matrix \[A\] = -\[B\]^T, a row for each branch (Eq. 13): {F}_b = -\[A\]{F}_c (Eq. 9).
    pub fn cutsets(&self, tree: &Tree<D>) -> Vec<SignedRow> {
        let mut rows: HashMap<ElementId, SignedRow> = HashMap::new();
        for &chord in &tree.chords {
            for (branch, sign) in self.circuit(chord) {
                rows.entry(branch).or_default().push((chord, -sign));
            }
        }
        tree.branches.iter().map(|branch| rows.remove(branch).unwrap_or_default()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::Translation;

    /// The graph of the paper's Fig. 2, its tree, and the element numbers of the paper.
    fn slider_crank() -> (LinearGraph<Translation>, Tree<Translation>) {
        let mut graph = LinearGraph::default();
        let node: Vec<_> = ["m1", "a", "b", "m2", "c", "d", "m3", "guide"].map(|n| graph.add_node(n)).into();
        let datum = Node::DATUM;
        let edges = [
            (1, [datum, node[0]]),
            (2, [datum, node[3]]),
            (3, [datum, node[6]]),
            (4, [datum, node[7]]),
            (5, [node[0], node[1]]),
            (6, [node[0], node[2]]),
            (7, [node[3], node[4]]),
            (8, [node[3], node[5]]),
            (9, [datum, node[1]]),
            (10, [node[2], node[4]]),
            (11, [node[5], node[6]]),
            (12, [node[7], node[6]]),
            (13, [datum, node[6]]),
        ];
        for (number, ends) in edges {
            graph.add_edge(ElementId(number), ends);
        }
        let tree = graph.tree([4, 5, 6, 7, 8, 9, 10, 11].map(ElementId));
        (graph, tree)
    }

    #[test]
    fn eq47_circuit_of_the_slider() {
        let (graph, tree) = slider_crank();
        let topology = Topology::new(&graph, &tree);
        let row: Vec<(usize, i8)> = topology.circuit(ElementId(12)).into_iter().map(|(e, s)| (e.0, s)).collect();
        // r12 = -r4 + r9 - r5 + r6 + r10 - r7 + r8 + r11 is minus the row.
        assert_eq!(row, [(4, 1), (5, 1), (6, -1), (7, 1), (8, -1), (9, -1), (10, -1), (11, -1)]);
    }

    #[test]
    fn eq49_cutset_of_the_first_arm() {
        let (graph, tree) = slider_crank();
        let topology = Topology::new(&graph, &tree);
        let rows = topology.cutsets(&tree);
        let arm = tree.branches.iter().position(|&b| b == ElementId(5)).unwrap();
        let chords: Vec<usize> = rows[arm].iter().map(|(e, _)| e.0).collect();
        assert_eq!(chords, [1, 2, 3, 12, 13]);
    }

    #[test]
    fn a_tree_of_kruskal_spans_and_has_no_loop() {
        let (graph, tree) = slider_crank();
        assert_eq!(tree.branches.len(), graph.nodes() - 1);
        assert!(graph.unreached(&tree.branches).is_empty());
        assert_eq!(graph.unreached(&tree.branches[1..]), ["guide"]);
    }

    /// The cutset matrix by elementary row operations on the reduced incidence matrix (Eq. 8), as the paper describes it.
    fn cutsets_by_row_reduction(graph: &LinearGraph<Translation>, tree: &Tree<Translation>) -> Vec<Vec<i64>> {
        let order: Vec<ElementId> = tree.branches.iter().chain(&tree.chords).copied().collect();
        let mut rows = vec![vec![0_i64; order.len()]; graph.nodes() - 1];
        for (element, [a, b]) in graph.edges() {
            let column = order.iter().position(|&e| e == element).unwrap();
            for (node, sign) in [(a, -1), (b, 1)] {
                if node != Node::DATUM {
                    rows[node.index() - 1][column] += sign;
                }
            }
        }
        for pivot in 0..rows.len() {
            let found = (pivot..rows.len()).find(|&r| rows[r][pivot] != 0).unwrap();
            rows.swap(pivot, found);
            let scale = rows[pivot][pivot];
            rows[pivot].iter_mut().for_each(|x| *x *= scale);
            for r in (0..rows.len()).filter(|&r| r != pivot) {
                let factor = rows[r][pivot];
                let pivot_row = rows[pivot].clone();
                rows[r].iter_mut().zip(pivot_row).for_each(|(x, p)| *x -= factor * p);
            }
        }
        rows.into_iter().map(|row| row[tree.branches.len()..].to_vec()).collect()
    }

    #[test]
    fn eq8_row_reduction_gives_the_same_cutsets() {
        let (graph, tree) = slider_crank();
        let topology = Topology::new(&graph, &tree);
        let dense = cutsets_by_row_reduction(&graph, &tree);
        for (row, expected) in topology.cutsets(&tree).into_iter().zip(dense) {
            let signs: HashMap<ElementId, i8> = row.into_iter().collect();
            for (chord, expected) in tree.chords.iter().zip(expected) {
                assert_eq!(i64::from(signs.get(chord).copied().unwrap_or(0)), expected);
            }
        }
    }
}
