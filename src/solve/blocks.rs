//! Which loop equations of a driven mechanism determine which coordinates, and in which order: the block triangular form of
//! \[Phi_q\] (Duff, Reid 1978). A maximum matching assigns an equation to each coordinate; the blocks are the strongly connected
//! components of the dependency graph of the equations. Where equations repeat others, which of them are independent changes with the pose: all that they can stand in for
//! make one block, whose coordinates are solved for by least squares. Its equations agree with each other, so that this is their solution, in every pose but a singular one.

use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::Dfs;

use super::eliminate::{EliminationSystem, Factorisation, Obstacle};
use super::motion::{scales, typical, unit_masses};
use crate::equations::Equations;
use crate::expr::{Arena, Expr};
use cotree_fmu::model::State;

/// Loop equations that determine as many coordinates, given those of the blocks before; more equations than coordinates if some repeat others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Indices of loop equations.
    pub rows: Vec<u32>,
    /// Indices of coordinates.
    pub columns: Vec<u32>,
}

/// An equation: its index, and the coordinates that occur in it.
pub type Incidence = (u32, Vec<u32>);

/// The blocks of a square system, with the equations that repeat others.
pub fn blocks(independent: &[Incidence], repeating: &[Incidence], coordinates: usize) -> Vec<Block> {
    let equations = [independent, repeating].concat();
    let Some(owner) = matching(independent, coordinates) else {
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
    unite(&mut needs, &nodes[independent.len()..]);
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

/// Puts nodes into one component, with all that they need.
fn unite(needs: &mut DiGraph<(), ()>, nodes: &[NodeIndex]) {
    let Some(&first) = nodes.first() else { return };
    nodes.iter().for_each(|&node| _ = needs.update_edge(first, node, ()));
    let mut search = Dfs::new(&*needs, first);
    while let Some(node) = search.next(&*needs) {
        needs.update_edge(node, first, ());
    }
}

/// The loop equations of a driven mechanism, factorised block by block: what a block does not depend on does not enter it, not even by rounding errors.
#[derive(Clone, Debug)]
pub struct BlockLoops {
    blocks: Vec<Factorised>,
    coordinates: usize,
}

/// A block with a unit mass on each of its coordinates: an elimination that is safe in every pose, and no mass matters to its solution. If equations repeat others, with one on each
/// equation instead, the coordinates being the multipliers: that is the system of least squares, \[D J; J^T 0\].
#[derive(Clone, Debug)]
struct Factorised {
    block: Block,
    factor: Factorisation,
    /// Unknowns with a mass, before the multipliers.
    masses: usize,
    /// (row of the block, coordinate of an earlier block, entry of Phi_q)
    before: Vec<(usize, usize, Expr)>,
}

impl BlockLoops {
    /// # Errors
    /// The loop equations do not determine a coordinate, or the elimination takes too many operations.
    pub fn new(equations: &mut Equations, blocks: &[Block], length: f64, pose: &State) -> Result<Self, Obstacle> {
        let scales = scales(equations, length);
        let blocks = blocks.iter().map(|block| Factorised::new(equations, block, (&scales, length), pose));
        Ok(BlockLoops { blocks: blocks.collect::<Result<_, _>>()?, coordinates: scales.len() })
    }

    /// x of Phi_q x = b, with b given for all loop equations.
    pub fn solve(&self, arena: &mut Arena, b: &[Expr]) -> Vec<Expr> {
        let mut x = vec![Expr::ZERO; self.coordinates];
        for Factorised { block, factor, before, masses } in &self.blocks {
            let mut right: Vec<Expr> = block.rows.iter().map(|&row| b[row as usize]).collect();
            for &(row, column, entry) in before {
                right[row] = arena.subtract_product(right[row], entry, x[column]);
            }
            let solution = match block.repeats() {
                true => factor.solve(arena, &right).split_off(*masses),
                false => factor.solve(arena, &[vec![Expr::ZERO; *masses], right].concat()),
            };
            block.columns.iter().zip(solution).for_each(|(&column, value)| x[column as usize] = value);
        }
        x
    }

    /// lambda of Phi_q^T lambda = b, with b given for all coordinates; zero for loop equations that are left out, and of least norm where some repeat others.
    pub fn balance(&self, arena: &mut Arena, b: &[Expr], constraints: usize) -> Vec<Expr> {
        let (mut left, mut lambda) = (b.to_vec(), vec![Expr::ZERO; constraints]);
        for Factorised { block, factor, before, masses } in self.blocks.iter().rev() {
            let right: Vec<Expr> = block.columns.iter().map(|&column| left[column as usize]).collect();
            let solution = match block.repeats() {
                true => factor.solve(arena, &[vec![Expr::ZERO; *masses], right].concat()),
                false => factor.solve(arena, &right).split_off(*masses),
            };
            for &(row, column, entry) in before {
                left[column] = arena.subtract_product(left[column], entry, solution[row]);
            }
            block.rows.iter().zip(solution).for_each(|(&row, value)| lambda[row as usize] = value);
        }
        lambda
    }

    /// Reciprocal pivots of the loop equations: they grow towards a singular configuration.
    pub fn reciprocal_pivots(&self, arena: &mut Arena) -> Vec<Expr> {
        self.blocks.iter().flat_map(|block| block.factor.reciprocal_pivots(arena, block.masses)).collect()
    }
}

impl Factorised {
    fn new(
        equations: &mut Equations,
        block: &Block,
        (scales, length): (&[f64], f64),
        pose: &State,
    ) -> Result<Self, Obstacle> {
        let values = typical(pose);
        let place = |column: usize| block.columns.iter().position(|&candidate| candidate as usize == column);
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
        let weights: Vec<f64> = match block.repeats() {
            true => {
                jacobian = transposed(&jacobian, block.columns.len());
                block.rows.iter().map(|&row| 1.0 / equations.constraints[row as usize].scale(length)).collect()
            }
            false => block.columns.iter().map(|&column| scales[column as usize]).collect(),
        };
        let arena = &mut equations.system.arena;
        let mass = unit_masses(arena, &weights);
        let system =
            EliminationSystem { mass: &mass, jacobian: &jacobian, diagonal: &[], scales: &weights, values: &values };
        let factor = Factorisation::new(arena, &system).map_err(|obstacle| match obstacle {
            Obstacle::Undetermined(index) => Obstacle::Undetermined(block.columns[index] as usize),
            Obstacle::TooLarge => obstacle,
        })?;
        Ok(Factorised { block: block.clone(), factor, before, masses: weights.len() })
    }
}

impl Block {
    /// Do some of its equations repeat others?
    pub fn repeats(&self) -> bool {
        self.rows.len() > self.columns.len()
    }
}

/// A sparse matrix by rows with so many columns, by columns.
pub fn transposed(rows: &[Vec<(usize, Expr)>], columns: usize) -> Vec<Vec<(usize, Expr)>> {
    let mut turned = vec![Vec::new(); columns];
    for (row, entries) in rows.iter().enumerate() {
        entries.iter().for_each(|&(column, entry)| turned[column].push((row, entry)));
    }
    turned
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
        with_repeating(equations, equations.len())
    }

    /// The equations after the first ones repeat them.
    fn with_repeating(equations: &[&[u32]], independent: usize) -> Vec<(Vec<u32>, Vec<u32>)> {
        let equations: Vec<Incidence> =
            equations.iter().enumerate().map(|(row, columns)| (row as u32, columns.to_vec())).collect();
        let (first, rest) = equations.split_at(independent);
        blocks(first, rest, independent).into_iter().map(|block| (block.rows, block.columns)).collect()
    }

    #[test]
    fn what_an_equation_can_stand_in_for_makes_one_block_with_it() {
        let equations: [&[u32]; 5] = [&[0], &[1, 2], &[1, 2], &[2, 3], &[2]];
        let mut found = with_repeating(&equations, 4);
        found.iter_mut().for_each(|(rows, columns)| {
            rows.sort_unstable();
            columns.sort_unstable();
        });
        found.sort();
        assert_eq!(found, [(vec![0], vec![0]), (vec![1, 2, 4], vec![1, 2]), (vec![3], vec![3])]);
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
