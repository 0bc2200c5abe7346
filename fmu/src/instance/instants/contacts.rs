//! Contacts: when they open, close and collide.
//!
//! Each is something that happens, as an event does, when its indicator begins to be positive: its reaction while it is closed, minus its gap while it is open.

use super::super::snapshot::Phase;
use super::super::{Computed, Instance, InstanceError};
use super::Instants;
use crate::failure::Failure;
use crate::hybrid::contact::{RESTING, TOUCHING, is_closed};

/// What is open by less than nothing, by more than this share of its scale, has been overlooked.
const PENETRATION: f64 = 1e-9;
/// So far below zero is the indicator of a contact that has just been left, as a share of its scale: more than `TOUCHING`, from where on it is seen as it is.
const CLEARANCE: f64 = 1e-10;

impl Instance {
    /// True if the reaction of a contact counts.
    pub(super) fn is_any_closed(&self) -> bool {
        let contacts = self.model.program().instants.contacts.as_ref();
        contacts.is_some_and(|data| (0..data.all.len()).any(|index| is_closed(data, &self.now.state, index)))
    }

    /// True for a contact that is open and where the last step begins has just been left.
    pub(super) fn has_left(&self, own: &Instants, event: usize) -> bool {
        !own.armed[event] && self.is_open(event)
    }

    /// True for a contact that is open now.
    fn is_open(&self, event: usize) -> bool {
        let contacts = self.model.program().instants.contacts.as_ref();
        let index = event.checked_sub(self.model.program().instants.events.len());
        contacts.zip(index).is_some_and(|(data, index)| !is_closed(data, &self.now.state, index))
    }

    /// How far a contact that rests seems to move in a step, by rounding errors.
    pub(super) fn resting(&self, event: usize, [begin, end]: [f64; 2]) -> f64 {
        let program = self.model.program();
        let contact = &program.instants.contacts()[event - program.instants.events.len()];
        RESTING * program.constraints[contact.constraint as usize].scale * (end - begin)
    }

    /// What an importer sees below zero of the indicator of a contact that has just been left: there it begins at zero, and a rounding error would be another impact.
    pub(super) fn clearance(&self, event: usize) -> f64 {
        let program = self.model.program();
        let index = event.checked_sub(program.instants.events.len());
        let contact = index.and_then(|index| program.instants.contacts().get(index));
        let is_left = !self.now.happened.armed[event] && self.is_open(event);
        let scale = contact.map_or(0.0, |contact| program.constraints[contact.constraint as usize].scale);
        if is_left { CLEARANCE * scale } else { 0.0 }
    }

    /// The indicators at the state within the step, whose accelerations and reactions are in the registers if any contact is closed. What has just been left is divided by the share of the step
    /// since then: it begins at zero, and nothing else tells that from a rounding error.
    pub(super) fn indicate(&mut self, own: &mut Instants, [begin, end]: [f64; 2]) {
        let model = self.model.clone();
        let Some(data) = &model.program().instants.contacts else { return };
        let (events, reactions) = (model.program().instants.events.len(), model.layout().reactions());
        for (index, contact) in data.all.iter().enumerate() {
            own.indicators[index] = self.machine.registers()[reactions + contact.constraint as usize];
        }
        let share = (own.within.time() - begin) / (end - begin);
        self.machine.evaluate(&data.gaps, &mut own.contacts.gaps);
        self.machine.evaluate(&data.rates, &mut own.contacts.rates);
        for index in (0..data.all.len()).filter(|&index| !is_closed(data, &self.now.state, index)) {
            let (gap, rate) = (own.contacts.gaps[index], own.contacts.rates[index]);
            own.indicators[index] = match share {
                _ if !self.has_left(own, events + index) => -gap,
                share if share > 0.0 => -gap / share,
                _ => -rate * (end - begin),
            };
        }
    }

    /// The indicators at the present state.
    pub(super) fn indicate_now(&mut self, own: &mut Instants) -> Result<(), InstanceError> {
        let model = self.model.clone();
        let Some(data) = &model.program().instants.contacts else { return Ok(()) };
        if self.is_any_closed() {
            self.accelerate()?;
        }
        self.load()?;
        for (index, contact) in data.all.iter().enumerate() {
            own.indicators[index] = self.machine.registers()[model.layout().reactions() + contact.constraint as usize];
        }
        self.machine.evaluate(&data.gaps, &mut own.contacts.gaps);
        for index in (0..data.all.len()).filter(|&index| !is_closed(data, &self.now.state, index)) {
            own.indicators[index] = -own.contacts.gaps[index];
        }
        Ok(())
    }

