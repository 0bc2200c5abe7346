//! Loading and freeing.

use std::ffi::{CStr, CString};
use std::path::Path;
use std::ptr::{null, null_mut};

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Error, fmi2OK};
use cotree_fmu::fmi2::types::*;

use super::super::fmu::*;

// SAFETY of all calls: the component is alive, and arrays are as long as announced.

pub(super) fn platform(fmu: &Fmu) {
    let text = |call: unsafe extern "C" fn() -> fmi2String| unsafe { CStr::from_ptr(call()) };
    assert_eq!((text(fmu.library.types_platform), text(fmu.library.version)), (c"default", c"2.0"));
}

pub(super) fn located(fmu: &Fmu, location: &str) {
    fmu.instantiate(fmi2CoSimulation, location, false).expect("instantiates").start();
}

pub(super) fn escapes(fmu: &Fmu) {
    let folder = tempfile::tempdir().expect("a folder");
    let resources = folder.path().join("a b é%");
    copy(&fmu.folder.join("resources"), &resources);
    located(fmu, &format!("file://{}/a%20b%20%C3%A9%25", folder.path().display()));
}

pub(super) fn copy(from: &Path, to: &Path) {
    std::fs::create_dir(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        std::fs::copy(entry.path(), to.join(entry.file_name())).expect("a copy");
    }
}

/// Calls `fmi2Instantiate` with these pointers.
pub(super) fn make(
    fmu: &Fmu,
    [name, guid, location]: [Option<&CStr>; 3],
    callbacks: *const fmi2CallbackFunctions,
) -> fmi2Component {
    let [name, guid, location] = [name, guid, location].map(|text| text.map_or(null(), CStr::as_ptr));
    unsafe { (fmu.library.instantiate)(name, fmi2CoSimulation, guid, location, callbacks, 0, 0) }
}

pub(super) fn good(fmu: &Fmu) -> [CString; 3] {
    ["a", &fmu.guid, &fmu.resources()].map(|text| CString::new(text).expect("no zero"))
}

pub(super) fn no_location(fmu: &Fmu) {
    let [name, guid, _] = good(fmu);
    for location in [None, Some(c"")] {
        let messages = Messages::default();
        let c = make(fmu, [Some(&name), Some(&guid), location], &callbacks(&messages));
        assert!(c.is_null() && messages.lock().expect("not poisoned").len() == 1);
    }
}

pub(super) fn wrong_guid(fmu: &Fmu) {
    let [name, _, location] = good(fmu);
    let messages = Messages::default();
    assert!(make(fmu, [Some(&name), Some(c"{1}"), Some(&location)], &callbacks(&messages)).is_null());
    assert_eq!(messages.lock().expect("not poisoned").len(), 1);
}

pub(super) fn missing_strings(fmu: &Fmu) {
    let [name, guid, location] = good(fmu);
    let messages = Messages::default();
    for [name, guid] in
        [[None, Some(&*guid)], [Some(c""), Some(&guid)], [Some(c" \t "), Some(&guid)], [Some(&name), None]]
    {
        assert!(make(fmu, [name, guid, Some(&location)], &callbacks(&messages)).is_null());
    }
}

pub(super) fn missing_callbacks(fmu: &Fmu) {
    let [name, guid, location] = good(fmu);
    let strings = [Some(&*name), Some(&guid), Some(&location)];
    assert!(make(fmu, strings, null()).is_null());
    let nothing = fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: null_mut(),
    };
    let c = make(fmu, strings, &nothing);
    assert!(!c.is_null());
    assert_eq!(unsafe { (fmu.library.do_step)(c, 0.0, 1.0, 1) }, fmi2Error);
    unsafe { (fmu.library.free_instance)(c) };
}

pub(super) fn wrong_interface(fmu: &Fmu) {
    let offered = !fmu.below("fmiModelDescription/ModelExchange").is_empty();
    assert_eq!(fmu.instantiate(fmi2ModelExchange, &fmu.resources(), false).is_some(), offered);
    assert!(fmu.instantiate(7, &fmu.resources(), false).is_none());
}

pub(super) fn transient_arguments(fmu: &Fmu) {
    let messages = Messages::default();
    let mut strings = good(fmu).map(CString::into_bytes_with_nul);
    let mut functions = callbacks(&messages);
    let texts = [0, 1, 2].map(|index| CStr::from_bytes_with_nul(&strings[index]).ok());
    let c = make(fmu, texts, &functions);
    strings.iter_mut().for_each(|text| text.fill(b'x'));
    functions.logger = None;
    functions.componentEnvironment = null_mut();
    std::hint::black_box((&strings, &functions));
    assert_eq!(unsafe { (fmu.library.terminate)(c) }, fmi2Error);
    assert_eq!(messages.lock().expect("not poisoned")[0].0, "a");
    unsafe { (fmu.library.free_instance)(c) };
}

pub(super) fn free_anywhere(fmu: &Fmu) {
    unsafe { (fmu.library.free_instance)(null_mut()) };
    drop(fmu.slave());
    let slave = fmu.slave();
    assert_eq!([slave.setup(0.0, None, None), slave.enter()], [fmi2OK; 2]);
    drop(slave);
    drop(fmu.started());
    let slave = fmu.started();
    slave.run(0..3);
    assert_eq!(slave.terminate(), fmi2OK);
}
