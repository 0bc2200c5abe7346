//! Contacts: when they open, close and collide.
//!
//! Each is something that happens, as an event does, when its indicator begins to be positive: its reaction while it is closed, minus its gap (of a freewheel minus its rate) while it is open; how far the force exceeds the level
//! while something sticks, minus its rate while it slips. After them come the sums whose signs are assumed where they press, and what must be positive lest friction locks the mechanism.

mod frictions;
mod polynomials;

use super::super::snapshot::Phase;
use super::super::{Computed, Instance, InstanceError};
use super::importer::{ERRORS_APART, LARGEST_ERRORS};
use super::{Continuation, Distance, Instants};
use crate::failure::Failure;
use crate::hybrid::contact::{FOUND, TOUCHING, direction, is_closed};
use crate::hybrid::onset::CHECKS;
use crate::machine::{CANCELLED, ROUNDING};
use crate::math::{maximum, minimum};
use crate::program::{Constraint, Contact, Contacts, Program};

/// A rate that is wrong by so many tolerances of its scale in a second is none of the method's errors.
const RATE_OVERLOOKED: f64 = 100.0;
/// In Model Exchange a series of bounces ends where the next flight would last less than this share of a fall: lower ones end within rounding errors, where an importer sees none.
const SHORTEST_SEEN: f64 = 1e-4;
/// A force that is smaller than rounding errors of the largest one is none, nor is one that is smaller than this \[N\].
const LEAST_FORCE: f64 = 1e-14;
/// The errors of a gap that others keep at zero, in tolerances of its scale: less than what counts as inside.
const ERRORS_OF_CLOSED_GAPS: f64 = 0.5;
/// A gap is far if it exceeds so many times the largest rate in three places of a step, times the step: to close and open between two of these places, which are apart by 0.54 of the step at most, it would have to be fifteen times as fast.
const FAR_GAP: f64 = 4.0;
/// So many changes of mode at one instant do not end: each of a few parts changes once or twice.
const MOST_CHANGES: u32 = 64;

impl Instance {
    /// True if the reaction of a contact counts, or of what sticks, the acceleration of a freewheel, or the sign of what presses.
    pub(super) fn is_any_solved(&self) -> bool {
        let contacts = self.model.program().instants.contacts.as_ref();
        let counts = |data: &Contacts, index: usize| {
            let contact = &data.all[index];
            contact.of_rate || !contact.state.signs.is_empty() || is_closed(data, &self.now.state, index)
        };
        contacts.is_some_and(|data| (0..data.all.len()).any(|index| counts(data, index)))
    }

    /// True if everything that could touch in a step is so far away, beside how fast it comes nearer in three places, that nothing does: most steps need not be looked through. The places are apart by no round
    /// share, lest something that turns many times in a step seems to rest in all of them.
    pub(super) fn stays_far(&mut self, run: &mut Instants, step: [f64; 2]) -> bool {
        let instants = &self.model.program().instants;
        let only_gaps = instants.events.is_empty()
            && instants.contours().is_empty()
            && instants.contacts().iter().all(|contact| contact.slip.is_none());
        if !only_gaps || run.armed.contains(&false) || self.is_any_solved() {
            run.known.end = None;
            return false;
        }
        let mut places = [run.known.end.filter(|end| end.time == step[0]), None, None];
        for (place, share) in places.iter_mut().zip([0.0, CHECKS[1], 1.0]) {
            if place.is_none() {
                self.evaluate_sides(run, (step, step), share);
                let gap = run.contacts.gaps.iter().fold(f64::INFINITY, |least, gap| minimum(least, *gap));
                let rate = run.contacts.rates.iter().fold(0.0, |most, rate| maximum(most, rate.abs()));
                *place = Some(Distance { time: run.within.time(), gap, rate });
            }
        }
        run.known.end = places[2];
        let mut known = places.iter().flatten();
        let fastest = known.clone().fold(0.0, |most, place| maximum(most, place.rate));
        known.all(|place| place.gap > FAR_GAP * fastest * (step[1] - step[0]))
    }

