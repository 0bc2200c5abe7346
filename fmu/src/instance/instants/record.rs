//! What has happened at instants, for those who ask: a log, and derivatives of the motion through it.

use super::super::Instance;
use super::Instants;
use crate::hybrid::contact::{Impact, direction, is_closed};
use crate::math::maximum;
use crate::model::{Model, State};
use crate::program::{Contacts, Target};

/// The excess of an event is looked at in so many places before it.
const PLACES_BEFORE_EVENT: u32 = 8;

/// Something that has happened at one instant. What that has led to at the same instant follows as others.
#[derive(Clone, Debug)]
pub struct Happening {
    /// The samplers that have ticked; empty at an event.
    pub ticks: Vec<usize>,
    /// Events, then contacts, that were due.
    pub due: Vec<usize>,
    /// Of what was found within a step: how long after its beginning \[s\], and how large its excess has been since then. None of what follows from something else.
    pub seen: Option<[f64; 2]>,
    /// Contacts that have hit.
    pub hit: Vec<usize>,
    /// The impacts, one after the other.
    pub impacts: Vec<Impact>,
    /// The state just before it.
    pub before: State,
    /// The state just after it.
    pub after: State,
}

impl Happening {
    /// When \[s\].
    pub fn time(&self) -> f64 {
        self.after.time()
    }

    /// True of what does not follow from something else at the same instant.
    pub fn is_first(&self) -> bool {
        self.seen.is_some() || !self.ticks.is_empty()
    }

    /// Contacts that are closed before and after.
    pub fn closed(&self, model: &Model) -> [Vec<bool>; 2] {
        self.of_contacts(model, is_closed)
    }

    /// Before and after: 1 or -1 for what slips that way, else 0.
    pub fn directions(&self, model: &Model) -> [Vec<f64>; 2] {
        self.of_contacts(model, direction)
    }

    /// The loop equations of joints that engage, which are true, and of those that are released; and of rates that are set.
    pub fn joining(&self, model: &Model) -> Vec<(usize, bool)> {
        let program = model.program();
        let events = self.due.iter().filter_map(|&index| program.instants.events.get(index));
        let written: Vec<Target> = events.flat_map(|event| &event.writes).map(|write| program.target(*write)).collect();
        let change = |(row, place): (usize, usize)| {
            let [before, after] = [&self.before, &self.after].map(|state| state.discrete()[place] != 0.0);
            let joins = !before && written.contains(&Target::Discrete(place));
            (joins || before && !after).then_some((row, joins))
        };
        program.masks_by_event().filter_map(change).collect()
    }

    fn of_contacts<T>(&self, model: &Model, value: impl Fn(&Contacts, &State, usize) -> T) -> [Vec<T>; 2] {
        let data = model.program().instants.contacts.as_ref();
        [&self.before, &self.after].map(|state| {
            data.into_iter().flat_map(|data| (0..data.all.len()).map(|index| value(data, state, index))).collect()
        })
    }
}

impl Instance {
    /// From now on everything that happens is recorded. To be called before the run begins.
    pub fn record_instants(&mut self) {
        if let Some(instants) = &mut self.instants {
            instants.record = Some(Vec::new());
            instants.contacts.impacts = Some(Vec::new());
        }
    }

    /// What has happened since this was last asked.
    pub fn take_record(&mut self) -> Vec<Happening> {
        let record = self.instants.as_mut().and_then(|instants| instants.record.as_mut());
        record.map(std::mem::take).unwrap_or_default()
    }

    /// The same motion, in which nothing happens from now on: what is open stays open, what is closed stays closed, and discrete variables stay as they are.
    #[must_use]
    pub fn without_instants(&self) -> Self {
        Self { instants: None, ..self.clone() }
    }

    /// The state before something happens, if that is recorded.
    pub(super) fn state_to_record(&self) -> Option<State> {
        let is_recorded = self.instants.as_ref().is_some_and(|instants| instants.record.is_some());
        is_recorded.then(|| self.state())
    }

    /// How long after the beginning of a step an event is found, and how large its excess is on the way there; what has just been left is measured by its gap itself.
    pub(super) fn seen_before(
        &mut self,
        instants: &mut Instants,
        step: [f64; 2],
        (at, event): (f64, usize),
    ) -> [f64; 2] {
        let (since, mut most) = (at - step[0], 0.0);
        for place in 0..PLACES_BEFORE_EVENT {
            let share = f64::from(place) / f64::from(PLACES_BEFORE_EVENT);
            self.evaluate_sides(instants, (step, [step[0], at]), share);
            let part = if self.has_left(instants, event) { share * since / (step[1] - step[0]) } else { 1.0 };
            let size = instants.excess(event).abs() * part;
            most = if size.is_finite() { maximum(most, size) } else { most };
        }
        [since, most]
    }

    /// The impacts that have been recorded since contacts were last decided.
    pub(super) fn take_impacts(&mut self) -> Vec<Impact> {
        let impacts = self.instants.as_mut().and_then(|instants| instants.contacts.impacts.as_mut());
        impacts.map(std::mem::take).unwrap_or_default()
    }

    /// Puts impacts before those that have followed them.
    pub(super) fn put_impacts(&mut self, first: Vec<Impact>) {
        if let Some(impacts) = self.instants.as_mut().and_then(|instants| instants.contacts.impacts.as_mut()) {
            impacts.splice(0..0, first);
        }
    }

    /// Notes what has happened since a state.
    pub(super) fn note(&mut self, before: Option<State>, ticks: Vec<usize>, found: Option<usize>) {
        let (Some(before), Some(instants)) = (before, &mut self.instants) else { return };
        let after = self.now.state.clone();
        let is_event = ticks.is_empty();
        let due = (0..instants.due.len()).filter(|&event| is_event && instants.due[event]).collect();
        let hit: Vec<usize> = (0..instants.contacts.hit.len()).filter(|&index| instants.contacts.hit[index]).collect();
        let impacts = instants.contacts.impacts.clone().unwrap_or_default();
        let seen = found.and(instants.known.seen);
        let record = Happening { ticks, due, seen, hit, impacts, before, after };
        instants.record.iter_mut().for_each(|all| all.push(record.clone()));
    }
}
