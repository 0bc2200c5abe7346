//! What happens at instants: ticks of sampled values, and events when a comparison begins to hold.
//!
//! A tick is known beforehand: steps end there, by every method. For an event every step is looked through when it has been taken, whatever communication points lie in it; the motion goes on from
//! where the comparison begins to hold. So what happens, and when, does not depend on the communication points.

mod contacts;
mod contours;
mod events;
mod importer;
mod noise;
mod record;

use serde::{Deserialize, Serialize};

pub use crate::hybrid::contact::Impact;
pub(super) use importer::LARGER;
pub use record::Happening;

use super::snapshot::Phase;
use super::{Computed, Instance, InstanceError, Snapshot};
use crate::context::Deadline;
use crate::failure::Failure;
use crate::hybrid::contact::ContactValues;
use crate::hybrid::onset::PARTS;
use crate::hybrid::tick::{Clock, is_later};
use crate::integrator::control::shortest;
use crate::math::maximum;
use crate::model::{Model, State};
use crate::program::{Program, Target, Write};
use crate::tape::Tape;
use contours::ContourValues;
use importer::Importer;

/// A communication step whose modes do not fit is taken again to these shares of the tolerance.
const RETRIES: [f64; 2] = [0.1, 0.01];
/// Not below this tolerance: steps to a smaller one end at rounding errors.
const CLOSEST: f64 = 1e-12;

/// What a run remembers of what has happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Happened {
    /// Of each event: true if its comparison can begin to hold where the last step begins.
    armed: Vec<bool>,
    /// How often each has happened.
    counts: Vec<u32>,
    /// Ticks up to this time are done \[s\].
    ticked: f64,
    /// The event that has ended the run.
    ended: Option<u32>,
    /// True for open contacts whose gaps others keep at zero.
    redundant: Vec<bool>,
    /// In Model Exchange.
    importer: Importer,
}

impl Happened {
    pub fn new(model: &Model) -> Self {
        let events = model.program().instants.occasions();
        Self {
            armed: vec![true; events],
            counts: vec![0; events],
            ticked: f64::MIN,
            ended: None,
            redundant: vec![false; model.program().instants.contacts().len()],
            importer: Importer::new(events),
        }
    }

    pub fn copy_from(&mut self, other: &Self) {
        self.armed.clone_from(&other.armed);
        self.counts.clone_from(&other.counts);
        self.redundant.clone_from(&other.redundant);
        self.importer.copy_from(&other.importer);
        (self.ticked, self.ended) = (other.ticked, other.ended);
    }

    pub fn belongs_to(&self, model: &Model) -> bool {
        let events = model.program().instants.occasions();
        self.armed.len() == events
            && self.counts.len() == events
            && self.redundant.len() == model.program().instants.contacts().len()
            && self.importer.is_sound(events)
            && self.ticked.is_finite()
            && self.ended.is_none_or(|event| (event as usize) < events)
    }
}

/// Storage of a model in which something happens.
#[derive(Clone, Debug)]
pub(super) struct Instants {
    clocks: Vec<Clock>,
    /// The next tick \[s\]; infinite if there is none.
    tick: f64,
    /// No step goes beyond this time \[s\].
    pub limit: f64,
    /// The end of the communication step under way \[s\].
    pub target: f64,
    /// When the computer must be done with the step under way.
    pub deadline: Option<Deadline>,
    known: Continuation,
    /// Results of the tapes.
    begin: Vec<f64>,
    written: Vec<f64>,
    sides: Vec<f64>,
    /// The error of each excess of an event, and work storage for the errors of all registers.
    noise: Vec<f64>,
    errors: Vec<f64>,
    /// True for tapes that read accelerations or reactions.
    write_solved: bool,
    sides_solved: bool,
    /// Before a step: a failure leaves the instance as it was.
    before: Snapshot,
    /// A state within the last step.
    within: State,
    /// One for each contact, positive where it must change: its reaction while it is closed, minus its gap while it is open.
    indicators: Vec<f64>,
    contacts: ContactValues,
    contours: ContourValues,
    /// An event whose places in a piece of the last step do not tell its excess between them.
    unresolved: Option<usize>,
    /// How many places within steps have been evaluated, and how many instructions of tapes that is each.
    evaluated: u64,
    evaluation: u64,
    /// All work before the communication step under way.
    done_before: u64,
    /// The excess of each event, then of each contact, in the parts of the last step.
    excesses: Vec<[f64; PARTS + 1]>,
    /// Events that are due, and what `armed` becomes at the end of the last step.
    due: Vec<bool>,
    armed: Vec<bool>,
    /// What has happened since it was last asked for, if anybody asks.
    record: Option<Vec<Happening>>,
    /// How much of it had happened before the communication step under way.
    recorded: usize,
}

