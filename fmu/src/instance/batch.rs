//! Simulations of one model side by side: the series of their steps are found together, which takes about as long as those of one or two of them. Each keeps its own steps
//! and its own end, and has the bits that it has alone.

use std::sync::Arc;

use super::{Instance, InstanceError};
use crate::context::Settings;
use crate::failure::Failure;
use crate::integrator::stiffness::Advance;
use crate::linalg::quad::Quad;
use crate::model::Model;
use crate::taylor::{self, Jet, MEMBERS};

/// What simulations of one model share.
#[derive(Debug)]
pub struct Batch {
    model: Arc<Model>,
    series: Box<taylor::Batch>,
    /// Series that have been found together with others, and those that have been begun together with others.
    found: u64,
    begun: u64,
}

/// How the way to a communication point has ended.
pub type Done = Result<(), InstanceError>;

/// Steps of one of them to a communication point.
struct Journey {
    from: f64,
    target: f64,
    settings: Settings,
    advance: Advance,
    failure: Option<Failure>,
}

impl Batch {
    /// The largest number of simulations that take their steps together.
    pub const MEMBERS: usize = MEMBERS;

    /// Storage, if motions of the model can take their steps together: there must be series without switches, and neither time events nor state events.
    pub fn new(model: &Arc<Model>) -> Option<Self> {
        let program = model.program();
        let is_smooth = program.instants.is_empty() && program.discrete.is_empty();
        let series = taylor::Batch::new(model).filter(|_| is_smooth && model.coordinates() > 0)?;
        Some(Self { model: Arc::clone(model), series: Box::new(series), found: 0, begun: 0 })
    }

    /// How many series have been found together with others.
    pub fn found(&self) -> u64 {
        self.found
    }

    /// How many series have been begun together with others, before the instances asked for them.
    pub fn begun(&self) -> u64 {
        self.begun
    }

    /// Moves instances on from one communication point to the next, each through its own ones, as [`Instance::step_to`] does. `next` is told how the way to the last point has ended, at first
    /// that of none, and gives the time of the next one, or none at the end. The first [`Batch::MEMBERS`] take their steps together if they are of the model.
    pub fn travel(
        &mut self,
        members: &mut [&mut Instance],
        mut next: impl FnMut(usize, &mut Instance, Done) -> Option<f64>,
    ) {
        let starts = members.iter_mut().enumerate().map(|(index, member)| set_out((index, member), Ok(()), &mut next));
        let mut journeys: Vec<Option<Journey>> = starts.collect();
        while journeys.iter().any(Option::is_some) {
            self.find_series(members, &journeys);
            for (index, (member, place)) in members.iter_mut().zip(&mut journeys).enumerate() {
                let Some(mut journey) = place.take() else { continue };
                journey.take_one(member);
                *place = if journey.goes_on(member) {
                    Some(journey)
                } else {
                    let done = journey.arrive(member);
                    set_out((index, member), done, &mut next)
                };
            }
        }
    }

    /// Finds the series of the next steps, if there are at least two.
    fn find_series(&mut self, members: &mut [&mut Instance], journeys: &[Option<Journey>]) {
        let mut orders = [0; MEMBERS];
        for (index, (member, journey)) in members.iter_mut().zip(journeys).enumerate().take(MEMBERS) {
            if let Some(journey) = journey.as_ref().filter(|_| Arc::ptr_eq(&member.model, &self.model))
                && let Some((jet, order, tolerance)) = journey.begun(member)
                && self.series.take(index, jet, tolerance)
            {
                orders[index] = order;
            }
        }
        if orders.iter().filter(|order| **order > 0).count() < 2 {
            return;
        }
        let highest = orders.into_iter().max().unwrap_or(0);
        self.series.expand(highest);
        for (index, (member, _)) in members.iter_mut().zip(orders).enumerate().filter(|(_, (_, order))| *order > 0) {
            if let Some(jet) = member.stepper.jet() {
                self.series.give(index, jet, highest);
                self.found += 1;
            }
        }
        if self.series.begins() {
            self.begin_next(members, journeys, orders.map(|order| order == highest));
        }
    }

