//! Singular poses that a run passes: judged by the motion there, and noted.

use super::crossing::Crossing;
use crate::math;
use crate::model::{Model, State};
use crate::motion::passage::Passage;
use crate::motion::poses::Follow;
use crate::motion::run::Run;
use crate::singular::detect::SHARE_OF_LARGEST;

/// What rounding errors of lengths make of branches that meet, in units of their spacing; those of positions count, for angles grow with every turn.
const ROUNDING_OF_BRANCHES: f64 = 64.0;

/// Judges a singular pose that the next step of a run passes, by the motion there, and notes it. False if the branches do not meet there: the step must
/// be taken again, following the curve.
pub(crate) fn note_passage(run: &mut Run, model: &Model, time: f64, pose: &[f64]) -> bool {
    let passage = passage(run, model, time, pose);
    if avoids(run, &passage) {
        return false;
    }
    let known = &mut run.singular;
    known.pose = Some(time);
    known.passages.push(passage);
    true
}

/// Is this a pose where branches come close to each other but do not meet, seen from the motion there? The next steps then follow the curve. If they almost meet it
/// is passed, and that is to be said.
pub(crate) fn finds_avoided(run: &mut Run, model: &Model, time: f64, pose: &[f64]) -> bool {
    let passage = passage(run, model, time, pose);
    let avoided = avoids(run, &passage);
    if !avoided && passage.is_inexact() {
        run.singular.passages.push(passage);
    }
    avoided
}

/// Notes a singular pose that is passed by leaving its zone, unless the step that first passed it has been noted.
pub(crate) fn note_left(run: &mut Run, model: &Model, [from, pose]: [f64; 2], there: &[f64]) {
    if pose > from && !run.singular.passages.iter().any(|passage| passage.time > from) {
        let passage = passage(run, model, pose, there);
        if !passage.is_avoided() {
            run.singular.passages.push(passage);
        }
    }
}

fn avoids(run: &mut Run, passage: &Passage) -> bool {
    let avoided = passage.is_avoided();
    if avoided {
        let ahead = passage.time - run.last.end_time;
        let known = &mut run.singular;
        known.follow = Some(Follow::past(passage.time, ahead));
        (known.ahead, known.pose) = (0.0, None);
    }
    avoided
}

fn passage(run: &Run, model: &Model, time: f64, pose: &[f64]) -> Passage {
    describe(model, &run.state_at(model, time, pose))
}

/// Each number once.
fn in_order(mut numbers: Vec<usize>) -> Vec<usize> {
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// Describes the pose of a state.
pub(crate) fn describe(model: &Model, state: &State) -> Passage {
    let mut passage = Passage { time: state.time(), joints: Vec::new(), bodies: Vec::new(), freedoms: 0, defect: 0.0 };
    let program = model.program();
    let Some(found) = Crossing::of(model, state) else { return passage };
    passage.freedoms = found.combinations.len();
    let shares = found.combinations.iter().flatten().filter(|(_, share)| share.abs() > SHARE_OF_LARGEST);
    let part = in_order(shares.map(|(place, _)| *place).collect());
    passage.joints = part.iter().map(|&place| program.constraints[found.imposed[place]].owner.clone()).collect();
    passage.joints.dedup();
    let moved = in_order(part.iter().flat_map(|&place| &found.columns[place]).copied().collect());
    let turning = moved.iter().filter_map(|&index| program.coordinates[index].name.strip_suffix(".angle"));
    passage.bodies = turning.map(String::from).collect();
    let coordinates = program.coordinates.iter().zip(state.positions()).take(model.mechanical());
    let largest =
        coordinates.fold(1.0, |most, (coordinate, place)| math::maximum(most, place.abs() / coordinate.scale));
    passage.defect = if found.defect > ROUNDING_OF_BRANCHES * f64::EPSILON * largest { found.defect } else { 0.0 };
    passage
}