/// What is known of the present motion beside its snapshot. It is of no other motion.
#[derive(Clone, Debug)]
struct Continuation {
    /// Why the last step cannot be searched, or what must have been missed in it.
    overlooked: Option<Failure>,
    /// When a contact last changed because of what followed, and which: an instant at which both modes fit.
    turned: Option<(f64, usize)>,
    changes: Changes,
    searched: Option<Searched>,
    /// Where the last step ends, if nothing could touch in it.
    end: Option<Distance>,
    /// How long after the beginning of the last step an event was found \[s\], and how large its excess has been since then.
    seen: Option<[f64; 2]>,
    /// True if something has happened since this was last asked.
    happened: bool,
    /// Counts that have been reported.
    reported: Vec<u32>,
}

impl Continuation {
    fn new(occasions: usize, contacts: usize) -> Self {
        Self {
            overlooked: None,
            turned: None,
            changes: Changes { since: 0.0, count: 0, who: vec![false; contacts] },
            searched: None,
            end: None,
            seen: None,
            happened: false,
            reported: vec![0; occasions],
        }
    }

    /// Another motion begins, in which so much has happened and been reported. Nothing is allocated.
    fn forget(&mut self, now: &Happened) {
        let Self { overlooked, turned, changes, searched, end, seen, happened, reported } = self;
        (*overlooked, *turned, *searched, *end, *seen, *happened) = (None, None, None, None, None, false);
        changes.count = 0;
        reported.clone_from(&now.counts);
    }
}

/// How often modes have changed since a time that is the present instant, and whose.
#[derive(Clone, Debug)]
struct Changes {
    since: f64,
    count: u32,
    who: Vec<bool>,
}

/// The least gap at a time, and the largest rate of one.
#[derive(Clone, Copy, Debug)]
struct Distance {
    time: f64,
    gap: f64,
    rate: f64,
}

/// What has been found in the last step.
#[derive(Clone, Copy, Debug)]
struct Searched {
    step: [f64; 2],
    /// The first event, and when.
    first: Option<(f64, usize)>,
}

/// What has come of an event of Model Exchange.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Handled {
    /// True if the states have changed.
    pub moved: bool,
    /// When the next tick is \[s\].
    pub next: Option<f64>,
    /// True if the run ends.
    pub ended: bool,
}

impl Instants {
    pub fn of(model: &Model, registers: usize, now: &Snapshot) -> Option<Box<Self>> {
        let program = model.program();
        let instants = &program.instants;
        if instants.is_empty() && program.discrete.is_empty() {
            return None;
        }
        let occasions = instants.occasions();
        let tapes = &program.tapes;
        let closing = [&tapes.constraint, &tapes.project_position, &tapes.project_velocity, &tapes.acceleration];
        let lengths = closing.into_iter().chain([&instants.sides]).map(|tape| tape.instructions().len() as u64);
        Some(Box::new(Self {
            clocks: Vec::with_capacity(instants.samplers.len()),
            tick: f64::INFINITY,
            limit: f64::INFINITY,
            target: f64::NEG_INFINITY,
            deadline: None,
            known: Continuation::new(occasions, instants.contacts().len()),
            begin: vec![0.0; instants.begin.results.len()],
            written: vec![0.0; instants.written.results.len()],
            sides: vec![0.0; instants.sides.results.len()],
            noise: vec![0.0; occasions],
            errors: vec![0.0; if instants.events.is_empty() { 0 } else { registers }],
            write_solved: reads_solved(program, &instants.written),
            sides_solved: reads_solved(program, &instants.sides),
            before: now.clone(),
            within: model.default_state(0.0),
            excesses: vec![[0.0; PARTS + 1]; occasions],
            due: vec![false; occasions],
            armed: vec![true; occasions],
            indicators: vec![0.0; occasions - instants.events.len()],
            contacts: ContactValues::new(model),
            contours: ContourValues::new(instants.contours().len()),
            unresolved: None,
            evaluated: 0,
            evaluation: lengths.sum(),
            done_before: 0,
            record: None,
            recorded: 0,
        }))
    }

