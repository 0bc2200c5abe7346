//! What dry friction takes of the drive's work, and whether it holds what the drive has moved.
//!
//! The motion is the same with friction and without it, so the drive's effort differs by what friction takes alone: the power of both is the power of what slides.

use serde::Serialize;

use super::drive::{self, Moved, Table};
use super::samples::{ANGULAR, Samples};
use super::{Drive, MotionError};

/// Less work than this share of what goes to and fro is none.
const NOTHING: f64 = 1e-9;

/// What the drive needs for dry friction that sticks at rest.
#[derive(Clone, Debug, Serialize)]
pub struct Friction {
    /// What friction takes over the turn or range \[J\].
    pub loss: f64,
    /// What loads and masses take \[J\]; below zero where they drive.
    pub work: f64,
    /// The share of the drive's work that is not lost, where loads and masses take any.
    pub efficiency: Option<f64>,
    /// Share of the poses in which loads do not move the mechanism back without the drive, at the same speed: it locks itself there.
    pub locked: f64,
    /// The drive's effort without friction, for each sample [N.m] or \[N\].
    #[serde(skip)]
    pub without: Option<Samples>,
}

/// The mechanism without its dry friction, and its motion; none if nothing rubs.
///
/// # Errors
/// As for the motion with friction.
pub(super) fn without(moved: &Moved, drive: &Drive) -> Result<Option<(Moved, Table)>, MotionError> {
    if moved.mechanism.first_slip().is_none() {
        return Ok(None);
    }
    let smooth = Moved { mechanism: moved.mechanism.without_slips(), ..moved.clone() };
    let table = drive::sample(&smooth, drive, None)?;
    Ok(Some((smooth, table)))
}

impl Friction {
    /// From the efforts with friction and without; none if there are no efforts.
    ///
    /// # Errors
    /// Friction locks the mechanism, or something that rubs rests: there is no effort.
    pub(super) fn of(moved: &Moved, drive: &Drive, table: &Table, smooth: &Table) -> Result<Option<Self>, MotionError> {
        let (Some(effort), Some(without)) = (table.effort(), smooth.effort()) else { return Ok(None) };
        check_known(moved, drive, &effort)?;
        let taken = effort.minus(&without);
        let [loss, work] = [&taken, &without].map(|effort| effort.work());
        // Over a turn conservative loads take nothing but rounding errors.
        let size = without.map(f64::abs).work().abs();
        let efficiency = (work > NOTHING * size).then(|| work / (work + loss));
        let back = drive::sample(moved, &drive.backwards(table), None)?;
        let locked = back.effort().map_or(0.0, |back| share_locked(&effort, &back, drive));
        Ok(Some(Friction { loss, work, efficiency, locked, without: Some(without) }))
    }
}

/// In how many poses the drive has to push both ways.
fn share_locked(forth: &Samples, back: &Samples, drive: &Drive) -> f64 {
    let direction = drive.direction();
    let both = forth.values().iter().enumerate().filter(|&(index, &effort)| {
        let returning = back.at_input(forth.input(index));
        direction * effort > 0.0 && direction * returning < 0.0
    });
    both.count() as f64 / forth.values().len() as f64
}

/// Says where there is no effort.
fn check_known(moved: &Moved, drive: &Drive, effort: &Samples) -> Result<(), MotionError> {
    let mut unknown = (0..effort.values().len()).filter(|&index| effort.values()[index].is_nan());
    let Some(first) = unknown.next() else { return Ok(()) };
    let last = unknown.next_back().unwrap_or(first);
    let [from, to] = [first, last].map(|index| effort.input(index));
    let name = moved.mechanism.first_slip().unwrap_or_default();
    let unit = if drive.motion == ANGULAR { "rad" } else { "m" };
    Err(MotionError::Request(format!(
        "between {from:.4} and {to:.4} {unit} of the input no drive moves the mechanism: friction locks it ({name} or others: what presses grows with the friction that follows from it), or something that rubs rests there; choose a range without that, or less friction"
    )))
}
