//! What the loop equations restrict: which of them are imposed, which repeat others, and what they imply in second order only.
//!
//! A loop equation whose gradient vanishes in the poses of the motion cannot be imposed there; left out, it would not hold. What it forbids gets an equation of its own: a
//! constant angle of a body, a constant sum or difference of two, or a constant coordinate of a mass centre. Planar angles add up linearly, so this says "level", "parallel" and "in line";
//! a direction that turns with the mechanism cannot be said so, and is refused.

use cotree_fmu::constraints::poses::scaled_rates;
use cotree_fmu::model::{Model, State};
use nalgebra::DVector;

use super::explain::assembly::owner_span;
use super::first_state;
use super::start::Start;
use crate::diagnostic::Fault;
use crate::diagnostic::suggest::list;
use crate::equations::{Equations, RowKind, Standing};
use crate::expr::Expr;
use crate::model::{BodyId, Dimension, Owner, Place, Quantity, Variable};
use crate::network::{Implied, ImpliedMeasure, System};
use crate::redundancy::independence::{Independence, independence};

/// How far a sum of coordinates may deviate where it counts as constant: poses lie within the root of what is left of the loops, on a way of about 1.
const CONSTANT: f64 = 1e-4;
/// A relation forbids a direction if it changes by more than this share of a step along it.
const FORBIDS: f64 = 0.05;
/// The step of that test.
const STEP: f64 = 1e-4;

/// What is imposed, at a state that satisfies it.
pub(super) struct Restrictions {
    pub equations: Equations,
    pub model: Model,
    pub state: State,
    /// Another one, where loop equations depend on each other only if they do in every pose of the motion.
    pub generic: State,
}

impl Restrictions {
    /// Directions of motion.
    pub fn mobility(&self) -> usize {
        let imposed = self.equations.rows_of(Standing::Imposed).len();
        self.equations.coordinates.len().saturating_sub(imposed)
    }
}

/// Finds out what the loop equations restrict at a state where they hold, and adds what they imply.
///
/// # Errors
/// What they restrict cannot be decided, or cannot be said by constant relations.
pub(super) fn restrictions(
    mut equations: Equations,
    (model, state): (Model, State),
    length: f64,
    start: Option<&Start>,
) -> Result<Restrictions, Vec<Fault>> {
    let found = independence(&model, &state, || ahead(&mut equations, &model, &state), &[]);
    let found = found.map_err(|undecided| vec![undecided_fault(&equations, &undecided.rows)])?;
    if found.forbidden.is_empty() {
        judge(&mut equations, &found.independent, &[]);
        let generic = generic(found, &state);
        return Ok(Restrictions { equations, model, state, generic });
    }
    let implied = implied(&mut equations, &model, &found).ok_or_else(|| vec![turns(&equations, &found.restricting)])?;
    let first = equations.constraints.len();
    let system = System::new(&equations.system.mechanism).implying(&implied);
    let mut equations = Equations::new(system, equations.trees);
    let mut faults = Vec::new();
    let (model, state) = first_state(&mut equations, length, start, &mut faults)?;
    if !faults.is_empty() {
        return Err(faults);
    }
    let rows: Vec<usize> = (first..equations.constraints.len()).collect();
    let restricting = found.restricting;
    let again = independence(&model, &state, || ahead(&mut equations, &model, &state), &rows);
    let again = again.map_err(|undecided| vec![undecided_fault(&equations, &undecided.rows)])?;
    if !again.forbidden.is_empty() || again.mobility != found.mobility {
        return Err(vec![turns(&equations, &restricting)]);
    }
    judge(&mut equations, &again.independent, &restricting);
    let generic = generic(again, &state);
    Ok(Restrictions { equations, model, state, generic })
}

/// Where the rows were counted.
fn generic(found: Independence, state: &State) -> State {
    found.poses.into_iter().next().unwrap_or_else(|| state.clone())
}

/// Gives each loop equation its standing: `independent` ones, in ascending order, are imposed, and `restricting` ones restrict in second order only.
pub(super) fn judge(equations: &mut Equations, independent: &[usize], restricting: &[usize]) {
    for (index, row) in equations.constraints.iter_mut().enumerate() {
        if row.standing().is_none() {
            continue;
        }
        row.kind = RowKind::Loop(if independent.binary_search(&index).is_ok() {
            Standing::Imposed
        } else if row.is_trivial() {
            Standing::Trivial
        } else if restricting.contains(&index) {
            Standing::SecondOrder
        } else {
            Standing::Repeats
        });
    }
}

/// Where the mechanism will move first: as it does already, as its loads push, and all coordinates alike. In units of the scales.
fn ahead(equations: &mut Equations, model: &Model, state: &State) -> Vec<Vec<f64>> {
    let coordinates = model.program().branch_coordinates();
    let load = equations.dynamics().load.clone();
    let push = equations.system.arena.evaluate(&load, state);
    let push = push.iter().zip(coordinates).map(|(load, coordinate)| load * coordinate.scale).collect();
    vec![scaled_rates(model, state), push, vec![1.0; coordinates.len()]]
}

/// What of bodies may be constant, as an expression with its natural size.
struct Candidate {
    terms: Vec<(f64, BodyId, ImpliedMeasure)>,
    name: String,
    value: Expr,
    size: f64,
    /// How it changes along each forbidden direction.
    slopes: DVector<f64>,
}

