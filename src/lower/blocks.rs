//! Which loop equations of a driven mechanism determine which coordinates, and in which order: the block triangular form of
//! \[Phi_q\] (Duff, Reid 1978). A maximum matching assigns an equation to each coordinate; the blocks are the strongly connected
//! components of the dependency graph of the equations.

use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};

use super::eliminate::{Factor, Obstacle, System};
use super::motion::{scales, typical, unit_masses};
use super::program::Pose;
use crate::equations::Equations;
use crate::expr::{Arena, Expr};

/// Loop equations that determine as many coordinates, given those of the blocks before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Indices of loop equations.
    pub rows: Vec<u32>,
    /// Indices of coordinates.
    pub columns: Vec<u32>,
}

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

/// The loop equations of a driven mechanism, factorised block by block: what a block does not depend on does not enter it, not even by rounding errors.
#[derive(Clone, Debug)]
pub struct Loops {
    blocks: Vec<Factorised>,
    coordinates: usize,
}

/// A block with a unit mass on each of its coordinates: an elimination that is safe in every pose, and no mass matters to its solution.
#[derive(Clone, Debug)]
struct Factorised {
    block: Block,
    factor: Factor,
    /// (row of the block, coordinate of an earlier block, entry of Phi_q)
    before: Vec<(usize, usize, Expr)>,
}

impl Loops {
    /// # Errors
    /// The loop equations do not determine a coordinate, or the elimination takes too many operations.
    pub fn new(equations: &mut Equations, blocks: &[Block], length: f64, pose: &Pose) -> Result<Self, Obstacle> {
        let scales = scales(equations, length);
        let blocks = blocks.iter().map(|block| Factorised::new(equations, block, &scales, pose));
        Ok(Loops { blocks: blocks.collect::<Result<_, _>>()?, coordinates: scales.len() })
    }

    /// x of Phi_q x = b, with b given for all loop equations.
    pub fn solve(&self, arena: &mut Arena, b: &[Expr]) -> Vec<Expr> {
        let mut x = vec![Expr::ZERO; self.coordinates];
        for Factorised { block, factor, before } in &self.blocks {
            let size = block.rows.len();
            let mut right = vec![Expr::ZERO; size];
            right.extend(block.rows.iter().map(|&row| b[row as usize]));
            for &(row, column, entry) in before {
                right[size + row] = arena.subtract_product(right[size + row], entry, x[column]);
            }
            let solution = factor.solve(arena, &right);
            block.columns.iter().zip(solution).for_each(|(&column, value)| x[column as usize] = value);
        }
        x
    }

    /// lambda of Phi_q^T lambda = b, with b given for all coordinates; zero for loop equations that are not active.
    pub fn balance(&self, arena: &mut Arena, b: &[Expr], constraints: usize) -> Vec<Expr> {
        let (mut left, mut lambda) = (b.to_vec(), vec![Expr::ZERO; constraints]);
        for Factorised { block, factor, before } in self.blocks.iter().rev() {
            let right: Vec<Expr> = block.columns.iter().map(|&column| left[column as usize]).collect();
            let solution = factor.solve(arena, &right).split_off(block.columns.len());
            for &(row, column, entry) in before {
                left[column] = arena.subtract_product(left[column], entry, solution[row]);
            }
            block.rows.iter().zip(solution).for_each(|(&row, value)| lambda[row as usize] = value);
        }
        lambda
    }

    /// Reciprocal pivots of the loop equations: they grow towards a singular configuration.
    pub fn reciprocal_pivots(&self, arena: &mut Arena) -> Vec<Expr> {
        self.blocks.iter().flat_map(|own| own.factor.reciprocal_pivots(arena, own.block.columns.len())).collect()
    }
}

impl Factorised {
    fn new(equations: &mut Equations, block: &Block, scales: &[f64], pose: &Pose) -> Result<Self, Obstacle> {
        let values = typical(&equations.system.mechanism, pose);
        let own: Vec<f64> = block.columns.iter().map(|&column| scales[column as usize]).collect();
        let place = |column: usize| block.columns.iter().position(|&own| own as usize == column);
        let (mut jacobian, mut before) = (Vec::new(), Vec::new());
        for (place_of_row, &row) in block.rows.iter().enumerate() {
            let mut inner = Vec::new();
            for &(column, entry) in &equations.constraints[row as usize].jacobian {
                match place(column) {
                    Some(place) => inner.push((place, entry)),
                    None => before.push((place_of_row, column, entry)),
                }
            }
            jacobian.push(inner);
        }
        let arena = &mut equations.system.arena;
        let mass = unit_masses(arena, &own);
        let system = System { mass: &mass, jacobian: &jacobian, scales: &own, values: &values };
        let factor = Factor::new(arena, &system).map_err(|obstacle| match obstacle {
            Obstacle::Undetermined(index) => Obstacle::Undetermined(block.columns[index] as usize),
            Obstacle::TooLarge => obstacle,
        })?;
        Ok(Factorised { block: block.clone(), factor, before })
    }
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
