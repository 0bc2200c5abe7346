//! Runs on their way from one communication point to the next: one alone, or several side by side.

use std::io;

use cotree_fmu::instance::{Batch, Instance, InstanceError};

use super::{FailedRun, Finish, Logged, Run, RunError, knots};
use crate::model::Experiment;

/// A run on its way, beside the instance that moves.
pub(super) struct Journey<'a, R> {
    run: &'a Run<'a>,
    report: R,
    values: Vec<f64>,
    log: Vec<Logged>,
    /// Where it is to stop next.
    stop: Option<Stop>,
    /// The event that ends the run, and when.
    ended: Option<(String, f64)>,
    /// Did it go on before the last row of the inputs?
    reads_inputs: bool,
    error: Option<RunError>,
}

/// A time at which a run stops \[s\].
#[derive(Clone, Copy)]
enum Stop {
    /// A row of the inputs.
    Knot(f64),
    /// A communication point.
    Point(f64),
}

impl<'a, R: FnMut(f64, &[f64]) -> io::Result<()>> Journey<'a, R> {
    /// A run that has not begun.
    pub fn new(run: &'a Run<'a>, report: R) -> Self {
        let values = vec![0.0; run.reported.len()];
        Self { run, report, values, log: Vec::new(), stop: None, ended: None, reads_inputs: false, error: None }
    }

    fn goes_on(&self) -> bool {
        self.ended.is_none() && self.error.is_none()
    }

    /// Does something unless the run has failed, or fails with it.
    fn attempt(&mut self, action: impl FnOnce(&mut Self) -> Result<(), RunError>) {
        if self.error.is_none() {
            self.error = action(self).err();
        }
    }

    fn begin(&mut self, instance: &mut Instance) {
        self.attempt(|journey| journey.run.begin(instance));
        if self.error.is_none() {
            self.log.extend(Logged::taken(instance));
        }
    }

    /// Takes note of how the way to the present stop has ended, and of what is to be done there. Returns the time of the next stop that the instance must move to, or none at the end.
    fn go_on(
        &mut self,
        instance: &mut Instance,
        done: Result<(), InstanceError>,
        stops: &mut impl Iterator<Item = Stop>,
    ) -> Option<f64> {
        self.note(done);
        loop {
            match self.stop.take() {
                Some(Stop::Knot(time)) if self.reads_inputs => {
                    self.attempt(|journey| journey.run.set_inputs(instance, time));
                }
                Some(Stop::Point(time)) => {
                    self.attempt(|journey| journey.observe(instance, time));
                    if !self.goes_on() {
                        return None;
                    }
                }
                _ => {}
            }
            let stop = stops.next()?;
            self.stop = Some(stop);
            let (Stop::Knot(time) | Stop::Point(time)) = stop;
            self.reads_inputs = self.goes_on();
            if self.goes_on() && time > instance.time() {
                return Some(time);
            }
        }
    }

    /// Takes note of how a step has ended.
    fn note(&mut self, done: Result<(), InstanceError>) {
        match done {
            Err(InstanceError::Ended { event, time }) => self.ended = Some((event, time)),
            done => self.attempt(|_| Ok(done?)),
        }
    }

    /// Hands over the values at a communication point, or where the run has ended before it.
    fn observe(&mut self, instance: &mut Instance, time: f64) -> Result<(), RunError> {
        self.log.extend(Logged::taken(instance));
        let time = self.ended.as_ref().map_or(time, |(_, time)| *time);
        for (value, &variable) in self.values.iter_mut().zip(&self.run.reported) {
            *value = instance.reading(variable)?;
        }
        Ok((self.report)(time, &self.values)?)
    }

    /// How it has ended.
    pub fn end(self, instance: &mut Instance) -> Result<Finish, FailedRun> {
        let Self { mut log, ended, error, .. } = self;
        log.extend(Logged::taken(instance));
        match error {
            Some(error) => Err(FailedRun { error, log }),
            None => Ok(finish(instance, (log, ended))),
        }
    }
}

/// Takes a run through the communication points.
pub(super) fn travel<R: FnMut(f64, &[f64]) -> io::Result<()>>(
    journey: &mut Journey<R>,
    instance: &mut Instance,
    times: impl Iterator<Item = f64>,
) {
    journey.begin(instance);
    let (mut stops, mut done) = (stops(journey.run, times), Ok(()));
    while let Some(time) = journey.go_on(instance, done, &mut stops) {
        done = instance.step_to(time);
    }
}

/// Takes runs that differ in their settings only through the communication points, side by side if there is a batch.
pub(super) fn travel_all<R: FnMut(f64, &[f64]) -> io::Result<()>>(
    journeys: &mut [Journey<R>],
    instances: &mut [Instance],
    times: impl Iterator<Item = f64> + Clone,
    batch: Option<&mut Batch>,
) {
    let Some(batch) = batch else {
        let runs = journeys.iter_mut().zip(instances);
        return runs.for_each(|(journey, instance)| travel(journey, instance, times.clone()));
    };
    let mut instances: Vec<&mut Instance> = instances.iter_mut().collect();
    journeys.iter_mut().zip(&mut instances).for_each(|(journey, instance)| journey.begin(instance));
    let mut stops: Vec<_> = journeys.iter().map(|journey| stops(journey.run, times.clone())).collect();
    batch.travel(&mut instances, |index, instance, done| journeys[index].go_on(instance, done, &mut stops[index]));
}

/// The communication points, with the rows of the inputs before them.
fn stops(run: &Run, times: impl Iterator<Item = f64>) -> impl Iterator<Item = Stop> {
    let Experiment { start, stop, .. } = run.experiment;
    let knots = run.inputs.iter().flat_map(move |(table, _)| knots(table, [start, stop]));
    let (mut knots, mut times) = (knots.peekable(), times.peekable());
    std::iter::from_fn(move || {
        let time = *times.peek()?;
        match knots.next_if(|knot| *knot <= time) {
            Some(knot) => Some(Stop::Knot(knot)),
            None => times.next().map(Stop::Point),
        }
    })
}

fn finish(instance: &mut Instance, (log, ended): (Vec<Logged>, Option<(String, f64)>)) -> Finish {
    let events = instance.events().map(|(name, count)| (name.to_owned(), count)).collect();
    Finish { inaccuracy: instance.take_inaccuracy(), events, log, ended }
}
