//! Events: steps are looked through for where comparisons begin to hold, and what holds happens.

use super::super::snapshot::Snapshot;
use super::super::{Computed, Instance, InstanceError};
use super::{Instants, Searched};
use crate::context::Settings;
use crate::failure::Failure;
use crate::hybrid::descent::DEEPEST;
use crate::hybrid::onset::{self, PARTS, Reach};
use crate::hybrid::tick::is_later;
use crate::program::{Program, Target};

/// A comparison jumps at no more places of a step than this, as one of a rounded value does; what seems to jump everywhere has errors that nobody knows.
const MOST_JUMPS: u32 = 4096;

impl Instance {
    /// The first event up to a time, and when. Each step of the method is looked through as a whole.
    pub(super) fn first_event(&mut self, target: f64) -> Result<Option<(f64, usize)>, InstanceError> {
        if self.model.program().instants.occasions() == 0 {
            return Ok(None);
        }
        // The state itself is read where something happens: the method goes on from the end of its last step.
        let mut now = self.time();
        while now < target {
            if self.now.run.is_changed() || self.now.run.step_end() <= now {
                self.leave_step();
                // Only the steps of the method count, wherever the communication points are.
                self.now.run.join(false);
                // The whole step is taken, of which only the very beginning is looked at.
                self.advance(now.next_up().min(target))?;
            }
            let found = self.search();
            if let Some(instants) = &mut self.instants
                && let Some(overlooked) = instants.known.overlooked.take()
            {
                (instants.known.searched, instants.known.end) = (None, None);
                return Err(overlooked.into());
            }
            if let Some((at, event)) = found {
                return Ok((!is_later(at, target)).then_some((at, event)));
            }
            if self.now.run.step_end() >= target {
                return Ok(None);
            }
            // Each step has a measure of its own; together they may not do more than a communication step may.
            self.check_work([now, target])?;
            now = self.now.run.step_end();
        }
        Ok(None)
    }

    /// What is armed at the end of a step is so at the beginning of the next one.
    fn leave_step(&mut self) {
        let last = &self.now.run.last;
        let step = [last.start_time, last.end_time];
        if let Some(instants) = &self.instants
            && instants.known.searched.is_some_and(|searched| searched.step == step)
        {
            self.now.happened.armed.clone_from(&instants.armed);
        }
    }

    /// Something changes within the last step: what has ceased to hold up to here is armed.
    pub(super) fn arm_until_now(&mut self) {
        let step = [self.now.run.last.start_time, self.now.run.before().time()];
        let is_covered = step[0] < step[1] && step[1] <= self.now.run.last.end_time;
        let Some(mut instants) = self.instants.take() else { return };
        if is_covered && !instants.due.is_empty() && self.search_step(&mut instants, step).first.is_none() {
            self.now.happened.armed.clone_from(&instants.armed);
        }
        (instants.known.searched, instants.known.end) = (None, None);
        self.instants = Some(instants);
    }

    /// Looks through the last step for the first event.
    fn search(&mut self) -> Option<(f64, usize)> {
        let step = [self.now.run.last.start_time, self.now.run.last.end_time];
        let mut instants = self.instants.take()?;
        let known = instants.known.searched.filter(|searched| searched.step == step);
        let found = known.unwrap_or_else(|| self.search_step(&mut instants, step));
        instants.known.searched = Some(found);
        self.instants = Some(instants);
        found.first
    }

    /// In pieces, each so short that the excesses are known from the places where they are looked at: a step is as long as the motion permits, which does not know the comparisons.
    fn search_step(&mut self, instants: &mut Instants, step: [f64; 2]) -> Searched {
        if let Some(found) = self.search_polynomials(instants, step) {
            return found;
        }
        if let Some(found) = self.search_frictions(instants, step) {
            return found;
        }
        instants.armed.clone_from(&self.now.happened.armed);
        if self.stays_far(instants, step) {
            self.computed = Computed::default();
            return Searched { step, first: None };
        }
        let (mut from, mut depth, mut first, mut jumps) = (0.0, 0, None, 0);
        while from < 1.0 && first.is_none() {
            let to = from + 0.5_f64.powi(depth);
            let piece = [from, to].map(|share| between(step, share));
            let is_resolved = self.is_resolved(instants, step, piece);
            if depth < DEEPEST && !is_resolved {
                depth += 1;
                if let Err(failure) = self.check_search(instants, [piece[0], step[1]]) {
                    instants.known.overlooked = Some(failure);
                    return Searched { step, first: None };
                }
                continue;
            }
            jumps += u32::from(!is_resolved && instants.unresolved.is_some());
            if jumps > MOST_JUMPS {
                instants.known.overlooked = self.never_resolved(instants, piece[0]);
                return Searched { step, first: None };
            }
            first = self.first_in(instants, step, piece);
            first = self.first_at_profiles(instants, piece, first);
            if instants.known.overlooked.is_some() {
                return Searched { step, first: None };
            }
            from = to;
            while depth > 0 && (from * 2.0_f64.powi(depth - 1)).fract() == 0.0 {
                depth -= 1;
            }
        }
        instants.known.seen =
            first.filter(|_| instants.record.is_some()).map(|found| self.seen_before(instants, step, found));
        if first.is_none() && !instants.indicators.is_empty() {
            self.evaluate_sides(instants, (step, step), 1.0);
            first = self.find_contradicted(instants).map(|event| (self.turn(instants, step, event), event));
            if first.is_none() {
                instants.known.overlooked = instants.known.overlooked.take().or_else(|| self.find_violated(instants));
            }
        }
        self.computed = Computed::default();
        Searched { step, first }
    }