    /// Begins the series at the ends of the steps that these members are about to take.
    fn begin_next(&mut self, members: &mut [&mut Instance], journeys: &[Option<Journey>], mut takes: [bool; MEMBERS]) {
        let (mut ends, mut lengths) = ([[f64::NAN; 2]; MEMBERS], [0.0; MEMBERS]);
        for (index, (member, journey)) in members.iter_mut().zip(journeys).enumerate().take(MEMBERS) {
            let foreseen = journey.as_ref().filter(|_| takes[index]).and_then(|journey| journey.foresee(member));
            takes[index] = foreseen.is_some();
            let Some([end, length]) = foreseen else { continue };
            (ends[index], lengths[index]) = ([end, length], length);
            if self.series.has_signals() {
                let Instance { model, machine, now, .. } = &mut **member;
                machine.load_signals(model, &now.run.signals.origin, end);
                self.series.set_signals(index, model, machine.registers());
            }
        }
        if takes.iter().filter(|takes| **takes).count() < 2 {
            return;
        }
        let open = self.series.begin(Quad::of(lengths), &mut takes);
        for (index, (member, _)) in members.iter_mut().zip(takes).enumerate().filter(|(_, (_, takes))| *takes) {
            if let Some(jet) = member.stepper.jet() {
                self.series.give_beginning(index, jet, ends[index], open);
                self.begun += 1;
            }
        }
    }
}

/// The way of a member to the next of its communication points that the last step does not reach; `done` is how the way to the last one has ended.
fn set_out(
    (index, member): (usize, &mut Instance),
    mut done: Done,
    next: &mut impl FnMut(usize, &mut Instance, Done) -> Option<f64>,
) -> Option<Journey> {
    loop {
        let target = next(index, member, done)?;
        done = match Journey::new(member, target) {
            Ok(Some(journey)) => return Some(journey),
            Ok(None) => Ok(()),
            Err(error) => Err(error),
        };
    }
}

impl Journey {
    /// The steps to a time; none if the last step reaches so far.
    fn new(member: &mut Instance, target: f64) -> Result<Option<Self>, InstanceError> {
        member.check_step(target)?;
        let from = member.time();
        if member.follow_last_step(target) {
            return Ok(None);
        }
        let settings = member.settings_of_step();
        let Instance { model, machine, stepper, now, .. } = &mut *member;
        let begun = stepper.set_out(model, machine, &now.state, (&mut now.run, &mut now.memory), target, &settings);
        match begun {
            Ok(advance) => Ok(Some(Self { from, target, settings, advance, failure: None })),
            Err(failure) => member.note_advance(from, Err(failure)).map(|()| None),
        }
    }

    /// True if another step is to be taken.
    fn goes_on(&self, member: &Instance) -> bool {
        self.failure.is_none() && member.now.run.last.end_time < self.target
    }

    /// The series that the next step begins with, its order and its tolerance, if it takes one.
    fn begun<'a>(&self, member: &'a mut Instance) -> Option<(&'a mut Jet, usize, f64)> {
        let Instance { stepper, now, .. } = member;
        stepper.begun(&now.run, &now.memory, &self.settings)
    }

    /// The end of the next step, and its length, as far as they can be told.
    fn foresee(&self, member: &mut Instance) -> Option<[f64; 2]> {
        let Instance { stepper, now, .. } = member;
        stepper.foresee(&now.run, &self.settings)
    }

    fn take_one(&mut self, member: &mut Instance) {
        if self.goes_on(member) {
            let Instance { model, machine, stepper, now, .. } = member;
            let run = (&mut now.run, &mut now.memory);
            if let Err(failure) = stepper.take_one(model, machine, run, &self.settings, &mut self.advance) {
                self.failure = Some(failure);
            }
        }
    }

    fn arrive(self, member: &mut Instance) -> Done {
        let Instance { model, machine, stepper, now, .. } = &mut *member;
        let (run, advanced) = ((&mut now.run, &mut now.memory), self.failure.map_or(Ok(()), Err));
        let done = stepper.arrive(model, machine, &mut now.state, run, &self.settings, (self.target, advanced));
        member.note_advance(self.from, done)
    }
}
