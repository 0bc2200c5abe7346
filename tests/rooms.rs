//! The rooms of the house: data flows one way, so each folder of `src` uses only those before it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The folders and files of `src`, each after all that it uses.
const ROOMS: [&str; 23] = [
    "diagnostic",
    "files",
    "columns",
    "graph",
    "expr",
    "mechanism",
    "scene",
    "component",
    "resolve",
    "tree",
    "equations",
    "lower",
    "formulate",
    "analysis",
    "output",
    "export",
    "compile",
    "simulate",
    "import",
    "motion",
    "sweep",
    "fit",
    "cli",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Rust files, in folders too.
fn files(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(path) else { return vec![path.to_path_buf()] };
    let mut found: Vec<PathBuf> = entries.flat_map(|entry| files(&entry.expect("an entry").path())).collect();
    found.retain(|file| file.extension().is_some_and(|extension| extension == "rs"));
    found
}

/// The rooms that a file names as `crate::room` or in `use crate::{room, ...}`, its tests left out.
fn used(text: &str) -> BTreeSet<String> {
    let code: String = text.split("#[cfg(test)]").next().unwrap_or_default().split_whitespace().collect();
    let word = |rest: &str| rest.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect::<String>();
    let mut rooms = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            None => _ = rooms.insert(word(rest)),
            Some(list) => {
                let mut depth = 0;
                let mut start = true;
                for (index, c) in list.char_indices() {
                    if start && depth == 0 {
                        rooms.insert(word(&list[index..]));
                    }
                    start = c == ',';
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        _ => (),
                    }
                }
            }
        }
    }
    rooms
}

#[test]
fn no_room_uses_one_that_comes_after_it() {
    let mut back = Vec::new();
    for (place, room) in ROOMS.iter().enumerate() {
        let folder = root().join(room);
        let of_room = if folder.is_dir() { files(&folder) } else { vec![folder.with_extension("rs")] };
        for file in of_room {
            let text = fs::read_to_string(&file).expect("a source file");
            let after = used(&text).into_iter().filter(|used| ROOMS[place + 1..].contains(&used.as_str()));
            back.extend(after.map(|used| format!("{} uses `{used}`", file.display())));
        }
    }
    assert!(back.is_empty(), "{}", back.join("\n"));
}

#[test]
fn every_room_is_in_the_list() {
    let there = fs::read_dir(root()).expect("the sources").map(|entry| entry.expect("an entry").path());
    let names = there.map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned());
    let names: BTreeSet<String> = names.filter(|name| !matches!(name.as_str(), "lib" | "main")).collect();
    assert_eq!(names, ROOMS.iter().map(|room| (*room).to_owned()).collect());
}

#[test]
fn uses_are_found_however_they_are_written() {
    let text = "use crate::{scene::{Body, Joint}, graph, lower::{self, tape}};\nfn f() { crate::expr::g() }\n#[cfg(test)] use crate::cli;";
    let found: Vec<String> = used(text).into_iter().collect();
    assert_eq!(found, ["expr", "graph", "lower", "scene"]);
}
