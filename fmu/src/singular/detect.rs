//! Singular poses: where a mechanism could leave its branch, and steps that cannot.
//!
//! In a singular pose (all bars of a loop in line, say) the rows of the Jacobian depend on each other and two branches of the motion cross. The motion itself
//! is analytic in time and goes straight on; but what is computed close to the pose knows the branch only up to rounding errors divided by
//! the distance. So nothing may be evaluated there: no step ends near a singular pose, and the polynomial of the step before
//! carries the motion across.
//!
//! The distance comes for nothing with the inverse of \[M J^T; J 0\]: the diagonal of its lower right block is that of
//! (J M^-1 J^T)^-1, and r_k = 1 / sqrt of its entry k is how far row k of J is from the rows that it may come to depend on. It passes zero like a straight
//! line in time.

use nalgebra::DMatrix;

use crate::constraints::poses::{imposed, rows_of};
use crate::constraints::reciprocals::{is_jump, is_within};
use crate::linalg::sparse::{Factors, SparseRow, product_with_transposed};
use crate::linalg::spectrum::{ends, ends_of_many};
use crate::math::{self, Random};
use crate::model::{Model, State};

/// A step may bring a row this much closer to the others.
const CLOSER_PER_STEP: f64 = 0.25;
/// A row that comes closer by this factor in one step may be on its way to a singular pose.
const FALLS: f64 = 1.05;
/// A pose further away than so many steps is of no concern.
pub(crate) const HORIZON: f64 = 12.0;
/// A row that has passed a pose has less than this share of its distance about there.
pub(crate) const HALF: f64 = 0.5;
/// A coarse tolerance: steps at this one or a larger one are as long as the way between poses, and may lie across one and show nothing at their ends. Steps that stiffness holds back pass a pose
/// at it.
pub(crate) const COARSE: f64 = 1e-5;
/// Steps at this tolerance show every pose that they come by.
pub(crate) const SIGHTED: f64 = 1e-6;
/// A row that comes closer by this factor in one step is about to arrive; one that was coming closer and ends a step with more than this share of its distance has turned round, or has passed a
/// singular pose.
pub(crate) const COMES_CLOSER: f64 = 0.8;
/// A joint or a loop equation takes part in a dependence with at least this share of the largest one.
pub(crate) const SHARE_OF_LARGEST: f64 = 0.1;
/// With more loop equations than this the weakest combination is found by iteration.
const MANY: usize = 100;
/// Loop equations are compared with those in so many poses around, up to a scale away in each coordinate.
const POSES: usize = 3;
/// A start is in the zone of a singular pose if a step along it brings a row so many times further from the others.
const ESCAPE: f64 = 20.0;

/// Shares of a usual step: the distance from which a step passes a pose best, and the largest one.
const TAKE_OFF: f64 = 0.77;
const PASSES: f64 = 0.85;
/// Length of the step that passes, in units of the distance: nothing is evaluated near the pose.
pub(crate) const LANDING: f64 = 1.28;

/// The share of the distance where the step begins that is as good as none.
const THERE: f64 = 0.02;
/// A pose at which this share is left is no singular one.
const NONE: f64 = 0.15;
/// Attempts to find the time of the pose.
const SECANTS: usize = 4;

/// Where the time of a pose is made more precise, before and after it, in shares of a step.
const CLOSER: [f64; 3] = [0.05, 2e-3, 1e-4];

/// How close the loop equations are to depending on each other, where the step begins and at the end of a step: 1 / r_k^2.
#[derive(Clone, Debug)]
pub struct Guard {
    pub start: Vec<f64>,
    pub next: Vec<f64>,
}

/// What a step does about a singular pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Plan {
    /// There is none near enough.
    Free,
    /// At most this long.
    Approach(f64),
    /// At least this long: it passes the pose.
    Pass(f64),
}

/// The plan for a pose so far ahead, if steps are usually so long.
pub fn plan(ahead: f64, usual: f64) -> Plan {
    if ahead <= PASSES * usual {
        Plan::Pass(LANDING * ahead)
    } else if ahead <= (1.0 + TAKE_OFF) * usual {
        Plan::Approach(ahead - TAKE_OFF * usual)
    } else {
        Plan::Free
    }
}

