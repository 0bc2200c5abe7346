//! Reading and setting variables, and derivatives.

use crate::fmi::boundary::{array, array_mut, call, plain};
use crate::fmi::component::{Outcome, Refusal};
use crate::fmi3::component::Fmi3;
use crate::fmi3::types::*;

/// Every variable is a scalar: one value each.
fn check_count(values: usize, references: usize) -> Outcome {
    match values == references {
        true => Ok(()),
        false => Err(Refusal::new(format!("{values} values for {references} scalar variables"))),
    }
}

/// Reads variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *mut fmi3Float64,
    nValues: usize,
) -> fmi3Status {
    call::<Fmi3>(instance, "fmi3GetFloat64", |component| {
        check_count(nValues, nValueReferences)?;
        component.get(array(valueReferences, nValueReferences)?, array_mut(values, nValues)?)
    })
}

/// Sets parameters, inputs and initial values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *const fmi3Float64,
    nValues: usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3SetFloat64", |component| {
        check_count(nValues, nValueReferences)?;
        component.set(array(valueReferences, nValueReferences)?, array(values, nValues)?)
    })
}

/// Derivatives of calculated variables along a direction of what is known: time, inputs, parameters and states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    instance: fmi3Instance,
    unknowns: *const fmi3ValueReference,
    nUnknowns: usize,
    knowns: *const fmi3ValueReference,
    nKnowns: usize,
    seed: *const fmi3Float64,
    nSeed: usize,
    sensitivity: *mut fmi3Float64,
    nSensitivity: usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3GetDirectionalDerivative", |component| {
        check_count(nSeed, nKnowns)?;
        check_count(nSensitivity, nUnknowns)?;
        let (unknowns, knowns) = (array(unknowns, nUnknowns)?, array(knowns, nKnowns)?);
        component.directional_derivative(unknowns, array_mut(sensitivity, nSensitivity)?, knowns, array(seed, nSeed)?)
    })
}

/// Derivatives of a weighted sum of calculated variables by what is known.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetAdjointDerivative(
    instance: fmi3Instance,
    unknowns: *const fmi3ValueReference,
    nUnknowns: usize,
    knowns: *const fmi3ValueReference,
    nKnowns: usize,
    seed: *const fmi3Float64,
    nSeed: usize,
    sensitivity: *mut fmi3Float64,
    nSensitivity: usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3GetAdjointDerivative", |component| {
        check_count(nSeed, nUnknowns)?;
        check_count(nSensitivity, nKnowns)?;
        let (unknowns, knowns) = (array(unknowns, nUnknowns)?, array(knowns, nKnowns)?);
        component.adjoint_derivative(unknowns, knowns, array(seed, nSeed)?, array_mut(sensitivity, nSensitivity)?)
    })
}

/// Derivatives of calculated variables by time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetOutputDerivatives(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    orders: *const fmi3Int32,
    values: *mut fmi3Float64,
    nValues: usize,
) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3GetOutputDerivatives", |component| {
        check_count(nValues, nValueReferences)?;
        let (references, orders) = (array(valueReferences, nValueReferences)?, array(orders, nValueReferences)?);
        component.output_derivatives(references, orders, array_mut(values, nValues)?)
    })
}
