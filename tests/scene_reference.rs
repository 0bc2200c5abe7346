//! The reference of the scene and the table of components are made from what the components say of themselves.
//!
//! `COTREE_WRITE_REFERENCE=1 cargo test --test library scene_reference::` writes both.

use crate::support::ROOT;
use std::path::{Path, PathBuf};

use cotree::component::{examples, reference};
use cotree::model::{Mechanism, Part};
use cotree::network::System;
use cotree::scene::Scene;

/// What the examples use.
const BASE: &str = r#"
name = "example"
parameters = { k = 1, l0 = 1, c = 1, tau = 1 }
inputs = { gas_force = 0 }
ground.points = { bearing = [0, 0] }
[bodies]
crank = { mass = 1, inertia = 1, points = { inner = [0, 0], outer = [1, 0] } }
rod = { mass = 1, inertia = 1 }
slider = { mass = 1, inertia = 1 }
[joints]
pin = { type = "revolute", between = ["ground", "crank.inner"] }
guide = { type = "prismatic", between = ["ground", "slider"], axis = [1, 0] }
"#;

fn docs(name: &str) -> PathBuf {
    Path::new(ROOT).join("docs").join(name)
}

/// Compares a file, or writes it.
fn compare(name: &str, expected: &str) {
    if std::env::var_os("COTREE_WRITE_REFERENCE").is_some() {
        std::fs::write(docs(name), expected).unwrap();
    }
    let text = std::fs::read_to_string(docs(name)).unwrap();
    let line = text.lines().zip(expected.lines()).position(|(is, wanted)| is != wanted);
    assert!(
        text == expected,
        "docs/{name} is not what the components say from line {:?} on; write it anew with COTREE_WRITE_REFERENCE=1",
        line.map(|line| line + 1)
    );
}

#[test]
fn the_reference_is_what_the_components_say() {
    compare("scene-reference.md", &reference());
}

#[test]
fn every_example_is_a_sound_scene() {
    for (_, name, example) in examples() {
        mechanism(name, &example);
    }
}

/// The example with names of the scene in the place of words.
fn named(example: &str) -> String {
    let driven = if example.contains("displacement =") { "\"guide\"" } else { "\"pin\"" };
    let words = [
        ("[\"BODY.POINT\", \"BODY.POINT\"]", "[\"ground.bearing\", \"crank.inner\"]"),
        ("[\"BODY\", \"BODY.POINT\"]", "[\"crank\", \"slider\"]"),
        ("[\"BODY\", \"BODY\"]", "[\"crank\", \"rod\"]"),
        ("guide = \"JOINT\"", "guide = \"guide\""),
        ("shaft = \"JOINT\"", "shaft = \"pin\""),
        ("\"JOINT\"", driven),
        ("\"BODY.POINT\"", "\"slider\""),
        ("\"BODY\"", "\"crank\""),
    ];
    words.iter().fold(example.to_owned(), |text, (word, name)| text.replace(word, name))
}

fn mechanism(name: &str, example: &str) -> Mechanism {
    let scene = Scene::from_toml(&format!("{BASE}{}", named(example)));
    let resolved = scene.and_then(|scene| scene.resolve());
    resolved.unwrap_or_else(|faults| panic!("{name}: {}\n{example}", faults.render(false, 100))).mechanism
}

/// A row of the table: priorities in Tables 2 and 3, and how many degrees of freedom the component takes.
fn row(section: &str, name: &str, example: &str) -> String {
    let mechanism = mechanism(name, example);
    let is_example = |part: &&Part| part.name == "example";
    let part = mechanism.parts().find(is_example).unwrap();
    let index = mechanism.bodies.len() + mechanism.ground.len();
    let system = System::new(&mechanism);
    let element = system.elements[index..].iter().find(|element| element.name == part.name).unwrap();
    let priority = |priority: Option<u8>| priority.map_or("-".to_string(), |priority| priority.to_string());
    let t = priority(element.translation.as_ref().map(|row| row.priority));
    let r = priority(element.rotation.as_ref().map(|row| row.priority));
    let held = element.translation.as_ref().map_or(0, |row| row.reaction.len());
    let turned = element.rotation.as_ref().is_some_and(|row| !matches!(row.angle, cotree::network::Angle::Free(_)));
    let taken = held + usize::from(turned) + usize::from(element.coupling.is_some());
    let taken = if taken == 0 { String::new() } else { taken.to_string() };
    let (t, r) =
        if element.coupling.is_some() && t == "-" && r == "-" { ("never".into(), "never".into()) } else { (t, r) };
    let key = if section == "driver" { format!("`{name} = ...`") } else { format!("`type = \"{name}\"`") };
    format!("| {section} | [{key}](scene-reference.md#{}) | {t} | {r} | {taken} |", anchor(section, name))
}

/// The anchor of a chapter of the reference.
fn anchor(section: &str, name: &str) -> String {
    let heading = if section == "driver" { "with-the-key" } else { "of-type" };
    format!("{section}-{heading}-{name}")
}

#[test]
fn the_table_of_components_is_what_their_rows_say() {
    let begin = "<!-- the table: tests/scene_reference.rs -->\n";
    let end = "<!-- end of the table -->\n";
    let text = std::fs::read_to_string(docs("components.md")).unwrap();
    let (before, rest) = text.split_once(begin).unwrap();
    let (_, after) = rest.split_once(end).unwrap();
    let mut table = String::from(
        "| | key | T priority | R priority | degrees of freedom taken |\n|---|---|---|---|---|\n\
         | body | [`[bodies.x]`](#rigid-body) | 5 | 3 with points in use, else 4 | |\n\
         | arm, ground vector | [a point that something uses](#rigid-arm-ground-vector) | 1 | - | |\n",
    );
    for (section, name, example) in examples() {
        table += &row(section, name, &example);
        table.push('\n');
    }
    compare("components.md", &format!("{before}{begin}{table}{end}{after}"));
    let reference = reference();
    for (section, name, _) in examples() {
        let heading = format!(
            "### {} {} `{name}`",
            section[..1].to_uppercase() + &section[1..],
            if section == "driver" { "with the key" } else { "of type" }
        );
        assert!(reference.contains(&heading), "{heading}");
    }
}