    /// By how much the first side of a comparison exceeds the second, where the sides were last evaluated; after the events, the indicators of contacts.
    fn excess(&self, event: usize) -> f64 {
        match self.sides.get(2 * event..2 * event + 2) {
            Some(sides) => sides[0] - sides[1],
            None => self.indicators[event - self.sides.len() / 2],
        }
    }

    /// About how much work the searches and trials have been, in instructions of tapes.
    pub fn work(&self, program: &Program) -> u64 {
        let trial = program.tapes.acceleration.instructions().len() as u64;
        self.evaluated * self.evaluation + self.contacts.trials * trial
    }

    /// True for what comes after the events.
    fn is_contact(&self, event: usize) -> bool {
        2 * event >= self.sides.len()
    }

    /// To be called when the continuation was replaced by another one, in which so much has happened.
    pub fn forget(&mut self, happened: &Happened) {
        self.known.forget(happened);
        // Where a joint could not engage, it has not had its impact.
        self.contacts.joining.end();
    }

    /// What has been recorded and not been taken is of a motion that is not continued.
    pub fn forget_record(&mut self, kept: usize) {
        self.record.iter_mut().for_each(|record| record.truncate(kept));
    }
}

/// True if a tape reads accelerations or reactions.
fn reads_solved(program: &Program, tape: &Tape) -> bool {
    let layout = program.layout();
    let operands = tape.instructions().iter().flat_map(|instruction| instruction.operands());
    let mut registers = operands.chain(tape.results.iter().copied());
    registers.any(|register| (layout.accelerations()..layout.constants()).contains(&(register as usize)))
}

/// Moves a step on through everything that happens in it.
impl Instance {
    /// Sets the discrete variables to what they begin with in the state, which is consistent.
    pub(super) fn begin_discrete(&mut self, state: &mut State) -> Result<(), InstanceError> {
        let Some(instants) = &mut self.instants else { return Ok(()) };
        self.machine.load(&self.model, state);
        self.machine.evaluate(&self.model.program().instants.begin, &mut instants.begin);
        for (index, &value) in instants.begin.iter().enumerate() {
            if !value.is_finite() {
                let name = self.model.program().discrete[index].name.clone();
                return Err(InstanceError::Undefined { name, time: state.time() });
            }
            state.discrete_mut()[index] = value;
        }
        Ok(())
    }

    /// What happens at the start, when the run has begun.
    pub(super) fn begin_instants(&mut self) -> Result<(), InstanceError> {
        if self.instants.is_none() {
            return Ok(());
        }
        let start = self.time();
        self.now.happened = Happened::new(&self.model);
        if let Some(instants) = &mut self.instants {
            instants.forget(&self.now.happened);
        }
        self.begin_contacts()?;
        self.now.happened.ticked = start - 2.0 * shortest(start);
        if self.next_tick(self.now.happened.ticked)? <= start + shortest(start) {
            self.tick()?;
        }
        self.now.happened.ticked = start;
        self.happen(None)
    }

    /// Moves on to a later time through everything that happens on the way. On failure the instance stays as it was.
    pub(super) fn pass_instants(&mut self, time: f64, to_first: bool) -> Result<(), InstanceError> {
        let Some(mut instants) = self.instants.take() else { return self.advance(time) };
        self.save_into(&mut instants.before);
        instants.known.happened = false;
        instants.deadline = Deadline::after(self.model.program().experiment.budget);
        instants.target = time;
        instants.recorded = instants.record.as_ref().map_or(0, Vec::len);
        instants.done_before = self.stepper.statistics().work + instants.work(self.model.program());
        self.instants = Some(instants);
        let changed = self.now.run.is_changed();
        let done = match self.go_through(time, to_first, changed) {
            Err(failure) if failure.is_of_modes() => self.go_closer(failure, (time, to_first, changed)),
            done => done,
        };
        if let Some(instants) = &mut self.instants {
            (instants.limit, instants.target) = (f64::INFINITY, f64::NEG_INFINITY);
        }
        match done {
            Err(failure) if !failure.is_unfinished() && !failure.is_end() => {
                self.go_back();
                Err(failure)
            }
            done => {
                self.now.run.join(changed);
                done
            }
        }
    }

