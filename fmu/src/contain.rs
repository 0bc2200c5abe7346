//! Nothing should panic. If something does all the same, the panic ends at the border of the program: the FMI functions, the command line, Python. It becomes an error that
//! says what failed and where in the code, and it neither unwinds into the caller nor prints.

use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::OnceLock;

thread_local! {
    /// Is this thread inside of [`contain`]?
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
    /// Where in the code the last panic inside of it began. Untouched as long as nothing panics.
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// The hook for panics outside. It stays in the library's own memory, and a function that captures nothing needs none: unloading
/// the library loses nothing.
static PREVIOUS: OnceLock<Hook> = OnceLock::new();
type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>;

/// Runs something that should not panic.
///
/// # Errors
/// It did: the message of the panic, and the line of the code, if it is known. A panic of another thread that is passed on has no line: that thread has printed it.
pub fn contain<T>(run: impl FnOnce() -> T) -> Result<T, String> {
    PREVIOUS.get_or_init(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(note));
        previous
    });
    let before = CONTAINED.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(run));
    CONTAINED.set(before);
    result.map_err(|payload| {
        let message = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let message = message.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
        match PLACE.take() {
            place if place.is_empty() => message,
            place => format!("{message} ({place})"),
        }
    })
}

/// Notes where a panic began, or prints it if nothing contains it.
fn note(info: &PanicHookInfo<'_>) {
    if CONTAINED.get() {
        let place = info.location().map(|place| format!("{}:{}", place.file(), place.line()));
        PLACE.set(place.unwrap_or_default());
    } else if let Some(previous) = PREVIOUS.get() {
        previous(info);
    }
}

#[cfg(test)]
mod tests {
    use super::contain;

    #[test]
    fn a_panic_says_what_and_where() {
        let list: Vec<usize> = Vec::new();
        let message = contain(|| list[std::hint::black_box(3)]).unwrap_err();
        assert!(message.contains("the index is 3") && message.contains("contain.rs:"), "{message}");
        assert_eq!(contain(|| 4), Ok(4));
        let inner = contain(|| contain(|| panic!("inside {}", 1)).is_err());
        assert_eq!(inner, Ok(true));
    }
}
