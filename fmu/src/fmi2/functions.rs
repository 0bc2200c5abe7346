//! What the importer calls. Pointers are checked here, and nothing else is done here; nothing unwinds into the importer.
//!
//! The caller's part of the contract, which cannot be checked, is the same for all functions: a component is one that
//! [`fmi2Instantiate`] returned and [`fmi2FreeInstance`] has not yet freed, used by one thread at a time; a state is one that this FMU handed
//! out; arrays are as long as announced; strings end with a zero byte.
#![allow(non_snake_case, non_upper_case_globals, reason = "the names of the standard")]
#![allow(clippy::missing_safety_doc, reason = "the contract is the standard's, in short at the head of this file")]

use std::cell::Cell;
use std::ffi::{CStr, CString};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::OnceLock;

use super::component::{Component, Interface, Refusal, SavedState};
use super::logging::{Category, Logger};
use super::resource;
use super::types::fmi2Status::{fmi2Discard, fmi2Error, fmi2OK};
use super::types::*;
use crate::instance::{Instance, InstanceError};

/// Runs a call on a component; refusals are logged.
fn call(component: fmi2Component, run: impl FnOnce(&mut Component) -> Result<fmi2Status, Refusal>) -> fmi2Status {
    let component = component.cast::<Component>();
    if component.is_null() {
        return fmi2Error;
    }
    // SAFETY: not null, so by the contract it came from `fmi2Instantiate`, is still alive and not in use by another thread.
    let component = unsafe { &mut *component };
    contain(|| match run(component) {
        Ok(status) => status,
        Err(refusal) => {
            component.refuse(&refusal);
            fmi2Error
        }
    })
    .unwrap_or_else(|| {
        component.logger.log(fmi2Error, Category::Errors, "internal error: please report it with this FMU");
        fmi2Error
    })
}

/// As [`call`], for calls that succeed or fail.
fn plain(component: fmi2Component, run: impl FnOnce(&mut Component) -> Result<(), Refusal>) -> fmi2Status {
    call(component, |component| run(component).map(|()| fmi2OK))
}

thread_local! {
    /// Is this thread inside a call?
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// What panics are told to outside of calls. It stays in the library's own memory, and a function that captures nothing needs none: unloading
/// the library loses nothing.
static PREVIOUS: OnceLock<Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>> = OnceLock::new();

/// Nothing here should panic; if something does all the same, it neither reaches the importer nor prints.
fn contain<T>(run: impl FnOnce() -> T) -> Option<T> {
    PREVIOUS.get_or_init(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(|info| {
            if !CONTAINED.get()
                && let Some(previous) = PREVIOUS.get()
            {
                previous(info);
            }
        }));
        previous
    });
    let before = CONTAINED.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(run)).ok();
    CONTAINED.set(before);
    result
}

/// An array argument. A null pointer is fine for no elements.
fn array<'a, T>(pointer: *const T, length: usize) -> Result<&'a [T], Refusal> {
    if length == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() || !pointer.is_aligned() || length.saturating_mul(size_of::<T>()) > isize::MAX as usize {
        return Err("an array is missing".into());
    }
    // SAFETY: neither null nor misaligned; by the contract it has this many elements and nobody writes to it during the call.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// An array to be filled. A null pointer is fine for no elements.
fn array_mut<'a, T>(pointer: *mut T, length: usize) -> Result<&'a mut [T], Refusal> {
    if length == 0 {
        return Ok(&mut []);
    }
    if pointer.is_null() || !pointer.is_aligned() || length.saturating_mul(size_of::<T>()) > isize::MAX as usize {
        return Err("an array is missing".into());
    }
    // SAFETY: neither null nor misaligned; by the contract it has this many elements and nobody else uses it during the call.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) })
}

/// A string argument.
fn string<'a>(pointer: fmi2String) -> Option<&'a CStr> {
    // SAFETY: not null; by the contract it ends with a zero byte and lives during the call.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// A place for one result.
fn place<'a, T>(pointer: *mut T) -> Result<&'a mut T, Refusal> {
    match array_mut(pointer, 1)? {
        [place] => Ok(place),
        _ => Err("a pointer is missing".into()),
    }
}

/// Platform of the types.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> fmi2String {
    c"default".as_ptr()
}

/// Version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> fmi2String {
    c"2.0".as_ptr()
}

