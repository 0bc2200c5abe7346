//! Simulations of one model side by side: the series of their steps are found together, which takes about as long as those of one or two of them. Each keeps its own steps
//! and its own end, and has the bits that it has alone.

use std::sync::Arc;

use super::{Instance, InstanceError};
use crate::context::Settings;
use crate::failure::Failure;
use crate::integrator::stiffness::Advance;
use crate::model::Model;
use crate::taylor::{self, Jet, MEMBERS};

/// What simulations of one model share.
#[derive(Debug)]
pub struct Batch {
    model: Arc<Model>,
    series: Box<taylor::Batch>,
    /// Series that have been found together with others.
    found: u64,
}

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
        Some(Self { model: Arc::clone(model), series: Box::new(series), found: 0 })
    }

    /// How many series have been found together with others.
    pub fn found(&self) -> u64 {
        self.found
    }

    /// Moves instances on to a later time, as [`Instance::step_to`] does each of them. The first [`Batch::MEMBERS`] take their steps together if they are of the model.
    pub fn step_to(&mut self, members: &mut [&mut Instance], time: f64) -> Vec<Result<(), InstanceError>> {
        let mut journeys: Vec<_> = members.iter_mut().map(|member| Journey::new(member, time)).collect();
        while self.find_series(members, &journeys) {
            for (member, journey) in members.iter_mut().zip(&mut journeys) {
                if let Ok(Some(journey)) = journey {
                    journey.take_one(member);
                }
            }
        }
        let arrived = |(member, journey): (&mut &mut Instance, Result<Option<Journey>, InstanceError>)| match journey? {
            Some(journey) => journey.arrive(member),
            None => Ok(()),
        };
        members.iter_mut().zip(journeys).map(arrived).collect()
    }

    /// Finds the series of the next steps, if there are at least two. False if no member takes a step.
    fn find_series(
        &mut self,
        members: &mut [&mut Instance],
        journeys: &[Result<Option<Journey>, InstanceError>],
    ) -> bool {
        let (mut taken, mut highest, mut goes_on) = ([false; MEMBERS], 0, false);
        for (index, (member, journey)) in members.iter_mut().zip(journeys).enumerate() {
            let Ok(Some(journey)) = journey else { continue };
            if !journey.goes_on(member) {
                continue;
            }
            goes_on = true;
            let may_join = index < MEMBERS && Arc::ptr_eq(&member.model, &self.model);
            if let Some((jet, order)) = journey.begun(member).filter(|_| may_join) {
                taken[index] = self.series.take(index, jet);
                highest = highest.max(if taken[index] { order } else { 0 });
            }
        }
        if taken.iter().filter(|taken| **taken).count() > 1 {
            self.series.expand(highest);
            let members = members.iter_mut().zip(journeys).enumerate().zip(taken);
            for ((index, (member, journey)), _) in members.filter(|(_, taken)| *taken) {
                if let Ok(Some(journey)) = journey
                    && let Some((jet, _)) = journey.begun(member)
                {
                    self.series.give(index, jet, highest);
                    self.found += 1;
                }
            }
        }
        goes_on
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

    /// The series that the next step begins with, and its order, if it takes one.
    fn begun<'a>(&self, member: &'a mut Instance) -> Option<(&'a mut Jet, usize)> {
        let Instance { stepper, now, .. } = member;
        stepper.begun(&now.run, &now.memory, &self.settings)
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

    fn arrive(self, member: &mut Instance) -> Result<(), InstanceError> {
        let Instance { model, machine, stepper, now, .. } = &mut *member;
        let (run, advanced) = ((&mut now.run, &mut now.memory), self.failure.map_or(Ok(()), Err));
        let done = stepper.arrive(model, machine, &mut now.state, run, &self.settings, (self.target, advanced));
        member.note_advance(self.from, done)
    }
}
