//! Co-Simulation.

use crate::fmi::boundary::{call, fast_path, place, plain};
use crate::fmi2::component::Fmi2;
use crate::fmi2::types::fmi2Status::{fmi2Discard, fmi2OK};
use crate::fmi2::types::*;

/// Moves to the next communication point.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: fmi2Component,
    currentCommunicationPoint: fmi2Real,
    communicationStepSize: fmi2Real,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
) -> fmi2Status {
    if fast_path::<Fmi2>(c, |component| component.interpolate(currentCommunicationPoint, communicationStepSize)) {
        return fmi2OK;
    }
    plain::<Fmi2>(c, "fmi2DoStep", |component| component.do_step(currentCommunicationPoint, communicationStepSize))
}

/// Steps are never pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: fmi2Component) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2CancelStep", |_| {
        Err("there is no step to cancel: steps are done when fmi2DoStep returns".into())
    })
}

/// Steps are never pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: fmi2Component, _s: fmi2StatusKind, _value: *mut fmi2Status) -> fmi2Status {
    call::<Fmi2>(c, "fmi2GetStatus", |_| Ok(fmi2Discard))
}

/// The last communication point reached.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Real) -> fmi2Status {
    call::<Fmi2>(c, "fmi2GetRealStatus", |component| match component.real_status(s) {
        Some(time) => {
            *place(value)? = time;
            Ok(fmi2OK)
        }
        None => Ok(fmi2Discard),
    })
}

/// There is no such status.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    c: fmi2Component,
    _s: fmi2StatusKind,
    _value: *mut fmi2Integer,
) -> fmi2Status {
    call::<Fmi2>(c, "fmi2GetIntegerStatus", |_| Ok(fmi2Discard))
}

/// An event of the scene can end the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    call::<Fmi2>(c, "fmi2GetBooleanStatus", |component| match s {
        fmi2Terminated => {
            *place(value)? = component.instance.is_ended().into();
            Ok(fmi2OK)
        }
        _ => Ok(fmi2Discard),
    })
}

/// There is no such status.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    c: fmi2Component,
    _s: fmi2StatusKind,
    _value: *mut fmi2String,
) -> fmi2Status {
    call::<Fmi2>(c, "fmi2GetStringStatus", |_| Ok(fmi2Discard))
}
