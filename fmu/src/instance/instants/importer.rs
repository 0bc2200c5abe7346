//! Events as an importer of Model Exchange finds them: by signs of indicators, at times and in states that it knows to its own tolerance only.
//!
//! An importer encloses a change of sign between two times and enters event mode at either end, so that the indicator may still have its old sign there. Then a comparison must count as
//! changed, and be shown as changed, or the importer finds the same change again. So the importer's search is followed: what has been seen beyond the present time, nearer than any step, is where the search
//! has ended. Whether a comparison begins or ceases to hold there follows from whether it held before, not from how small its excess is.
//!
//! What has just been left (a contact that opens or rebounds, friction that begins to slip) begins at zero, about which the importer's errors are larger than the motion. Nobody tells the runtime how
//! large they are: many importers keep their tolerance for themselves. Where a contact returns without ever having been apart, or returns while its parts move apart, errors are what has been seen, and they are
//! taken for ten times as large from there on.

use serde::{Deserialize, Serialize};

use super::super::snapshot::Phase;
use super::super::{Instance, InstanceError};
use super::Instants;
use crate::hybrid::contact::{direction, is_closed};
use crate::math::{maximum, minimum};

/// Two ends of an interval are those of a search if it is a smaller share than this of the importer's step.
const ENCLOSED: f64 = 1e-5;
/// An importer's errors are taken for so many times as large where they have been seen to be larger.
pub(crate) const LARGER: f64 = 10.0;
/// The largest that they are taken for, as a share of the scale.
pub(super) const LARGEST_ERRORS: f64 = 2e-3;
/// What has been left is apart where it is further away than so many errors.
pub(super) const ERRORS_APART: f64 = 2.0;

/// What is known of an importer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Importer {
    /// By how much the sides of each comparison have differed at most.
    pub sizes: Vec<f64>,
    /// What is added to each indicator, so that its sign says whether the comparison holds.
    shifts: Vec<f64>,
    /// The first time after the last completed step or event at which each was seen with the other sign \[s\]; infinite if it was not.
    beyond: Vec<f64>,
    /// True for an indicator that had its own sign when the step began; then zero is a change: some importers end their search where an indicator is zero, and it may have been zero all the time.
    signed: Vec<bool>,
    /// When the last step was completed, or the last event handled, and the last time that has been looked at since then \[s\].
    step: [f64; 2],
    /// The errors of gaps and their rates, as a share of their scales.
    errors: f64,
    /// True for what has returned before it was apart, and has not been apart since then.
    returned: Vec<bool>,
}

impl Importer {
    pub fn new(occasions: usize) -> Self {
        Self {
            sizes: vec![0.0; occasions],
            shifts: vec![0.0; occasions],
            beyond: vec![f64::INFINITY; occasions],
            signed: vec![false; occasions],
            step: [f64::MAX, f64::MIN],
            errors: 0.0,
            returned: vec![false; occasions],
        }
    }

    pub fn copy_from(&mut self, other: &Self) {
        self.sizes.clone_from(&other.sizes);
        self.shifts.clone_from(&other.shifts);
        self.beyond.clone_from(&other.beyond);
        self.signed.clone_from(&other.signed);
        self.returned.clone_from(&other.returned);
        (self.step, self.errors) = (other.step, other.errors);
    }

    pub fn is_sound(&self, occasions: usize) -> bool {
        let signs = [self.signed.len(), self.returned.len()];
        let counts = [self.sizes.len(), self.shifts.len(), self.beyond.len()];
        let numbers = self.sizes.iter().chain(&self.shifts).chain(&self.step).chain([&self.errors]);
        counts == [occasions; 3]
            && signs == [occasions; 2]
            && numbers.into_iter().all(|number| number.is_finite())
            && self.errors >= 0.0
            && self.beyond.iter().all(|time| !time.is_nan())
    }

    /// True if a search for where an indicator changes its sign has ended at a time, before the change.
    fn encloses(&self, event: usize, time: f64) -> bool {
        let [begin, end] = self.step;
        (time..=time + ENCLOSED * (end - begin)).contains(&self.beyond[event])
    }
}