/// Switches log categories.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: fmi2Component,
    loggingOn: fmi2Boolean,
    nCategories: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    plain(c, |component| {
        let names: Option<Vec<&CStr>> = array(categories, nCategories)?.iter().map(|&name| string(name)).collect();
        let names = names.ok_or("a log category is missing")?;
        component.logger.switch(loggingOn != fmi2False, &names).map_err(Refusal)
    })
}

/// Loads the model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instanceName: fmi2String,
    fmuType: fmi2Type,
    fmuGUID: fmi2String,
    fmuResourceLocation: fmi2String,
    functions: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    loggingOn: fmi2Boolean,
) -> fmi2Component {
    let made = contain(|| {
        let Ok([functions]) = array(functions, 1) else {
            return None;
        };
        let name = string(instanceName).unwrap_or_default();
        let (callback, environment) = (functions.logger, functions.componentEnvironment);
        let logger = Logger::new(callback, environment, CString::from(name), loggingOn != fmi2False);
        match instantiate(name, fmuType, string(fmuGUID), string(fmuResourceLocation)) {
            Ok((interface, instance)) => Some(Component::new(logger, interface, instance)),
            Err(refusal) => {
                logger.log(fmi2Error, Category::Errors, &refusal.0);
                None
            }
        }
    });
    match made.flatten() {
        Some(component) => Box::into_raw(Box::new(component)).cast(),
        None => std::ptr::null_mut(),
    }
}

fn instantiate(
    name: &CStr,
    kind: fmi2Type,
    guid: Option<&CStr>,
    location: Option<&CStr>,
) -> Result<(Interface, Instance), Refusal> {
    if name.is_empty() {
        return Err("the instance needs a name".into());
    }
    let interface = match kind {
        fmi2CoSimulation => Interface::CoSimulation,
        fmi2ModelExchange => Interface::ModelExchange,
        _ => return Err("the interface is neither Co-Simulation nor Model Exchange".into()),
    };
    let guid = guid.ok_or("the GUID is missing")?;
    let model = resource::load(location.unwrap_or_default()).map_err(Refusal)?;
    if guid.to_bytes() != model.program().guid.as_bytes() {
        return Err(
            "the GUID is not that of this FMU: modelDescription.xml and the program do not belong together".into()
        );
    }
    if interface == Interface::ModelExchange && !model.program().offers_exchange() {
        return Err(InstanceError::NoExchange.into());
    }
    Ok((interface, Instance::new(model)))
}

/// Frees an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
    if !c.is_null() {
        // SAFETY: by the contract it came from `Box::into_raw` in `fmi2Instantiate` and is not used again.
        let component = unsafe { Box::from_raw(c.cast::<Component>()) };
        contain(|| drop(component));
    }
}

/// Sets times and tolerance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: fmi2Component,
    toleranceDefined: fmi2Boolean,
    tolerance: fmi2Real,
    startTime: fmi2Real,
    stopTimeDefined: fmi2Boolean,
    stopTime: fmi2Real,
) -> fmi2Status {
    plain(c, |component| {
        let tolerance = (toleranceDefined != fmi2False).then_some(tolerance);
        let stop = (stopTimeDefined != fmi2False).then_some(stopTime);
        component.setup_experiment(tolerance, startTime, stop)
    })
}

/// Starts initialization mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status {
    plain(c, Component::enter_initialization)
}

/// Solves for the initial state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status {
    plain(c, Component::exit_initialization)
}

/// Ends the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: fmi2Component) -> fmi2Status {
    plain(c, Component::terminate)
}

/// Back to the state after instantiation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: fmi2Component) -> fmi2Status {
    plain(c, Component::reset)
}

/// Reads variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    plain(c, |component| component.get(array(vr, nvr)?, array_mut(value, nvr)?))
}

/// Sets parameters and inputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    plain(c, |component| component.set(array(vr, nvr)?, array(value, nvr)?))
}

