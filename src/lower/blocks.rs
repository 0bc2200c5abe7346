//! Which loop equations of a driven mechanism determine which coordinates, and in which order: the block triangular form of
//! \[Phi_q\] (Duff, Reid 1978). A maximum matching assigns an equation to each coordinate; the blocks are the strongly connected
//! components of the dependency graph of the equations.

use cotree_fmu::program::Block;
use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};

/// The blocks of a square system: for each equation its index and the coordinates that occur in it.
pub fn blocks(equations: &[(u32, Vec<u32>)], coordinates: usize) -> Vec<Block> {
    let Some(owner) = matching(equations, coordinates) else {
        // A regular matrix has a complete matching; if there is none, the runtime reports what is singular.
        let rows = equations.iter().map(|&(row, _)| row).collect();
        return vec![Block { rows, columns: (0..coordinates as u32).collect() }];
    };
    let mut needs: DiGraph<(), ()> = DiGraph::new();
    let nodes: Vec<NodeIndex> = equations.iter().map(|_| needs.add_node(())).collect();
    for (place, (_, columns)) in equations.iter().enumerate() {
        for &column in columns {
            needs.add_edge(nodes[place], nodes[owner[column as usize]], ());
        }
    }
    // In topological order: a block after those that it depends on.
    let components = kosaraju_scc(&needs);
    let mut blocks = vec![Block { rows: Vec::new(), columns: Vec::new() }; components.len()];
    let mut of = vec![0; equations.len()];
    for (index, component) in components.iter().enumerate() {
        component.iter().for_each(|node| of[node.index()] = index);
    }
    for (place, &(row, _)) in equations.iter().enumerate() {
        blocks[of[place]].rows.push(row);
    }
    for (column, place) in owner.into_iter().enumerate() {
        blocks[of[place]].columns.push(column as u32);
    }
    blocks
}

/// The equation of each coordinate, by augmenting paths; `None` if not every coordinate can have its own.
fn matching(equations: &[(u32, Vec<u32>)], coordinates: usize) -> Option<Vec<usize>> {
    let mut owner: Vec<Option<usize>> = vec![None; coordinates];
    for place in 0..equations.len() {
        augment(equations, place, &mut owner, &mut vec![false; coordinates]);
    }
    owner.into_iter().collect()
}

fn augment(equations: &[(u32, Vec<u32>)], place: usize, owner: &mut [Option<usize>], seen: &mut [bool]) -> bool {
    for &column in &equations[place].1 {
        let column = column as usize;
        if std::mem::replace(&mut seen[column], true) {
            continue;
        }
        if owner[column].is_none_or(|other| augment(equations, other, owner, seen)) {
            owner[column] = Some(place);
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(equations: &[&[u32]]) -> Vec<(Vec<u32>, Vec<u32>)> {
        let equations: Vec<(u32, Vec<u32>)> =
            equations.iter().enumerate().map(|(row, columns)| (row as u32, columns.to_vec())).collect();
        blocks(&equations, equations.len()).into_iter().map(|block| (block.rows, block.columns)).collect()
    }

    #[test]
    fn a_chain_is_solved_link_by_link() {
        let chain = found(&[&[1, 2], &[0], &[0, 1]]);
        assert_eq!(chain, [(vec![1], vec![0]), (vec![2], vec![1]), (vec![0], vec![2])]);
    }

    #[test]
    fn what_needs_each_other_stays_together() {
        let loops = found(&[&[0, 1], &[0, 1], &[1, 2, 3], &[2, 3]]);
        assert_eq!(loops, [(vec![0, 1], vec![0, 1]), (vec![2, 3], vec![2, 3])]);
    }

    #[test]
    fn a_matching_is_found_by_augmenting() {
        // The greedy matching of the first two equations must be changed.
        assert_eq!(found(&[&[0, 1, 2], &[1, 2], &[1]]).len(), 3);
    }

    #[test]
    fn without_a_matching_there_is_one_block() {
        assert_eq!(found(&[&[0], &[0]]), [(vec![0, 1], vec![0, 1])]);
    }
}
