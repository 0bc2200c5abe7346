//! Between C and Rust: pointers are checked, and nothing unwinds into the importer.

use std::cell::UnsafeCell;
use std::ffi::CStr;
use std::sync::atomic::{AtomicBool, Ordering};

use core::ffi::{c_char, c_void};

use super::component::{FmiComponent, Outcome, Refusal, Version};
pub(crate) use super::environment::FloatEnvironment;
use super::logging::{Category, LogSeverity};
pub(crate) use crate::contain::contain;

/// Runs what can neither panic nor fail; false without a component.
pub(crate) fn fast_path<V: Version>(component: *mut c_void, run: impl FnOnce(&mut FmiComponent<V>) -> bool) -> bool {
    let _environment = FloatEnvironment::enter();
    with(component, run).unwrap_or(false)
}

/// Runs a call on a component; refusals are logged.
pub(crate) fn call<V: Version>(
    component: *mut c_void,
    name: &'static str,
    run: impl FnOnce(&mut FmiComponent<V>) -> Outcome<V::Status>,
) -> V::Status {
    let _environment = FloatEnvironment::enter();
    let done = with(component, |component: &mut FmiComponent<V>| {
        component.call = name;
        contain(|| run(component).unwrap_or_else(|refusal| V::refuse(component, &refusal))).unwrap_or_else(|panic| {
            let message = format!("internal error: {panic}; please report it with this FMU");
            component.logger.log(LogSeverity::Error, Category::Errors, &message);
            V::ERROR
        })
    });
    done.unwrap_or(V::ERROR)
}

/// What the importer's pointer points to.
pub(crate) struct Handle<V> {
    /// Is a call under way?
    busy: AtomicBool,
    component: UnsafeCell<FmiComponent<V>>,
}

impl<V: Version> Handle<V> {
    /// Hands a component over to the importer.
    pub(crate) fn give(component: FmiComponent<V>) -> *mut c_void {
        let handle = Self { busy: AtomicBool::new(false), component: UnsafeCell::new(component) };
        Box::into_raw(Box::new(handle)).cast()
    }

    /// Frees a component that [`Handle::give`] handed over; null is ignored.
    pub(crate) fn free(component: *mut c_void) {
        if !component.is_null() {
            let _environment = FloatEnvironment::enter();
            // SAFETY: by the contract it came from `Box::into_raw` in `give` and is not used again.
            let handle = unsafe { Box::from_raw(component.cast::<Self>()) };
            let _ = contain(|| drop(handle)); // nobody is left to tell
        }
    }
}

/// Lends the component to one call; nothing without a component, or while another call is under way: from another thread, or from the importer's
/// own logger.
fn with<V: Version, T>(component: *mut c_void, run: impl FnOnce(&mut FmiComponent<V>) -> T) -> Option<T> {
    // SAFETY: by the contract it is null, or came from an instantiation of this version and is still alive.
    let handle = unsafe { component.cast::<Handle<V>>().as_ref() }?;
    if handle.busy.swap(true, Ordering::Acquire) {
        return None;
    }
    // SAFETY: only who has found it idle comes here, and nobody else before it is idle again.
    let result = run(unsafe { &mut *handle.component.get() });
    handle.busy.store(false, Ordering::Release);
    Some(result)
}

/// As [`call`], for calls that succeed or fail.
pub(crate) fn plain<V: Version>(
    component: *mut c_void,
    name: &'static str,
    run: impl FnOnce(&mut FmiComponent<V>) -> Outcome,
) -> V::Status {
    call(component, name, |component| run(component).map(|()| V::OK))
}

/// An array argument. A null pointer is fine for no elements.
pub(crate) fn array<'a, T>(pointer: *const T, length: usize) -> Result<&'a [T], Refusal> {
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
pub(crate) fn array_mut<'a, T>(pointer: *mut T, length: usize) -> Result<&'a mut [T], Refusal> {
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
pub(crate) fn string<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not null; by the contract it ends with a zero byte and lives during the call.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// A place for one result.
pub(crate) fn place<'a, T>(pointer: *mut T) -> Result<&'a mut T, Refusal> {
    match array_mut(pointer, 1)? {
        [place] => Ok(place),
        _ => Err("a pointer is missing".into()),
    }
}
