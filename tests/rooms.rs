//! The rooms of the house: data flows one way, so each crate uses only those before it, and each folder of a crate too.

use crate::support::ROOT;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A crate: its name, its folder, and the folders and files in it, each after all that it uses. A crate without a list is one room.
type Crate = (&'static str, &'static str, &'static [&'static str]);

/// The crates, each after all that it uses.
const CRATES: [Crate; 8] = [
    (
        "cotree_fmu",
        "fmu/src",
        &[
            "math",
            "linalg",
            "tape",
            "program",
            "contain",
            "failure",
            "model",
            "machine",
            "motion",
            "events",
            "taylor",
            "constraints",
            "context",
            "pace",
            "singular",
            "integrator",
            "hybrid",
            "instance",
            "fmi",
            "fmi2",
            "fmi3",
        ],
    ),
    (
        "cotree_synthesis",
        "crates/synthesis/src",
        &[
            "random",
            "least",
            "valley",
            "poses",
            "conics",
            "dyad",
            "linkage",
            "defects",
            "cognates",
            "corridor",
            "limits",
            "function",
            "stroke",
            "chain",
            "tolerance",
            "bounded",
            "atlas",
            "sextic",
            "path",
            "within",
            "function_within",
            "six",
        ],
    ),
    (
        "cotree",
        "src",
        &[
            "diagnostic",
            "files",
            "typeset",
            "expr",
            "model",
            "network",
            "equations",
            "laws",
            "scene",
            "sheet",
            "component",
            "resolve",
            "tape",
            "solve",
            "arms",
            "program",
            "redundancy",
            "formulate",
            "export",
            "report",
            "compile",
            "run",
            "import",
            "task",
            "gallery",
        ],
    ),
    (
        "cotree_study",
        "crates/study/src",
        &["analysis", "bench", "compare", "contact", "sweep", "motion", "request", "fit", "optimize", "synthesis"],
    ),
    (
        "cotree_draw",
        "crates/draw/src",
        &["alike", "carrier", "svg", "letters", "png", "drawing", "dxf", "line", "pose", "graph", "plot", "study"],
    ),
    ("cotree_text", "crates/text/src", &[]),
    (
        "cotree_page",
        "crates/page/src",
        &[
            "motionless",
            "page",
            "accuracy",
            "icon",
            "documentation",
            "overview",
            "moving",
            "sketch",
            "film",
            "export",
            "desk",
            "pull",
            "serve",
        ],
    ),
    ("cotree_cli", "crates/cli/src", &[]),
];

fn root() -> PathBuf {
    PathBuf::from(ROOT)
}

/// Rust files, in folders too.
fn files(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(path) else { return vec![path.to_path_buf()] };
    let mut found: Vec<PathBuf> = entries.flat_map(|entry| files(&entry.expect("an entry").path())).collect();
    found.retain(|file| file.extension().is_some_and(|extension| extension == "rs"));
    found
}

/// The rooms of its crate that a file names as `crate::room` or in `use crate::{room, ...}`, its tests left out.
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
fn no_crate_uses_one_that_comes_after_it() {
    let mut back = Vec::new();
    for (place, (_, folder, _)) in CRATES.iter().enumerate() {
        for file in files(&root().join(folder)) {
            let text = fs::read_to_string(&file).expect("a source file");
            let after = CRATES[place + 1..].iter().filter(|(name, ..)| text.contains(&format!("{name}::")));
            back.extend(after.map(|(name, ..)| format!("{} uses `{name}`", file.display())));
        }
    }
    assert!(back.is_empty(), "{}", back.join("\n"));
}

#[test]
fn no_room_uses_one_that_comes_after_it() {
    let mut back = Vec::new();
    for (_, folder, rooms) in CRATES {
        for (place, room) in rooms.iter().enumerate() {
            let own = root().join(folder).join(room);
            let of_room = if own.is_dir() { files(&own) } else { vec![own.with_extension("rs")] };
            for file in of_room {
                let text = fs::read_to_string(&file).expect("a source file");
                let after = used(&text).into_iter().filter(|used| rooms[place + 1..].contains(&used.as_str()));
                back.extend(after.map(|used| format!("{} uses `{used}`", file.display())));
            }
        }
    }
    assert!(back.is_empty(), "{}", back.join("\n"));
}

#[test]
fn every_room_is_in_the_list() {
    for (_, folder, rooms) in CRATES.iter().filter(|(.., rooms)| !rooms.is_empty()) {
        let there =
            fs::read_dir(root().join(folder)).expect("the sources").map(|entry| entry.expect("an entry").path());
        let names = there.map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned());
        let names: BTreeSet<String> = names.filter(|name| name != "lib").collect();
        assert_eq!(names, rooms.iter().map(|room| (*room).to_owned()).collect(), "{folder}");
    }
}

#[test]
fn uses_are_found_however_they_are_written() {
    let text = "use crate::{scene::{Body, Joint}, graph, lower::{self, tape}};\nfn f() { crate::expr::g() }\n#[cfg(test)] use crate::cli;";
    let found: Vec<String> = used(text).into_iter().collect();
    assert_eq!(found, ["expr", "graph", "lower", "scene"]);
}
