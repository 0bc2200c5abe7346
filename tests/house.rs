//! What a stranger can check of the structure of the sources.

use std::path::{Path, PathBuf};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => sources(&path, found),
            false if path.extension().is_some_and(|extension| extension == "rs") => found.push(path),
            false => {}
        }
    }
}

/// The names of the components, as their own files give them.
fn kinds(folder: &Path) -> Vec<String> {
    let mut files = Vec::new();
    sources(folder, &mut files);
    let constructors = ["Facts::joint(\"", "Facts::driver(\"", "Facts::load(\""];
    let name = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let rest = constructors.iter().find_map(|start| text.split_once(start))?.1.to_string();
        rest.split_once('"').map(|(name, _)| name.to_string())
    };
    files.iter().filter_map(name).collect()
}

/// A component is one file: nothing outside `src/component` decides by the name of a kind, neither in a pattern nor in a comparison.
#[test]
fn no_other_room_decides_by_the_kind_of_a_component() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let kinds = kinds(&root.join("component"));
    assert!(kinds.len() >= 17, "{kinds:?}");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let mut named = Vec::new();
    for path in files.iter().filter(|path| !path.starts_with(root.join("component"))) {
        let text = std::fs::read_to_string(path).unwrap();
        for (number, line) in text.lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            let decides = |kind: &String| {
                let quoted = format!("\"{kind}\"");
                [format!("{quoted} =>"), format!("== {quoted}"), format!("{quoted} |")]
                    .iter()
                    .any(|use_of| code.contains(use_of))
            };
            let enumerates = ["JointKind::", "LoadKind::", "DriverKind::"].iter().any(|kind| code.contains(kind));
            if enumerates || code.contains(".kind ==") && kinds.iter().any(decides) {
                named.push(format!("{}:{}: {line}", path.display(), number + 1));
            }
        }
    }
    assert!(named.is_empty(), "a kind is named outside src/component:\n{}", named.join("\n"));
}