/// Constant relations that forbid all directions which the loop equations forbid in second order; none if there are too few.
fn implied(equations: &mut Equations, model: &Model, found: &Independence) -> Option<Vec<Implied>> {
    let mut candidates = single(equations, model, found);
    candidates.retain(|candidate| candidate.slopes.norm() > FORBIDS);
    let pairs = pairs(equations, &candidates);
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut relations = Vec::new();
    for candidate in candidates.into_iter().chain(pairs) {
        if basis.len() == found.forbidden.len() {
            break;
        }
        let mut new = candidate.slopes.clone();
        basis.iter().for_each(|direction| new -= direction * direction.dot(&new));
        if new.norm() > FORBIDS && is_constant(equations, found, &candidate) {
            let offset = equations.system.arena.evaluate(&[candidate.value], &found.poses[0])[0];
            relations.push(Implied { name: candidate.name, terms: candidate.terms, offset });
            basis.push(new.normalize());
        }
    }
    (basis.len() == found.forbidden.len()).then_some(relations)
}

/// The angles of all bodies, then the coordinates of their mass centres.
fn single(equations: &mut Equations, model: &Model, found: &Independence) -> Vec<Candidate> {
    let mechanism = &*equations.system.mechanism.clone();
    let length = model.program().length;
    let turns: &[_] =
        if mechanism.dimension == Dimension::Two { &[(ImpliedMeasure::Angle, Quantity::Angle, 1.0)] } else { &[] };
    let moves = [(ImpliedMeasure::X, Quantity::X, length), (ImpliedMeasure::Y, Quantity::Y, length)];
    let kinds = turns.iter().chain(if mechanism.dimension == Dimension::Two { &moves[..] } else { &moves[..1] });
    let mut candidates = Vec::new();
    for &(measured, quantity, size) in kinds {
        for body in (0..mechanism.bodies.len()).map(BodyId) {
            let variable = Variable { owner: Owner::Place(Place::Centre(body)), quantity };
            candidates.push(Candidate {
                terms: vec![(1.0, body, measured)],
                name: mechanism.variable_name(variable),
                value: equations.variable(variable),
                size,
                slopes: DVector::zeros(0),
            });
        }
    }
    let values: Vec<Expr> = candidates.iter().map(|candidate| candidate.value).collect();
    let ways: Vec<Vec<f64>> =
        found.forbidden.iter().map(|way| slopes(equations, model, &found.poses[0], way, &values)).collect();
    for (index, candidate) in candidates.iter_mut().enumerate() {
        candidate.slopes = DVector::from_iterator(ways.len(), ways.iter().map(|way| way[index] / candidate.size));
    }
    candidates
}

/// Derivatives of expressions along a direction in units of the scales.
fn slopes(equations: &Equations, model: &Model, pose: &State, way: &[f64], values: &[Expr]) -> Vec<f64> {
    let [ahead, behind] = [STEP, -STEP].map(|step| {
        let mut moved = pose.clone();
        let coordinates = model.program().branch_coordinates();
        for ((place, way), coordinate) in moved.positions_mut().iter_mut().zip(way).zip(coordinates) {
            *place += step * way * coordinate.scale;
        }
        equations.system.arena.evaluate(values, &moved)
    });
    ahead.iter().zip(behind).map(|(ahead, behind)| (ahead - behind) / (2.0 * STEP)).collect()
}

/// Differences and sums of the angles of two bodies.
fn pairs(equations: &mut Equations, candidates: &[Candidate]) -> Vec<Candidate> {
    let angles: Vec<&Candidate> =
        candidates.iter().filter(|candidate| matches!(candidate.terms[..], [(_, _, ImpliedMeasure::Angle)])).collect();
    let mut pairs = Vec::new();
    for (sign, word) in [(-1.0, "-"), (1.0, "+")] {
        for (index, a) in angles.iter().enumerate() {
            for b in &angles[index + 1..] {
                let factor = equations.system.arena.constant(sign);
                pairs.push(Candidate {
                    terms: vec![a.terms[0], (sign, b.terms[0].1, ImpliedMeasure::Angle)],
                    name: format!("{} {word} {}", a.name, b.name),
                    value: equations.system.arena.add_product(a.value, factor, b.value),
                    size: 1.0,
                    slopes: &a.slopes + sign * &b.slopes,
                });
            }
        }
    }
    pairs
}

/// Is it the same in all poses of the motion?
fn is_constant(equations: &Equations, found: &Independence, candidate: &Candidate) -> bool {
    let value = |pose: &State| equations.system.arena.evaluate(&[candidate.value], pose)[0];
    let first = value(&found.poses[0]);
    found.poses.iter().all(|pose| (value(pose) - first).abs() <= CONSTANT * candidate.size)
}

/// The joints and drivers that loop equations belong to.
pub(super) fn owners(equations: &Equations, rows: &[usize]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for &row in rows {
        let name = &equations.system.element(equations.constraints[row].element).name;
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}

fn undecided_fault(equations: &Equations, rows: &[usize]) -> Fault {
    let names = owners(equations, rows);
    let message = format!(
        "the degrees of freedom of {} cannot be decided: the loops constrain them to higher than second order",
        list(&names)
    );
    fault(equations, &names, message).help(
        "the motion there depends on rounding errors: change a length slightly, or remove the redundant constraint",
    )
}

fn turns(equations: &Equations, rows: &[usize]) -> Fault {
    let names = owners(equations, rows);
    let message = format!(
        "together with other joints, {} {} a motion to second order only, in a direction that turns with the mechanism",
        list(&names),
        if names.len() == 1 { "forbids" } else { "forbid" }
    );
    fault(equations, &names, message).help(
        "no constant angle or coordinate of a body expresses this constraint: where two links hold a point in line, replace them by one, or give the point a link of its own",
    )
}

fn fault(equations: &Equations, names: &[String], message: String) -> Fault {
    let span = names.first().map(|name| owner_span(equations, name)).unwrap_or_default();
    Fault::new("assembly::second_order", message, span).label("one of them")
}
