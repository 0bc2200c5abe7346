//! From a scene to its FMU for browsers, behind functions that a script can call.
//!
//! A script writes a text or bytes into the [room](front_room), calls, and reads the [answer](front_answer): a JSON text, a page, or an FMU. A function
//! that can fail returns 0 if it did not; the answer is then what was asked for, else what is wrong, as JSON. Nothing here reads a file or a clock, or starts a
//! thread.

#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        reason = "no input may cause a panic"
    )
)]

use std::cell::RefCell;

use cotree::export::FmiVersion;
use cotree::export::runtime::{Platform, Runtime};
use cotree_page::desk::{self, Desk, failed};
use serde_json::Value;

#[derive(Default)]
struct Exchange {
    room: Vec<u8>,
    answer: Vec<u8>,
    desk: Desk,
}

thread_local! {
    static DESK: RefCell<Exchange> = RefCell::default();
}

/// Room for so many bytes, for what the next call is about.
#[unsafe(no_mangle)]
pub extern "C" fn front_room(length: usize) -> *mut u8 {
    DESK.with_borrow_mut(|desk| {
        desk.room = vec![0; length];
        desk.room.as_mut_ptr()
    })
}

/// The last answer; valid until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn front_answer() -> *const u8 {
    DESK.with_borrow(|desk| desk.answer.as_ptr())
}

/// Its length in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn front_answer_length() -> usize {
    DESK.with_borrow(|desk| desk.answer.len())
}

/// What is wrong with a scene, the mechanism at its start, where its numbers are written.
#[unsafe(no_mangle)]
pub extern "C" fn front_look() -> i32 {
    answer(Ok(desk::look(&text())))
}

/// A text after edits, both in JSON.
#[unsafe(no_mangle)]
pub extern "C" fn front_edit() -> i32 {
    answer(desk::edit(&text()))
}

/// The page of a scene, without its solver.
#[unsafe(no_mangle)]
pub extern "C" fn front_page() -> i32 {
    // The drawing page has the solver already, and lends it.
    answer(desk::page(&text()))
}

/// The linkages for a task.
#[unsafe(no_mangle)]
pub extern "C" fn front_answers() -> i32 {
    answer(Ok(desk::answers(&text())))
}

/// The scene of a robot, a drawing or a linkage of another program. The room has its file and those that it includes, as [`desk::import`] reads them.
#[unsafe(no_mangle)]
pub extern "C" fn front_import() -> i32 {
    let room = DESK.with_borrow_mut(|desk| std::mem::take(&mut desk.room));
    answer(desk::import(&room))
}

/// The models that a drawing can start from.
#[unsafe(no_mangle)]
pub extern "C" fn front_gallery() -> i32 {
    answer(Ok(desk::gallery()))
}

/// The room has the runtime for browsers: pages in FMUs carry it.
#[unsafe(no_mangle)]
pub extern "C" fn front_take_module() {
    DESK.with_borrow_mut(|desk| desk.desk.module = Some(std::mem::take(&mut desk.room)));
}

/// The room has the name of a platform, a zero byte, and the runtime for it.
#[unsafe(no_mangle)]
pub extern "C" fn front_take_runtime() -> i32 {
    let mut name = DESK.with_borrow_mut(|desk| std::mem::take(&mut desk.room));
    let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
    let library = name.split_off((end + 1).min(name.len()));
    name.truncate(end);
    let platform = Platform::named(&String::from_utf8_lossy(&name));
    answer(platform.map_err(|error| failed(&error)).map(|platform| {
        DESK.with_borrow_mut(|desk| desk.desk.runtimes.push(Runtime { platform, library: library.into() }));
        Vec::new()
    }))
}

/// The FMU of a scene, of FMI 2.0 or 3.0, for the platforms of the runtimes.
#[unsafe(no_mangle)]
pub extern "C" fn front_fmu(version: u32) -> i32 {
    let version = if version == 3 { FmiVersion::V3 } else { FmiVersion::V2 };
    let text = text();
    answer(DESK.with_borrow(|desk| desk.desk.fmu(&text, version)))
}

/// The text in the room.
fn text() -> String {
    String::from_utf8_lossy(&DESK.with_borrow_mut(|desk| std::mem::take(&mut desk.room))).into_owned()
}

/// Keeps an answer. 0, or 1 if it says what is wrong.
fn answer(result: Result<Vec<u8>, Value>) -> i32 {
    let (code, bytes) = match result {
        Ok(bytes) => (0, bytes),
        Err(faults) => (1, faults.to_string().into_bytes()),
    };
    DESK.with_borrow_mut(|desk| desk.answer = bytes);
    code
}

#[cfg(test)]
mod tests {
    use cotree_page::{Made, sketch};

    use super::*;

    /// Puts bytes into the room and calls; the code and the answer.
    fn requested(bytes: &[u8], call: impl Fn() -> i32) -> (i32, Vec<u8>) {
        DESK.with_borrow_mut(|desk| desk.room = bytes.to_vec());
        (call(), DESK.with_borrow(|desk| desk.answer.clone()))
    }

    #[test]
    fn an_fmu_has_the_bytes_that_the_command_writes() {
        let (_, text) = cotree::gallery::MODELS.iter().find(|(name, _)| *name == "pendulum").unwrap();
        let runtime = Runtime::embedded().unwrap();
        let library = [runtime.platform.folder.as_bytes(), b"\0", &runtime.packed_library()].concat();
        assert_eq!(requested(&library, || front_take_runtime()).0, 0);
        for (number, version) in [(2, FmiVersion::V2), (3, FmiVersion::V3)] {
            let (code, bytes) = requested(text.as_bytes(), || front_fmu(number));
            let made = Made::of(&sketch::scene(text).unwrap(), false).unwrap();
            let extras = made.extras(version, None).unwrap();
            let expected = made.compiled.pack_fmu(version, extras, std::slice::from_ref(&runtime)).unwrap();
            assert!(code == 0 && bytes == expected, "FMI {number}: {} and {} bytes", bytes.len(), expected.len());
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        for call in [&(|| front_page()) as &dyn Fn() -> i32, &|| front_fmu(2)] {
            let (code, answer) = requested(b"name = 'a'\n[bodies.bar]\nmas = 2", call);
            let answer: Value = serde_json::from_slice(&answer).unwrap();
            assert_eq!((code, &answer["faults"][0]["place"]["line"]), (1, &3.into()), "{answer}");
        }
        let (code, answer) = requested(b"amiga\0...", || front_take_runtime());
        assert!(code == 1 && String::from_utf8(answer).unwrap().contains("no platform `amiga`"));
        assert_eq!(requested(&[0xff, 0xfe], || front_look()).0, 0, "no text at all has faults like any other");
    }
}
