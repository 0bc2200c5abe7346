//! Every fault has a page in docs/faults: its wrong scene has that fault and the message that is shown, its right scene is right.
//! `COTREE_WRITE_REFERENCE=1` writes the messages anew.

use crate::support::ROOT;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use cotree::compile::compile;
use cotree::scene::{Faults, Scene, Source};

fn folder() -> PathBuf {
    Path::new(ROOT).join("docs/faults")
}

/// Of `scene::wrong_unit`: `scene_wrong_unit`.
fn stem(code: &str) -> String {
    code.replace("::", "_")
}

/// The codes of all faults in the sources.
fn codes(folder: &Path, codes: &mut BTreeSet<String>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            self::codes(&path, codes);
        } else if path.extension().is_some_and(|end| end == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let quoted = text.split('"').filter(|part| {
                let (area, name) = part.split_once("::").unwrap_or_default();
                let is_word = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c == '_');
                ["scene", "assembly", "contact", "coordinates", "cotree", "export"].contains(&area) && is_word(name)
            });
            codes.extend(quoted.map(str::to_string));
        }
    }
}

/// What follows a mark, up to the end of its block of code.
fn block<'a>(page: &'a str, marks: &[&str]) -> Option<&'a str> {
    let rest = marks.iter().try_fold(page, |rest, mark| rest.split_once(mark).map(|(_, rest)| rest))?;
    rest.split_once("```").map(|(block, _)| block)
}

/// Errors and warnings.
fn faults(text: &str) -> Option<Faults> {
    match Scene::from_source(Source::new("scene.toml", text), false).and_then(|scene| compile(&scene)) {
        Err(faults) => Some(faults),
        Ok(compiled) => compiled.warnings,
    }
}

#[test]
fn every_fault_has_a_page_and_every_page_a_fault() {
    let mut known = BTreeSet::new();
    codes(&Path::new(ROOT).join("src"), &mut known);
    codes(&Path::new(ROOT).join("crates"), &mut known);
    assert!(known.len() > 70, "{known:?}");
    let index = fs::read_to_string(folder().join("README.md")).unwrap();
    let book = fs::read_to_string(folder().join("../SUMMARY.md")).unwrap();
    for code in &known {
        assert!(folder().join(stem(code) + ".md").is_file(), "`{code}` has no page in docs/faults");
        assert!(index.contains(&format!("({}.md)", stem(code))), "docs/faults/README.md does not list `{code}`");
        assert!(book.contains(&format!("(faults/{}.md)", stem(code))), "docs/SUMMARY.md does not list `{code}`");
    }
    let pages = folder().read_dir().unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let stems: BTreeSet<String> = known.iter().map(|code| stem(code) + ".md").chain(["README.md".into()]).collect();
    assert_eq!(pages.collect::<BTreeSet<_>>(), stems);
}

#[test]
fn wrong_scenes_have_the_fault_and_right_ones_have_none() {
    // Their files are named as seen from the top; no other test depends on where it runs.
    std::env::set_current_dir(ROOT).unwrap();
    let mut shown = 0;
    for entry in folder().read_dir().unwrap() {
        let path = entry.unwrap().path();
        let page = fs::read_to_string(&path).unwrap();
        let title = page.lines().next().and_then(|line| line.strip_prefix("# "));
        let title = title.unwrap_or_else(|| panic!("{} has no title", path.display()));
        let Some(code) = Some(title).filter(|title| title.contains("::")) else { continue };
        if let Some(right) = block(&page, &["## Right", "```toml\n"]) {
            assert!(faults(right).is_none(), "{code}: {}", faults(right).unwrap());
        }
        let Some(wrong) = block(&page, &["## Wrong", "```toml\n"]) else { continue };
        let found = faults(wrong).unwrap_or_else(|| panic!("{code}: the wrong scene is right"));
        assert!(found.list.iter().all(|fault| fault.code == code), "{code}: {found}");
        let said = found.render(false, 100);
        let written = block(&page, &["## Wrong", "```text\n"]).unwrap_or_else(|| panic!("{code}: no message"));
        if std::env::var_os("COTREE_WRITE_REFERENCE").is_some() {
            let begin = written.as_ptr() as usize - page.as_ptr() as usize;
            let [before, after] = [&page[..begin], &page[begin + written.len()..]];
            fs::write(&path, format!("{before}{}\n{after}", said.trim())).unwrap();
        } else {
            assert_eq!(written.trim(), said.trim(), "{code}: COTREE_WRITE_REFERENCE=1 writes the page anew");
        }
        shown += 1;
    }
    assert!(shown > 60, "{shown} pages have a wrong scene");
}
