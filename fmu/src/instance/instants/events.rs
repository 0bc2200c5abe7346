//! Events: steps are looked through for where comparisons begin to hold, and what holds happens.

use super::super::snapshot::Snapshot;
use super::super::{Computed, Instance, InstanceError};
use super::{Instants, Searched};
use crate::context::Settings;
use crate::failure::Failure;
use crate::hybrid::onset::{self, PARTS, Reach};
use crate::hybrid::tick::is_later;
use crate::machine::ROUNDING;
use crate::math::minimum;

/// A step is halved so often at most where places do not tell what is between them: as where a law jumps.
const DEEPEST: i32 = 20;

impl Instance {
    /// The first event up to a time, and when. Each step of the method is looked through as a whole.
    pub(super) fn first_event(&mut self, target: f64) -> Result<Option<(f64, usize)>, InstanceError> {
        if self.model.program().instants.occasions() == 0 {
            return Ok(None);
        }
        while self.time() < target {
            let now = self.time();
            if self.now.run.is_changed() || self.now.run.step_end() <= now {
                self.leave_step();
                // Only the steps of the method count, wherever the communication points are.
                self.now.run.join(false);
                // The whole step is taken, of which only the very beginning is looked at.
                self.advance(now.next_up().min(target))?;
            }
            let found = self.search();
            if let Some(own) = &mut self.instants
                && let Some(overlooked) = own.overlooked.take()
            {
                (own.searched, own.end) = (None, None);
                return Err(overlooked.into());
            }
            if let Some((at, event)) = found {
                return Ok((!is_later(at, target)).then_some((at, event)));
            }
            if self.now.run.step_end() >= target {
                return Ok(None);
            }
            // Each step has a measure of its own; together they may not do more than a communication step may.
            self.check_work([self.time(), target])?;
            self.reach(self.now.run.step_end())?;
        }
        Ok(None)
    }

    /// What is armed at the end of a step is so at the beginning of the next one.
    fn leave_step(&mut self) {
        let last = &self.now.run.last;
        let step = [last.start_time, last.end_time];
        if let Some(own) = &self.instants
            && own.searched.is_some_and(|searched| searched.step == step)
        {
            self.now.happened.armed.clone_from(&own.armed);
        }
    }

    /// Something changes within the last step: what has ceased to hold up to here is armed.
    pub(super) fn arm_until_now(&mut self) {
        let step = [self.now.run.last.start_time, self.now.run.before().time()];
        let is_covered = step[0] < step[1] && step[1] <= self.now.run.last.end_time;
        let Some(mut own) = self.instants.take() else { return };
        if is_covered && !own.due.is_empty() && self.search_step(&mut own, step).first.is_none() {
            self.now.happened.armed.clone_from(&own.armed);
        }
        (own.searched, own.end) = (None, None);
        self.instants = Some(own);
    }

    /// Looks through the last step for the first event.
    fn search(&mut self) -> Option<(f64, usize)> {
        let step = [self.now.run.last.start_time, self.now.run.last.end_time];
        let mut own = self.instants.take()?;
        let known = own.searched.filter(|searched| searched.step == step);
        let found = known.unwrap_or_else(|| self.search_step(&mut own, step));
        own.searched = Some(found);
        self.instants = Some(own);
        found.first
    }

    /// In pieces, each so short that the excesses are known from the places where they are looked at: a step is as long as the motion permits, which does not know the comparisons.
    fn search_step(&mut self, own: &mut Instants, step: [f64; 2]) -> Searched {
        own.armed.clone_from(&self.now.happened.armed);
        if self.stays_far(own, step) {
            self.computed = Computed::default();
            return Searched { step, first: None };
        }
        let (mut from, mut depth, mut first) = (0.0, 0, None);
        while from < 1.0 && first.is_none() {
            let to = from + 0.5_f64.powi(depth);
            let piece = [from, to].map(|share| between(step, share));
            let is_resolved = self.is_resolved(own, step, piece);
            if depth < DEEPEST && !is_resolved {
                depth += 1;
                if let Err(failure) = self.check_search(own, [piece[0], step[1]]) {
                    own.overlooked = Some(failure);
                    return Searched { step, first: None };
                }
                continue;
            }
            first = self.first_in(own, step, piece);
            from = to;
            while depth > 0 && (from * 2.0_f64.powi(depth - 1)).fract() == 0.0 {
                depth -= 1;
            }
        }
        own.seen = first.filter(|_| own.record.is_some()).map(|found| self.seen_before(own, step, found));
        if first.is_none() && !own.indicators.is_empty() {
            self.evaluate_sides(own, (step, step), 1.0);
            first = self.find_contradicted(own).map(|event| (self.turn(own, step, event), event));
            if first.is_none() {
                own.overlooked = own.overlooked.take().or_else(|| self.find_violated(own));
            }
        }
        self.computed = Computed::default();
        Searched { step, first }
    }