/// Finds the next singular pose near a guess of how far it is ahead, by the share that the row closest to the others has of its distance now.
pub fn locate(guess: f64, mut share_at: impl FnMut(f64) -> f64) -> Option<f64> {
    let (mut best, mut share) = (guess, share_at(guess));
    for _ in 0..SECANTS {
        if share < THERE {
            break;
        }
        let mut evaluate = |time: f64| (time, share_at(time));
        // The guess is behind the pose, which is likelier (the distance falls faster and faster, like a sine), or before it.
        let passed = evaluate(best / (1.0 + share));
        let may_come = passed.1 >= THERE && share < COMES_CLOSER;
        let coming = if may_come { evaluate(best / (1.0 - share)) } else { passed };
        let (time, least) = if coming.1 <= passed.1 { coming } else { passed };
        if least >= share {
            break;
        }
        (best, share) = (time, least);
    }
    (share < NONE).then_some(best)
}

/// The time of a pose that is known about, more precisely: the distance from it grows alike on both sides. `span`: the length of the step. (A place on one side alone does not tell: where branches miss each
/// other the distance does not fall to zero.)
pub fn refine(at: f64, span: f64, mut share_at: impl FnMut(f64) -> f64) -> f64 {
    CLOSER.iter().fold(at, |at, closer| {
        let [before, after] = [-1.0, 1.0].map(|side| share_at(at + side * closer * span));
        let shift = closer * span * (before - after) / (before + after);
        if shift.is_finite() { at + shift } else { at }
    })
}

/// The place of a singular pose within a step of length h that none was announced for, where the smallest distance at its end is this share of that at its start.
/// `share_at` is that share after a time.
pub(crate) fn leapt_over(h: f64, share: f64, mut share_at: impl FnMut(f64) -> f64) -> Option<f64> {
    let [mut before, mut best, mut after] = valley([0.0, 1.0], [h, share], 1, &mut share_at)?;
    for _ in 0..SECANTS {
        if best[1] < THERE {
            break;
        }
        let (left, right) = (lowest(before, best, &mut share_at), lowest(best, after, &mut share_at));
        if best[1] <= left[1].min(right[1]) {
            break;
        }
        (before, best, after) = if left[1] < right[1] { (before, left, best) } else { (best, right, after) };
    }
    (best[1] < NONE).then_some(best[0])
}

/// A time, and how far from a singular pose the motion is then.
type Place = [f64; 2];

/// Between two places of a distance that falls to zero and rises again, as straight lines have it.
fn lowest([from, there]: Place, [to, here]: Place, share_at: &mut impl FnMut(f64) -> f64) -> Place {
    let time = from + (to - from) * there / (there + here);
    [time, share_at(time)]
}

/// A place that is much lower than both of its neighbours. Looked for between two places, and then on both sides of what was found, so many times.
fn valley(from: Place, to: Place, more: u32, share_at: &mut impl FnMut(f64) -> f64) -> Option<[Place; 3]> {
    let middle = lowest(from, to, share_at);
    if middle[1] < HALF * math::minimum(from[1], to[1]) {
        return Some([from, middle, to]);
    }
    let more = more.checked_sub(1)?;
    valley(from, middle, more, share_at).or_else(|| valley(middle, to, more, share_at))
}

impl Guard {
    /// For so many joints.
    pub fn new(joints: usize) -> Self {
        Self { start: vec![0.0; joints], next: vec![0.0; joints] }
    }

    /// The end of the step has become the start of the next one.
    pub fn roll(&mut self) {
        self.start.copy_from_slice(&self.next);
    }

    /// Where the step begins, is a loop equation this close to the others?
    pub fn begins_within(&self, distance: f64) -> bool {
        self.start.iter().any(|start| is_within(*start, distance))
    }

    /// Is the end of the step in the zone of a singular pose, as seen from its start?
    pub fn ends_near(&self) -> bool {
        let growth = 1.0 / (CLOSER_PER_STEP * CLOSER_PER_STEP);
        self.start.iter().zip(&self.next).any(|(start, next)| *next > growth * start && *start > 0.0)
    }

    /// Was the start of the step in the zone of a singular pose, as seen from its end?
    pub fn began_near(&self) -> bool {
        self.start.iter().zip(&self.next).any(|(start, next)| *start > ESCAPE * ESCAPE * next && *next > 0.0)
    }

