//! Model Exchange.

use crate::fmi::boundary::{array, array_mut, place, plain};
use crate::fmi3::component::{Fmi3, Fmi3Component};
use crate::fmi3::types::*;

/// Sets the time of Model Exchange.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetTime(instance: fmi3Instance, time: fmi3Float64) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3SetTime", |component| component.move_time(time))
}

/// Sets q and v.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetContinuousStates(
    instance: fmi3Instance,
    continuousStates: *const fmi3Float64,
    nContinuousStates: usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3SetContinuousStates", |component| {
        component.set_states(array(continuousStates, nContinuousStates)?)
    })
}

/// From an event back to continuous-time mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterContinuousTimeMode(instance: fmi3Instance) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3EnterContinuousTimeMode", Fmi3Component::enter_continuous_time_mode)
}

/// Asks for an event when the loops have come apart.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3CompletedIntegratorStep(
    instance: fmi3Instance,
    _noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
    enterEventMode: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3CompletedIntegratorStep", |component| {
        let (enter, terminate) = (place(enterEventMode)?, place(terminateSimulation)?);
        (*enter, *terminate) = (fmi3False, fmi3False);
        *enter = component.completed_integrator_step()?.into();
        Ok(())
    })
}

/// v and a.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStateDerivatives(
    instance: fmi3Instance,
    derivatives: *mut fmi3Float64,
    nContinuousStates: usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3GetContinuousStateDerivatives", |component| {
        component.state_derivatives(array_mut(derivatives, nContinuousStates)?)
    })
}

/// Values that change sign at events.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetEventIndicators(
    instance: fmi3Instance,
    eventIndicators: *mut fmi3Float64,
    nEventIndicators: usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3GetEventIndicators", |component| {
        component.indicators(array_mut(eventIndicators, nEventIndicators)?)
    })
}

/// q and v.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStates(
    instance: fmi3Instance,
    continuousStates: *mut fmi3Float64,
    nContinuousStates: usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3GetContinuousStates", |component| {
        component.states(array_mut(continuousStates, nContinuousStates)?)
    })
}

/// Natural sizes of q and v.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNominalsOfContinuousStates(
    instance: fmi3Instance,
    nominals: *mut fmi3Float64,
    nContinuousStates: usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3GetNominalsOfContinuousStates", |component| {
        component.nominals(array_mut(nominals, nContinuousStates)?)
    })
}

/// How many event indicators there are.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfEventIndicators(
    instance: fmi3Instance,
    nEventIndicators: *mut usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3GetNumberOfEventIndicators", |component| {
        *place(nEventIndicators)? = component.numbers()?.1;
        Ok(())
    })
}

/// How many states there are.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfContinuousStates(
    instance: fmi3Instance,
    nContinuousStates: *mut usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3GetNumberOfContinuousStates", |component| {
        *place(nContinuousStates)? = component.numbers()?.0;
        Ok(())
    })
}