    /// When something whose mode the motion contradicts at the end of a step begins to be against it by more than the tolerance.
    fn turn(&mut self, own: &mut Instants, step: [f64; 2], event: usize) -> f64 {
        let (mut before, mut after) = (0.0, 1.0);
        for _ in 0..DEEPEST {
            let middle = 0.5 * (before + after);
            self.evaluate_sides(own, (step, step), middle);
            if self.is_contradicted(own, event) { after = middle } else { before = middle }
        }
        between(step, after)
    }

    /// Fails where a search takes more work than a communication step may, or the time for it is over: a comparison may jump at every place.
    fn check_search(&self, own: &Instants, [time, target]: [f64; 2]) -> Result<(), Failure> {
        Settings { deadline: own.deadline, ..self.settings() }.check_patience(time)?;
        self.check_work_of(own, [time, target])
    }

    /// Fails where more work has been done since the last communication point than a communication step may be.
    pub(super) fn check_work(&self, [time, target]: [f64; 2]) -> Result<(), Failure> {
        self.instants.as_ref().map_or(Ok(()), |own| self.check_work_of(own, [time, target]))
    }

    fn check_work_of(&self, own: &Instants, [time, target]: [f64; 2]) -> Result<(), Failure> {
        let done = self.stepper.statistics().work + own.work(self.model.program()) - own.done_before;
        if done > self.most_work { Err(Failure::TooMuchWork { time, target }) } else { Ok(()) }
    }

    /// Looks at all excesses in the places of a piece, and whether those tell what they are in between.
    fn is_resolved(&mut self, own: &mut Instants, step: [f64; 2], piece: [f64; 2]) -> bool {
        for part in 0..=PARTS {
            self.evaluate_sides(own, (step, piece), part as f64 / PARTS as f64);
            for event in 0..own.excesses.len() {
                own.excesses[event][part] = own.excess(event);
            }
        }
        if piece[0] == step[0] && (0..own.excesses.len()).any(|event| self.hides_flight(own, (step, piece), event)) {
            return false;
        }
        onset::CHECKS.iter().all(|&share| {
            self.evaluate_sides(own, (step, piece), share);
            let mut counting = (0..own.excesses.len()).filter(|event| !self.is_over(*event));
            counting.all(|event| {
                let (values, found) = (&own.excesses[event], own.excess(event));
                onset::fits(values, share, found) || own.is_contact(event) && onset::stays_away(values, share, found)
            })
        })
    }

    /// True for a contact that has just been left, with no rate, and seems to go in at once, but is apart earlier: its flight ends before the first place.
    fn hides_flight(&mut self, own: &mut Instants, (step, piece): ([f64; 2], [f64; 2]), event: usize) -> bool {
        let (begin, least) = (own.excesses[event][0], self.resting(event, step));
        // What leaves with a rate is seen to.
        if !self.has_left(own, event) || begin < -least || !onset::begins_at_once(&own.excesses[event]) {
            return false;
        }
        (1..=DEEPEST).any(|halvings| {
            self.evaluate_sides(own, (step, piece), 0.5_f64.powi(halvings) / PARTS as f64);
            own.excess(event) < -least
        })
    }

    /// The first event in a piece that is resolved.
    fn first_in(&mut self, own: &mut Instants, step: [f64; 2], piece: [f64; 2]) -> Option<(f64, usize)> {
        let mut first: Option<(f64, usize)> = None;
        for event in 0..own.armed.len() {
            if self.is_over(event) {
                continue;
            }
            let (values, strict) = (own.excesses[event], self.is_strict(event));
            // What has just been left is seen by its distance over the time since then, which does not begin at zero.
            let armed = own.armed[event] || self.has_left(own, event) && values[0] < -self.resting(event, step);
            // Where both modes of a contact fit at an instant, what follows says which it is.
            if !armed && piece[0] == step[0] && own.is_contact(event) && onset::begins_at_once(&values) {
                let turned = own.turned.replace((step[0], event));
                if turned.is_none_or(|(time, last)| last != event || is_later(step[0], time)) {
                    return Some((step[0], event));
                }
                own.overlooked = Some(self.never_fits(event, step[0]));
            }
            let whole = piece[1] - piece[0];
            let reach = Reach {
                limit: first.map_or(1.0, |(at, _)| (at - piece[0]) / whole),
                spacing: f64::EPSILON * minimum(piece[0].abs(), piece[1].abs()) / whole,
            };
            let onset = onset::first(&values, armed, strict, reach, &mut |share: f64| {
                self.evaluate_sides(own, (step, piece), share);
                own.excess(event)
            });
            own.armed[event] = onset.armed;
            if let Some(share) = onset.begin {
                let at = between(piece, share);
                first = Some(first.filter(|(time, _)| *time <= at).unwrap_or((at, event)));
            }
        }
        first
    }

