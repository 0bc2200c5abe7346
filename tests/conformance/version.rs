//! A runtime of another version: the same sources but for a line that changes the format of what is stored.

use crate::support::ROOT;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::python;

/// The workspace around the copied sources.
const WORKSPACE: &str = r#"
[workspace]
members = ["fmu", "tools/runtime"]
resolver = "3"

[workspace.lints.rust]
missing_docs = "warn"

[profile.dev]
opt-level = 0
debug = false
"#;
/// Every source is part of the format, comments too.
const CHANGE: (&str, &str) = ("fmu/src/program/mod.rs", "// Of the next version.\n");
/// What comes before the format in the bytes of a runtime.
const KIND: &str = "a cotree program of format ";

/// What the members have from the workspace, which is of the next version.
fn package(root: &Path) -> String {
    let manifest = fs::read_to_string(root.join("Cargo.toml")).expect("a manifest");
    let (_, rest) = manifest.split_once("[workspace.package]\n").expect("what the members share");
    let lines = rest.lines().take_while(|line| !line.starts_with('['));
    let own = lines.map(|line| if line.starts_with("version ") { "version = \"0.1.1\"" } else { line });
    own.fold("\n[workspace.package]\n".to_owned(), |all, line| all + line + "\n")
}

/// Builds it, once for unchanged sources; its shared library.
pub fn other_runtime() -> PathBuf {
    let root = Path::new(ROOT);
    let work = Path::new(env!("CARGO_TARGET_TMPDIR")).join("other-version");
    write(&work.join("Cargo.toml"), (WORKSPACE.to_owned() + &package(root)).as_bytes());
    for part in ["Cargo.lock", "fmu/Cargo.toml", "fmu/build.rs", "fmu/src", "tools/runtime"] {
        copy(root, &work, Path::new(part));
    }
    let mut build = Command::new(env!("CARGO"));
    build.args(["build", "--quiet", "--package", "cotree-runtime"]).current_dir(&work);
    build.arg("--target-dir").arg(work.join("target"));
    python::run(&mut build).unwrap_or_else(|report| panic!("the other version cannot be built:\n{report}"));
    let name = format!("{}cotree_runtime{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    work.join("target/debug").join(name)
}

fn copy(from: &Path, to: &Path, part: &Path) {
    if from.join(part).is_dir() {
        let names = names(&from.join(part));
        // What an earlier copy had and is no source any more.
        for old in names_there(&to.join(part)).difference(&names) {
            let old = to.join(part).join(old);
            let removed = if old.is_dir() { fs::remove_dir_all(&old) } else { fs::remove_file(&old) };
            removed.expect("the copy can be changed");
        }
        return names.iter().for_each(|name| copy(from, to, &part.join(name)));
    }
    let mut content = fs::read(from.join(part)).expect("a source");
    if part == Path::new(CHANGE.0) {
        content.extend(CHANGE.1.as_bytes());
    }
    write(&to.join(part), &content);
}

fn names(folder: &Path) -> BTreeSet<OsString> {
    fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name()).collect()
}

fn names_there(folder: &Path) -> BTreeSet<OsString> {
    if folder.is_dir() { names(folder) } else { BTreeSet::new() }
}

/// A file that stays untouched if it is right already, so that nothing is built again.
fn write(path: &Path, content: &[u8]) {
    if fs::read(path).is_ok_and(|old| old == content) {
        return;
    }
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    fs::write(path, content).expect("a file");
}

/// The format that a runtime reads and writes.
pub fn format(library: &Path) -> u32 {
    let bytes = fs::read(library).expect("a library");
    let place = bytes.windows(KIND.len()).position(|window| window == KIND.as_bytes()).expect("a runtime of cotree");
    let digits = &bytes[place + KIND.len()..][..8];
    u32::from_str_radix(str::from_utf8(digits).expect("digits"), 16).expect("a hexadecimal number")
}