    /// To where the communication step under way began.
    fn go_back(&mut self) {
        if let Some(mut instants) = self.instants.take() {
            self.now.copy_from(&instants.before);
            let recorded = instants.recorded;
            instants.forget_record(recorded);
            self.instants = Some(instants);
        }
        self.forget_continuation();
    }

    /// Takes a communication step again in which modes change without end, or none fits, or a change has been missed: what decides between modes there, errors of the method, is smaller each time.
    ///
    /// # Errors
    /// The failure that the step ended with, where nothing helps.
    fn go_closer(
        &mut self,
        failure: InstanceError,
        (time, to_first, changed): (f64, bool, bool),
    ) -> Result<(), InstanceError> {
        let tolerance = self.now.tolerance;
        for share in RETRIES {
            self.go_back();
            self.now.tolerance = maximum(share * tolerance, CLOSEST);
            let done = self.go_through(time, to_first, changed);
            self.now.tolerance = tolerance;
            match done {
                Err(again) if again.is_of_modes() => {}
                done => return done,
            }
        }
        Err(failure)
    }

    fn go_through(&mut self, time: f64, to_first: bool, changed: bool) -> Result<(), InstanceError> {
        self.check_end()?;
        let each_ends = self.now.run.ends_at_communication_points();
        if changed {
            self.arm_until_now();
            self.happen(None)?;
        }
        loop {
            // Counted from what is done: an instant that is found within rounding errors of a tick must not leave it behind.
            let tick = self.next_tick(self.now.happened.ticked)?;
            let (target, ticks) = if is_later(tick, time) { (time, false) } else { (tick, true) };
            if let Some(instants) = &mut self.instants {
                instants.limit = if each_ends { target } else { tick };
                // A sample time that rounding errors have taken behind the stop is the stop, too.
                instants.target = maximum(time, target);
            }
            match self.first_event(target)? {
                Some((at, event)) => {
                    self.reach(at)?;
                    if !is_later(tick, at) {
                        // A step that is taken again up to here is so before anything changes.
                        self.go_on_anew();
                        self.tick()?;
                    }
                    self.happen(Some(event))?;
                }
                None => {
                    self.reach(target)?;
                    if !ticks {
                        return Ok(());
                    }
                    self.tick()?;
                    self.happen(None)?;
                }
            }
            self.check_end()?;
            // Each part has a measure of its own; together they may not do more than one step may.
            self.check_work([self.time(), time])?;
            self.end_at_stop(time);
            if to_first || self.time() >= time {
                return Ok(());
            }
        }
    }

    /// Between a sample time and the stop there may be rounding errors, too: no implicit step is so short.
    fn end_at_stop(&mut self, time: f64) {
        let is_stop = self.now.stop.is_some_and(|stop| !is_later(stop, time));
        if is_stop && self.is_stiff() && self.time() < time && !is_later(time, self.time()) {
            self.now.state.set_time(time);
            self.go_on_anew();
        }
    }

    /// The event that has ended the run, if one has: there is no step beyond the present time.
    pub fn ended(&self) -> Option<&str> {
        let event = self.now.happened.ended?;
        Some(&self.model.program().instants.events[event as usize].name)
    }

    /// Fails if an event has ended the run.
    fn check_end(&self) -> Result<(), InstanceError> {
        let Some(event) = self.ended() else { return Ok(()) };
        Err(InstanceError::Ended { event: event.to_owned(), time: self.time() })
    }

    /// Moves on to a time, unless it has been reached.
    fn reach(&mut self, time: f64) -> Result<(), InstanceError> {
        if time > self.time() { self.advance(time) } else { Ok(()) }
    }

