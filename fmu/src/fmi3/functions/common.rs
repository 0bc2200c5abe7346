//! Functions of both interfaces: creation, initialization, events, the end.

use std::ffi::CStr;

use crate::fmi::boundary::{FloatEnvironment, Handle, array, contain, place, plain, string};
use crate::fmi::component::{Interface, Outcome, Refusal};
use crate::fmi::logging::{Category, LogSeverity, Logger};
use crate::fmi::resource;
use crate::fmi3::component::{Fmi3, Fmi3Component};
use crate::fmi3::logging;
use crate::fmi3::references::{References, Referent};
use crate::fmi3::types::*;
use crate::instance::{Handled, Instance, InstanceError};

/// Version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> fmi3String {
    c"3.0".as_ptr()
}

/// Switches log categories.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: fmi3Instance,
    loggingOn: fmi3Boolean,
    nCategories: usize,
    categories: *const fmi3String,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3SetDebugLogging", |component| {
        let names: Option<Vec<&CStr>> = array(categories, nCategories)?.iter().map(|&name| string(name)).collect();
        let names = names.ok_or("a log category is a null pointer")?;
        let chosen = Category::named(&names, logging::name).map_err(Refusal::new)?;
        if loggingOn != fmi3False && !chosen.is_empty() {
            // These and no others (2.3.1).
            component.logger.switch(false, &[]);
        }
        component.logger.switch(loggingOn != fmi3False, &chosen);
        Ok(())
    })
}

/// What an importer says of the FMU that it wants an instance of.
struct Wish {
    name: fmi3String,
    token: fmi3String,
    resources: fmi3String,
}

/// Makes an instance, or tells why not.
fn instantiate(logger: Logger, make: impl FnOnce(Logger) -> Result<Fmi3Component, (Logger, Refusal)>) -> fmi3Instance {
    let _environment = FloatEnvironment::enter();
    let made = contain(|| match make(logger) {
        Ok(component) => Some(component),
        Err((logger, refusal)) => {
            logger.log(LogSeverity::Error, Category::Errors, &refusal.reason);
            None
        }
    });
    match made.ok().flatten() {
        Some(component) => Handle::give(component),
        None => std::ptr::null_mut(),
    }
}

impl Wish {
    /// Loads the model.
    fn load(&self) -> Outcome<Box<Instance>> {
        let name = string(self.name).unwrap_or_default();
        if name.to_string_lossy().trim().is_empty() {
            return Err("the instance needs a name that is not blank".into());
        }
        let token = string(self.token).ok_or("the instantiation token is missing")?;
        let place = string(self.resources).map(CStr::to_bytes).filter(|place| !place.is_empty());
        let place = place.ok_or("the resource path is missing, but it contains the program of the FMU")?;
        let model = resource::load(resource::path(place.to_vec()).map_err(Refusal::new)?).map_err(Refusal::new)?;
        if token.to_bytes() != crate::fmi3::token(&model.program().guid).as_bytes() {
            return Err(
                "the instantiation token is not that of this FMU: modelDescription.xml and the program do not belong \
                        together"
                    .into(),
            );
        }
        Ok(Instance::boxed(model))
    }
}

/// An instance for Model Exchange.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    instanceName: fmi3String,
    instantiationToken: fmi3String,
    resourcePath: fmi3String,
    _visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: fmi3LogMessageCallback,
) -> fmi3Instance {
    let wish = Wish { name: instanceName, token: instantiationToken, resources: resourcePath };
    let logger = logging::logger(logMessage, instanceEnvironment, loggingOn != fmi3False);
    instantiate(logger, |logger| {
        let loaded = wish.load().and_then(|instance| match instance.model().program().offers_exchange_with_rates() {
            true => Ok(instance),
            false => Err(InstanceError::no_exchange(instance.model().program()).into()),
        });
        match loaded {
            Ok(instance) => Ok(Fmi3Component::new(logger, Interface::ModelExchange, Fmi3::new(&instance), instance)),
            Err(refusal) => Err((logger, refusal)),
        }
    })
}