    /// Does a row come so much closer to the others in the step, or go so much further from them, that it could have gone over to another branch?
    pub fn jumps(&self) -> bool {
        self.start.iter().zip(&self.next).any(|(start, next)| *start > 0.0 && is_jump(*start, *next))
    }

    /// The smallest r_k at the end of the step, as a share of that at its start.
    pub fn share(&self) -> f64 {
        let squares =
            self.start.iter().zip(&self.next).filter(|(start, _)| **start > 0.0).map(|(start, next)| start / next);
        squares.fold(f64::INFINITY, f64::min).sqrt()
    }

    /// Does a row come so close that the loops must be closed tightly?
    pub fn arrives(&self) -> bool {
        self.share() < COMES_CLOSER
    }

    /// When a row that was coming closer may have passed a singular pose in a step of length h.
    pub fn turned(&self, h: f64) -> Option<f64> {
        let share = self.share();
        (share > COMES_CLOSER).then_some(h / (1.0 + share))
    }

    /// How long after the step a row will depend on the others, if it comes closer at the same rate; 0 if none does soon.
    pub fn ahead(&self, h: f64) -> f64 {
        let ahead = self.arrival(h);
        if self.share() * FALLS < 1.0 && ahead < HORIZON * h { ahead } else { 0.0 }
    }

    /// How long after the step a row would depend on the others, if it came closer at the same rate.
    pub fn arrival(&self, h: f64) -> f64 {
        let share = self.share();
        if share < 1.0 { h * share / (1.0 - share) } else { f64::INFINITY }
    }
}

/// Joints and drivers whose loop equations depend on each other at a state, or do so most, and how far from it they are, relative to how far they are in
/// other poses: 0 to 1.
pub fn dependent(model: &Model, state: &State) -> (f64, Vec<String>) {
    let imposed = imposed(model, state);
    dependent_in(model, &imposed, &poses_around(model, state, &imposed))
}

/// Is that distance less than this?
pub fn depends_within(model: &Model, state: &State, distance: f64) -> bool {
    let imposed = imposed(model, state);
    let poses = poses_around(model, state, &imposed);
    // Rows are not larger than 1, and so no further from depending on each other in any pose.
    let apart = poses.first().is_some_and(|here| is_apart(here, distance));
    !apart && dependent_in(model, &imposed, &poses).0 < distance
}

/// What [`dependent`] says of rows in a pose and in others.
fn dependent_in(model: &Model, imposed: &[usize], poses: &[Vec<SparseRow>]) -> (f64, Vec<String>) {
    let mut found = poses.iter().filter_map(|rows| distance(model, (imposed, rows)));
    let Some((here, joints)) = found.next() else { return (1.0, Vec::new()) };
    let usual = found.fold(here, |most, (distance, _)| math::maximum(most, distance));
    (if here > 0.0 { here / usual } else { 0.0 }, joints)
}

/// The rows of loop equations at a state and in poses around it, each 1 where it is largest.
fn poses_around(model: &Model, state: &State, imposed: &[usize]) -> Vec<Vec<SparseRow>> {
    let mut poses = vec![rows_of(model, state, imposed)];
    // A law may have no value in some poses.
    let is_defined = |rows: &Vec<SparseRow>| rows.iter().flat_map(SparseRow::values).all(|entry| entry.is_finite());
    poses.extend(open_poses(model, state).map(|pose| rows_of(model, &pose, imposed)).filter(is_defined));
    divide_by_sizes(&mut poses);
    poses
}

/// Are all eigenvalues of J J^T larger than the square of a distance? They are if what is left without it has positive pivots (Golub and Van Loan, Matrix
/// Computations, 2013, 8.1.5).
fn is_apart(rows: &[SparseRow], distance: f64) -> bool {
    let mut product = product_with_transposed(rows);
    for (index, row) in product.iter_mut().enumerate() {
        *row.entry(index).or_default() -= distance * distance;
    }
    Factors::new(product).is_some()
}

/// How far rows of loop equations of about unit size are from depending on each other, and the joints and drivers that do so most.
fn distance(model: &Model, (imposed, rows): (&[usize], &[SparseRow])) -> Option<(f64, Vec<String>)> {
    // The largest combination is no measure: a single row, and rows that vanish together, would never depend on each other.
    let (least, _, combination) = weakest(model, rows)?;
    Some((least.max(0.0).sqrt(), named(model, imposed, &combination)))
}