    /// The next tick later than a time; infinite if there is none.
    fn next_tick(&mut self, after: f64) -> Result<f64, InstanceError> {
        let Some(instants) = &mut self.instants else { return Ok(f64::INFINITY) };
        let samplers = &self.model.program().instants.samplers;
        if samplers.is_empty() {
            return Ok(f64::INFINITY);
        }
        self.machine.load_constant(&self.model, &self.now.state);
        let tape = &self.model.program().instants.clocks;
        self.machine.run(tape);
        instants.clocks.clear();
        instants.tick = f64::INFINITY;
        for (index, sampler) in samplers.iter().enumerate() {
            let [period, offset] = [0, 1].map(|half| self.machine.result(tape, 2 * index + half));
            let clock = Clock { period, offset };
            if !clock.is_sound(after) {
                return Err(InstanceError::Period { sampler: sampler.name.clone(), period });
            }
            instants.tick = instants.tick.min(clock.after(after));
            instants.clocks.push(clock);
        }
        Ok(instants.tick)
    }

    /// When the next tick is, if there are any \[s\].
    pub(crate) fn next_event_time(&mut self) -> Result<Option<f64>, InstanceError> {
        let is_done = matches!(self.now.phase, Phase::Exchange | Phase::Running);
        let after = if is_done { self.now.happened.ticked } else { self.time() };
        Ok(Some(self.next_tick(after)?).filter(|tick| tick.is_finite()))
    }

    /// Writes the values whose samplers tick now.
    fn tick(&mut self) -> Result<(), InstanceError> {
        let (time, before) = (self.time(), self.state_to_record());
        self.evaluate_written()?;
        let model = self.model.clone();
        let Some(instants) = self.instants.take() else { return Ok(()) };
        let ticks = match before {
            Some(_) => (0..instants.clocks.len()).filter(|&sampler| instants.clocks[sampler].is_at(time)).collect(),
            None => Vec::new(),
        };
        let ticking =
            model.program().instants.samplers.iter().zip(&instants.clocks).filter(|(_, clock)| clock.is_at(time));
        let written =
            ticking.flat_map(|(sampler, _)| &sampler.writes).try_for_each(|write| self.write(&instants, *write));
        self.instants = Some(instants);
        written?;
        self.resolve_unfound()?;
        self.note(before, ticks, None);
        self.now.happened.ticked = time;
        self.go_on_anew();
        Ok(())
    }

    /// Everything that ticks and events could write now.
    fn evaluate_written(&mut self) -> Result<(), InstanceError> {
        let Some(mut instants) = self.instants.take() else { return Ok(()) };
        let evaluated =
            self.evaluate(&self.model.clone().program().instants.written, instants.write_solved, &mut instants.written);
        self.instants = Some(instants);
        evaluated
    }

    /// Results of a tape at the present state.
    fn evaluate(&mut self, tape: &Tape, solved: bool, results: &mut [f64]) -> Result<(), InstanceError> {
        if results.is_empty() {
            return Ok(());
        }
        if solved {
            self.accelerate()?;
        }
        self.load()?;
        self.machine.evaluate(tape, results);
        Ok(())
    }

    fn write(&mut self, instants: &Instants, write: Write) -> Result<(), InstanceError> {
        let (program, value) = (self.model.program(), instants.written[write.result as usize]);
        let (name, place) = match program.target(write) {
            Target::Discrete(place) => (&program.discrete[place].name, &mut self.now.state.discrete_mut()[place]),
            Target::State(state) => {
                let index = program.mechanical() + state;
                (&program.coordinates[index].name, &mut self.now.state.rates_mut()[index])
            }
        };
        if !value.is_finite() {
            return Err(InstanceError::Undefined { name: name.clone(), time: self.time() });
        }
        *place = value;
        Ok(())
    }

    /// The run begins anew at the present state, whose discrete variables or states have changed.
    fn go_on_anew(&mut self) {
        // Signals go on from this state: its inputs must be those of its time.
        self.catch_up();
        self.computed = Computed::default();
        if let Some(instants) = &mut self.instants {
            let known = &mut instants.known;
            (known.searched, known.end, known.happened) = (None, None, true);
        }
        if self.now.phase == Phase::Running {
            let settings = self.settings();
            let Snapshot { state, run, memory, .. } = &mut self.now;
            self.stepper.begin_anew(&self.model, &mut self.machine, (run, memory), state, &settings);
        }
    }
}