/// An instance for Co-Simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instanceName: fmi3String,
    instantiationToken: fmi3String,
    resourcePath: fmi3String,
    _visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    eventModeUsed: fmi3Boolean,
    earlyReturnAllowed: fmi3Boolean,
    requiredIntermediateVariables: *const fmi3ValueReference,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: fmi3LogMessageCallback,
    intermediateUpdate: fmi3IntermediateUpdateCallback,
) -> fmi3Instance {
    let wish = Wish { name: instanceName, token: instantiationToken, resources: resourcePath };
    let logger = logging::logger(logMessage, instanceEnvironment, loggingOn != fmi3False);
    instantiate(logger, |logger| {
        let loaded = wish.load().and_then(|instance| {
            check_intermediate(&instance, array(requiredIntermediateVariables, nRequiredIntermediateVariables)?)?;
            Ok(instance)
        });
        let instance = match loaded {
            Ok(instance) => instance,
            Err(refusal) => return Err((logger, refusal)),
        };
        let version = Fmi3 {
            event_mode_used: eventModeUsed != fmi3False,
            early_return_allowed: earlyReturnAllowed != fmi3False,
            intermediate_update: intermediateUpdate,
            environment: instanceEnvironment,
            ..Fmi3::new(&instance)
        };
        Ok(Fmi3Component::new(logger, Interface::CoSimulation, version, instance))
    })
}

/// Intermediate values are those of calculated variables.
fn check_intermediate(instance: &Instance, references: &[u32]) -> Outcome {
    let known = References::of(instance.model().program());
    let calculated = |reference: u32| match known.find(reference) {
        Some(Referent::Variable(variable)) => instance.is_calculated(variable),
        _ => false,
    };
    match references.iter().find(|reference| !calculated(**reference)) {
        None => Ok(()),
        Some(reference) => {
            Err(Refusal::new(format!("there is no variable for intermediate updates with value reference {reference}")))
        }
    }
}

/// There is no Scheduled Execution.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _instanceName: fmi3String,
    _instantiationToken: fmi3String,
    _resourcePath: fmi3String,
    _visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: fmi3LogMessageCallback,
    _clockUpdate: fmi3ClockUpdateCallback,
    _lockPreemption: fmi3LockPreemptionCallback,
    _unlockPreemption: fmi3UnlockPreemptionCallback,
) -> fmi3Instance {
    let logger = logging::logger(logMessage, instanceEnvironment, loggingOn != fmi3False);
    instantiate(logger, |logger| Err((logger, "this FMU is not for Scheduled Execution".into())))
}

/// Frees an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: fmi3Instance) {
    Handle::<Fmi3>::free(instance);
}

/// Sets times and tolerance, and starts initialization mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: fmi3Instance,
    toleranceDefined: fmi3Boolean,
    tolerance: fmi3Float64,
    startTime: fmi3Float64,
    stopTimeDefined: fmi3Boolean,
    stopTime: fmi3Float64,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3EnterInitializationMode", |component| {
        let tolerance = (toleranceDefined != fmi3False).then_some(tolerance);
        component.enter_initialization(tolerance, startTime, (stopTimeDefined != fmi3False).then_some(stopTime))
    })
}

/// Solves for the initial state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: fmi3Instance) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3ExitInitializationMode", Fmi3Component::start)
}

/// To an event.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(instance: fmi3Instance) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3EnterEventMode", Fmi3Component::go_to_event_mode)
}

/// Closes the loops.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: fmi3Instance,
    discreteStatesNeedUpdate: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
    nominalsOfContinuousStatesChanged: *mut fmi3Boolean,
    valuesOfContinuousStatesChanged: *mut fmi3Boolean,
    nextEventTimeDefined: *mut fmi3Boolean,
    nextEventTime: *mut fmi3Float64,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3UpdateDiscreteStates", |component| {
        let (again, terminate) = (place(discreteStatesNeedUpdate)?, place(terminateSimulation)?);
        let (nominals, values) = (place(nominalsOfContinuousStatesChanged)?, place(valuesOfContinuousStatesChanged)?);
        let (defined, time) = (place(nextEventTimeDefined)?, place(nextEventTime)?);
        let handled = component.update_discrete_states();
        // Some importers look at the answer even where the call fails, and would ask again for ever.
        let (Handled { moved, next, ended }, failed) = match &handled {
            Ok(handled) => (*handled, false),
            Err(_) => (Handled::default(), true),
        };
        (*again, *nominals) = (fmi3False, fmi3False);
        (*terminate, *values) = ((failed || ended).into(), moved.into());
        (*defined, *time) = (next.is_some().into(), next.unwrap_or_default());
        handled.map(|_| ())
    })
}

/// Ends the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: fmi3Instance) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3Terminate", Fmi3Component::terminate)
}

/// Back to the state after instantiation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: fmi3Instance) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3Reset", Fmi3Component::reset)
}
