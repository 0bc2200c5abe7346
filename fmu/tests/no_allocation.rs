//! Nothing allocates while stepping.

mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use support::*;

struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call is passed on unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // SAFETY: the caller's promise is the same.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is the same.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn stepping_setting_getting_and_saving_do_not_allocate() {
    for program in [pendulum(), slider_crank(), four_bar(Drive::Velocity, true), four_bar(Drive::Position, false)] {
        let variables = program.variables.len();
        let mut instance = started(program);
        let input = instance
            .model()
            .program()
            .variables
            .iter()
            .position(|variable| matches!(variable.source, cotree_fmu::program::Source::Input(_)));
        let input = input.expect("all have one");
        let mut snapshot = instance.save();
        let before = COUNT.get();
        for step in 1..=200_u32 {
            if step % 3 == 0 {
                instance.set(input, f64::from(step % 5) * 0.1).expect("input");
                instance.set_derivative(input, 1, 0.1).expect("input");
            }
            instance.step_to(f64::from(step) * 0.01).expect("regular");
            for variable in 0..variables {
                instance.get(variable).expect("defined");
            }
            instance.save_into(&mut snapshot);
            instance.restore(&snapshot).expect("own state");
        }
        assert_eq!(COUNT.get(), before);
    }
}