    /// The event whose comparison jumps at more places of a step than a law does.
    fn never_resolved(&self, instants: &Instants, time: f64) -> Option<Failure> {
        let event = self.model.program().instants.events.get(instants.unresolved?)?;
        Some(Failure::EventJumps { time, event: event.name.clone() })
    }

    /// When something whose mode the motion contradicts at the end of a step begins to be against it by more than the tolerance.
    fn turn(&mut self, instants: &mut Instants, step: [f64; 2], event: usize) -> f64 {
        let (mut before, mut after) = (0.0, 1.0);
        for _ in 0..DEEPEST {
            let middle = 0.5 * (before + after);
            self.evaluate_sides(instants, (step, step), middle);
            if self.is_contradicted(instants, event) { after = middle } else { before = middle }
        }
        between(step, after)
    }

    /// Fails where a search takes more work than a communication step may, or the time for it is over: a comparison may jump at every place.
    pub(super) fn check_search(&self, instants: &Instants, [time, target]: [f64; 2]) -> Result<(), Failure> {
        Settings { deadline: instants.deadline, ..self.settings() }.check_patience(time)?;
        self.check_work_of(instants, [time, target])
    }

    /// Fails where more work has been done since the last communication point than a communication step may be.
    pub(super) fn check_work(&self, [time, target]: [f64; 2]) -> Result<(), Failure> {
        self.instants.as_ref().map_or(Ok(()), |instants| self.check_work_of(instants, [time, target]))
    }

    fn check_work_of(&self, instants: &Instants, [time, target]: [f64; 2]) -> Result<(), Failure> {
        let done = self.stepper.statistics().work + instants.work(self.model.program()) - instants.done_before;
        if done > self.most_work { Err(Failure::TooMuchWork { time, target }) } else { Ok(()) }
    }

    /// Looks at all excesses in the places of a piece, and whether those tell what they are in between.
    fn is_resolved(&mut self, instants: &mut Instants, step: [f64; 2], piece: [f64; 2]) -> bool {
        instants.unresolved = None;
        for part in 0..=PARTS {
            self.evaluate_sides(instants, (step, piece), part as f64 / PARTS as f64);
            for event in 0..instants.excesses.len() {
                instants.excesses[event][part] = instants.excess(event);
            }
            instants.contours.keep(part);
        }
        if piece[0] == step[0]
            && (0..instants.excesses.len()).any(|event| self.hides_flight(instants, (step, piece), event))
        {
            return false;
        }
        onset::CHECKS.iter().all(|&share| {
            self.evaluate_sides(instants, (step, piece), share);
            let unresolved = (0..instants.excesses.len())
                .find(|&event| !self.is_over(event) && !self.is_known(instants, event, share));
            instants.unresolved = unresolved.filter(|&event| !instants.is_contact(event));
            unresolved.is_none() && instants.contours.fit(share)
        })
    }

    /// True if the places of a piece tell the excess at a share of it, where the sides were last evaluated.
    fn is_known(&mut self, instants: &mut Instants, event: usize, share: f64) -> bool {
        let found = instants.excess(event);
        if onset::fits(&instants.excesses[event], share, found, 0.0) {
            return true;
        }
        if instants.is_contact(event) {
            return onset::stays_away(&instants.excesses[event], share, found);
        }
        self.find_noise(instants);
        onset::fits(&instants.excesses[event], share, found, instants.noise[event])
    }