/// There are only Real variables: any access of another type that is not empty is refused.
fn wrong_type(c: fmi2Component, nvr: usize, name: &str) -> fmi2Status {
    plain(c, |_| match nvr {
        0 => Ok(()),
        _ => Err(Refusal(format!("this FMU has no {name} variables: all its variables are Real"))),
    })
}

/// There is no Integer variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *mut fmi2Integer,
) -> fmi2Status {
    wrong_type(c, nvr, "Integer")
}

/// There is no Boolean variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *mut fmi2Boolean,
) -> fmi2Status {
    wrong_type(c, nvr, "Boolean")
}

/// There is no String variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *mut fmi2String,
) -> fmi2Status {
    wrong_type(c, nvr, "String")
}

/// There is no Integer variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *const fmi2Integer,
) -> fmi2Status {
    wrong_type(c, nvr, "Integer")
}

/// There is no Boolean variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *const fmi2Boolean,
) -> fmi2Status {
    wrong_type(c, nvr, "Boolean")
}

/// There is no String variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *const fmi2String,
) -> fmi2Status {
    wrong_type(c, nvr, "String")
}

/// Saves the state; into an existing one if there is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    plain(c, |component| {
        let place = place(FMUstate)?;
        let existing = place.cast::<SavedState>();
        if existing.is_null() {
            *place = Box::into_raw(Box::new(component.save())).cast();
        } else {
            // SAFETY: by the contract a state that is not null was handed out here and has not been freed.
            component.save_into(unsafe { &mut *existing });
        }
        Ok(())
    })
}

/// Goes back to a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status {
    plain(c, |component| {
        let [state] = array(FMUstate.cast::<SavedState>(), 1)? else {
            return Err("the state is missing".into());
        };
        component.restore(state)
    })
}

/// Frees a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    plain(c, |_| {
        if let Ok(place) = place(FMUstate)
            && !place.is_null()
        {
            // SAFETY: by the contract it came from `Box::into_raw` here; the importer's pointer to it is cleared.
            drop(unsafe { Box::from_raw(place.cast::<SavedState>()) });
            *place = std::ptr::null_mut();
        }
        Ok(())
    })
}

/// Size of a saved state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    plain(c, |_| {
        let [state] = array(FMUstate.cast::<SavedState>(), 1)? else {
            return Err("the state is missing".into());
        };
        *place(size)? = state.to_bytes()?.len();
        Ok(())
    })
}

/// A saved state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    serializedState: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    plain(c, |_| {
        let [state] = array(FMUstate.cast::<SavedState>(), 1)? else {
            return Err("the state is missing".into());
        };
        let bytes = state.to_bytes()?;
        let room = array_mut(serializedState.cast::<u8>(), size)?;
        let room = room.get_mut(..bytes.len()).ok_or("the buffer is too small for the state")?;
        room.copy_from_slice(&bytes);
        Ok(())
    })
}

/// A saved state from bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: fmi2Component,
    serializedState: *const fmi2Byte,
    size: usize,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    plain(c, |component| {
        let place = place(FMUstate)?;
        let state = component.deserialize(array(serializedState.cast::<u8>(), size)?)?;
        let existing = place.cast::<SavedState>();
        if existing.is_null() {
            *place = Box::into_raw(Box::new(state)).cast();
        } else {
            // SAFETY: by the contract a state that is not null was handed out here and has not been freed.
            unsafe { *existing = state };
        }
        Ok(())
    })
}

/// Derivatives of calculated variables by inputs, parameters and states, along a direction.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: fmi2Component,
    vUnknown_ref: *const fmi2ValueReference,
    nUnknown: usize,
    vKnown_ref: *const fmi2ValueReference,
    nKnown: usize,
    dvKnown: *const fmi2Real,
    dvUnknown: *mut fmi2Real,
) -> fmi2Status {
    plain(c, |component| {
        let (unknowns, derivatives) = (array(vUnknown_ref, nUnknown)?, array_mut(dvUnknown, nUnknown)?);
        component.directional_derivative(unknowns, derivatives, array(vKnown_ref, nKnown)?, array(dvKnown, nKnown)?)
    })
}

