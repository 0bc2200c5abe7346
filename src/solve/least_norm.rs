//! Reactions of redundant joints: of all that are in balance with the same motion, those of least norm.
//!
//! Redundant loop equations leave self-stresses: reactions N mu with J^T N = 0, which are in equilibrium among themselves. The trees
//! decide which loop equation is dropped, and with it the value of mu; the norm does not depend on them. It is the sum of the squares of all forces and torques of
//! joints and drivers, torques divided by the typical length of the mechanism, so that it does not depend on units either. With R the reactions for any mu and
//! S how they change with it, mu = -(S^T W S)^-1 S^T W R.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::DMatrix;

use super::blocks::{Block, transposed};
use super::eliminate::{EliminationSystem, Factorisation, Obstacle};
use super::motion::{scales, typical, unit_masses};
use crate::equations::{Equations, Standing};
use crate::expr::{Arena, Expr, Symbol};
use crate::model::{Owner, Quantity, Variable};
use cotree_fmu::model::State;

/// A share of the largest stress below which there is none: rounding errors of the elimination.
const NONE: f64 = 1e-9;

struct Reaction {
    variable: Variable,
    value: Expr,
    /// Square of the factor that converts it to a force.
    weight: f64,
    stress: Vec<Expr>,
}

/// Reactions that the equations of motion do not determine.
#[derive(Clone, Debug, Default)]
pub struct Shared {
    /// Joints and drivers that share their loads with others: those of least norm are reported.
    pub owners: Vec<Owner>,
    /// What grows without bound where joints hold a direction in second order only: nothing can be reported.
    pub undetermined: Vec<Variable>,
}

/// Makes the reactions of joints and drivers those of least norm.
///
/// # Errors
/// The elimination takes too many operations.
pub fn impose(equations: &mut Equations, length: f64, [pose, generic]: [&State; 2]) -> Result<Shared, Obstacle> {
    if equations.constraints.iter().all(|row| row.is_imposed() || !row.is_loop()) {
        return Ok(Shared::default());
    }
    let stresses = self_stresses(equations, length, pose)?;
    let mut reactions = reactions(equations, &stresses, length);
    let values = stress_values(equations, &reactions, stresses.len(), generic);
    let largest = values.iter().flatten().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let shares = |row: &[f64], states: &[usize]| states.iter().any(|&state| row[state].abs() > NONE * largest);
    let dropped = equations.constraints.iter().filter(|row| !row.is_imposed() && row.is_loop());
    let unbounded = dropped.enumerate().filter(|(_, row)| row.standing() == Some(Standing::SecondOrder));
    let unbounded: Vec<usize> = unbounded.map(|(state, _)| state).collect();
    let undetermined = reactions.iter().zip(&values).filter(|(_, row)| shares(row, &unbounded));
    let undetermined = undetermined.map(|(reaction, _)| reaction.variable).collect();
    let independent = independent(&values);
    if independent.is_empty() {
        return Ok(Shared { owners: Vec::new(), undetermined });
    }
    for reaction in &mut reactions {
        reaction.stress = independent.iter().map(|&state| reaction.stress[state]).collect();
    }
    let minimising = minimising(&mut equations.system.arena, &reactions, independent.len());
    for reaction in &reactions {
        let arena = &mut equations.system.arena;
        let value = reaction.stress.iter().zip(&minimising).fold(reaction.value, |sum, (&stress, &size)| {
            let more = arena.multiply(stress, size);
            arena.add(sum, more)
        });
        equations.redefine(reaction.variable, value);
    }
    let sharing = reactions.iter().zip(&values).filter(|(_, row)| shares(row, &independent));
    let mut owners: Vec<Owner> = sharing.map(|(reaction, _)| reaction.variable.owner).collect();
    owners.dedup();
    Ok(Shared { owners, undetermined })
}