    /// Lets those collide that touch, and opens and closes what fits. A contact whose reaction has fallen to zero is left.
    pub(super) fn resolve_contacts(&mut self) -> Result<(), InstanceError> {
        let (model, tolerance) = (self.model.clone(), self.now.tolerance);
        let Some(data) = &model.program().instants.contacts else { return Ok(()) };
        self.catch_up();
        self.check_inside()?;
        let Some(mut own) = self.instants.take() else { return Ok(()) };
        let (first, state) = (model.program().instants.events.len(), &mut self.now.state);
        let Instants { due, armed, contacts, .. } = &mut *own;
        for index in 0..data.all.len() {
            // Who was closed is kept where nothing else is until the next search.
            armed[first + index] = is_closed(data, state, index);
        }
        let resolved = contacts.resolve(&model, &mut self.machine, (state, tolerance), |index| due[first + index]);
        let happened = &mut self.now.happened;
        for index in 0..data.all.len() {
            if contacts.hit[index] || armed[first + index] != is_closed(data, state, index) {
                happened.counts[first + index] = happened.counts[first + index].saturating_add(1);
                happened.armed[first + index] = false;
            }
        }
        self.instants = Some(own);
        self.computed = Computed::default();
        resolved.map_err(InstanceError::Solver)
    }

    /// What is changed during a run must not put a limit where the mechanism is already: nothing could move it there. An importer's own steps may have gone further than a limit.
    fn check_inside(&mut self) -> Result<(), InstanceError> {
        let model = self.model.clone();
        let (Some(data), Some(own)) = (&model.program().instants.contacts, &mut self.instants) else { return Ok(()) };
        if self.now.phase == Phase::Exchange {
            return Ok(());
        }
        own.contacts.measure(&model, &mut self.machine, &self.now.state);
        for (index, &gap) in own.contacts.gaps.iter().enumerate() {
            let row = &model.program().constraints[data.all[index].constraint as usize];
            let least = PENETRATION.max(self.now.tolerance) * row.scale;
            if gap < -least {
                let (name, angular, time) = (data.all[index].name.clone(), row.angular, self.now.state.time());
                return Err(Failure::Beyond { name, time, by: -gap, angular }.into());
            }
        }
        Ok(())
    }

    /// What a tick writes may let contacts open.
    pub(super) fn resolve_contacts_after_tick(&mut self) -> Result<(), InstanceError> {
        if let Some(own) = &mut self.instants {
            own.due.fill(false);
        }
        self.resolve_contacts()
    }

    /// At the start of a run: what touches is opened or closed.
    ///
    /// # Errors
    /// The start is beyond a limit, or inside what it touches.
    pub(super) fn begin_contacts(&mut self) -> Result<(), InstanceError> {
        let model = self.model.clone();
        let Some(data) = &model.program().instants.contacts else { return Ok(()) };
        let Some(own) = &mut self.instants else { return Ok(()) };
        own.contacts.measure(&model, &mut self.machine, &self.now.state);
        own.due.fill(false);
        for (contact, &gap) in data.all.iter().zip(&own.contacts.gaps) {
            let row = &model.program().constraints[contact.constraint as usize];
            if gap < -TOUCHING * row.scale {
                let (name, angular) = (contact.name.clone(), row.angular);
                return Err(Failure::Beyond { name, time: self.now.state.time(), by: -gap, angular }.into());
            }
        }
        self.resolve_contacts()?;
        self.now.happened.counts.fill(0);
        Ok(())
    }

    /// Arms the contacts that press, or are open by more than rounding errors.
    pub(super) fn arm_contacts(&mut self) {
        let model = self.model.clone();
        let (Some(data), Some(own)) = (&model.program().instants.contacts, &self.instants) else { return };
        let first = model.program().instants.events.len();
        for (index, contact) in data.all.iter().enumerate() {
            let scale = model.program().constraints[contact.constraint as usize].scale;
            let least = if is_closed(data, &self.now.state, index) { 0.0 } else { TOUCHING * scale };
            self.now.happened.armed[first + index] |= own.indicators[index] < -least;
        }
    }

    /// A contact that is open by less than nothing at the end of a step through which it has been looked for.
    pub(super) fn find_overlooked(&self, own: &Instants) -> Option<Failure> {
        let data = self.model.program().instants.contacts.as_ref()?;
        let is_inside = |index: usize| {
            let row = &self.model.program().constraints[data.all[index].constraint as usize];
            own.contacts.gaps[index] < -PENETRATION * row.scale && !is_closed(data, &self.now.state, index)
        };
        let index = (0..data.all.len()).find(|&index| is_inside(index))?;
        let (names, time) = (vec![data.all[index].name.clone()], own.within.time());
        Some(Failure::Contact { time, names, why: "it has been passed without a beginning that could be found" })
    }
}