/// Sets the first and second derivatives of inputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *const fmi2Real,
) -> fmi2Status {
    plain(c, |component| component.set_derivatives(array(vr, nvr)?, array(order, nvr)?, array(value, nvr)?))
}

/// Derivatives of calculated variables by time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *mut fmi2Real,
) -> fmi2Status {
    plain(c, |component| component.output_derivatives(array(vr, nvr)?, array(order, nvr)?, array_mut(value, nvr)?))
}

/// Moves to the next communication point.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: fmi2Component,
    currentCommunicationPoint: fmi2Real,
    communicationStepSize: fmi2Real,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
) -> fmi2Status {
    plain(c, |component| component.do_step(currentCommunicationPoint, communicationStepSize))
}

/// Steps are never pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: fmi2Component) -> fmi2Status {
    plain(c, |_| Err("there is no step to cancel: steps are done when fmi2DoStep returns".into()))
}

/// Steps are never pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: fmi2Component, _s: fmi2StatusKind, _value: *mut fmi2Status) -> fmi2Status {
    call(c, |_| Ok(fmi2Discard))
}

/// The last communication point reached.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Real) -> fmi2Status {
    call(c, |component| match component.real_status(s) {
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
    call(c, |_| Ok(fmi2Discard))
}

/// The simulation never asks to be terminated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    call(c, |_| match s {
        fmi2Terminated => {
            *place(value)? = fmi2False;
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
    call(c, |_| Ok(fmi2Discard))
}

/// Sets the time of Model Exchange.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: fmi2Component, time: fmi2Real) -> fmi2Status {
    plain(c, |component| component.set_time(time))
}

/// Sets q and v.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(c: fmi2Component, x: *const fmi2Real, nx: usize) -> fmi2Status {
    plain(c, |component| component.set_states(array(x, nx)?))
}

/// From continuous-time mode to an event.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(c: fmi2Component) -> fmi2Status {
    plain(c, Component::enter_event_mode)
}

/// Closes the loops.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(c: fmi2Component, eventInfo: *mut fmi2EventInfo) -> fmi2Status {
    plain(c, |component| {
        let info = place(eventInfo)?;
        let moved = component.new_discrete_states()?;
        *info = fmi2EventInfo {
            newDiscreteStatesNeeded: fmi2False,
            terminateSimulation: fmi2False,
            nominalsOfContinuousStatesChanged: fmi2False,
            valuesOfContinuousStatesChanged: moved.into(),
            nextEventTimeDefined: fmi2False,
            nextEventTime: 0.0,
        };
        Ok(())
    })
}

/// From an event back to continuous-time mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: fmi2Component) -> fmi2Status {
    plain(c, Component::enter_continuous_time_mode)
}

/// Asks for an event when the loops have come apart.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: fmi2Component,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
    enterEventMode: *mut fmi2Boolean,
    terminateSimulation: *mut fmi2Boolean,
) -> fmi2Status {
    plain(c, |component| {
        let (enter, terminate) = (place(enterEventMode)?, place(terminateSimulation)?);
        *enter = component.completed_integrator_step()?.into();
        *terminate = fmi2False;
        Ok(())
    })
}

/// v and a.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(c: fmi2Component, derivatives: *mut fmi2Real, nx: usize) -> fmi2Status {
    plain(c, |component| component.state_derivatives(array_mut(derivatives, nx)?))
}

/// Values that change sign at events.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(
    c: fmi2Component,
    eventIndicators: *mut fmi2Real,
    ni: usize,
) -> fmi2Status {
    plain(c, |component| component.indicators(array_mut(eventIndicators, ni)?))
}

/// q and v.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(c: fmi2Component, x: *mut fmi2Real, nx: usize) -> fmi2Status {
    plain(c, |component| component.states(array_mut(x, nx)?))
}

/// Natural sizes of q and v.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    c: fmi2Component,
    x_nominal: *mut fmi2Real,
    nx: usize,
) -> fmi2Status {
    plain(c, |component| component.nominals(array_mut(x_nominal, nx)?))
}
