//! Functions of both interfaces: creation, initialization, the end.

use std::ffi::{CStr, CString};

use crate::fmi::boundary::{FloatEnvironment, Handle, array, contain, plain, string};
use crate::fmi::component::{Interface, Refusal};
use crate::fmi::logging::{Category, LogSeverity};
use crate::fmi2::component::{Fmi2, Fmi2Component};
use crate::fmi2::types::*;
use crate::fmi2::{logging, resource};
use crate::instance::{Instance, InstanceError};

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
    plain::<Fmi2>(c, "fmi2SetDebugLogging", |component| {
        let names: Option<Vec<&CStr>> = array(categories, nCategories)?.iter().map(|&name| string(name)).collect();
        let names = names.ok_or("a log category is a null pointer")?;
        let categories = Category::named(&names, logging::name).map_err(Refusal::new)?;
        component.logger.switch(loggingOn != fmi2False, &categories);
        Ok(())
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
    let _environment = FloatEnvironment::enter();
    let made = contain(|| {
        let Ok([functions]) = array(functions, 1) else {
            return None;
        };
        let name = string(instanceName).unwrap_or_default();
        let (callback, environment) = (functions.logger, functions.componentEnvironment);
        let logger = logging::logger(callback, environment, CString::from(name), loggingOn != fmi2False);
        match instantiate(name, fmuType, string(fmuGUID), string(fmuResourceLocation)) {
            Ok((interface, instance)) => Some(Fmi2Component::new(logger, interface, Fmi2, instance)),
            Err(refusal) => {
                logger.log(LogSeverity::Error, Category::Errors, &refusal.reason);
                None
            }
        }
    });
    match made.ok().flatten() {
        Some(component) => Handle::give(component),
        None => std::ptr::null_mut(),
    }
}

fn instantiate(
    name: &CStr,
    kind: fmi2Type,
    guid: Option<&CStr>,
    location: Option<&CStr>,
) -> Result<(Interface, Box<Instance>), Refusal> {
    if name.to_string_lossy().trim().is_empty() {
        return Err("the instance needs a name that is not blank".into());
    }
    let interface = match kind {
        fmi2CoSimulation => Interface::CoSimulation,
        fmi2ModelExchange => Interface::ModelExchange,
        _ => return Err("the interface is neither Co-Simulation nor Model Exchange".into()),
    };
    let guid = guid.ok_or("the GUID is missing")?;
    let folder = resource::folder(location.unwrap_or_default().to_bytes()).map_err(Refusal::new)?;
    let model = crate::fmi::resource::load(folder).map_err(Refusal::new)?;
    if guid.to_bytes() != model.program().guid.as_bytes() {
        return Err(
            "the GUID is not that of this FMU: modelDescription.xml and the program do not belong together".into()
        );
    }
    if interface == Interface::ModelExchange && !model.program().offers_exchange() {
        return Err(InstanceError::no_exchange(model.program()).into());
    }
    Ok((interface, Instance::boxed(model)))
}

/// Frees an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
    Handle::<Fmi2>::free(c);
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
    plain::<Fmi2>(c, "fmi2SetupExperiment", |component| {
        let tolerance = (toleranceDefined != fmi2False).then_some(tolerance);
        let stop = (stopTimeDefined != fmi2False).then_some(stopTime);
        component.setup_experiment(tolerance, startTime, stop)
    })
}

/// Starts initialization mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2EnterInitializationMode", Fmi2Component::enter_initialization)
}

/// Solves for the initial state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2ExitInitializationMode", Fmi2Component::exit_initialization)
}

/// Ends the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: fmi2Component) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2Terminate", Fmi2Component::terminate)
}

/// Back to the state after instantiation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: fmi2Component) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2Reset", Fmi2Component::reset)
}
