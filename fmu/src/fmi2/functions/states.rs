//! Saved states.

use crate::fmi::boundary::plain;
use crate::fmi::states;
use crate::fmi2::component::Fmi2;
use crate::fmi2::types::*;

/// Saves the state; into an existing one if there is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    states::save::<Fmi2>(c, "fmi2GetFMUstate", FMUstate)
}

/// Goes back to a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2SetFMUstate", |component| states::restore(component, FMUstate))
}

/// Frees a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    states::free::<Fmi2>(c, "fmi2FreeFMUstate", FMUstate)
}

/// Size of a saved state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    states::size::<Fmi2>(c, "fmi2SerializedFMUstateSize", FMUstate, size)
}

/// A saved state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    serializedState: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    states::serialize::<Fmi2>(c, "fmi2SerializeFMUstate", FMUstate, serializedState.cast::<u8>(), size)
}

/// A saved state from bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: fmi2Component,
    serializedState: *const fmi2Byte,
    size: usize,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    states::deserialize::<Fmi2>(c, "fmi2DeSerializeFMUstate", serializedState.cast::<u8>(), size, FMUstate)
}
