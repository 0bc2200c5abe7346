//! Reading and setting variables, and derivatives.

use crate::fmi::boundary::{array, array_mut, call, plain};
use crate::fmi::component::Refusal;
use crate::fmi2::component::Fmi2;
use crate::fmi2::types::*;

/// Reads variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    call::<Fmi2>(c, "fmi2GetReal", |component| component.get(array(vr, nvr)?, array_mut(value, nvr)?))
}

/// Sets parameters and inputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2SetReal", |component| component.set(array(vr, nvr)?, array(value, nvr)?))
}

/// There are only Real variables: any access of another type that is not empty is refused.
fn wrong_type(c: fmi2Component, call: &'static str, nvr: usize, name: &str) -> fmi2Status {
    plain::<Fmi2>(c, call, |_| match nvr {
        0 => Ok(()),
        _ => Err(Refusal::new(format!("this FMU has no {name} variables: all its variables are Real"))),
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
    wrong_type(c, "fmi2GetInteger", nvr, "Integer")
}

/// There is no Boolean variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *mut fmi2Boolean,
) -> fmi2Status {
    wrong_type(c, "fmi2GetBoolean", nvr, "Boolean")
}

/// There is no String variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *mut fmi2String,
) -> fmi2Status {
    wrong_type(c, "fmi2GetString", nvr, "String")
}

/// There is no Integer variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *const fmi2Integer,
) -> fmi2Status {
    wrong_type(c, "fmi2SetInteger", nvr, "Integer")
}

/// There is no Boolean variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *const fmi2Boolean,
) -> fmi2Status {
    wrong_type(c, "fmi2SetBoolean", nvr, "Boolean")
}

/// There is no String variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *const fmi2String,
) -> fmi2Status {
    wrong_type(c, "fmi2SetString", nvr, "String")
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
    plain::<Fmi2>(c, "fmi2GetDirectionalDerivative", |component| {
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
    plain::<Fmi2>(c, "fmi2SetRealInputDerivatives", |component| {
        component.set_derivatives(array(vr, nvr)?, array(order, nvr)?, array(value, nvr)?)
    })
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
    plain::<Fmi2>(c, "fmi2GetRealOutputDerivatives", |component| {
        component.output_derivatives(array(vr, nvr)?, array(order, nvr)?, array_mut(value, nvr)?)
    })
}
