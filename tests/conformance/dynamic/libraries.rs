//! Several libraries in one process, and damaged ones.

use std::ffi::CString;
use std::path::Path;

use cotree_fmu::fmi2::types::fmi2Status::fmi2Error;

use super::super::fmu::*;
use super::super::version;
use super::instantiation::{copy, good, located, make};

pub(super) fn second_library(fmu: &Fmu) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = fmu.library_path();
    let copy = folder.path().join("another.so");
    std::fs::copy(path, &copy).expect("a copy");
    let mut second = Fmu::open(&fmu.folder);
    second.library = Library::load(&copy);
    let expected = fmu.started().run(0..20);
    let (first, other) = (fmu.started(), second.started());
    for step in 0..20 {
        let wanted = &expected[step as usize..=step as usize];
        assert!(first.run(step..step + 1) == wanted && other.run(step..step + 1) == wanted);
    }
}

/// Whatever has happened to the program: no instance, one message, no crash.
pub(super) fn damaged_resources(fmu: &Fmu) {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = std::fs::read(fmu.folder.join("resources/program.bin")).expect("a program");
    let refused = |bytes: Option<&[u8]>| {
        let file = folder.path().join("program.bin");
        match bytes {
            Some(bytes) => std::fs::write(&file, bytes).expect("a file"),
            None => std::fs::remove_file(&file).expect("a file"),
        }
        let [name, guid, _] = good(fmu);
        let location = CString::new(format!("file://{}", folder.path().display())).expect("no zero");
        let messages = Messages::default();
        let c = make(fmu, [Some(&name), Some(&guid), Some(&location)], &callbacks(&messages));
        assert!(c.is_null() && messages.lock().expect("not poisoned").len() == 1);
    };
    let places = (0..whole.len()).step_by(whole.len() / 200 + 1);
    for place in places {
        let mut changed = whole.clone();
        changed[place] ^= 0x24;
        refused(Some(&changed));
        refused(Some(&whole[..place]));
    }
    refused(Some(&[&whole[..], b"more"].concat()));
    refused(None);
    located(fmu, &fmu.resources());
}

/// In turns with an instance of each other model, each from its own library.
pub(super) fn another_model(fmu: &Fmu) {
    let models = fmu.folder.parent().expect("models beside it");
    let folders = std::fs::read_dir(models).expect("a folder").map(|entry| entry.expect("an entry").path());
    let folders = folders.filter(|path| path.join("modelDescription.xml").is_file() && *path != fmu.folder);
    let others: Vec<Fmu> = folders.map(|folder| Fmu::open(&folder)).collect();
    assert!(!others.is_empty());
    let expected = fmu.started().run(0..20);
    let slave = fmu.started();
    let strangers: Vec<Slave> = others.iter().map(Fmu::started).collect();
    for step in 0..20 {
        strangers.iter().for_each(|stranger| drop(stranger.run(step..step + 1)));
        assert!(slave.run(step..step + 1) == expected[step as usize..=step as usize]);
    }
    // A state of another model is refused.
    let state = strangers[0].save();
    assert_eq!(slave.deserialize(&strangers[0].bytes(state)), Err(fmi2Error));
    strangers[0].free(state);
}

/// An FMU of another version: its own runtime, and a program in that runtime's format.
fn of_another_version(fmu: &Fmu, folder: &Path) -> Fmu {
    let path = std::env::var(super::super::OTHER).expect("set by the first process");
    let format = version::format(Path::new(&path));
    assert_ne!(format, version::format(&fmu.library_path()));
    copy(&fmu.folder.join("resources"), &folder.join("resources"));
    let program = folder.join("resources/program.bin");
    let mut bytes = std::fs::read(&program).expect("a program");
    // After the mark.
    bytes[4..8].copy_from_slice(&format.to_le_bytes());
    std::fs::write(&program, bytes).expect("a file");
    let mut other = Fmu::open(&fmu.folder);
    (other.about.folder, other.library) = (folder.to_owned(), Library::load(Path::new(&path)));
    other
}

/// In turns with an instance of a runtime of another version; neither reads what the other has written.
pub(super) fn another_version(fmu: &Fmu) {
    let folder = tempfile::tempdir().expect("a folder");
    let other = of_another_version(fmu, folder.path());
    let expected = fmu.started().run(0..20);
    let (slave, stranger) = (fmu.started(), other.started());
    for step in 0..20 {
        let wanted = &expected[step as usize..=step as usize];
        assert!(slave.run(step..step + 1) == wanted && stranger.run(step..step + 1) == wanted);
    }
    for [reader, writer] in [[&slave, &stranger], [&stranger, &slave]] {
        let [name, guid, _] = good(reader.fmu);
        let location = CString::new(writer.fmu.resources()).expect("no zero");
        let messages = Messages::default();
        assert!(make(reader.fmu, [Some(&name), Some(&guid), Some(&location)], &callbacks(&messages)).is_null());
        let said = messages.lock().expect("not poisoned").pop().expect("a message").3;
        assert!(said.contains("format") && said.contains("export again"), "{said}");
        let state = writer.save();
        assert_eq!(reader.deserialize(&writer.bytes(state)), Err(fmi2Error));
        writer.free(state);
        let said = reader.log().pop().expect("a message").3;
        assert!(said.contains("the saved state cannot be read: its format"), "{said}");
    }
    assert_eq!(slave.run(20..30), stranger.run(20..30));
}