/// The same where drivers determine the motion by a block of loop equations some of which repeat others: no choice of them, and so no finite self-stress, serves in every pose. With
/// T for how the reactions R change with the multipliers of all these equations, the change of least norm solves \[T^T W T, J; J^T, 0\] {mu, nu} = {-T^T W R, 0}. None if a self-stress changes no
/// reaction that is reported.
///
/// # Errors
/// The elimination takes too many operations.
pub fn impose_in_every_pose(
    equations: &mut Equations,
    block: &Block,
    length: f64,
    generic: &State,
) -> Result<Option<Shared>, Obstacle> {
    let trivial = equations.rows_of(Standing::Trivial);
    let rows: Vec<usize> = block.rows.iter().map(|&row| row as usize).chain(trivial).collect();
    let single: Vec<BTreeMap<usize, Expr>> = rows.iter().map(|&row| BTreeMap::from([(row, Expr::ONE)])).collect();
    let reactions = reactions(equations, &single, length);
    let place = |column: usize| block.columns.iter().position(|&candidate| candidate as usize == column);
    let entries = |&row: &usize| -> Vec<(usize, Expr)> {
        let jacobian = equations.constraints[row].jacobian.iter();
        jacobian.filter_map(|&(column, entry)| Some((place(column)?, entry))).collect()
    };
    let jacobian = transposed(&rows.iter().map(entries).collect::<Vec<_>>(), block.columns.len());
    let values = stress_values(equations, &reactions, rows.len(), generic);
    let Some(states) = states(equations, &jacobian, rows.len(), generic) else { return Ok(None) };
    let by_state = values_by_state(&values, &states);
    if independent(&by_state).len() < states.ncols() {
        return Ok(None);
    }
    let changes = match least_change(equations, (&rows, &jacobian), &reactions, (length, generic)) {
        Ok(changes) => changes,
        Err(Obstacle::Undetermined(_)) => return Ok(None),
        Err(obstacle @ Obstacle::TooLarge) => return Err(obstacle),
    };
    for reaction in &reactions {
        let arena = &mut equations.system.arena;
        let value = reaction.stress.iter().zip(&changes);
        let value = value.fold(reaction.value, |sum, (&slope, &change)| arena.add_product(sum, slope, change));
        equations.redefine(reaction.variable, value);
    }
    let largest = by_state.iter().flatten().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let sharing = reactions.iter().zip(&by_state);
    let sharing = sharing.filter(|(_, row)| row.iter().any(|value| value.abs() > NONE * largest));
    let mut owners: Vec<Owner> = sharing.map(|(reaction, _)| reaction.variable.owner).collect();
    owners.dedup();
    Ok(Some(Shared { owners, undetermined: Vec::new() }))
}

/// Self-stresses of loop equations, given by columns, as numbers in a pose: a column for each. None if they have no values there.
fn states(equations: &Equations, jacobian: &[Vec<(usize, Expr)>], rows: usize, pose: &State) -> Option<DMatrix<f64>> {
    let exprs: Vec<Expr> = jacobian.iter().flatten().map(|(_, entry)| *entry).collect();
    let numbers = equations.system.arena.evaluate(&exprs, &typical(pose));
    if !numbers.iter().all(|number| number.is_finite()) {
        return None;
    }
    // Square, so that all right singular vectors are found.
    let mut matrix = DMatrix::zeros(rows, rows);
    let places =
        jacobian.iter().enumerate().flat_map(|(column, entries)| entries.iter().map(move |(row, _)| (column, *row)));
    places.zip(numbers).for_each(|(place, number)| matrix[place] = number);
    let svd = matrix.svd(false, true);
    let v_t = svd.v_t?;
    // The columns of the equations are independent in a generic pose.
    let mut order: Vec<usize> = (0..rows).collect();
    order.sort_by(|&a, &b| svd.singular_values[a].total_cmp(&svd.singular_values[b]));
    let free = &order[..rows - jacobian.len()];
    Some(DMatrix::from_fn(rows, free.len(), |row, state| v_t[(free[state], row)]))
}

/// How reactions change with self-stresses, from how they change with multipliers.
fn values_by_state(values: &[Vec<f64>], states: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let along = |row: &Vec<f64>, state: usize| row.iter().zip(states.column(state).iter()).map(|(a, b)| a * b).sum();
    values.iter().map(|row| (0..states.ncols()).map(|state| along(row, state)).collect()).collect()
}

/// Column and entry.
type SparseRow = Vec<(usize, Expr)>;