    /// True if friction may lock the mechanism: it does so for good, so that the ends of pieces of a step tell.
    pub(super) fn may_lock(&self) -> bool {
        let contacts = self.model.program().instants.contacts.as_ref();
        contacts.is_some_and(|data| !data.locks.results.is_empty())
    }

    /// True for a contact that is open and where the last step begins has just been left.
    pub(super) fn has_left(&self, instants: &Instants, event: usize) -> bool {
        !instants.armed[event] && self.is_open(event)
    }

    /// True for a contact that is open now.
    fn is_open(&self, event: usize) -> bool {
        let contacts = self.model.program().instants.contacts.as_ref();
        let index = event.checked_sub(self.model.program().instants.events.len());
        contacts.zip(index).is_some_and(|(data, index)| {
            data.all.get(index).is_some_and(|contact| contact.slip.is_none())
                && !is_closed(data, &self.now.state, index)
        })
    }

    /// In Model Exchange: true for a contact that was closed where its reaction was zero, and now would pull by more than rounding errors.
    pub(super) fn pulls(&self, event: usize, excess: f64) -> bool {
        let (program, happened) = (self.model.program(), &self.now.happened);
        let is_closed = event >= program.instants.events.len() && !self.is_open(event);
        let is_seen = excess > 0.0 && excess > CANCELLED * happened.importer.sizes[event];
        self.now.phase == Phase::Exchange && is_closed && !happened.armed[event] && is_seen
    }

    /// How far a contact that rests seems to move in a step, by rounding errors.
    pub(super) fn resting(&self, event: usize, [begin, end]: [f64; 2]) -> f64 {
        TOUCHING * self.scale_of(event) * (end - begin)
    }

    /// The scale of a contact; zero for what is none.
    pub(super) fn scale_of(&self, event: usize) -> f64 {
        let program = self.model.program();
        let contact = event.checked_sub(program.instants.events.len());
        let contact = contact.and_then(|index| program.instants.contacts().get(index));
        contact.map_or(0.0, |contact| row_of(program, contact).scale)
    }

    /// The indicators at the state in the registers, whose accelerations and reactions are there, too, if they are `solved` or any of them counts. Within a step what has just been left is divided by the share of
    /// the step since then: it begins at zero, and nothing else tells that from a rounding error.
    pub(super) fn indicate(&mut self, instants: &mut Instants, step: Option<[f64; 2]>, solved: bool) {
        let model = self.model.clone();
        let Some(data) = &model.program().instants.contacts else { return };
        let (events, reactions) = (model.program().instants.events.len(), model.layout().reactions());
        for (index, contact) in data.all.iter().enumerate() {
            instants.indicators[index] = self.machine.registers()[reactions + contact.constraint as usize];
        }
        instants.contacts.watch(data, &mut self.machine, &self.now.state);
        self.indicate_friction(instants, data, solved);
        let is_open = |index: usize| data.all[index].slip.is_none() && !is_closed(data, &self.now.state, index);
        for index in (0..data.all.len()).filter(|&index| is_open(index)) {
            let (gap, rate) = (instants.contacts.gaps[index], instants.contacts.rates[index]);
            if self.now.happened.redundant[index] {
                instants.indicators[index] = -gap - self.undisturbed() * self.scale_of(events + index);
                continue;
            }
            let left = step.filter(|_| self.has_left(instants, events + index));
            instants.indicators[index] = match left.map(|[begin, end]| (instants.within.time() - begin, end - begin)) {
                None => -gap,
                Some((since, whole)) if since > 0.0 => -gap * whole / since,
                Some((_, whole)) => -rate * whole,
            };
        }
        if let Some(contours) = &data.contours {
            self.indicate_profiles(instants, contours);
        }
    }

    /// The gap of what others make redundant is the errors of theirs, up to this share of the scale.
    fn undisturbed(&self) -> f64 {
        if self.is_exchanged() {
            ERRORS_APART * self.importer_errors()
        } else {
            maximum(TOUCHING, ERRORS_OF_CLOSED_GAPS * self.now.tolerance)
        }
    }

