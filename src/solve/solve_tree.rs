//! The solve tree: a second pair of trees for the acceleration kernel alone.
//!
//! In branch coordinates a body at the end of a long path moves with every angle before it, so that \[M\] is full and grows with
//! the square of the depth. With bodies as branches of the translational tree the equations are many but sparse: \[M\] is constant, each
//! joint couples two bodies, and eliminating in the right order costs an amount that grows with the depth only. Positions and
//! rates of those bodies are functions of the branch coordinates (their across variables), and the accelerations of the branch
//! coordinates are across accelerations again, so nothing but the kernel changes.
//!
//! The rotational tree is the same in both. The loop equations of the solve tree are those of the branch coordinates and one set for each joint
//! that was a branch; the latter are identities in branch coordinates and independent, so the redundant equations are the same.

use std::collections::HashMap;

use super::eliminate::Obstacle;
use super::motion::{Branch, LoopRow, MotionSolver, MotionSystem, scales, typical};
use crate::equations::{Constraint, Coordinate, Equations};
use crate::expr::{Expr, Order, Symbol};
use crate::model::BodyId;
use crate::network::{Constrained, ElementId, Trees};
use crate::tape::{Cost, kernel_cost};
use cotree_fmu::model::State;

/// From so many angles on one path on, a solve tree is tried.
const DEEP: usize = 8;
const LONG: usize = 12;
/// Up to so many bodies the costs of several choices are compared; beyond, all bodies become branches.
const COUNTED: usize = 60;
/// With more bodies nothing is formulated in branch coordinates that move many bodies each.
const FULL: usize = 250;
/// Choices of bodies: those at a multiple of so many angles from the ground.
const STRIDES: [usize; 3] = [1, 2, 3];

/// The trees that the acceleration kernel is made with.
#[derive(Clone, Debug)]
pub struct SolveTree {
    pub trees: Trees,
    pub cost: Cost,
    /// The cost in branch coordinates, if it was counted.
    pub branch_cost: Option<Cost>,
}

/// The factorised equations of motion: in branch coordinates, or in a solve tree where one path is so deep or one loop so long that
/// it pays.
///
/// # Errors
/// A branch coordinate that moves no mass and is not constrained.
pub fn solver(
    equations: &mut Equations,
    length: f64,
    pose: &State,
) -> Result<(MotionSolver, Option<SolveTree>), Obstacle> {
    let bodies = equations.system.mechanism.bodies.len();
    let deepest = (0..bodies).map(|body| equations.depth(BodyId(body))).max().unwrap_or(0);
    // Levels act on the branch coordinates.
    let has_levels = equations.constraints.iter().any(|row| !row.is_loop());
    let many = bodies > COUNTED && (0..bodies).any(|body| equations.moving(BodyId(body)) >= DEEP);
    if has_levels || !many && deepest < DEEP && equations.largest_loop() < LONG {
        let system = MotionSystem::in_branch_coordinates(equations, length);
        return Ok((system.factorise(equations, pose)?, None));
    }
    if bodies > COUNTED {
        let arm = longest_arm(equations, length, pose);
        match with_stride(equations, 1, arm, pose) {
            Ok((solver, tree)) => return Ok((solver, Some(tree))),
            Err(obstacle) if bodies > FULL => return Err(obstacle),
            Err(_) => {}
        }
    }
    let system = MotionSystem::in_branch_coordinates(equations, length).factorise(equations, pose)?;
    let branch_cost = cost_of(equations, &system);
    let mut best: Option<(MotionSolver, SolveTree)> = None;
    let mut least = branch_cost.nanoseconds();
    for stride in STRIDES {
        // A body without mass may leave the order without a pivot that the branch coordinates have.
        let Ok((solver, tree)) = with_stride(equations, stride, length, pose) else { continue };
        if tree.cost.nanoseconds() < least {
            least = tree.cost.nanoseconds();
            best = Some((solver, SolveTree { branch_cost: Some(branch_cost), ..tree }));
        }
    }
    Ok(best.map_or((system, None), |(solver, tree)| (solver, Some(tree))))
}

/// The longest arm of a body: the length by which masses and inertias compare in a large mechanism, whose ground is much larger than its bodies. The
/// length of the mechanism if no body has an arm.
fn longest_arm(equations: &mut Equations, length: f64, pose: &State) -> f64 {
    let mechanism = &*equations.system.mechanism.clone();
    let components = mechanism.bodies.iter().flat_map(|body| &body.points).flat_map(|point| &point.at);
    let exprs: Vec<Expr> = components.map(|formula| equations.system.value(formula)).collect();
    let values = equations.system.arena.evaluate(&exprs, &typical(pose));
    let longest = values.chunks(2).map(|at| at.iter().map(|x| x * x).sum::<f64>().sqrt()).fold(0.0, f64::max);
    if longest > 0.0 && longest.is_finite() { longest } else { length }
}

