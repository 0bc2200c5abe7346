//! The runtime for browsers: one simulation, and bodies that are pulled, behind functions that a script can call.
//!
//! A script passes numbers and addresses in the module's memory, which it allocates here. A function that can fail returns 0 if it did
//! not; the message of the last failure is at [`cotree_error`].

#![deny(unsafe_op_in_unsafe_fn)]

/// What holds a pulled body, in `cotree-page` for the pages that this machine serves.
#[path = "../../../crates/page/src/pull/mod.rs"]
mod pull;

use std::cell::RefCell;
use std::fmt::Display;
use std::sync::Arc;

use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Program;
use pull::Grip;

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

/// A body that is held in the pose of these coordinates, with the time, parameters and inputs that are set; or null. What is released are parameters and inputs, each
/// followed by 1 if it is an angle; `body` are the places of its x, y and angle.
///
/// # Safety
/// As for [`cotree_setup`]; the addresses lead to as many numbers as are counted: twice `released`, and three of the body.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_grip(
    instance: *mut Instance,
    positions: *const f64,
    count: usize,
    released: *const u32,
    releases: usize,
    body: *const u32,
) -> *mut Grip {
    // SAFETY: the caller says so, and `cotree_alloc` aligns.
    let (instance, positions, released, body) = unsafe {
        let positions = std::slice::from_raw_parts(positions, count);
        let released = std::slice::from_raw_parts(released, 2 * releases);
        (&mut *instance, positions, released, std::slice::from_raw_parts(body, 3))
    };
    let (pairs, _) = released.as_chunks::<2>();
    let released: Vec<(usize, bool)> = pairs.iter().map(|&[place, angle]| (place as usize, angle == 1)).collect();
    let body = [body[0] as usize, body[1] as usize, body[2] as usize];
    match Grip::new(Arc::clone(instance.model()), instance.state(), positions, &released, body) {
        Ok(grip) => Box::into_raw(Box::new(grip)),
        Err(message) => {
            code::<(), _>(Err(message));
            std::ptr::null_mut()
        }
    }
}

/// Pulls a point of the body, in the body's axes, to a place. 0: it is there, or as near as its path comes; 1: it is on its way; 2: at a dead point; 3: where branches
/// of the motion meet; 4: nothing moves the point; 5: nothing
/// moves at all.
///
/// # Safety
/// `grip` comes from [`cotree_grip`], and nobody else uses it now.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_pull(grip: *mut Grip, x: f64, y: f64, to_x: f64, to_y: f64) -> i32 {
    // SAFETY: the caller says so.
    unsafe { &mut *grip }.pull([x, y], [to_x, to_y]) as i32
}

/// Another time for the pose that is held.
///
/// # Safety
/// As for [`cotree_pull`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_pull_time(grip: *mut Grip, time: f64) {
    // SAFETY: the caller says so.
    unsafe { &mut *grip }.set_time(time);
}

/// The values of so many variables in the pose that is held.
///
/// # Safety
/// As for [`cotree_pull`] and [`cotree_record`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_pull_record(grip: *mut Grip, variables: *const u32, count: usize, values: *mut f64) {
    // SAFETY: the caller says so, and `cotree_alloc` aligns.
    let (grip, variables, values) = unsafe {
        let variables = std::slice::from_raw_parts(variables, count);
        (&mut *grip, variables, std::slice::from_raw_parts_mut(values, count))
    };
    grip.values(variables, values);
}

/// The next start is the pose that is held: it is followed from there to what is set meanwhile.
///
/// # Safety
/// As for [`cotree_setup`] and [`cotree_pull`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_start_from(instance: *mut Instance, grip: *const Grip) -> i32 {
    // SAFETY: the caller says so.
    let (instance, grip) = unsafe { (&mut *instance, &*grip) };
    let pose = grip.at_the_values_of(&instance.state());
    code(instance.start_from(pose))
}

/// Lets go.
///
/// # Safety
/// `grip` comes from [`cotree_grip`] and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cotree_let_go(grip: *mut Grip) {
    // SAFETY: this is the box that `cotree_grip` gave away.
    drop(unsafe { Box::from_raw(grip) });
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