    /// Those of what sticks or slips, of the signs of what presses, and of friction that locks.
    fn indicate_friction(&mut self, instants: &mut Instants, data: &Contacts, solved: bool) {
        if data.all.iter().all(|contact| contact.slip.is_none()) {
            return;
        }
        let model = self.model.clone();
        self.machine.evaluate(&data.restitutions, &mut instants.contacts.restitutions);
        self.machine.evaluate(&data.pressing, &mut instants.contacts.sums);
        match solved {
            true => self.machine.evaluate(&data.locks, &mut instants.contacts.locks),
            false => instants.contacts.locks.fill(1.0),
        }
        let layout = model.layout();
        let none = ROUNDING * self.largest_reaction() + LEAST_FORCE;
        let multipliers = &self.machine.registers()[layout.reactions()..layout.constants()];
        for (index, contact) in data.all.iter().enumerate() {
            let Some(slip) = &contact.slip else { continue };
            let direction = direction(data, &self.now.state, index);
            let rubs = slip.on.is_none_or(|on| is_closed(data, &self.now.state, on as usize));
            instants.indicators[index] = if is_closed(data, &self.now.state, index) {
                let force = multipliers[contact.constraint as usize];
                let level = instants.contacts.restitutions[index] * multipliers[slip.level as usize];
                // Squares are smooth where the force changes its sign.
                (force * force - level * level.abs()) - none * none
            } else if direction.abs() == 1.0 && rubs {
                -direction * instants.contacts.rates[index] - self.at_rest() * row_of(model.program(), contact).scale
            } else {
                -1.0
            };
            let signs = contact.state.signs.iter().enumerate();
            for (place, &sign) in signs.map(|(place, sign)| (slip.sums as usize + place, sign)) {
                let sum = self.now.state.discrete()[sign as usize] * instants.contacts.sums[place];
                instants.indicators[data.all.len() + place] = -sum - none;
            }
        }
        let first = data.all.len() + instants.contacts.sums.len();
        for (indicator, lock) in instants.indicators[first..].iter_mut().zip(&instants.contacts.locks) {
            // Signs alone: they are the same at the ends of a piece and in it. What is not a number is not positive.
            *indicator = if *lock > 0.0 { -1.0 } else { 1.0 };
        }
    }

    /// What slides back by no more than this share of its scale in a second rests: rounding errors. A polynomial of the implicit method knows rates within a step to within the tolerance only, and would return a
    /// sliding that has just begun to rest.
    fn at_rest(&self) -> f64 {
        if self.now.memory.is_implicit() { maximum(ROUNDING, self.now.tolerance) } else { ROUNDING }
    }

    /// The indicators at the present state.
    pub(super) fn indicate_now(&mut self, instants: &mut Instants) -> Result<(), InstanceError> {
        if self.model.program().instants.contacts.is_none() {
            return Ok(());
        }
        let solved = self.is_any_solved() || self.may_lock();
        if solved {
            self.accelerate()?;
        }
        self.load()?;
        self.indicate(instants, None, solved);
        Ok(())
    }

