//! How far the loop equations of a driven mechanism fall apart into small systems.

use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};

use crate::formulate::Formulated;

/// The sum of the cubes of the sizes of the blocks in the block-triangular form of the active loop equations: what solving them one after another
/// takes.
pub fn blocks(formulated: &Formulated) -> usize {
    let constraints = &formulated.equations.constraints;
    let active = (0..constraints.len()).filter(|index| formulated.redundant.binary_search(index).is_err());
    let rows: Vec<Vec<usize>> =
        active.map(|index| constraints[index].jacobian.iter().map(|(column, _)| *column).collect()).collect();
    cubes(&rows, formulated.equations.coordinates.len())
}

fn cubes(rows: &[Vec<usize>], columns: usize) -> usize {
    let owner = matching(rows, columns);
    let mut graph: DiGraph<(), ()> = DiGraph::new();
    (0..rows.len()).for_each(|_| {
        graph.add_node(());
    });
    for (row, entries) in rows.iter().enumerate() {
        for other in entries.iter().filter_map(|&column| owner[column]).filter(|&other| other != row) {
            graph.add_edge(NodeIndex::new(row), NodeIndex::new(other), ());
        }
    }
    tarjan_scc(&graph).into_iter().map(|block| block.len().pow(3)).sum()
}

/// For each column the row that determines it, by augmenting paths (Kuhn's algorithm).
fn matching(rows: &[Vec<usize>], columns: usize) -> Vec<Option<usize>> {
    let mut owner = vec![None; columns];
    for row in 0..rows.len() {
        augment(rows, row, &mut owner, &mut vec![false; columns]);
    }
    owner
}

fn augment(rows: &[Vec<usize>], row: usize, owner: &mut [Option<usize>], tried: &mut [bool]) -> bool {
    for &column in &rows[row] {
        if std::mem::replace(&mut tried[column], true) {
            continue;
        }
        let free = match owner[column] {
            None => true,
            Some(other) => augment(rows, other, owner, tried),
        };
        if free {
            owner[column] = Some(row);
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangular_system_falls_apart_and_a_ring_does_not() {
        assert_eq!(cubes(&[vec![0, 1, 2], vec![1, 2], vec![2]], 3), 3);
        assert_eq!(cubes(&[vec![0, 1], vec![1, 2], vec![2, 0]], 3), 27);
        assert_eq!(cubes(&[vec![1, 0], vec![0, 1], vec![2, 0]], 3), 8 + 1);
    }
}
