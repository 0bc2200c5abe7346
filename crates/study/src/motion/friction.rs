//! Work that dry friction dissipates, and whether the mechanism is self-locking.
//!
//! The motion is the same with friction and without it, so the drive's effort differs by what friction takes alone: the power of both is the power of what slides.

use serde::Serialize;

use super::drive::{self, InputTable, Moved};
use super::samples::{ANGULAR, Samples};
use super::{DrivenJoint, MotionError};

/// Less work than this share of what goes to and fro is none.
const NOTHING: f64 = 1e-9;

/// What the drive needs for dry friction that sticks at rest.
#[derive(Clone, Debug, Serialize)]
pub struct DriveFriction {
    /// What friction takes over the turn or range \[J\].
    pub loss: f64,
    /// What loads and masses take \[J\]; below zero where they drive.
    pub work: f64,
    /// The share of the drive's work that is not lost, where loads and masses take any.
    pub efficiency: Option<f64>,
    /// Of the poses in which loads would move the mechanism back without friction, at the same speed, the share in which they do not: it locks itself there. None if there are no such poses.
    pub locked: Option<f64>,
    /// The drive's effort without friction, for each sample [N.m] or \[N\].
    #[serde(skip)]
    pub without: Option<Samples>,
}

/// The mechanism without its dry friction, and its motion; none if nothing rubs.
///
/// # Errors
/// As for the motion with friction.
pub(super) fn without(moved: &Moved, drive: &DrivenJoint) -> Result<Option<(Moved, InputTable)>, MotionError> {
    if moved.mechanism.first_slip().is_none() {
        return Ok(None);
    }
    let smooth = Moved { mechanism: moved.mechanism.without_slips(), ..moved.clone() };
    let table = drive::sample(&smooth, drive, None)?;
    Ok(Some((smooth, table)))
}

impl DriveFriction {
    /// From the efforts with friction and without; none if there are no efforts.
    ///
    /// # Errors
    /// Friction locks the mechanism, or something that rubs rests: there is no effort.
    pub(super) fn of(
        moved: &Moved,
        drive: &DrivenJoint,
        table: &InputTable,
        (smooth, ideal): &(Moved, InputTable),
    ) -> Result<Option<Self>, MotionError> {
        let (Some(effort), Some(without)) = (table.effort(), ideal.effort()) else { return Ok(None) };
        check_known(moved, drive, &effort)?;
        let taken = effort.minus(&without);
        let [loss, work] = [&taken, &without].map(|effort| effort.work());
        // Over a turn conservative loads take nothing but rounding errors.
        let size = without.map(f64::abs).work().abs();
        let efficiency = (work > NOTHING * size).then(|| work / (work + loss));
        let back = drive.backwards(table);
        let returning = |moved: &Moved| Ok::<_, MotionError>(drive::sample(moved, &back, None)?.effort());
        let locked =
            returning(moved)?.zip(returning(smooth)?).and_then(|(with, without)| share_locked(&with, &without, &back));
        Ok(Some(DriveFriction { loss, work, efficiency, locked, without: Some(without) }))
    }
}

/// Where the drive has to push back, of the poses in which it would have to brake without friction.
fn share_locked(with: &Samples, without: &Samples, back: &DrivenJoint) -> Option<f64> {
    let direction = back.direction();
    let efforts = with.values().iter().zip(without.values());
    let driven = efforts.filter(|(_, without)| direction * *without < 0.0);
    let (mut held, mut all) = (0.0, 0.0);
    for (with, _) in driven {
        all += 1.0;
        held += f64::from(u8::from(direction * with > 0.0));
    }
    (all > 0.0).then(|| held / all)
}

/// Says where there is no effort.
fn check_known(moved: &Moved, drive: &DrivenJoint, effort: &Samples) -> Result<(), MotionError> {
    let mut unknown = (0..effort.values().len()).filter(|&index| effort.values()[index].is_nan());
    let Some(first) = unknown.next() else { return Ok(()) };
    let last = unknown.next_back().unwrap_or(first);
    let [from, to] = [first, last].map(|index| effort.input(index));
    let name = moved.mechanism.first_slip().unwrap_or_default();
    let unit = if drive.motion == ANGULAR { "rad" } else { "m" };
    Err(MotionError::Request(format!(
        "between {from:.4} and {to:.4} {unit} of the input no drive can move the mechanism: friction locks it (self-locking at {name} or others), or a frictional contact is at rest; choose a range without that, or reduce the friction"
    )))
}
