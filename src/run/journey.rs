//! Runs on their way from one communication point to the next: one alone, or several side by side.

use std::io;

use cotree_fmu::instance::{Batch, Instance, InstanceError};

use super::{FailedRun, Finish, Logged, Run, RunError, knots};
use crate::model::Experiment;

/// A run on its way.
pub(super) struct Journey<'a, R> {
    run: &'a Run<'a>,
    instance: &'a mut Instance,
    report: R,
    values: Vec<f64>,
    log: Vec<Logged>,
    /// The event that ends the run, and when.
    ended: Option<(String, f64)>,
    /// Have the values there been handed over?
    is_over: bool,
    /// Did it go on before the last row of the inputs?
    reads_inputs: bool,
    error: Option<RunError>,
}

impl<'a, R: FnMut(f64, &[f64]) -> io::Result<()>> Journey<'a, R> {
    /// A run that has not begun.
    pub fn new(run: &'a Run<'a>, instance: &'a mut Instance, report: R) -> Self {
        let values = vec![0.0; run.reported.len()];
        Self {
            run,
            instance,
            report,
            values,
            log: Vec::new(),
            ended: None,
            is_over: false,
            reads_inputs: false,
            error: None,
        }
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

    fn begin(&mut self) -> Result<(), RunError> {
        self.run.begin(self.instance)?;
        self.log.extend(Logged::taken(self.instance));
        Ok(())
    }

    /// Must the instance still move to reach a time?
    fn is_before(&self, time: f64) -> bool {
        self.goes_on() && time > self.instance.time()
    }

    /// Takes note of how a step has ended.
    fn note(&mut self, done: Result<(), InstanceError>) {
        match done {
            Err(InstanceError::Ended { event, time }) => self.ended = Some((event, time)),
            done => self.attempt(|_| Ok(done?)),
        }
    }

    /// Hands over the values at a communication point, or where the run has ended before it.
    fn observe(&mut self, time: f64) -> Result<(), RunError> {
        self.log.extend(Logged::taken(self.instance));
        let time = self.ended.as_ref().map_or(time, |(_, time)| *time);
        for (value, &variable) in self.values.iter_mut().zip(&self.run.reported) {
            *value = self.instance.reading(variable)?;
        }
        self.is_over = self.ended.is_some();
        Ok((self.report)(time, &self.values)?)
    }

    /// How it has ended.
    pub fn end(self) -> Result<Finish, FailedRun> {
        let Self { instance, mut log, ended, error, .. } = self;
        log.extend(Logged::taken(instance));
        match error {
            Some(error) => Err(FailedRun { error, log }),
            None => Ok(finish(instance, (log, ended))),
        }
    }
}

/// Takes runs that differ in their settings only through the communication points, side by side if there is a batch.
pub(super) fn travel<R: FnMut(f64, &[f64]) -> io::Result<()>>(
    journeys: &mut [Journey<R>],
    times: impl IntoIterator<Item = f64>,
    mut batch: Option<&mut Batch>,
) {
    journeys.iter_mut().for_each(|journey| journey.attempt(Journey::begin));
    let Some(run) = journeys.first().map(|journey| journey.run) else { return };
    let Experiment { start, stop, .. } = run.experiment;
    let knots = run.inputs.iter().flat_map(|(table, _)| knots(table, [start, stop]));
    let mut knots = knots.peekable();
    for time in times {
        while let Some(knot) = knots.next_if(|knot| *knot <= time) {
            journeys.iter_mut().for_each(|journey| journey.reads_inputs = journey.goes_on());
            reach(journeys, knot, batch.as_deref_mut());
            for journey in journeys.iter_mut().filter(|journey| journey.reads_inputs) {
                journey.attempt(|journey| run.set_inputs(journey.instance, knot));
            }
        }
        reach(journeys, time, batch.as_deref_mut());
        for journey in journeys.iter_mut().filter(|journey| !journey.is_over) {
            journey.attempt(|journey| journey.observe(time));
        }
        if journeys.iter().all(|journey| !journey.goes_on()) {
            break;
        }
    }
}

/// Moves all that still go on to a time.
fn reach<R: FnMut(f64, &[f64]) -> io::Result<()>>(journeys: &mut [Journey<R>], time: f64, batch: Option<&mut Batch>) {
    let before = journeys.iter_mut().filter(|journey| journey.is_before(time));
    let Some(batch) = batch else {
        return before.for_each(|journey| {
            let done = journey.instance.step_to(time);
            journey.note(done);
        });
    };
    let mut members: Vec<&mut Journey<R>> = before.collect();
    let mut instances: Vec<&mut Instance> = members.iter_mut().map(|journey| &mut *journey.instance).collect();
    let done = batch.step_to(&mut instances, time);
    members.into_iter().zip(done).for_each(|(journey, done)| journey.note(done));
}

fn finish(instance: &mut Instance, (log, ended): (Vec<Logged>, Option<(String, f64)>)) -> Finish {
    let events = instance.events().map(|(name, count)| (name.to_owned(), count)).collect();
    Finish { inaccuracy: instance.take_inaccuracy(), events, log, ended }
}
