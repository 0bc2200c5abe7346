//! Wrong scenes: what each is told, as reviewed in the snapshots, and that nothing panics.

use crate::support::ROOT;
use std::path::{Path, PathBuf};

use cotree::scene::{Fault, Faults, Scene, Source};
use proptest::prelude::*;

/// The wrong scenes, in alphabetical order.
fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(ROOT).join("tests/faults");
    let mut paths: Vec<PathBuf> = folder
        .read_dir()
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml" || extension == "json"))
        .collect();
    paths.sort();
    paths
}

fn faults(source: Source, json: bool) -> Option<Faults> {
    match Scene::from_source(source, json) {
        Err(faults) => Some(faults),
        Ok(scene) => match scene.resolve() {
            Err(faults) => Some(faults),
            Ok(resolved) if resolved.warnings.is_empty() => None,
            Ok(resolved) => Some(Faults::new(scene.source, resolved.warnings)),
        },
    }
}

#[test]
fn each_wrong_scene_is_told_what_to_do() {
    let settings = {
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path("faults");
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings
    };
    for path in scenes() {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).unwrap();
        let faults =
            faults(Source::new(&name, text), name.ends_with("json")).unwrap_or_else(|| panic!("{name} has no fault"));
        settings.bind(|| insta::assert_snapshot!(name, faults.render(false, 100)));
    }
}

#[test]
fn editors_get_lines_and_columns() {
    let path = Path::new(ROOT).join("tests/faults/unknown_point.toml");
    let scene = Scene::from_source(Source::new("scene.toml", std::fs::read_to_string(path).unwrap()), false).unwrap();
    let json = scene.resolve().unwrap_err().to_json();
    insta::assert_snapshot!(serde_json::to_string_pretty(&json).unwrap());
}

#[test]
fn a_scene_built_in_rust_has_faults_without_places() {
    let faults = Scene::new("empty").gravity([0.0, f64::NAN]).resolve().unwrap_err();
    let codes: Vec<&str> = faults.list.iter().map(|fault| fault.code).collect();
    assert_eq!(codes, ["scene::not_finite", "scene::no_bodies"]);
    assert!(faults.render(false, 80).contains("`gravity` is not a finite number"));
}

#[test]
fn a_law_that_divides_by_zero_is_reported_at_its_place() {
    let text = [
        "name = \"press\"\n[inputs]\ngas_force = { start = \"1 N\" }\n[bodies.slider]\nmass = 1.0",
        "[joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"slider\"]\naxis = [1, 0]",
        "[loads.gas]\ntype = \"force\"\non = \"slider\"\nvector = [\"-gas_force/0\", 0.0]",
    ];
    let found = faults(Source::new("press.toml", text.join("\n")), false).unwrap().render(false, 100);
    for part in ["`gas`", "divides by zero", "press.toml:13:"] {
        assert!(found.contains(part), "{part}: {found}");
    }
}

#[test]
fn files_that_are_no_text_are_faults() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, b"name = \"a\"\n# \xff").unwrap();
    assert_eq!(Scene::read(&path).unwrap_err().list[0].code, "scene::not_utf8");
    assert_eq!(Scene::read(folder.path().join("none.toml")).unwrap_err().list[0].code, "scene::unreadable");
}

/// As other programs save it: the message says which encoding it is, and where.
#[test]
fn texts_in_other_encodings_are_faults_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let fault = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let fault = Scene::read(&path).unwrap_err().list.remove(0);
        assert_eq!(fault.code, "scene::not_utf8", "{}", fault.message);
        assert!(fault.help.starts_with("save it as UTF-8"), "{}", fault.help);
        fault.message
    };
    let text = "name = \"lever\"\n# of steel, with two holes\n";
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    for bytes in [[&[0xff, 0xfe][..], &little].concat(), [&[0xfe, 0xff][..], &big].concat(), little, big] {
        assert!(fault(&bytes).contains("UTF-16"));
    }
    let latin = fault(b"name = \"lever\"\ndescription = \"B\xfcgel\"\n");
    assert!(latin.contains("line 2, column 17") && latin.ends_with("it is `\u{fc}`"), "{latin}");
}

