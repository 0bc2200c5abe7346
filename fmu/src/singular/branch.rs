//! Has the motion stayed on its branch where short steps pass a singular pose?
//!
//! Steps of natural length pass such a pose in one leap. Steps that stiffness keeps short come so close to it that rounding errors may decide where they
//! go on. In the pose the velocities v that continue a branch fulfil J v = 0 and, for the combination l of the loop equations that vanishes, l (J_q v) v = 0:
//! two straight lines, and l (J_q v) w = 0 too for v and w on the same one. So the rates a little before and a little after the pose tell the branches apart.

use super::crossing::Changes;
use super::passing::describe;
use crate::constraints::poses::{imposed, rows_of, scaled_rates};
use crate::constraints::reciprocals::read;
use crate::context::Context;
use crate::failure::Failure;
use crate::math;
use crate::model::{Model, State};
use crate::motion::Run;
use crate::motion::poses::SingularPoses;
use crate::motion::trail::WINDOW;
use crate::singular::detect::{COMES_CLOSER, dependent, weakest_combination};
/// What l (J_q v) w may be of the product of its factors if v and w belong to the same branch.
const SAME: f64 = 0.01;

/// Looks at the end of the last step.
///
/// # Errors
/// The motion has left its branch.
pub(crate) fn watch(context: &mut Context, run: &mut Run) -> Result<(), Failure> {
    let model = context.model;
    if model.program().tapes.reciprocal_pivots.is_empty() {
        return Ok(());
    }
    if !extend(context, run) {
        return Ok(());
    }
    let SingularPoses { trail, smallest, pose, .. } = &run.singular;
    let Some(closest) = trail.closest(smallest, *pose) else { return Ok(()) };
    let followed = run.singular.follow.is_some_and(|follow| follow.until >= trail.state(0)[0]);
    let at = |place: usize| {
        let state = trail.state(place);
        run.state_at(model, state[0], &state[1..])
    };
    if followed {
        return Ok(());
    }
    let distances = [0, closest, WINDOW - 1].map(|place| dependent(model, &at(place)).0);
    // Closeness in the metric of the masses alone may change while loop equations come no closer to depending on each other: very different masses do that.
    if distances[1] > COMES_CLOSER * math::minimum(distances[0], distances[2]) {
        return Ok(());
    }
    let before = trail.first();
    let (angle, joints) = turn(model, [&at(before), &at(closest), &at(WINDOW - 1)]);
    // Written so that no number is another branch too.
    let same = angle < SAME;
    if same {
        return Ok(());
    }
    let time = trail.state(closest)[0];
    Err(Failure::BranchLost { time, joints, named: context.settings.is_named() })
}

/// Adds the end of the last step to the trail; says whether it did.
fn extend(context: &mut Context, run: &mut Run) -> bool {
    let Context { model, machine, statistics, .. } = context;
    let Run { signals, last, singular } = run;
    singular.trail.extend(model, (last.end_time, &last.end), &mut singular.smallest, |state, rows| {
        machine.load_signals(model, &signals.origin, state[0]);
        machine.load_motion(model, &state[1..]);
        machine.run(&model.program().tapes.acceleration);
        statistics.evaluations += 1;
        read(model, machine, rows);
    })
}

/// l (J_q v) w at a pose for the rates before and after it, of the product of its factors; and the joints that take part in l. Zero where branches
/// only come close to each other: there the motion turns from the one to the other.
fn turn(model: &Model, [before, pose, after]: [&State; 3]) -> (f64, Vec<String>) {
    let imposed = imposed(model, pose);
    let rows = rows_of(model, pose, &imposed);
    let Some((combination, joints)) = weakest_combination(model, (&imposed, &rows)) else { return (0.0, Vec::new()) };
    let bend = change_along((model, pose), (imposed, &combination), &scaled_rates(model, before));
    let (mut product, mut bends, mut rates) = (0.0, 0.0, 0.0);
    for (bend, rate) in bend.iter().zip(scaled_rates(model, after)) {
        product += bend * rate;
        bends += bend * bend;
        rates += if *bend == 0.0 { 0.0 } else { rate * rate };
    }
    let factors = (bends * rates).sqrt();
    let angle = if factors > 0.0 { product.abs() / factors } else { 0.0 };
    let turned = angle >= SAME && !describe(model, pose).is_avoided();
    (if turned { angle } else { 0.0 }, joints)
}

/// How l J, the combination of the loop equations' rows, changes along a direction in units of the scales.
fn change_along(
    (model, pose): (&Model, &State),
    (imposed, combination): (Vec<usize>, &[f64]),
    direction: &[f64],
) -> Vec<f64> {
    let mut sum = vec![0.0; direction.len()];
    let directions = direction.iter().enumerate().map(|(column, part)| (column, [*part, 0.0, 0.0, 0.0]));
    for (row, column, change) in Changes::new(model, imposed).along(pose, directions) {
        sum[column] += combination[row] * change[0];
    }
    sum
}
