//! Saved states.

use crate::fmi::boundary::plain;
use crate::fmi::states;
use crate::fmi3::component::Fmi3;
use crate::fmi3::types::*;

/// Saves the state; into an existing one if there is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: fmi3Instance, FMUState: *mut fmi3FMUState) -> fmi3Status {
    states::save::<Fmi3>(instance, "fmi3GetFMUState", FMUState)
}

/// Goes back to a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: fmi3Instance, FMUState: fmi3FMUState) -> fmi3Status {
    plain::<Fmi3>(instance, "fmi3SetFMUState", |component| component.restore_state(FMUState))
}

/// Frees a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: fmi3Instance, FMUState: *mut fmi3FMUState) -> fmi3Status {
    states::free::<Fmi3>(instance, "fmi3FreeFMUState", FMUState)
}

/// Size of a saved state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    size: *mut usize,
) -> fmi3Status {
    states::size::<Fmi3>(instance, "fmi3SerializedFMUStateSize", FMUState, size)
}

/// A saved state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    serializedState: *mut fmi3Byte,
    size: usize,
) -> fmi3Status {
    states::serialize::<Fmi3>(instance, "fmi3SerializeFMUState", FMUState, serializedState, size)
}

/// A saved state from bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: fmi3Instance,
    serializedState: *const fmi3Byte,
    size: usize,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    states::deserialize::<Fmi3>(instance, "fmi3DeserializeFMUState", serializedState, size, FMUState)
}
