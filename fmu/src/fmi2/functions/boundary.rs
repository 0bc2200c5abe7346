//! Between C and Rust: pointers are checked, and nothing unwinds into the importer.

use std::cell::{Cell, UnsafeCell};
use std::ffi::CStr;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use super::environment::FloatEnvironment;
use crate::fmi2::component::{Component, Refusal};
use crate::fmi2::logging::Category;
use crate::fmi2::types::fmi2Status::{fmi2Error, fmi2OK};
use crate::fmi2::types::*;

/// Runs what can neither panic nor fail; false without a component.
pub(super) fn quick(component: fmi2Component, run: impl FnOnce(&mut Component) -> bool) -> bool {
    let _environment = FloatEnvironment::enter();
    with(component, run).unwrap_or(false)
}

/// Runs a call on a component; refusals are logged.
pub(super) fn call(
    component: fmi2Component,
    run: impl FnOnce(&mut Component) -> Result<fmi2Status, Refusal>,
) -> fmi2Status {
    let _environment = FloatEnvironment::enter();
    let done = with(component, |component| {
        contain(|| match run(component) {
            Ok(status) => status,
            Err(refusal) => {
                component.refuse(&refusal);
                refusal.status()
            }
        })
        .unwrap_or_else(|| {
            component.logger.log(fmi2Error, Category::Errors, "internal error: please report it with this FMU");
            fmi2Error
        })
    });
    done.unwrap_or(fmi2Error)
}

/// What the importer's pointer points to.
pub(super) struct Handle {
    /// Is a call under way?
    busy: AtomicBool,
    component: UnsafeCell<Component>,
}

impl Handle {
    pub(super) fn new(component: Component) -> Self {
        Self { busy: AtomicBool::new(false), component: UnsafeCell::new(component) }
    }
}

/// Lends the component to one call; nothing without a component, or while another call is under way: from another thread, or from the importer's
/// own logger.
fn with<T>(component: fmi2Component, run: impl FnOnce(&mut Component) -> T) -> Option<T> {
    // SAFETY: by the contract it is null, or came from `fmi2Instantiate` and is still alive.
    let handle = unsafe { component.cast::<Handle>().as_ref() }?;
    if handle.busy.swap(true, Ordering::Acquire) {
        return None;
    }
    // SAFETY: only who has found it idle comes here, and nobody else before it is idle again.
    let result = run(unsafe { &mut *handle.component.get() });
    handle.busy.store(false, Ordering::Release);
    Some(result)
}

/// As [`call`], for calls that succeed or fail.
pub(super) fn plain(component: fmi2Component, run: impl FnOnce(&mut Component) -> Result<(), Refusal>) -> fmi2Status {
    call(component, |component| run(component).map(|()| fmi2OK))
}

thread_local! {
    /// Is this thread inside a call?
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// What panics are told to outside of calls. It stays in the library's own memory, and a function that captures nothing needs none: unloading
/// the library loses nothing.
static PREVIOUS: OnceLock<Hook> = OnceLock::new();
type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>;

/// Nothing here should panic; if something does all the same, it neither reaches the importer nor prints.
pub(super) fn contain<T>(run: impl FnOnce() -> T) -> Option<T> {
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
pub(super) fn array<'a, T>(pointer: *const T, length: usize) -> Result<&'a [T], Refusal> {
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
pub(super) fn array_mut<'a, T>(pointer: *mut T, length: usize) -> Result<&'a mut [T], Refusal> {
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
pub(super) fn string<'a>(pointer: fmi2String) -> Option<&'a CStr> {
    // SAFETY: not null; by the contract it ends with a zero byte and lives during the call.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// A place for one result.
pub(super) fn place<'a, T>(pointer: *mut T) -> Result<&'a mut T, Refusal> {
    match array_mut(pointer, 1)? {
        [place] => Ok(place),
        _ => Err("a pointer is missing".into()),
    }
}