/// One body with ten uses of a name that is not there.
#[test]
fn a_missing_name_is_one_fault() {
    let mut text = String::from("name = \"x\"\n[bodies.a]\nmass = 1\n");
    for index in 0..10 {
        text += &format!("[joints.j{index}]\ntype = \"revolute\"\nbetween = [\"a\", \"missing\"]\n");
    }
    let faults = faults(Source::new("", text), false).unwrap();
    let codes: Vec<&str> = faults.list.iter().map(|fault: &Fault| fault.code).collect();
    assert_eq!(codes, ["scene::unknown_body"]);
}

#[test]
fn big_files_are_read_and_reported() {
    let mut text = String::from("name = \"big\"\n[bodies.a]\nmass = 1\n[outputs]\nvariables = [");
    for index in 0..600_000 {
        text += &format!("\"nobody{index}.x\",");
    }
    text += "]\n";
    assert!(text.len() > 10_000_000);
    let faults = faults(Source::new("big.toml", text), false).unwrap();
    assert!(faults.omitted > 500_000);
    assert!(faults.render(false, 100).len() < 200_000);
}

#[test]
fn deep_nesting_does_not_exhaust_the_stack() {
    let depth = 200_000;
    let texts = [
        format!("a = {}", "[".repeat(depth)),
        format!("a{} = 1", ".a".repeat(depth)),
        format!("[{}]", vec!["a"; depth].join(".")),
        "[".repeat(depth),
        format!("a = {}", "{a=".repeat(depth)),
        format!("{{\"a\": {}", "[".repeat(depth)),
        "{\"a\":".repeat(depth),
        format!("name = \"a\"\n[bodies.b]\nmass = \"{}1\"", "1+".repeat(depth)),
        format!("name = \"a\"\n[bodies.b]\nmass = \"{}1\"", "(".repeat(depth)),
    ];
    for text in texts {
        assert!(faults(Source::new("deep", text), false).is_some());
    }
}

fn never_panics(text: String) {
    for json in [false, true] {
        if let Some(faults) = faults(Source::new("fuzz", text.clone()), json) {
            faults.render(true, 60);
            faults.to_json();
        }
    }
}

const SLIDER_CRANK: [&str; 2] = [include_str!("scenes/slider_crank.toml"), include_str!("scenes/slider_crank.json")];

/// Words that are likely to mean something somewhere.
const WORDS: [&str; 24] = [
    "1e999",
    "nan",
    "-1",
    "0",
    "\"",
    "'",
    "[",
    "]",
    "{",
    "}",
    "=",
    "\n",
    "crank",
    "ground",
    ".x",
    "t",
    "\"1 m\"",
    "\"a+b\"",
    "[bodies.a]\n",
    "type",
    "µ",
    "^",
    "if(",
    "\\u00b5",
];

proptest! {
    #[test]
    fn random_text_never_panics(text in "\\PC*") {
        never_panics(text);
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        never_panics(String::from_utf8_lossy(&bytes).into_owned());
    }

    #[test]
    fn random_expressions_never_panic(text in "[-+*/^()., <>=a-z0-9µ]{0,30}") {
        never_panics(format!("name = \"x\"\n[parameters]\na = \"2 m\"\n[bodies.b]\nmass = 1\n[outputs]\no = '{text}'\np = '2 {text}'\n"));
    }

    #[test]
    fn mutated_scenes_never_panic(
        json in any::<bool>(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0usize..12, 0..WORDS.len()), 1..6),
    ) {
        let mut text: Vec<char> = SLIDER_CRANK[usize::from(json)].chars().collect();
        for (place, removed, word) in edits {
            let start = place.index(text.len());
            let end = (start + removed).min(text.len());
            text.splice(start..end, WORDS[word].chars());
        }
        never_panics(text.into_iter().collect());
    }
}