    /// True for a contact that has just been left, with no rate, and seems to go in at once, but is apart earlier: its flight ends before the first place.
    fn hides_flight(&mut self, instants: &mut Instants, (step, piece): ([f64; 2], [f64; 2]), event: usize) -> bool {
        let (begin, least) = (instants.excesses[event][0], self.resting(event, step));
        // What leaves with a rate is seen to.
        if !self.has_left(instants, event) || begin < -least || !onset::begins_at_once(&instants.excesses[event]) {
            return false;
        }
        (1..=DEEPEST).any(|halvings| {
            self.evaluate_sides(instants, (step, piece), 0.5_f64.powi(halvings) / PARTS as f64);
            instants.excess(event) < -least
        })
    }

    /// The first event in a piece that is resolved.
    fn first_in(&mut self, instants: &mut Instants, step: [f64; 2], piece: [f64; 2]) -> Option<(f64, usize)> {
        let mut first: Option<(f64, usize)> = None;
        if (0..instants.sides.len() / 2).any(|event| !instants.armed[event] && !self.is_over(event)) {
            self.find_noise(instants);
        }
        for event in 0..instants.armed.len() {
            if self.is_over(event) {
                continue;
            }
            let (values, strict) = (instants.excesses[event], self.is_strict(event));
            // What has just been left is seen by its distance over the time since then, which does not begin at zero.
            let armed =
                instants.armed[event] || self.has_left(instants, event) && values[0] < -self.resting(event, step);
            // Where both modes of a contact fit at an instant, what follows says which it is.
            if !armed && piece[0] == step[0] && instants.is_contact(event) && onset::begins_at_once(&values) {
                let turned = instants.known.turned.replace((step[0], event));
                if turned.is_none_or(|(time, last)| last != event || is_later(step[0], time)) {
                    return Some((step[0], event));
                }
                instants.known.overlooked = Some(self.never_fits(event, step[0]));
            }
            let until = first.map_or(piece[1], |(at, _)| at);
            let range = Reach { noise: instants.noise[event], ..Reach::new(piece, until) };
            let onset = onset::first(&values, armed, strict, range, &mut |share: f64| {
                self.evaluate_sides(instants, (step, piece), share);
                instants.excess(event)
            });
            instants.armed[event] = onset.armed;
            let until = onset.begin.unwrap_or(range.limit);
            let closer = if armed { self.looked_at_closer(instants, (step, piece), event, until) } else { None };
            if let Some(at) = closer.or(onset.begin.map(|share| between(piece, share))) {
                instants.armed[event] = false;
                first = Some(first.filter(|(time, _)| *time <= at).unwrap_or((at, event)));
            }
        }
        first
    }

    /// When a force that is armed reaches its limit before a share of a piece, where it is nearly there while it varies by far more in the rest of the piece, whose places do not tell it: they are looked at as
    /// a piece of their own.
    fn looked_at_closer(
        &mut self,
        instants: &mut Instants,
        (step, mut piece): ([f64; 2], [f64; 2]),
        event: usize,
        until: f64,
    ) -> Option<f64> {
        if !self.is_closed_contact(event) {
            return None;
        }
        let before = |share: f64| (share * PARTS as f64) as usize;
        let (mut values, mut end, mut first) = (instants.excesses[event], before(until), None);
        while let Some(window) = onset::doubtful(&values, end) {
            piece = window.map(|place| between(piece, place as f64 / PARTS as f64));
            let mut excess = |instance: &mut Self, share: f64| {
                instance.evaluate_sides(instants, (step, piece), share);
                instants.excess(event)
            };
            values = std::array::from_fn(|place| excess(self, place as f64 / PARTS as f64));
            let least = self.least_force(self.now.tolerance);
            if values.iter().all(|value| value.abs() <= least) {
                break;
            }
            let range = Reach::new(piece, piece[1]);
            let begin = onset::first(&values, true, true, range, &mut |share| excess(self, share)).begin;
            first = begin.map(|share| between(piece, share)).or(first);
            end = before(begin.unwrap_or(1.0));
        }
        first
    }