/// The changes of the multipliers, with no effect on the motion, that make the norm of the reactions least.
fn least_change(
    equations: &mut Equations,
    (rows, jacobian): (&[usize], &[SparseRow]),
    reactions: &[Reaction],
    (length, pose): (f64, &State),
) -> Result<Vec<Expr>, Obstacle> {
    let values = typical(pose);
    // A force by itself, a torque by the force at the typical length.
    let scales: Vec<f64> = rows.iter().map(|&row| length / equations.constraints[row].scale(length)).collect();
    let arena = &mut equations.system.arena;
    let normal = normal_equations(arena, reactions, rows.len());
    let sparse = |row: &Vec<Expr>| {
        let entries = row[..rows.len()].iter().copied().enumerate();
        entries.filter(|(_, entry)| *entry != Expr::ZERO).collect()
    };
    let mass: Vec<Vec<(usize, Expr)>> = normal.iter().map(sparse).collect();
    let system = EliminationSystem { mass: &mass, jacobian, diagonal: &[], scales: &scales, values: &values };
    let factor = Factorisation::new(arena, &system)?;
    let mut right: Vec<Expr> = normal.iter().map(|row| row[rows.len()]).collect();
    right.resize(rows.len() + jacobian.len(), Expr::ZERO);
    let mut solution = factor.solve(arena, &right);
    solution.truncate(rows.len());
    Ok(solution)
}

/// For each redundant loop equation, multipliers of it and of the independent ones in equilibrium: J_a^T y = J_d^T. A diagonal matrix
/// replaces the masses, which do not matter.
fn self_stresses(equations: &mut Equations, length: f64, pose: &State) -> Result<Vec<BTreeMap<usize, Expr>>, Obstacle> {
    let scales = scales(equations, length);
    let values = typical(pose);
    // What may be open takes no part: where it closes upon what is held already, the run is refused.
    let standing = |row: &usize| equations.constraints[*row].standing();
    let always = (0..equations.constraints.len()).filter(|row| standing(row).is_some());
    let (rows, dropped): (Vec<usize>, Vec<usize>) = always.partition(|row| standing(row) == Some(Standing::Imposed));
    let jacobian: Vec<_> = rows.iter().map(|&row| equations.constraints[row].jacobian.clone()).collect();
    let dropped = dropped.into_iter().map(|row| (row, equations.constraints[row].jacobian.clone()));
    let dropped: Vec<_> = dropped.collect();
    let arena = &mut equations.system.arena;
    let mass = unit_masses(arena, &scales);
    let system =
        EliminationSystem { mass: &mass, jacobian: &jacobian, diagonal: &[], scales: &scales, values: &values };
    let factor = Factorisation::new(arena, &system)?;
    let balance = |(row, entries): (usize, Vec<(usize, Expr)>)| {
        let mut right = vec![Expr::ZERO; mass.len()];
        entries.into_iter().for_each(|(column, entry)| right[column] = entry);
        let solution = factor.solve(arena, &right);
        let multipliers = rows.iter().zip(&solution[mass.len()..]).filter(|(_, entry)| **entry != Expr::ZERO);
        let mut stress: BTreeMap<usize, Expr> = multipliers.map(|(&row, &entry)| (row, arena.negate(entry))).collect();
        stress.insert(row, Expr::ONE);
        stress
    };
    Ok(dropped.into_iter().map(balance).collect())
}

/// Those reactions of joints and drivers that change with a self-stress.
fn reactions(equations: &mut Equations, stresses: &[BTreeMap<usize, Expr>], length: f64) -> Vec<Reaction> {
    let mechanism = &equations.system.mechanism;
    let variables: Vec<Variable> = mechanism.joint_reactions().into_iter().chain(mechanism.driver_efforts()).collect();
    let concerned: BTreeSet<usize> = stresses.iter().flat_map(|stress| stress.keys().copied()).collect();
    let mut found: Vec<Reaction> = Vec::new();
    let values = equations.with_all_reactions(&variables);
    for (variable, value) in variables.into_iter().zip(values) {
        let symbols = equations.system.arena.symbols([value]);
        if symbols.iter().any(|symbol| matches!(symbol, Symbol::Reaction(row) if concerned.contains(row))) {
            let weight = if variable.quantity == Quantity::Torque { (length * length).recip() } else { 1.0 };
            found.push(Reaction { variable, value, weight, stress: vec![Expr::ZERO; stresses.len()] });
        }
    }
    let values: Vec<Expr> = found.iter().map(|reaction| reaction.value).collect();
    let arena = &mut equations.system.arena;
    for row in concerned {
        let slopes = arena.derivatives(&values, Symbol::Reaction(row));
        for (reaction, slope) in found.iter_mut().zip(slopes) {
            for (sum, stress) in reaction.stress.iter_mut().zip(stresses) {
                let Some(&entry) = stress.get(&row) else { continue };
                *sum = arena.add_product(*sum, slope, entry);
            }
        }
    }
    found
}

