//! Model Exchange.

use crate::fmi::boundary::{array, array_mut, place, plain};
use crate::fmi2::component::{Fmi2, Fmi2Component};
use crate::fmi2::types::*;
use crate::instance::Handled;

/// Sets the time of Model Exchange.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: fmi2Component, time: fmi2Real) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2SetTime", |component| component.set_time(time))
}

/// Sets q and v.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(c: fmi2Component, x: *const fmi2Real, nx: usize) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2SetContinuousStates", |component| component.set_states(array(x, nx)?))
}

/// From continuous-time mode to an event.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(c: fmi2Component) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2EnterEventMode", Fmi2Component::enter_event_mode)
}

/// Closes the loops.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(c: fmi2Component, eventInfo: *mut fmi2EventInfo) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2NewDiscreteStates", |component| {
        let info = place(eventInfo)?;
        let handled = component.new_discrete_states();
        // Some importers look at the answer even where the call fails, and would ask again for ever.
        let (Handled { moved, next, ended }, failed) = match &handled {
            Ok(handled) => (*handled, false),
            Err(_) => (Handled::default(), true),
        };
        *info = fmi2EventInfo {
            newDiscreteStatesNeeded: fmi2False,
            terminateSimulation: (failed || ended).into(),
            nominalsOfContinuousStatesChanged: fmi2False,
            valuesOfContinuousStatesChanged: moved.into(),
            nextEventTimeDefined: next.is_some().into(),
            nextEventTime: next.unwrap_or_default(),
        };
        handled.map(|_| ())
    })
}

/// From an event back to continuous-time mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: fmi2Component) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2EnterContinuousTimeMode", Fmi2Component::enter_continuous_time_mode)
}

/// Asks for an event when the loops have come apart.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: fmi2Component,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
    enterEventMode: *mut fmi2Boolean,
    terminateSimulation: *mut fmi2Boolean,
) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2CompletedIntegratorStep", |component| {
        let (enter, terminate) = (place(enterEventMode)?, place(terminateSimulation)?);
        *enter = component.completed_integrator_step()?.into();
        *terminate = fmi2False;
        Ok(())
    })
}

/// v and a.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(c: fmi2Component, derivatives: *mut fmi2Real, nx: usize) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2GetDerivatives", |component| component.state_derivatives(array_mut(derivatives, nx)?))
}

/// Values that change sign at events.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(
    c: fmi2Component,
    eventIndicators: *mut fmi2Real,
    ni: usize,
) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2GetEventIndicators", |component| component.indicators(array_mut(eventIndicators, ni)?))
}

/// q and v.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(c: fmi2Component, x: *mut fmi2Real, nx: usize) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2GetContinuousStates", |component| component.states(array_mut(x, nx)?))
}

/// Natural sizes of q and v.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    c: fmi2Component,
    x_nominal: *mut fmi2Real,
    nx: usize,
) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2GetNominalsOfContinuousStates", |component| component.nominals(array_mut(x_nominal, nx)?))
}