    /// Lets those collide that touch, and opens and closes what fits. A contact whose reaction has fallen to zero is left.
    pub(super) fn resolve_contacts(&mut self) -> Result<(), InstanceError> {
        let (model, tolerance) = (self.model.clone(), self.now.tolerance);
        let Some(data) = &model.program().instants.contacts else { return Ok(()) };
        let begins = self.instants.as_ref().is_some_and(|instants| instants.contacts.joining.any);
        if !begins {
            self.ready_contacts()?;
        }
        let shortest = self.shortest_flight();
        let Some(mut instants) = self.instants.take() else { return Ok(()) };
        let (first, state) = (model.program().instants.events.len(), &mut self.now.state);
        let Instants { due, contacts, .. } = &mut *instants;
        let resolved =
            contacts.resolve(&model, &mut self.machine, (state, [tolerance, shortest]), |index| due[first + index]);
        contacts.joining.end();
        let happened = &mut self.now.happened;
        for index in (0..data.all.len()).filter(|&index| contacts.has_changed(data, state, index)) {
            happened.counts[first + index] = happened.counts[first + index].saturating_add(1);
            happened.armed[first + index] = false;
        }
        for (index, &redundant) in contacts.redundant.iter().enumerate() {
            // Its gap is watched in another way from here on, or begins at zero.
            let ends = happened.redundant[index] && !redundant;
            happened.armed[first + index] = redundant || happened.armed[first + index] && !ends;
            happened.redundant[index] = redundant;
        }
        for index in data.all.len()..data.all.len() + contacts.sums.len() {
            happened.armed[first + index] &= !due[first + index];
        }
        let sticks = |index: usize| {
            let sticks = data.all[index].slip.is_some() && is_closed(data, state, index);
            sticks && contacts.has_changed(data, state, index)
        };
        let stops = (0..data.all.len()).any(sticks);
        let resolved = resolved.and_then(|()| self.count_changes(&mut instants, data));
        self.instants = Some(instants);
        self.computed = Computed::default();
        resolved.map_err(InstanceError::Solver)?;
        self.forget_impulses();
        if stops {
            // The step that ends here knows the rate to within the tolerance.
            let closed = self.stepper.close_rates(&model, &mut self.machine, &mut self.now.state);
            closed.map_err(InstanceError::Solver)?;
        }
        Ok(())
    }

    /// Puts the mechanism where what touches can be decided: onto its loops, and onto what it has gone into. Before events engage joints this is done without their loop equations: with what is closed and sticks they
    /// may be redundant until it has been decided what gives way.
    pub(super) fn ready_contacts(&mut self) -> Result<(), InstanceError> {
        let model = self.model.clone();
        let Some(data) = &model.program().instants.contacts else { return Ok(()) };
        self.catch_up();
        self.find_features()?;
        if self.is_exchanged() {
            self.note_returns();
            return self.put_back();
        }
        self.close_for_friction(data)?;
        self.check_inside(CANCELLED.max(self.now.tolerance))
    }

    /// Shorter flights end a series of bounces, as shares of a fall: nor are flights seen that are never apart. How high one is, is the square of its share of a fall, divided by 8.
    fn shortest_flight(&self) -> f64 {
        match self.is_exchanged() {
            true => maximum(SHORTEST_SEEN, (8.0 * ERRORS_APART * self.importer_errors()).sqrt()),
            false => self.now.tolerance,
        }
    }

    /// A polynomial of the series leaves the loops open by about the tolerance, and the next step begins with them closed: whether something that has come to rest slides, and in which direction, must be
    /// decided for the rates that it then has.
    fn close_for_friction(&mut self, data: &Contacts) -> Result<(), InstanceError> {
        if data.all.iter().all(|contact| contact.slip.is_none()) {
            return Ok(());
        }
        let closed = self.stepper.close_positions(&self.model, &mut self.machine, &mut self.now.state);
        let closed =
            closed.and_then(|()| self.stepper.close_rates(&self.model, &mut self.machine, &mut self.now.state));
        closed.map_err(InstanceError::Solver)
    }

    /// Looks whether anything is inside what it touches by more than `least` of its scale: at the start, or where a limit has been moved.
    ///
    /// # Errors
    /// Something is: nothing could have moved it there.
    fn check_inside(&mut self, least: f64) -> Result<(), InstanceError> {
        let model = self.model.clone();
        let (Some(data), Some(instants)) = (&model.program().instants.contacts, &mut self.instants) else {
            return Ok(());
        };
        instants.contacts.measure(&model, &mut self.machine, &self.now.state);
        let gaps = data.all.iter().zip(&instants.contacts.gaps).filter(|(contact, _)| contact.slip.is_none());
        for (contact, &gap) in gaps {
            let row = row_of(model.program(), contact);
            if gap < -least * row.scale {
                let (name, angular, time) = (contact.name.clone(), row.is_angle(), self.now.state.time());
                return Err(Failure::Beyond { name, time, by: -gap, angular }.into());
            }
        }
        Ok(())
    }

