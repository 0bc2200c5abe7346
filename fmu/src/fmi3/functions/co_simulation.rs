//! Co-Simulation.

use std::cell::Cell;

use crate::fmi::boundary::{fast_path, place, plain};
use crate::fmi::component::Outcome;
use crate::fmi3::component::{Fmi3, Fmi3Component, Progress, StepEnd};
use crate::fmi3::types::fmi3Status::fmi3OK;
use crate::fmi3::types::*;

/// Where the results of a step go.
#[derive(Clone, Copy)]
struct Results {
    event: *mut fmi3Boolean,
    terminate: *mut fmi3Boolean,
    early: *mut fmi3Boolean,
    time: *mut fmi3Float64,
}

impl Results {
    fn write(self, end: StepEnd) -> Outcome {
        *place(self.event)? = end.event.into();
        *place(self.terminate)? = end.ended.into();
        *place(self.early)? = end.early.into();
        *place(self.time)? = end.time;
        Ok(())
    }
}

/// Moves to the next communication point, or less far.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: fmi3Instance,
    currentCommunicationPoint: fmi3Float64,
    communicationStepSize: fmi3Float64,
    _noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
    eventHandlingNeeded: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
    earlyReturn: *mut fmi3Boolean,
    lastSuccessfulTime: *mut fmi3Float64,
) -> fmi3Status {
    let results = Results {
        event: eventHandlingNeeded,
        terminate: terminateSimulation,
        early: earlyReturn,
        time: lastSuccessfulTime,
    };
    if fast_path::<Fmi3>(instance, |component| {
        let end = StepEnd { event: false, early: false, ended: false, time: component.instance.time() };
        results.write(end).is_ok()
            && component.is_undivided()
            && component.interpolate(currentCommunicationPoint, communicationStepSize)
            && results.write(StepEnd { time: component.instance.time(), ..end }).is_ok()
    }) {
        return fmi3OK;
    }
    step(instance, results, |component| component.begin_step(currentCommunicationPoint, communicationStepSize))
}

/// Runs a step. Between its parts the importer may call back, so that no part may hold the instance.
fn step(
    instance: fmi3Instance,
    results: Results,
    begin: impl FnOnce(&mut Fmi3Component) -> Outcome<Progress>,
) -> fmi3Status {
    let underway = Cell::new(None);
    let note = |component: &mut Fmi3Component, done: Outcome<Progress>| {
        let time = component.instance.time();
        let progress = match done {
            Ok(progress) => progress,
            Err(refusal) => {
                results.write(StepEnd { event: false, early: false, ended: false, time })?;
                return Err(refusal);
            }
        };
        match progress {
            Progress::Done(end) => results.write(end),
            Progress::Underway { can_return } => {
                underway.set(Some((component.version.callback(), time, can_return)));
                Ok(())
            }
        }
    };
    let mut status = plain::<Fmi3>(instance, "fmi3DoStep", |component| {
        let done = begin(component);
        note(component, done)
    });
    while let Some((callback, time, can_return)) = underway.take() {
        let wish = callback.ask(time, can_return);
        status = plain::<Fmi3>(instance, "fmi3DoStep", |component| {
            let done = component.continue_step(wish);
            note(component, done)
        });
    }
    status
}

/// From an event to stepping.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterStepMode(instance: fmi3Instance) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3EnterStepMode", Fmi3Component::enter_step_mode)
}