/// The stresses as numbers in a typical pose, torques as forces: a row for each reaction.
fn stress_values(equations: &Equations, reactions: &[Reaction], states: usize, pose: &State) -> Vec<Vec<f64>> {
    if states == 0 {
        return vec![Vec::new(); reactions.len()];
    }
    let exprs: Vec<Expr> = reactions.iter().flat_map(|reaction| reaction.stress.iter().copied()).collect();
    let numbers = equations.system.arena.evaluate(&exprs, &typical(pose));
    let scaled =
        |(row, reaction): (&[f64], &Reaction)| row.iter().map(|value| value * reaction.weight.sqrt()).collect();
    numbers.chunks(states).zip(reactions).map(scaled).collect()
}

/// Self-stresses that change the reactions in ways of their own, by Gram and Schmidt. A joint that shares its load with its own driver, both reported as one, has none.
fn independent(values: &[Vec<f64>]) -> Vec<usize> {
    let states = values.first().map_or(0, Vec::len);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut found = Vec::new();
    for state in 0..states {
        let mut rest: Vec<f64> = values.iter().map(|row| row[state]).collect();
        let norm = |vector: &[f64]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        let size = norm(&rest);
        for direction in &basis {
            let share: f64 = direction.iter().zip(&rest).map(|(a, b)| a * b).sum();
            rest.iter_mut().zip(direction).for_each(|(rest, direction)| *rest -= share * direction);
        }
        let new = norm(&rest);
        if new > NONE * size.max(1.0) {
            rest.iter_mut().for_each(|entry| *entry /= new);
            basis.push(rest);
            found.push(state);
        }
    }
    found
}

/// The equations that make the norm least: a matrix, and its right-hand side as the last column.
fn normal_equations(arena: &mut Arena, reactions: &[Reaction], states: usize) -> Vec<Vec<Expr>> {
    let mut rows: Vec<Vec<Expr>> = vec![vec![Expr::ZERO; states + 1]; states];
    for reaction in reactions {
        let weight = arena.constant(reaction.weight);
        for (row, &stress) in rows.iter_mut().zip(&reaction.stress) {
            let weighted = arena.multiply(weight, stress);
            for (entry, &other) in row.iter_mut().zip(&reaction.stress) {
                *entry = arena.add_product(*entry, weighted, other);
            }
            row[states] = arena.subtract_product(row[states], weighted, reaction.value);
        }
    }
    rows
}

/// Sizes of the self-stresses that make the norm least, by Gaussian elimination (the matrix is positive definite).
fn minimising(arena: &mut Arena, reactions: &[Reaction], states: usize) -> Vec<Expr> {
    let mut rows = normal_equations(arena, reactions, states);
    for pivot in 0..states {
        let upper = rows[pivot].clone();
        for row in &mut rows[pivot + 1..] {
            let factor = arena.divide(row[pivot], upper[pivot]);
            for (entry, &above) in row.iter_mut().zip(&upper).skip(pivot) {
                *entry = arena.subtract_product(*entry, factor, above);
            }
        }
    }
    let mut sizes = vec![Expr::ZERO; states];
    for pivot in (0..states).rev() {
        let right = (pivot + 1..states)
            .fold(rows[pivot][states], |right, other| arena.subtract_product(right, rows[pivot][other], sizes[other]));
        sizes[pivot] = arena.divide(right, rows[pivot][pivot]);
    }
    sizes
}