    /// Evaluates the sides of all comparisons at a share of the last step; none is a number where the motion is not known.
    pub(super) fn evaluate_sides(&mut self, own: &mut Instants, (step, piece): ([f64; 2], [f64; 2]), share: f64) {
        own.evaluated += 1;
        let settings = self.settings();
        let Snapshot { run, memory, .. } = &mut self.now;
        let at = (between(piece, share), &mut own.within);
        let mut known = self.stepper.interpolate(&self.model, &mut self.machine, (run, memory), at, &settings).is_ok();
        self.machine.load(&self.model, &own.within);
        let solved = own.sides_solved || self.is_any_solved() || share == 1.0 && self.may_lock();
        if solved {
            known = known && self.accelerations.evaluate(&self.model, &mut self.machine).is_ok();
            self.machine.load(&self.model, &own.within);
        }
        self.machine.evaluate(&self.model.program().instants.sides, &mut own.sides);
        self.indicate(own, Some(step), solved);
        if !known {
            own.sides.fill(f64::NAN);
            own.indicators.fill(f64::NAN);
        }
    }

    /// True if an event has happened that happens once only.
    fn is_over(&self, event: usize) -> bool {
        let own = self.model.program().instants.events.get(event);
        own.is_some_and(|own| own.once) && self.now.happened.counts[event] > 0
    }

    /// True if something happens only where its excess is more than zero: a contact opens where its reaction has passed zero.
    fn is_strict(&self, event: usize) -> bool {
        self.model.program().instants.events.get(event).is_none_or(|own| own.strict)
    }

    /// Lets everything happen that holds at the present time and has not held before, and what has been found to begin here. What that changes may let other comparisons hold.
    pub(super) fn happen(&mut self, found: Option<usize>) -> Result<(), InstanceError> {
        let events = self.model.program().instants.occasions();
        let mut found = found;
        if found.is_some_and(|found| found >= self.model.program().instants.events.len()) {
            // A step that is taken again up to here is so before anything changes.
            self.go_on_anew();
        }
        // After it has happened an event cannot begin to hold at the same instant.
        for _ in 0..=events {
            if !self.find_due(found)? {
                break;
            }
            self.let_happen(found)?;
            found = None;
        }
        self.arm();
        Ok(())
    }

    /// The sides of all comparisons, and what contacts do, at the present state.
    pub(super) fn evaluate_now(&mut self) -> Result<(), InstanceError> {
        let Some(mut own) = self.instants.take() else { return Ok(()) };
        let model = self.model.clone();
        let evaluated = self.evaluate(&model.program().instants.sides, own.sides_solved, &mut own.sides);
        let evaluated = evaluated.and_then(|()| self.indicate_now(&mut own));
        self.instants = Some(own);
        evaluated
    }

    /// Says whether an event is due.
    fn find_due(&mut self, found: Option<usize>) -> Result<bool, InstanceError> {
        self.evaluate_now()?;
        let Some(mut own) = self.instants.take() else { return Ok(false) };
        for index in 0..own.due.len() {
            let excess = self.counted(&own, index);
            let holds = if self.is_strict(index) { excess > 0.0 } else { excess >= 0.0 };
            let holds = holds || self.is_exchanged() && self.has_come_to_zero(&own, index);
            // An importer may go on into what has been left for less than it can see.
            let inside = self.is_exchanged() && self.is_left(index) && excess > 0.0;
            let begins =
                found == Some(index) || inside || self.pulls(index, excess) || self.now.happened.armed[index] && holds;
            own.due[index] = begins && !self.is_over(index);
        }
        let any = own.due.contains(&true);
        self.instants = Some(own);
        Ok(any)
    }