    /// Evaluates the sides of all comparisons at a share of the last step; none is a number where the motion is not known.
    pub(super) fn evaluate_sides(&mut self, instants: &mut Instants, (step, piece): ([f64; 2], [f64; 2]), share: f64) {
        instants.evaluated += 1;
        let settings = self.settings();
        let Snapshot { run, memory, .. } = &mut self.now;
        let at = (between(piece, share), &mut instants.within);
        let mut known = self.stepper.interpolate(&self.model, &mut self.machine, (run, memory), at, &settings).is_ok();
        self.machine.load(&self.model, &instants.within);
        let solved = instants.sides_solved || self.is_any_solved() || share == 1.0 && self.may_lock();
        // A series that has begun there has limits of friction that nothing locks.
        let is_end = share == 1.0 && piece[1] == self.now.run.last.end_time && !instants.sides_solved;
        let is_begun = known && solved && is_end && self.take_from_series();
        if solved && !is_begun {
            known = known && self.accelerations.evaluate(&self.model, &mut self.machine).is_ok();
        }
        if solved {
            self.machine.load(&self.model, &instants.within);
        }
        self.machine.evaluate(&self.model.program().instants.sides, &mut instants.sides);
        self.indicate(instants, Some(step), solved && !is_begun);
        if !known {
            instants.sides.fill(f64::NAN);
            instants.indicators.fill(f64::NAN);
        }
    }

    /// Accelerations and multipliers where the last step ends, from the series that begins there; false if it has none.
    fn take_from_series(&mut self) -> bool {
        let settings = self.settings();
        let (run, memory) = (&self.now.run, &self.now.memory);
        self.accelerations.take(&self.model, &mut self.machine, |values| {
            self.stepper.solved_at_end(&self.model, run, memory, &settings, values)
        })
    }

    /// True if an event has happened that happens once only.
    fn is_over(&self, event: usize) -> bool {
        let event_data = self.model.program().instants.events.get(event);
        event_data.is_some_and(|event_data| event_data.once) && self.now.happened.counts[event] > 0
    }

    /// True if something happens only where its excess is more than zero: a contact opens where its reaction has passed zero.
    fn is_strict(&self, event: usize) -> bool {
        self.model.program().instants.events.get(event).is_none_or(|event| event.strict)
    }