impl Instance {
    /// True while an importer integrates.
    pub(super) fn is_exchanged(&self) -> bool {
        self.now.phase == Phase::Exchange
    }

    /// The errors of an importer, as a share of the scales: the tolerance, until they are seen to be larger.
    pub(super) fn importer_errors(&self) -> f64 {
        maximum(self.now.happened.importer.errors, self.now.tolerance)
    }

    /// True if others keep the gap of an open contact at zero.
    pub(in crate::instance) fn holds_redundant(&self) -> bool {
        self.now.happened.redundant.contains(&true)
    }

    /// What an importer is shown of an excess.
    fn shown(&self, instants: &Instants, event: usize) -> f64 {
        instants.excess(event) + self.now.happened.importer.shifts[event] - self.clearance(event)
    }

    /// What is shown where it counts: to an importer, or within a run.
    pub(super) fn counted(&self, instants: &Instants, event: usize) -> f64 {
        if self.is_exchanged() { self.shown(instants, event) } else { instants.excess(event) }
    }

    /// A step of the importer begins, where the sides have been evaluated.
    pub(super) fn begin_search(&mut self) {
        let Some(instants) = self.instants.take() else { return };
        let time = self.time();
        for event in 0..instants.due.len() {
            let shown = self.shown(&instants, event);
            let signed = shown != 0.0 && !self.has_other_sign(&instants, event);
            let importer = &mut self.now.happened.importer;
            (importer.signed[event], importer.beyond[event]) = (signed, f64::INFINITY);
        }
        self.now.happened.importer.step = [time, time];
        self.instants = Some(instants);
    }

    /// True for what is zero here, and was not where the importer's step began.
    pub(super) fn has_come_to_zero(&self, instants: &Instants, event: usize) -> bool {
        self.now.happened.importer.signed[event] && self.shown(instants, event) == 0.0
    }

    /// True if an indicator has the sign that it has not had since its comparison last began or ceased to hold.
    fn has_other_sign(&self, instants: &Instants, event: usize) -> bool {
        let (shown, holds) =
            (self.shown(instants, event), !self.now.happened.armed[event] && !instants.is_contact(event));
        self.has_come_to_zero(instants, event) || if holds { shown < 0.0 } else { shown > 0.0 }
    }

    /// Shows all indicators, where the sides have been evaluated.
    pub(super) fn show(&mut self, instants: &Instants, shown: &mut [f64]) {
        let time = self.time();
        for (event, shown) in shown.iter_mut().enumerate() {
            *shown = self.shown(instants, event);
            let changes = self.has_other_sign(instants, event);
            let (size, importer) = (instants.excess(event).abs(), &mut self.now.happened.importer);
            if size.is_finite() {
                importer.sizes[event] = maximum(importer.sizes[event], size);
            }
            if changes && time >= importer.step[0] {
                importer.beyond[event] = minimum(importer.beyond[event], time);
            }
            importer.step[1] = maximum(importer.step[1], time);
            // Flights may be shorter than what the importer takes for a step.
            self.now.happened.armed[event] |= self.is_left(event) && instants.excess(event) < -self.apart(event);
        }
    }

    /// True for an indicator that changes its sign where a search has ended; nowhere if any has changed it here already, where the sides have been evaluated.
    fn changes_beyond(&self, instants: &Instants, event: usize) -> bool {
        self.now.happened.importer.encloses(event, self.time())
            && !(0..instants.due.len()).any(|other| self.has_other_sign(instants, other))
    }

    /// Where an importer has completed a step: true if it must handle an event, since something is due or its search has ended just before something begins to hold.
    pub(super) fn end_step(&mut self, due: bool) -> bool {
        let Some(instants) = &self.instants else { return due };
        let changes = |event: &usize| self.changes_beyond(instants, *event);
        let begins = (0..instants.due.len()).filter(changes).any(|event| self.now.happened.armed[event]);
        if due || begins || (0..instants.due.len()).any(|event| changes(&event)) {
            return due || begins;
        }
        for (event, shift) in self.now.happened.importer.shifts.iter_mut().enumerate() {
            // Far from zero it has the same sign as it is.
            if instants.excess(event).abs() > 2.0 * shift.abs() {
                *shift = 0.0;
            }
        }
        self.begin_search();
        false
    }

