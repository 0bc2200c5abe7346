//! Joints that events engage, and rates that they set: what of them is free to be held.

use cotree_fmu::constraints::poses::sparse_jacobian;
use cotree_fmu::linalg::sparse::{SparseRow, independent_rows};
use cotree_fmu::model::{Model, State};

use crate::diagnostic::Fault;
use crate::equations::{Equations, Standing, impulse_of};
use crate::model::{DiscreteId, Engaging, Mechanism, Owner, Quantity};
use crate::network::{Constrained, Origin};
use crate::redundancy::nearby::consistent_poses;

/// A row counts as dependent when less than this share of it is new.
const NEW: f64 = 1e-8;
/// The same as no doubt.
const CLEAR: f64 = 1e-4;
/// Poses near the start, how far they are apart in units of the scales, and the parts of the way to them.
const SAMPLES: (usize, f64, usize) = (5, 0.3, 12);

/// What engages or is set, but moves by drivers alone.
pub(super) fn check(equations: &Equations) -> Vec<Fault> {
    let mechanism = &equations.system.mechanism;
    let driven = equations.is_driven();
    let mut faults = Vec::new();
    for (index, set) in mechanism.set_rates.iter().enumerate() {
        let id = equations.system.find(Origin::SetRate(index));
        let moves = equations.constraints.iter().any(|row| Some(row.element) == id && !row.is_trivial());
        if driven || !moves {
            let message =
                format!("an event sets `{}`, which drivers or joints prescribe", mechanism.variable_name(set.variable));
            let fault = Fault::new("scene::engage", message, set.span).label("prescribed");
            faults
                .push(fault.help("set a rate that the loads determine, or replace the driver by a force or a torque"));
        }
    }
    let joints = mechanism.parts().filter(|part| driven && mechanism.engaging(part.owner).is_some());
    faults.extend(joints.map(|part| {
        let message = format!("joint `{}` engages by an event, but drivers determine the whole motion", part.name);
        let fault = Fault::new("scene::engage", message, part.span).label("holds what drivers move");
        fault.help("replace the driver by a force or a torque, or leave the joint out")
    }));
    faults
}

/// The same mechanism without the loop equations of joints that engage which others repeat in every pose; none if there are none.
pub(super) fn without_repeated(equations: &mut Equations, model: &Model, state: &State) -> Option<Mechanism> {
    let mechanism = equations.system.mechanism.clone();
    if mechanism.engaging.is_empty() {
        return None;
    }
    let (samples, distance, parts) = SAMPLES;
    let poses = consistent_poses(model, state, samples, distance, parts);
    let poses: Vec<State> = poses.into_iter().map(|pose| engaged(equations, pose)).collect();
    let jacobians: Vec<Vec<SparseRow>> = poses.iter().map(|pose| sparse_jacobian(model, pose)).collect();
    let mut changed = Mechanism::clone(&mechanism);
    let mut any = false;
    for (place, engaging) in mechanism.engaging.iter().enumerate() {
        let repeated = repeated(equations, engaging, &jacobians);
        any |= !repeated.is_empty();
        changed.engaging[place].left_out.extend(repeated);
    }
    any.then_some(changed)
}

/// The loop equations of a joint that the fewest of them imply, together with those that always hold, in all of these poses. Which ones remain must not depend on the pose: of a weld on a pendulum the angle suffices
/// everywhere, one of the displacements only where the arm is not along it.
fn repeated(equations: &Equations, engaging: &Engaging, jacobians: &[Vec<SparseRow>]) -> Vec<Quantity> {
    let always = equations.rows_of(Standing::Imposed);
    let mut joint: Vec<usize> = rows_of(equations, engaging.owner);
    joint.sort_by_key(|&row| equations.constraints[row].constrained != Constrained::Angle);
    let rank = |jacobian: &Vec<SparseRow>, chosen: &[usize]| {
        let rows = always.iter().chain(chosen).map(|&row| jacobian[row].clone()).collect();
        independent_rows(rows, NEW, CLEAR).1.len()
    };
    let ranks: Vec<usize> = jacobians.iter().map(|jacobian| rank(jacobian, &joint)).collect();
    let suffices =
        |chosen: &[usize]| jacobians.iter().zip(&ranks).all(|(jacobian, &all)| rank(jacobian, chosen) == all);
    let holds = subsets(&joint).into_iter().find(|chosen| suffices(chosen)).unwrap_or_else(|| joint.clone());
    let repeated = joint.iter().filter(|row| !holds.contains(row));
    repeated.filter_map(|&row| impulse_of(equations.constraints[row].constrained, engaging)).collect()
}

/// All subsets of a joint's three rows at most, smaller ones first, and of one size those with the first rows.
fn subsets(rows: &[usize]) -> Vec<Vec<usize>> {
    let chosen = |mask: u32| rows.iter().enumerate().filter(move |(place, _)| mask & (1 << place) != 0);
    let mut masks: Vec<u32> = (0..1 << rows.len()).collect();
    masks.sort_by_key(|mask| mask.count_ones());
    masks.into_iter().map(|mask| chosen(mask).map(|(_, &row)| row).collect()).collect()
}

fn rows_of(equations: &Equations, owner: Owner) -> Vec<usize> {
    let id = Origin::of(owner).and_then(|origin| equations.system.find(origin));
    let rows = equations.constraints.iter().enumerate();
    rows.filter(|(_, row)| Some(row.element) == id && row.contact().is_some()).map(|(index, _)| index).collect()
}

/// A pose in which all joints engage where they stand.
fn engaged(equations: &mut Equations, mut pose: State) -> State {
    let mechanism = equations.system.mechanism.clone();
    for event in &mechanism.events {
        for (id, written) in event.writes.iter().filter(|(id, _)| is_captured(&mechanism, *id)) {
            let value = equations.formula(written);
            let value = equations.system.arena.evaluate(&[value], &pose)[0];
            pose.discrete_mut()[id.0] = value;
        }
    }
    for engaging in &mechanism.engaging {
        pose.discrete_mut()[engaging.engaged.0] = 1.0;
    }
    pose
}

fn is_captured(mechanism: &Mechanism, id: DiscreteId) -> bool {
    matches!(mechanism.discrete[id.0].kind, crate::model::DiscreteKind::Captured(_))
}

/// Joints some of whose constraints hold anyway.
pub(super) fn warnings(equations: &Equations) -> Vec<Fault> {
    let mechanism = &equations.system.mechanism;
    let mut warnings = Vec::new();
    for engaging in &mechanism.engaging {
        let (all, holds) = (engaging.impulses.len(), rows_of(equations, engaging.owner).len());
        let Some(part) = mechanism.parts().find(|part| part.owner == engaging.owner).filter(|_| holds < all) else {
            continue;
        };
        let message =
            format!("`{}` holds {holds} of its {all} constraints: other joints hold the rest already", part.name);
        let fault = Fault::warning("scene::redundant", message, part.span).label("repeats others");
        warnings.push(fault.help("its reactions and impulses along the rest are shown as zero"));
    }
    warnings
}