    /// An importer's steps end beyond what is hit: the mechanism is put back onto it, or it would go in further with every impact.
    fn put_back(&mut self) -> Result<(), InstanceError> {
        let (model, errors) = (self.model.clone(), self.undisturbed());
        let (Some(data), Some(instants)) = (&model.program().instants.contacts, &mut self.instants) else {
            return Ok(());
        };
        let (state, redundant) = (&mut self.now.state, &self.now.happened.redundant);
        instants.contacts.measure(&model, &mut self.machine, state);
        for (index, contact) in data.all.iter().enumerate() {
            let is_contact = contact.slip.is_none();
            let least = if redundant[index] { errors * row_of(model.program(), contact).scale } else { 0.0 };
            let is_beyond = is_contact && instants.contacts.gaps[index] < -least && !is_closed(data, state, index);
            instants.contacts.hit[index] = is_beyond;
            if is_beyond {
                state.discrete_mut()[contact.state.closed as usize] = 1.0;
            }
        }
        if !instants.contacts.hit.contains(&true) {
            return Ok(());
        }
        let closed = self.stepper.close_positions(&model, &mut self.machine, state);
        for (contact, _) in data.all.iter().zip(&instants.contacts.hit).filter(|(_, beyond)| **beyond) {
            state.discrete_mut()[contact.state.closed as usize] = 0.0;
        }
        let closed = closed.and_then(|()| self.stepper.close_rates(&model, &mut self.machine, state));
        closed.map_err(InstanceError::Solver)
    }

    /// Where nothing has been found to open or to close by itself, but something has changed: at a tick, and at the start of a run.
    pub(super) fn resolve_unfound(&mut self) -> Result<(), InstanceError> {
        if let Some(instants) = &mut self.instants {
            instants.due.fill(false);
        }
        self.resolve_contacts()
    }

    /// At the start of a run: what touches is opened or closed.
    ///
    /// # Errors
    /// The start is beyond a limit, or inside what it touches.
    pub(super) fn begin_contacts(&mut self) -> Result<(), InstanceError> {
        if self.model.program().instants.contacts.is_none() {
            return Ok(());
        }
        self.check_profiles()?;
        self.check_inside(TOUCHING)?;
        self.resolve_unfound()?;
        self.now.happened.counts.fill(0);
        let hit = self.instants.as_ref().is_some_and(|instants| instants.contacts.hit.contains(&true));
        if hit {
            // Rates are no longer those that were given.
            self.now.at_start = false;
        }
        if hit || self.is_any_solved() || self.may_lock() {
            // The run is to begin with what is closed, and what slips.
            self.go_on_anew();
        }
        Ok(())
    }

    /// Arms the contacts that press, or are open by more than rounding errors.
    pub(super) fn arm_contacts(&mut self) {
        let model = self.model.clone();
        let (Some(data), Some(instants)) = (&model.program().instants.contacts, &self.instants) else { return };
        let first = model.program().instants.events.len();
        for (index, contact) in data.all.iter().enumerate() {
            let scale = row_of(model.program(), contact).scale;
            let is_open = contact.slip.is_none() && !is_closed(data, &self.now.state, index);
            let least = maximum(if is_open { TOUCHING * scale } else { 0.0 }, self.apart(first + index));
            self.now.happened.armed[first + index] |= instants.indicators[index] < -least;
        }
        for index in data.all.len()..instants.indicators.len() {
            self.now.happened.armed[first + index] |= instants.indicators[index] < 0.0;
        }
    }

