//! The book of mdBook: what its preprocessor makes of the pages leads nowhere outside of it.

use crate::support::ROOT;

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::{Value, json};

/// The targets of links in a text: what stands between `](` and `)`, not in code.
fn targets(text: &str) -> Vec<&str> {
    let prose: Vec<&str> = text.split("```").step_by(2).flat_map(|prose| prose.split('`').step_by(2)).collect();
    let targets = prose.into_iter().flat_map(|part| part.split("](").skip(1));
    targets.filter_map(|rest| rest.split_once(')')).map(|(target, _)| target).collect()
}

/// The pages that `docs/SUMMARY.md` lists, as mdBook gives them to preprocessors.
fn chapters() -> Vec<Value> {
    let docs = Path::new(ROOT).join("docs");
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let chapter = |path: &str| {
        let content = fs::read_to_string(docs.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
        json!({ "Chapter": { "name": path, "content": content, "path": path, "sub_items": [] } })
    };
    targets(&summary).into_iter().map(chapter).collect()
}

/// A path without `..`.
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        if part == Component::ParentDir && plain.file_name().is_some() {
            _ = plain.pop()
        } else {
            plain.push(part)
        }
        plain
    })
}

#[test]
fn all_links_of_the_book_lead_to_its_pages() {
    let Ok(mut child) = Command::new("python3")
        .arg("tools/book.py")
        .current_dir(ROOT)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
    else {
        panic!("the book's preprocessor needs python3")
    };
    let input = json!([{ "root": ROOT, "config": { "book": { "src": "docs" } } }, { "sections": chapters() }]);
    child.stdin.take().unwrap().write_all(input.to_string().as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    let book: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |chapter: &Value, key: &str| chapter["Chapter"][key].as_str().unwrap().to_owned();
    let pages: BTreeMap<PathBuf, String> = book["sections"]
        .as_array()
        .unwrap()
        .iter()
        .map(|chapter| (PathBuf::from(text(chapter, "path")), text(chapter, "content")))
        .collect();
    // The pages stay within the folder of the book, and there is none that nothing lists.
    assert!(
        pages.contains_key(Path::new("overview.md"))
            && pages.keys().all(|path| plain(path) == *path && !path.starts_with(".."))
    );
    let mut links = 0;
    for (page, content) in &pages {
        for target in targets(content).into_iter().filter(|target| !target.contains(':') && !target.starts_with('#')) {
            let path = target.split('#').next().unwrap();
            let place = plain(&page.parent().unwrap().join(path));
            // mdBook copies pictures that lie beside the pages.
            let is_picture = place.extension().is_some_and(|ending| ending == "svg");
            let is_there = is_picture && Path::new(ROOT).join("docs").join(&place).is_file();
            assert!(is_there || pages.contains_key(&place), "{} leads to {target}", page.display());
            links += 1;
        }
    }
    assert!(links > 100, "{links}");
}

#[test]
fn the_book_is_built_below_target() {
    let settings = fs::read_to_string(Path::new(ROOT).join("book.toml")).unwrap();
    let settings: toml::Table = settings.parse().unwrap();
    let folder = settings["build"]["build-dir"].as_str().unwrap();
    assert!(folder.starts_with("target/"), "{folder}");
    let command = settings["preprocessor"]["repository"]["command"].as_str().unwrap();
    assert!(command.split(' ').any(|word| Path::new(ROOT).join(word).is_file()), "{command}");
}
