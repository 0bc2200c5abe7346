//! The runtime for browsers: one simulation behind a dozen functions that a script can call.
//!
//! A script passes numbers and addresses in the module's memory, which it allocates here. A function that can fail returns 0 if it did
//! not; the message of the last failure is at [`cotree_error`].

#![deny(unsafe_op_in_unsafe_fn)]

use std::cell::RefCell;
use std::fmt::Display;
use std::sync::Arc;

use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Program;

thread_local! {
    static MESSAGE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// 0, or 1 and the message is kept.
fn code<T, E: Display>(result: Result<T, E>) -> i32 {
    match result {
        Ok(_) => 0,
        Err(error) => {
            MESSAGE.with_borrow_mut(|message| *message = error.to_string());
            1
        }
    }
}

/// Room for so many bytes, at a multiple of eight; to be returned to [`cotree_free`] with the same length.
#[unsafe(no_mangle)]
pub extern "C" fn cotree_alloc(length: usize) -> *mut u8 {
    Box::into_raw(vec![0_u64; length.div_ceil(8)].into_boxed_slice()).cast()
}

/// Gives room back.
///
/// # Safety
/// `at` comes from [`cotree_alloc`] with this length and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_free(at: *mut u8, length: usize) {
    let room = std::ptr::slice_from_raw_parts_mut(at.cast::<u64>(), length.div_ceil(8));
    // SAFETY: this is the box that `cotree_alloc` gave away.
    drop(unsafe { Box::from_raw(room) });
}

/// A simulation of the program in these bytes, or null.
///
/// # Safety
/// `at` points to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_load(at: *const u8, length: usize) -> *mut Instance {
    // SAFETY: the caller says so.
    let bytes = unsafe { std::slice::from_raw_parts(at, length) };
    let program = Program::from_bytes(bytes).map_err(|error| error.to_string());
    let model = program.and_then(|program| Model::new(program).map_err(|error| error.to_string()));
    match model {
        Ok(model) => Box::into_raw(Box::new(Instance::new(Arc::new(model)))),
        Err(message) => {
            code::<(), _>(Err(message));
            std::ptr::null_mut()
        }
    }
}

/// Ends a simulation.
///
/// # Safety
/// `instance` comes from [`cotree_load`] and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_unload(instance: *mut Instance) {
    // SAFETY: this is the box that `cotree_load` gave away.
    drop(unsafe { Box::from_raw(instance) });
}

/// Start time, stop time, tolerance.
///
/// # Safety
/// `instance` comes from [`cotree_load`], and nobody else uses it now.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_setup(instance: *mut Instance, start: f64, stop: f64, tolerance: f64) -> i32 {
    // SAFETY: the caller says so.
    code(unsafe { &mut *instance }.setup(start, Some(stop), Some(tolerance)))
}

/// Sets a parameter, an initial value or an input, by the place of its variable.
///
/// # Safety
/// As for [`cotree_setup`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_set(instance: *mut Instance, variable: usize, value: f64) -> i32 {
    // SAFETY: the caller says so.
    code(unsafe { &mut *instance }.set(variable, value))
}

/// Solves for the initial state.
///
/// # Safety
/// As for [`cotree_setup`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_init(instance: *mut Instance) -> i32 {
    // SAFETY: the caller says so.
    code(unsafe { &mut *instance }.initialise())
}

/// Back to the values of the program, as if just loaded.
///
/// # Safety
/// As for [`cotree_setup`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_reset(instance: *mut Instance) {
    // SAFETY: the caller says so.
    unsafe { &mut *instance }.reset();
}

/// Moves on to a later time.
///
/// # Safety
/// As for [`cotree_setup`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_step(instance: *mut Instance, time: f64) -> i32 {
    // SAFETY: the caller says so.
    code(unsafe { &mut *instance }.step_to(time))
}

/// Whether rounding errors are larger than the tolerance, said once a run: 1 if they are, and the message is kept as that of a failure.
///
/// # Safety
/// As for [`cotree_setup`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_inaccurate(instance: *mut Instance) -> i32 {
    // SAFETY: the caller says so.
    let found = unsafe { &mut *instance }.take_inaccuracy();
    code(found.map_or(Ok(()), |found| Err(format!("{found}; {}", found.help()))))
}

/// The present values of so many variables, by their places.
///
/// # Safety
/// As for [`cotree_setup`]; `variables` points to `count` places and `values` to room for as many numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_record(
    instance: *mut Instance,
    variables: *const u32,
    count: usize,
    values: *mut f64,
) -> i32 {
    // SAFETY: the caller says so, and `cotree_alloc` aligns.
    let (instance, variables, values) = unsafe {
        let variables = std::slice::from_raw_parts(variables, count);
        (&mut *instance, variables, std::slice::from_raw_parts_mut(values, count))
    };
    code(variables.iter().zip(values).try_for_each(|(&variable, value)| {
        *value = instance.reading(variable as usize)?;
        Ok::<(), cotree_fmu::instance::InstanceError>(())
    }))
}

/// The message of the last failure, UTF-8; valid until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn cotree_error() -> *const u8 {
    MESSAGE.with_borrow(|message| message.as_ptr())
}

/// Its length in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn cotree_error_length() -> usize {
    MESSAGE.with_borrow(String::len)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_that_are_no_program_are_refused_with_a_message() {
        let length = 24;
        let at = cotree_alloc(length);
        // SAFETY: `at` is room for so many bytes, all zero.
        let instance = unsafe { cotree_load(at, length) };
        assert!(instance.is_null());
        // SAFETY: the message lives until the next call.
        let message = unsafe { std::slice::from_raw_parts(cotree_error(), cotree_error_length()) };
        assert!(!message.is_empty());
        // SAFETY: it is not used any more.
        unsafe { cotree_free(at, length) };
    }
}
