//! Every tree pair gives the motion and the reactions of an independent solution in absolute coordinates.

use std::sync::Arc;

use cotree::equations::Equations;
use cotree::expr::{Order, Symbol};
use cotree::formulate::{Formulated, formulate};
use cotree::scene::Resolved;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use nalgebra::DMatrix;

use super::redundant::{double_guides, parallel_cranks};
use super::trees::light_case;
use super::{cases, choices, resolved};
use crate::support::random::{Case, Family};

/// Random trees for each mechanism, besides the presets.
const RANDOM_TREES: usize = 3;
/// Errors may be this many roundings, times the condition of the equations where they have been solved (see [`Bound`]).
const ROUNDINGS: f64 = 100.0;

#[test]
fn chains() {
    agree(Family::Chain, cases(Family::Chain, 60));
}

#[test]
fn trees() {
    agree(Family::Tree, cases(Family::Tree, 60));
}

#[test]
fn loops() {
    agree(Family::Loops, cases(Family::Loops, 80));
}

#[test]
fn driven() {
    agree(Family::Driven, cases(Family::Driven, 60));
}

/// Reactions of redundant joints are not unique: in all trees those of least norm are reported.
#[test]
fn redundant() {
    agree(Family::Redundant, cases(Family::Redundant, 60));
    agree(Family::Redundant, (0..20).map(|seed| (seed, parallel_cranks(seed))));
    agree(Family::Redundant, (0..20).map(|seed| (seed, double_guides(seed))));
}

/// Bodies without mass or inertia, as long as the others determine the motion.
#[test]
fn light() {
    for family in [Family::Tree, Family::Loops, Family::Driven] {
        agree(family, (0..40).map(|seed| (seed, light_case(seed, family))));
    }
}

/// The initial state is assembled no closer than this to the one that is given.
const ASSEMBLED: f64 = 1e-10;

fn agree(family: Family, cases: impl Iterator<Item = (u64, Case)>) {
    for (seed, case) in cases {
        let mut resolved = resolved(&case.scene);
        for choice in choices(&resolved.mechanism, seed, RANDOM_TREES) {
            resolved.mechanism.coordinates = choice;
            agrees(&case, &resolved)
                .unwrap_or_else(|error| panic!("{family:?} {seed}, {:?}: {error}", resolved.mechanism.coordinates));
        }
    }
}

/// Compares all variables at the start.
fn agrees(case: &Case, resolved: &Resolved) -> Result<(), String> {
    let formulated = formulate(&resolved.mechanism, &resolved.outputs).map_err(|faults| faults[0].message.clone())?;
    let model = Arc::new(Model::new(formulated.lowered.program.clone()).map_err(|fault| fault.to_string())?);
    let mut instance = Instance::new(model);
    instance.initialise().map_err(|error| error.to_string())?;
    let condition = condition(&formulated);
    for kind in [Kind::Moving, Kind::Acceleration, Kind::Reaction] {
        let members: Vec<_> = case.expected.iter().filter(|(name, _)| Kind::of(name) == kind).collect();
        let scale = members.iter().map(|(_, value)| value.abs()).fold(1.0, f64::max);
        let rounding = ROUNDINGS * f64::EPSILON * scale;
        let amplified = if kind == Kind::Moving { rounding } else { rounding * condition };
        let bound = amplified.max(ASSEMBLED * scale);
        for (name, &expected) in members {
            let variable = instance.variable(name).ok_or(format!("`{name}` is missing"))?;
            let value = instance.get(variable).map_err(|error| error.to_string())?;
            let agrees = (value - expected).abs() <= bound;
            if !agrees {
                return Err(format!("{name} is {value} instead of {expected}, bound {bound:e}"));
            }
        }
    }
    Ok(())
}

/// Quantities with a common scale. What depends on positions and velocities only is evaluated, its errors are roundings; accelerations and reactions
/// come from a linear system, which amplifies the rounding of its entries by its condition number.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Moving,
    Acceleration,
    Reaction,
}

impl Kind {
    /// Joints are `j0`, drivers `d0` in random mechanisms.
    fn of(name: &str) -> Kind {
        let quantity = name.rsplit('.').next().unwrap_or_default();
        match quantity {
            "ax" | "ay" | "alpha" | "a" => Kind::Acceleration,
            "fx" | "fy" | "fn" | "torque" | "force" | "power" if name.starts_with(['j', 'd']) => Kind::Reaction,
            _ => Kind::Moving,
        }
    }
}

/// Condition number of \[M J^T; J 0\] at the initial state, with the active loop equations, scaled so that coordinates move unit mass and loop
/// equations have unit length: what no choice of units can improve much (van der Sluis 1969).
fn condition(formulated: &Formulated) -> f64 {
    let matrix = matrix(formulated);
    let n = formulated.equations.coordinates.len();
    if matrix.is_empty() {
        return 1.0;
    }
    let heaviest = (0..n).map(|i| matrix[(i, i)]).fold(f64::MIN_POSITIVE, f64::max);
    let weight = |i: usize| matrix[(i, i)].max(1e-4 * heaviest);
    let scale: Vec<f64> = (0..matrix.nrows())
        .map(|i| if i < n { weight(i) } else { (0..n).map(|j| matrix[(i, j)].powi(2) / weight(j)).sum() })
        .map(|square: f64| square.sqrt().recip())
        .collect();
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.nrows(), |i, j| scale[i] * scale[j] * matrix[(i, j)]);
    let values = scaled.singular_values();
    values.max() / values.min()
}

fn matrix(formulated: &Formulated) -> DMatrix<f64> {
    let mut equations: Equations = formulated.equations.clone();
    let dynamics = equations.dynamics().clone();
    let n = equations.coordinates.len();
    let active: Vec<usize> =
        (0..equations.constraints.len()).filter(|row| !formulated.redundant.contains(row)).collect();
    let state = &formulated.state;
    let values = |symbol: Symbol| match symbol {
        Symbol::Coordinate(i, Order::Position) => state.positions()[i],
        Symbol::Time => state.time(),
        other => panic!("M and Phi_q must not depend on {other:?}"),
    };
    let evaluate = |expr| equations.system.arena.evaluate(&[expr], &values)[0];
    let mut matrix = DMatrix::zeros(n + active.len(), n + active.len());
    for (row, entries) in dynamics.mass.iter().enumerate() {
        for &(column, entry) in entries {
            matrix[(row, column)] = evaluate(entry);
        }
    }
    for (place, &row) in active.iter().enumerate() {
        for &(column, entry) in &equations.constraints[row].jacobian {
            let value = evaluate(entry);
            matrix[(n + place, column)] = value;
            matrix[(column, n + place)] = value;
        }
    }
    matrix
}