    /// A contact, or a sign of what presses, that has been turned at an instant, and would have to be turned again.
    pub(super) fn never_fits(&self, event: usize, time: f64) -> Failure {
        let instants = &self.model.program().instants;
        let turned = instants.contacts().get(event - instants.events.len());
        let sticking = || instants.contacts().iter().filter(|contact| contact.slip.is_some());
        let at_profile = event.checked_sub(instants.first_at_profiles());
        let slots = instants.contours().iter().flat_map(|contour| contour.slots.iter().map(move |_| contour));
        let contour = at_profile.and_then(|place| instants.contours().iter().chain(slots).nth(place));
        let names = match turned {
            Some(contact) => vec![contact.name.clone()],
            None if contour.is_some() => contour.iter().map(|contour| contour.name.clone()).collect(),
            None => sticking().map(|contact| contact.name.clone()).collect(),
        };
        Failure::Contact { time, names, why: "neither open nor closed is consistent with the motion that follows" }
    }

    /// Something that is against the law of its mode by more than errors where the sides were last evaluated: a step has been looked through up to there, or everything has been decided.
    pub(super) fn find_violated(&self, instants: &Instants) -> Option<Failure> {
        let data = self.model.program().instants.contacts.as_ref()?;
        let violated = |index| Some((index, self.violation(instants, data, index)?));
        let (index, why) = (0..data.all.len()).find_map(violated)?;
        Some(Failure::Contact { time: instants.within.time(), names: vec![data.all[index].name.clone()], why })
    }

    /// In which way something is against the law of its mode: a gap is negative, a contact pulls, friction exceeds its limit, or what sticks or is held by others slides.
    fn violation(&self, instants: &Instants, data: &Contacts, index: usize) -> Option<&'static str> {
        let (contact, errors) =
            (&data.all[index], if self.is_exchanged() { self.importer_errors() } else { self.now.tolerance });
        let (state, scale) = (&self.now.state, row_of(self.model.program(), contact).scale);
        let closed = is_closed(data, state, index);
        let excess = if closed { self.pull(instants, data, index) } else { instants.indicators[index] };
        let Some(slip) = &contact.slip else {
            let open =
                if self.is_exchanged() || self.now.happened.redundant[index] { ERRORS_APART * errors } else { 0.0 };
            let passed = !closed && instants.contacts.gaps[index] < -maximum(CANCELLED, open) * scale;
            let pulls = closed && excess > self.least_force(errors);
            return passed.then_some(PASSED).or_else(|| pulls.then_some(PULLED));
        };
        if closed {
            return (excess > self.least_force(errors)).then_some(EXCEEDED);
        }
        let rubs = slip.on.is_none_or(|on| is_closed(data, state, on as usize));
        let slides = direction(data, state, index).abs() == 1.0;
        // By more than the method's errors; an importer keeps what sticks at rest by its own.
        let errors = if self.is_exchanged() { maximum(errors, LARGEST_ERRORS) } else { errors };
        let least = maximum(CANCELLED, RATE_OVERLOOKED * errors) * scale;
        let back = if slides { excess } else { instants.contacts.rates[index].abs() };
        (rubs && back > least).then_some(if slides { PASSED } else { SLIDES })
    }

    /// By how much the reaction of a closed contact pulls, or what sticks exceeds its limit.
    fn pull(&self, instants: &Instants, data: &Contacts, index: usize) -> f64 {
        let contact = &data.all[index];
        let reaction = |row: u32| self.machine.registers()[self.model.layout().reactions() + row as usize];
        let force = reaction(contact.constraint);
        match &contact.slip {
            Some(slip) => force.abs() - instants.contacts.restitutions[index] * reaction(slip.level),
            None => force,
        }
    }

    /// Forces are known to no more than this.
    pub(super) fn least_force(&self, errors: f64) -> f64 {
        LEAST_FORCE + FOUND * maximum(CANCELLED, errors) * self.largest_reaction()
    }

    /// In Model Exchange, where everything has been decided, and where a step of the importer has been completed in which nothing begins: looks whether everything obeys the law of its mode.
    ///
    /// # Errors
    /// Something does not.
    pub(in crate::instance) fn check_modes(&mut self) -> Result<(), InstanceError> {
        if self.model.program().instants.contacts.is_none() {
            return Ok(());
        }
        self.evaluate_now()?;
        let Some(mut instants) = self.instants.take() else { return Ok(()) };
        instants.within.copy_from(&self.now.state);
        let violated = self.find_violated(&instants);
        self.instants = Some(instants);
        violated.map_or(Ok(()), |failure| Err(failure.into()))
    }
}