    /// At an importer's event: indicators whose change has been found beyond the present time are shown as changed.
    pub(super) fn follow_search(&mut self) -> Result<(), InstanceError> {
        self.evaluate_now()?;
        let Some(mut instants) = self.instants.take() else { return Ok(()) };
        for event in 0..instants.due.len() {
            instants.due[event] = self.changes_beyond(&instants, event);
        }
        for event in (0..instants.due.len()).filter(|&event| instants.due[event]) {
            let shown = self.shown(&instants, event);
            self.now.happened.importer.shifts[event] -= 2.0 * shown;
        }
        self.instants = Some(instants);
        Ok(())
    }

    /// An importer's event is over.
    pub(super) fn end_search(&mut self) {
        let Some(mut instants) = self.instants.take() else { return };
        let events = instants.sides.len() / 2;
        if self.now.happened.armed[..events].contains(&false) {
            self.find_noise(&mut instants);
        }
        for event in 0..instants.due.len() {
            let is_held = !self.now.happened.armed[event] && instants.excess(event).abs() <= instants.noise[event];
            let shift = &mut self.now.happened.importer.shifts[event];
            if instants.is_contact(event) {
                *shift = 0.0;
            } else if is_held {
                // What is held at its threshold has either sign: it is shown as what holds until it is clear of that.
                *shift = 2.0 * instants.noise[event];
            }
        }
        self.instants = Some(instants);
        self.begin_search();
    }

    /// A comparison that held at its threshold has ceased to: it is shown as it is again.
    pub(super) fn show_as_it_is(&mut self, event: usize) {
        let shift = &mut self.now.happened.importer.shifts[event];
        *shift = minimum(*shift, 0.0);
    }

    /// What an importer sees below zero of the indicator of what has just been left.
    fn clearance(&self, event: usize) -> f64 {
        if self.is_left(event) { self.importer_errors() * self.scale_of(event) } else { 0.0 }
    }

    /// True for an open contact, and for what slips, that has not been apart or slipped by more than errors yet.
    pub(super) fn is_left(&self, event: usize) -> bool {
        !self.now.happened.armed[event] && self.is_free(event)
    }

    /// True for a contact that is open, and for what slips.
    fn is_free(&self, event: usize) -> bool {
        let instants = &self.model.program().instants;
        let Some(data) = &instants.contacts else { return false };
        let index = event.checked_sub(instants.events.len()).filter(|&index| index < data.all.len());
        index.is_some_and(|index| match data.all[index].slip {
            None => !is_closed(data, &self.now.state, index),
            Some(_) => direction(data, &self.now.state, index) != 0.0,
        })
    }

    /// How far something must be apart before it counts as apart, where an importer integrates.
    pub(super) fn apart(&self, event: usize) -> f64 {
        if self.is_exchanged() && self.is_free(event) {
            ERRORS_APART * self.importer_errors() * self.scale_of(event)
        } else {
            0.0
        }
    }

    /// Learns the importer's errors from what returns, where the sides have been evaluated. What returns has to be left again.
    pub(super) fn note_returns(&mut self) {
        let Some(instants) = self.instants.take() else { return };
        let first = self.model.program().instants.events.len();
        let mut are_larger = false;
        for event in first..instants.due.len() {
            let (left, index, due) = (self.is_left(event), event - first, instants.due[event]);
            if due && self.is_free(event) {
                let is_gap = self.model.program().instants.contacts()[index].slip.is_none();
                let parts = is_gap && instants.contacts.gaps[index] < 0.0 && instants.contacts.rates[index] > 0.0;
                are_larger |= parts || left && self.now.happened.importer.returned[event];
                self.now.happened.armed[event] = false;
            }
            let returned = &mut self.now.happened.importer.returned[event];
            *returned = left && (due || *returned);
        }
        if are_larger {
            self.now.happened.importer.errors = minimum(LARGER * self.importer_errors(), LARGEST_ERRORS);
        }
        self.instants = Some(instants);
    }
}