/// Poses around a state, whose loops are open.
pub(super) fn open_poses(model: &Model, state: &State) -> impl Iterator<Item = State> {
    let mut random = Random::new(3);
    (0..POSES).map(move |_| {
        let mut pose = state.clone();
        let places = pose.positions_mut().iter_mut().zip(&model.program().coordinates);
        places.for_each(|(place, coordinate)| *place += coordinate.scale * random.symmetric());
        pose
    })
}

/// Makes each row 1 where it is largest: between angles and lengths of whatever order some rows are smaller than others in all poses.
fn divide_by_sizes(poses: &mut [Vec<SparseRow>]) {
    let size = |row: &SparseRow| row.values().map(|entry| entry * entry).sum::<f64>().sqrt();
    for index in 0..poses.first().map_or(0, Vec::len) {
        let largest = poses.iter().map(|rows| size(&rows[index])).fold(0.0, math::maximum);
        if largest > 0.0 {
            poses.iter_mut().flat_map(|rows| rows[index].values_mut()).for_each(|entry| *entry /= largest);
        }
    }
}

/// The combination of some loop equations, given with their rows, that holds least, and the joints and drivers that take part in it.
pub(crate) fn weakest_combination(
    model: &Model,
    (imposed, rows): (&[usize], &[SparseRow]),
) -> Option<(Vec<f64>, Vec<String>)> {
    let (_, _, combination) = weakest(model, rows)?;
    let joints = named(model, imposed, &combination);
    Some((combination, joints))
}

/// The smallest and the largest eigenvalue of J J^T, and the combination that belongs to the smallest.
pub(crate) fn weakest(model: &Model, rows: &[SparseRow]) -> Option<(f64, f64, Vec<f64>)> {
    if rows.len() > MANY {
        return ends_of_many(rows);
    }
    let columns = model.coordinates();
    ends(&DMatrix::from_fn(rows.len(), columns, |row, column| rows[row].get(&column).copied().unwrap_or_default()))
}

/// The joints and drivers that take part in a combination of loop equations.
fn named(model: &Model, imposed: &[usize], combination: &[f64]) -> Vec<String> {
    let share = SHARE_OF_LARGEST * combination.iter().fold(0.0, |largest, part| math::maximum(largest, part.abs()));
    let taking_part = imposed.iter().zip(combination).filter(|(_, part)| part.abs() > share);
    let constraints = &model.program().constraints;
    let mut joints: Vec<String> = taking_part.map(|(&row, _)| constraints[row].owner.clone()).collect();
    joints.dedup();
    joints
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_comes_closer_evenly_arrives_when_predicted() {
        let mut guard = Guard::new(2);
        guard.start = vec![1.0, 4.0];
        guard.next = vec![1.0, 16.0];
        assert!((guard.ahead(0.3) - 0.3).abs() < 1e-12);
        assert!(!guard.ends_near() && !guard.began_near());
        guard.next = vec![1.0, 100.0];
        assert!(guard.ends_near());
        (guard.start, guard.next) = (guard.next.clone(), vec![1.0, 0.2]);
        assert!(guard.began_near());
    }

    #[test]
    fn rows_are_apart_up_to_their_distance() {
        // Two unit vectors at an angle: the smallest eigenvalue is 1 - cos.
        let angle: f64 = 0.2;
        let rows = [vec![(0, 1.0)], vec![(0, angle.cos()), (1, angle.sin())]];
        let rows = rows.map(SparseRow::from_iter);
        let distance = (1.0 - angle.cos()).sqrt();
        assert!(is_apart(&rows, 0.999 * distance) && !is_apart(&rows, 1.001 * distance));
        assert!(is_apart(&[], 0.1) && !is_apart(&[SparseRow::from([(0, f64::NAN)])], 0.1));
    }

    #[test]
    fn no_planned_step_ends_near_the_pose() {
        for usual in [1e-3, 1.0] {
            let mut ahead = 4.0 * usual;
            while ahead > 0.0 {
                let h = match plan(ahead, usual) {
                    Plan::Free => usual,
                    Plan::Approach(most) => most.min(usual),
                    Plan::Pass(least) => least,
                };
                assert!((ahead - h).abs() > 0.2 * ahead && h > 0.05 * usual, "{ahead} {h}");
                ahead -= h;
            }
        }
    }
}
