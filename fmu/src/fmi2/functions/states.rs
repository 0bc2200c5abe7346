//! Saved states.

use crate::fmi::boundary::{array, array_mut, place, plain};
use crate::fmi::component::SavedState;
use crate::fmi2::component::Fmi2;
use crate::fmi2::types::*;

/// Saves the state; into an existing one if there is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2GetFMUstate", |component| {
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
    plain::<Fmi2>(c, "fmi2SetFMUstate", |component| {
        let [state] = array(FMUstate.cast::<SavedState>(), 1)? else {
            return Err("the state is missing".into());
        };
        component.restore(state)
    })
}

/// Frees a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    plain::<Fmi2>(c, "fmi2FreeFMUstate", |_| {
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
    plain::<Fmi2>(c, "fmi2SerializedFMUstateSize", |_| {
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
    plain::<Fmi2>(c, "fmi2SerializeFMUstate", |_| {
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
    plain::<Fmi2>(c, "fmi2DeSerializeFMUstate", |component| {
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