impl Instance {
    /// Something whose mode the motion contradicts where the excesses were last evaluated.
    pub(super) fn find_contradicted(&self, instants: &Instants) -> Option<usize> {
        let first = self.model.program().instants.events.len();
        (first..instants.armed.len()).find(|&event| self.is_contradicted(instants, event))
    }

    /// True for what could not be armed since it last changed, and is against its mode by more than the tolerance: it slides back, sticks by more than its level, or pulls. Less, and it has been so for less
    /// than the method resolves.
    pub(super) fn is_contradicted(&self, instants: &Instants, event: usize) -> bool {
        let program = self.model.program();
        let index = event - program.instants.events.len();
        let Some(data) = program.instants.contacts.as_ref().filter(|data| index < data.all.len()) else { return false };
        let (tolerance, scale) = (self.now.tolerance, self.scale_of(event));
        let is_open = data.all[index].slip.is_none();
        let [excess, least] = match is_closed(data, &self.now.state, index) {
            true => [self.pull(instants, data, index), self.least_force(tolerance)],
            false if is_open => return false,
            false => [instants.indicators[index], tolerance * scale],
        };
        !instants.armed[event] && excess > least
    }

    /// True for a contact that presses, and for friction that sticks.
    pub(super) fn is_closed_contact(&self, event: usize) -> bool {
        let program = self.model.program();
        let place = event.checked_sub(program.instants.events.len());
        let known = place.zip(program.instants.contacts.as_ref()).filter(|(index, data)| *index < data.all.len());
        known.is_some_and(|(index, data)| is_closed(data, &self.now.state, index))
    }

    /// The largest of all multipliers in the registers.
    pub(super) fn largest_reaction(&self) -> f64 {
        let layout = self.model.layout();
        let multipliers = &self.machine.registers()[layout.reactions()..layout.constants()];
        multipliers.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
    }

    /// Counts the changes of mode at one instant.
    ///
    /// # Errors
    /// They do not end.
    fn count_changes(&self, instants: &mut Instants, data: &Contacts) -> Result<(), Failure> {
        let state = &self.now.state;
        let first = self.model.program().instants.events.len();
        let Instants { contacts, known: Continuation { changes, .. }, due, .. } = instants;
        // What is found at an instant counts, too, where nothing follows from it.
        let changed = |index: usize| contacts.has_changed(data, state, index) || due[first + index];
        if !(0..data.all.len()).any(changed) {
            return Ok(());
        }
        let time = state.time();
        if changes.count == 0 || time > changes.since + ROUNDING * maximum(time.abs(), 1.0) {
            (changes.since, changes.count) = (time, 0);
            changes.who.fill(false);
        }
        changes.count += 1;
        for index in 0..data.all.len() {
            changes.who[index] |= changed(index);
        }
        if changes.count <= MOST_CHANGES {
            return Ok(());
        }
        changes.count = 0;
        let who = data.all.iter().zip(&changes.who).filter(|(_, changes)| **changes);
        let names = who.map(|(contact, _)| contact.name.clone()).collect();
        Err(Failure::Contact {
            time,
            names,
            why: "their states (open or closed, stick or slip) change without end at the same time (chattering)",
        })
    }
}

const PASSED: &str = "the time of its event could not be located";
const PULLED: &str = "its contact force is tensile, and no change of mode was found";
const EXCEEDED: &str = "its friction exceeds its limit, and no change of mode was found";
const SLIDES: &str = "it slides although other parts hold it, and no change of mode was found";

/// The loop equation of a contact.
fn row_of<'p>(program: &'p Program, contact: &Contact) -> &'p Constraint {
    &program.constraints[contact.constraint as usize]
}