    /// Lets everything happen that holds at the present time and has not held before, and what has been found to begin here. What that changes may let other comparisons hold.
    pub(super) fn happen(&mut self, found: Option<usize>) -> Result<(), InstanceError> {
        let events = self.model.program().instants.occasions();
        let mut found = found;
        let program = self.model.program();
        if found.is_some_and(|found| found >= program.instants.events.len() || program.has_jumping_events()) {
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
        let Some(mut instants) = self.instants.take() else { return Ok(()) };
        let model = self.model.clone();
        let evaluated = self.evaluate(&model.program().instants.sides, instants.sides_solved, &mut instants.sides);
        let evaluated = evaluated.and_then(|()| self.indicate_now(&mut instants));
        self.instants = Some(instants);
        evaluated
    }

    /// Says whether an event is due.
    fn find_due(&mut self, found: Option<usize>) -> Result<bool, InstanceError> {
        self.evaluate_now()?;
        let Some(mut instants) = self.instants.take() else { return Ok(false) };
        for index in 0..instants.due.len() {
            let excess = self.counted(&instants, index);
            let holds = if self.is_strict(index) { excess > 0.0 } else { excess >= 0.0 };
            let holds = holds || self.is_exchanged() && self.has_come_to_zero(&instants, index);
            // An importer may go on into what has been left for less than it can see.
            let inside = self.is_exchanged() && self.is_left(index) && excess > 0.0;
            let begins =
                found == Some(index) || inside || self.pulls(index, excess) || self.now.happened.armed[index] && holds;
            instants.due[index] = begins && !self.is_over(index);
        }
        let any = instants.due.contains(&true);
        self.instants = Some(instants);
        Ok(any)
    }

    /// Writes what the events that are due write, all at once.
    fn let_happen(&mut self, found: Option<usize>) -> Result<(), InstanceError> {
        let before = self.state_to_record();
        if self.joins() {
            self.ready_contacts()?;
        }
        self.evaluate_written()?;
        let model = self.model.clone();
        let Some(mut instants) = self.instants.take() else { return Ok(()) };
        let mut written = Ok(());
        instants.contacts.joining.begin(&self.now.state);
        for (index, event) in
            model.program().instants.events.iter().enumerate().filter(|(index, _)| instants.due[*index])
        {
            written = written.and_then(|()| event.writes.iter().try_for_each(|write| self.write(&instants, *write)));
            let happened = &mut self.now.happened;
            happened.armed[index] = false;
            happened.counts[index] = happened.counts[index].saturating_add(1);
            if event.stop {
                happened.ended = Some(index as u32);
            }
        }
        let released = self.release(&instants);
        let joins = instants.contacts.joining.find(&model, &mut self.machine, &self.now.state);
        self.instants = Some(instants);
        written?;
        joins.map_err(InstanceError::Solver)?;
        self.resolve_contacts()?;
        if released {
            // It has had its impact.
            let impacts = self.take_impacts();
            self.release_engaged();
            self.resolve_contacts()?;
            self.put_impacts(impacts);
        }
        self.note(before, Vec::new(), found);
        self.go_on_anew();
        Ok(())
    }

    /// True if an event that is due engages a joint or sets a rate.
    fn joins(&self) -> bool {
        let (program, Some(instants)) = (self.model.program(), &self.instants) else { return false };
        let is_mask = |target: Target| program.masks_by_event().any(|(_, place)| target == Target::Discrete(place));
        let mut events = program.instants.events.iter().zip(&instants.due).filter(|(_, due)| **due);
        events.any(|(event, _)| event.writes.iter().any(|write| is_mask(program.target(*write))))
    }

    /// Removes and releases what the due events say, but for what another one has just engaged; true if there is any of that.
    fn release(&mut self, instants: &Instants) -> bool {
        let mut is_engaged = false;
        let events = &self.model.program().instants.events;
        for event in events.iter().zip(&instants.due).filter(|(_, due)| **due).map(|(event, _)| event) {
            for place in event.removes.iter().map(|&place| place as usize) {
                match instants.contacts.joining.has_begun(&self.now.state, place) {
                    true => is_engaged = true,
                    false => self.now.state.discrete_mut()[place] = 0.0,
                }
            }
        }
        is_engaged
    }

    /// Releases what the due events have engaged and released together.
    fn release_engaged(&mut self) {
        let Some(instants) = &self.instants else { return };
        let events = &self.model.program().instants.events;
        let due = events.iter().zip(&instants.due).filter(|(_, due)| **due).flat_map(|(event, _)| &event.removes);
        for &place in due {
            self.now.state.discrete_mut()[place as usize] = 0.0;
        }
    }

    /// Arms the events whose comparisons do not hold at the present time, by more than rounding errors.
    fn arm(&mut self) {
        let Some(mut instants) = self.instants.take() else { return };
        let mut ceased = false;
        let events = instants.sides.len() / 2;
        let may_cease = |event: usize| !self.now.happened.armed[event] && self.counted(&instants, event) < 0.0;
        if (0..events).any(may_cease) {
            self.find_noise(&mut instants);
        }
        for event in 0..events {
            let ceases = self.counted(&instants, event) < -instants.noise[event];
            ceased |= ceases && !self.now.happened.armed[event];
            self.now.happened.armed[event] |= ceases;
            if ceases {
                self.show_as_it_is(event);
            }
        }
        self.instants = Some(instants);
        if ceased && self.is_exchanged() {
            self.begin_search();
        }
        self.arm_contacts();
    }

    /// By how much the first side of each comparison exceeds the second, as an importer is shown it.
    pub(in crate::instance) fn excesses(&mut self, excesses: &mut [f64]) -> Result<(), InstanceError> {
        self.evaluate_now()?;
        let Some(instants) = self.instants.take() else { return Ok(()) };
        self.show(&instants, excesses);
        self.instants = Some(instants);
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
        self.instants.as_mut().is_some_and(|instants| std::mem::take(&mut instants.known.happened))
    }

    /// Every event of the scene and every contact, and how often it has happened.
    pub fn events(&self) -> impl Iterator<Item = (&str, u32)> {
        let counted = occasions(self.model.program()).zip(self.now.happened.counts.iter().copied());
        counted.filter_map(|(name, count)| Some((name?, count)))
    }

    /// Reports the events that have happened since the last report.
    pub(crate) fn report_events(&mut self, mut report: impl FnMut(&str, f64)) {
        let Some(run) = &mut self.instants else { return };
        let names = occasions(self.model.program());
        for ((name, count), reported) in names.zip(&self.now.happened.counts).zip(&mut run.known.reported) {
            if let Some(name) = name.filter(|_| count > reported) {
                report(name, self.now.state.time());
            }
            *reported = *count;
        }
    }
}

/// The names of events, then of contacts; none of events that are not of the scene.
fn occasions(program: &Program) -> impl Iterator<Item = Option<&str>> {
    let events = program.instants.events.iter().map(|event| event.is_of_scene().then_some(event.name.as_str()));
    events.chain(program.instants.contacts().iter().map(|contact| Some(contact.name.as_str())))
}

/// The time at a share of a step.
pub(super) fn between([start, end]: [f64; 2], share: f64) -> f64 {
    if share < 1.0 { start + share * (end - start) } else { end }
}