    /// Writes what the events that are due write, all at once.
    fn let_happen(&mut self, found: Option<usize>) -> Result<(), InstanceError> {
        let before = self.state_to_record();
        self.evaluate_written()?;
        let model = self.model.clone();
        let Some(own) = self.instants.take() else { return Ok(()) };
        let mut written = Ok(());
        for (index, event) in model.program().instants.events.iter().enumerate().filter(|(index, _)| own.due[*index]) {
            written = written.and_then(|()| event.writes.iter().try_for_each(|write| self.write(&own, *write)));
            for &there in &event.removes {
                self.now.state.parameters_mut()[there as usize] = 0.0;
            }
            let happened = &mut self.now.happened;
            happened.armed[index] = false;
            happened.counts[index] = happened.counts[index].saturating_add(1);
            if event.stop {
                happened.ended = Some(index as u32);
            }
        }
        self.instants = Some(own);
        written?;
        self.resolve_contacts()?;
        self.note(before, Vec::new(), found);
        self.go_on_anew();
        Ok(())
    }

    /// Arms the events whose comparisons do not hold at the present time, by more than rounding errors.
    fn arm(&mut self) {
        let Some(own) = self.instants.take() else { return };
        let mut ceased = false;
        for (event, sides) in own.sides.chunks_exact(2).enumerate() {
            // Sides that have just been equal differ by rounding errors.
            let ceases = self.counted(&own, event) < -ROUNDING * (sides[0].abs() + sides[1].abs());
            ceased |= ceases && !self.now.happened.armed[event];
            self.now.happened.armed[event] |= ceases;
        }
        self.instants = Some(own);
        if ceased && self.is_exchanged() {
            self.begin_search();
        }
        self.arm_contacts();
    }

    /// By how much the first side of each comparison exceeds the second, as an importer is shown it.
    pub(in crate::instance) fn excesses(&mut self, excesses: &mut [f64]) -> Result<(), InstanceError> {
        self.evaluate_now()?;
        let Some(own) = self.instants.take() else { return Ok(()) };
        self.show(&own, excesses);
        self.instants = Some(own);
        Ok(())
    }

    /// In Model Exchange: true if there is a tick or an event that the importer must let happen.
    pub(in crate::instance) fn is_due(&mut self) -> Result<bool, InstanceError> {
        if self.instants.is_none() {
            return Ok(false);
        }
        let due = self.find_due(None)?;
        let due = self.end_step(due);
        self.arm();
        let tick = self.next_tick(self.now.happened.ticked)?;
        Ok(due || !is_later(tick, self.time()))
    }

    /// At an event of Model Exchange: lets everything happen that is due.
    ///
    /// # Errors
    /// The importer has gone past a tick.
    pub(in crate::instance) fn handle_instants(&mut self) -> Result<(), InstanceError> {
        if self.instants.is_none() {
            return Ok(());
        }
        let (now, tick) = (self.time(), self.next_tick(self.now.happened.ticked)?);
        if is_later(now, tick) {
            return Err(InstanceError::Passed { time: tick, now });
        }
        self.follow_search()?;
        if !is_later(tick, now) {
            self.tick()?;
        }
        self.happen(None)?;
        self.end_search();
        Ok(())
    }

    /// True if an event has ended the run.
    pub(crate) fn is_ended(&self) -> bool {
        self.now.happened.ended.is_some()
    }

    /// True if something has happened in the last step.
    pub(in crate::instance) fn take_happened(&mut self) -> bool {
        self.instants.as_mut().is_some_and(|own| std::mem::take(&mut own.happened))
    }

    /// Every event of the scene, and how often it has happened.
    pub fn events(&self) -> impl Iterator<Item = (&str, u32)> {
        self.occasions().zip(self.now.happened.counts.iter().copied())
    }

    /// The names of events, then of contacts.
    fn occasions(&self) -> impl Iterator<Item = &str> {
        let instants = &self.model.program().instants;
        let events = instants.events.iter().map(|event| event.name.as_str());
        events.chain(instants.contacts().iter().map(|contact| contact.name.as_str()))
    }

    /// Reports the events that have happened since the last report.
    pub(crate) fn report_events(&mut self, mut report: impl FnMut(&str, f64)) {
        let Some(own) = &mut self.instants else { return };
        let instants = &self.model.program().instants;
        let events = instants.events.iter().map(|event| &event.name);
        let names = events.chain(instants.contacts().iter().map(|contact| &contact.name));
        for ((name, count), reported) in names.zip(&self.now.happened.counts).zip(&mut own.reported) {
            if count > reported {
                report(name, self.now.state.time());
            }
            *reported = *count;
        }
    }
}

/// The time at a share of a step.
fn between([start, end]: [f64; 2], share: f64) -> f64 {
    if share < 1.0 { start + share * (end - start) } else { end }
}
