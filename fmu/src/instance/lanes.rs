//! Simulations of one model, several at a time in the lanes of one processor: the members of an ensemble.
//!
//! Each has its own parameters, times, step lengths and orders of events. Steps of the usual kind are found together; a step that must be shortened, a singular pose, a
//! change of inputs or a failure concerns its own member only. What a member does follows from its own state, so the results have the same bits whatever its
//! neighbours are and however many lanes there are.

use super::{Computed, Instance};
pub use crate::integrator::taylor::MOST_LANES;
use crate::integrator::taylor::{Each, Motions, Proposed};
use crate::integrator::together;
use crate::model::Model;

/// So many steps to one communication point; beyond, the run goes on alone, and finds out whether there are too many.
const MOST_STEPS: u32 = 1 << 20;

/// One of the simulations.
pub trait Member {
    /// It must have been initialised while there is a next communication point.
    fn instance(&mut self) -> &mut Instance;

    /// The next communication point; none at the end.
    fn next(&mut self) -> Option<f64>;

    /// Steps to the next communication point, and does what is to be done there.
    fn reach(&mut self);
}

/// Several simulations of one model at a time.
#[derive(Debug)]
pub struct Lanes {
    /// None if each goes alone.
    motions: Option<Motions>,
    width: usize,
}

/// A lane with its member.
struct Slot<M> {
    member: M,
    /// Does the series in the lane begin where the last step ends?
    begun: bool,
    /// Must the member take the next step by itself?
    declined: bool,
    /// Does it go to its next communication point by itself?
    alone: bool,
    /// Steps since the last communication point.
    steps: u32,
    proposed: Option<Proposed>,
}

/// One slot for each lane.
type Slots<M> = Each<Option<Slot<M>>>;

impl Lanes {
    /// For members with this tolerance, up to `width` at a time; 0 for each by itself, as a single simulation.
    pub fn new(model: &Model, tolerance: f64, width: usize) -> Self {
        let motions = if width == 0 { None } else { Motions::new(model, tolerance) };
        Self { motions, width: width.clamp(1, MOST_LANES) }
    }

    /// Are several motions of this model found together at all?
    pub fn has_lanes(&self) -> bool {
        self.motions.is_some()
    }

    /// Runs all members; `done` receives each at its end.
    pub fn run<M: Member>(&mut self, mut members: impl Iterator<Item = M>, mut done: impl FnMut(M)) {
        let tolerance = self.motions.as_ref().map(|motions| motions.tolerance());
        let mut slots: Slots<M> = [const { None }; MOST_LANES];
        loop {
            for place in slots.iter_mut().take(self.width) {
                loop {
                    if place.is_none() {
                        *place = members.next().map(Slot::new);
                    }
                    if place.as_mut().is_none_or(|slot| slot.accept(tolerance)) {
                        break;
                    }
                    if let Some(ended) = place.take() {
                        done(ended.member);
                    }
                }
            }
            let Some(motions) = self.motions.as_mut().filter(|_| slots.iter().any(Option::is_some)) else {
                return;
            };
            step(motions, &mut slots);
        }
    }
}

impl<M: Member> Slot<M> {
    fn new(member: M) -> Self {
        Self { member, begun: false, declined: false, alone: false, steps: 0, proposed: None }
    }

    /// Goes on by itself as far as it must. Says whether its next step may be found together with others; otherwise it has come to its end.
    fn accept(&mut self, tolerance: Option<f64>) -> bool {
        while let Some(target) = self.member.next() {
            let run = &self.member.instance().now.run;
            let together = tolerance.filter(|_| !self.alone && !run.is_changed() && self.steps < MOST_STEPS);
            let Some(tolerance) = together.filter(|_| run.step_end() < target) else {
                self.begun &= together.is_some();
                (self.alone, self.steps) = (false, 0);
                self.member.reach();
                continue;
            };
            let mut member = self.member.instance().member();
            if !self.declined && member.joins(tolerance) {
                return true;
            }
            self.alone = member.step_alone().is_err();
            (self.begun, self.declined) = (false, false);
            self.steps += 1;
        }
        false
    }

    /// Its series begins where its last step ends, if there is one.
    fn begin(&mut self, motions: &Motions, place: usize) {
        if !self.begun {
            self.begun = self.member.instance().member().begins(motions, place);
        }
    }

    /// Accepts the proposed step, or leaves the lane.
    fn conclude(&mut self, motions: &Motions, place: usize) {
        let mut member = self.member.instance().member();
        let done = self.proposed.map_or(Ok(false), |step| member.conclude(motions, place, &step));
        self.alone = done.is_err();
        self.begun = done.is_ok_and(|accepted| accepted);
        self.declined = !self.begun;
        self.steps += 1;
    }
}

/// One step of all lanes.
fn step<M: Member>(motions: &mut Motions, slots: &mut Slots<M>) {
    if slots.iter().flatten().any(|slot| !slot.begun) {
        enter(motions, slots);
    }
    motions.expand();
    let lengths = motions.lengths();
    let mut h = [0.0; MOST_LANES];
    for (place, slot) in taken(slots) {
        let mut member = slot.member.instance().member();
        slot.proposed = if slot.begun { member.propose(motions, place, lengths[place]) } else { None };
        if let Some(step) = &slot.proposed {
            h[place] = step.h;
            member.signal(motions, place, Some(step.end));
        }
    }
    motions.go(&h);
    for (place, slot) in taken(slots) {
        slot.conclude(motions, place);
    }
    motions.roll();
}

/// Begins the series of those that are new in their lanes.
fn enter<M: Member>(motions: &mut Motions, slots: &mut Slots<M>) {
    let mut first = None;
    for (place, slot) in taken(slots) {
        let mut member = slot.member.instance().member();
        if !slot.begun {
            member.enter(motions, place);
        }
        member.signal(motions, place, None);
        first = first.or(Some(place));
    }
    for place in 0..MOST_LANES {
        if let (None, Some(first)) = (&slots[place], first) {
            motions.follow(place, first);
        }
    }
    motions.begin();
    for (place, slot) in taken(slots) {
        slot.begin(motions, place);
    }
}

/// The lanes that have a member.
fn taken<M>(slots: &mut Slots<M>) -> impl Iterator<Item = (usize, &mut Slot<M>)> {
    slots.iter_mut().enumerate().filter_map(|(place, slot)| Some((place, slot.as_mut()?)))
}

impl Instance {
    /// Its run, as one of several.
    fn member(&mut self) -> together::Member<'_> {
        // The registers are not those of the present state any more.
        self.computed = Computed { state: self.computed.state, ..Computed::default() };
        let settings = self.settings();
        let Self { model, machine, stepper, now, .. } = self;
        together::Member { model, machine, stepper, run: &mut now.run, memory: &mut now.memory, settings }
    }
}