/// The solve tree in which every body at a multiple of `stride` angles from the ground is a branch.
fn with_stride(
    equations: &mut Equations,
    stride: usize,
    length: f64,
    pose: &State,
) -> Result<(MotionSolver, SolveTree), Obstacle> {
    let chosen = |body: BodyId| equations.depth(body).is_multiple_of(stride);
    let trees = equations.trees.with_bodies(&equations.system, chosen);
    let mut other = Equations::new(equations.system.anew(), trees.clone());
    let system = in_other_trees(equations, &mut other, length);
    let solver = system.factorise(equations, pose).map_err(|obstacle| match obstacle {
        Obstacle::Undetermined(index) => Obstacle::Undetermined(equations.counterpart(&other.coordinates[index])),
        Obstacle::TooLarge => obstacle,
    })?;
    let cost = cost_of(equations, &solver);
    Ok((solver, SolveTree { trees, cost, branch_cost: None }))
}

fn cost_of(equations: &mut Equations, solver: &MotionSolver) -> Cost {
    let results = solver.motion(&mut equations.system.arena, equations.constraints.len());
    kernel_cost(equations, &results)
}

/// Formulates the equations for `trees` and expresses them in the branch coordinates, their rates, and the symbols of the
/// mechanism.
pub fn in_solve_tree(equations: &mut Equations, trees: Trees, length: f64) -> MotionSystem {
    let mut other = Equations::new(equations.system.anew(), trees);
    in_other_trees(equations, &mut other, length)
}

fn in_other_trees(equations: &mut Equations, other: &mut Equations, length: f64) -> MotionSystem {
    let dynamics = other.dynamics();
    let (mass, load) = (dynamics.mass.clone(), dynamics.load.clone());
    let rows = imposed_rows(equations, other);
    let branches: Vec<Branch> = (equations.coordinates.iter())
        .map(|coordinate| other.acceleration_of(coordinate))
        .map(|(terms, rest)| Branch { terms, rest })
        .collect();
    let mut system = MotionSystem { mass, load, rows, scales: scales(other, length), branches };
    move_to(equations, other, &mut system);
    system
}

/// The other trees' loop equations, without those that are not imposed in branch coordinates.
fn imposed_rows(equations: &Equations, other: &mut Equations) -> Vec<LoopRow> {
    // The equations of one chord in one graph have the same order for all trees; those of its coupling are separate.
    let kind = |row: &Constraint| (row.element, row.constrained == Constrained::Angle, row.coupled.is_empty());
    let mut by_kind: HashMap<(ElementId, bool, bool), Vec<usize>> = HashMap::new();
    for (index, constraint) in equations.constraints.iter().enumerate().rev() {
        by_kind.entry(kind(constraint)).or_default().push(index);
    }
    let mut rows = Vec::new();
    let Equations { constraints, system, .. } = other;
    for constraint in &*constraints {
        let branch = by_kind.get_mut(&kind(constraint)).and_then(Vec::pop);
        if branch.is_none_or(|index| equations.constraints[index].is_imposed()) && !constraint.is_trivial() {
            let diagonal = constraint.multiplier_diagonal(&mut system.arena);
            rows.push(LoopRow { jacobian: constraint.jacobian.clone(), gamma: constraint.gamma, branch, diagonal });
        }
    }
    rows
}

fn move_to(equations: &mut Equations, other: &Equations, system: &mut MotionSystem) {
    let mut places: Vec<&mut Expr> = system.mass.iter_mut().flatten().map(|(_, entry)| entry).collect();
    places.extend(&mut system.load);
    for row in &mut system.rows {
        places.extend(row.jacobian.iter_mut().map(|(_, entry)| entry));
        places.extend([&mut row.gamma, &mut row.diagonal]);
    }
    for branch in &mut system.branches {
        places.extend(branch.terms.iter_mut().map(|(_, entry)| entry));
        places.push(&mut branch.rest);
    }
    let roots: Vec<Expr> = places.iter().map(|place| **place).collect();
    let arena = &other.system.arena;
    let mut given = HashMap::new();
    for symbol in arena.symbols(roots.iter().copied()) {
        if let Symbol::Coordinate(index, order @ (Order::Position | Order::Velocity)) = symbol {
            let coordinate: &Coordinate = &other.coordinates[index];
            given.insert(symbol, equations.value_of(coordinate, order));
        }
    }
    let moved = equations.system.arena.import(arena, &roots, &given);
    for (place, expr) in places.into_iter().zip(moved) {
        *place = expr;
    }
}
