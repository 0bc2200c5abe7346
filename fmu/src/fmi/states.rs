//! Saved states, as pointers and as bytes.

use core::ffi::c_void;

use super::boundary::{array, array_mut, place, plain};
use super::component::{FmiComponent, Mode, Outcome, SavedState, Version};

/// Saves the state; into an existing one if there is one.
pub(crate) fn save<V: Version>(c: *mut c_void, call: &'static str, state: *mut *mut c_void) -> V::Status {
    plain::<V>(c, call, |component| {
        if component.mode == Mode::Intermediate {
            return component.allow(&[]);
        }
        let place = place(state)?;
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

fn saved<'a>(state: *mut c_void) -> Outcome<&'a SavedState> {
    match array(state.cast::<SavedState>(), 1)? {
        [state] => Ok(state),
        _ => Err("the state is missing".into()),
    }
}

/// Goes back to a saved state.
pub(crate) fn restore<V: Version>(component: &mut FmiComponent<V>, state: *mut c_void) -> Outcome {
    component.restore(saved(state)?)
}

/// Frees a saved state.
pub(crate) fn free<V: Version>(c: *mut c_void, call: &'static str, state: *mut *mut c_void) -> V::Status {
    plain::<V>(c, call, |_| {
        if let Ok(place) = place(state)
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
pub(crate) fn size<V: Version>(c: *mut c_void, call: &'static str, state: *mut c_void, size: *mut usize) -> V::Status {
    plain::<V>(c, call, |_| {
        *place(size)? = saved(state)?.to_bytes()?.len();
        Ok(())
    })
}

/// A saved state as bytes.
pub(crate) fn serialize<V: Version>(
    c: *mut c_void,
    call: &'static str,
    state: *mut c_void,
    buffer: *mut u8,
    size: usize,
) -> V::Status {
    plain::<V>(c, call, |_| {
        let bytes = saved(state)?.to_bytes()?;
        let room = array_mut(buffer, size)?;
        let room = room.get_mut(..bytes.len()).ok_or("the buffer is too small for the state")?;
        room.copy_from_slice(&bytes);
        Ok(())
    })
}

/// A saved state from bytes.
pub(crate) fn deserialize<V: Version>(
    c: *mut c_void,
    call: &'static str,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> V::Status {
    plain::<V>(c, call, |component| {
        let place = place(state)?;
        let state = component.deserialize(array(bytes, size)?)?;
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
