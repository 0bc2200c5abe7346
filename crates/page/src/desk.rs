//! From a text to what a drawing page asks about it: what is wrong, the page that moves, linkages, the FMU. An answer is bytes: a JSON text, a page or an FMU; or what is wrong, as JSON.
//!
//! The WebAssembly module in `tools/front` answers with these inside a page, the server in the folder `serve` beside it.

use cotree::export::FmiVersion;
use cotree::export::runtime::Runtime;
use cotree::import::{ImportOptions, import_file};
use cotree::model::identifier;
use cotree::scene::{Edit, Faults, edited};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::{Made, moving, sketch};

/// An answer, or what is wrong.
pub type Answer = Result<Vec<u8>, Value>;

/// What FMUs carry beside the model.
#[derive(Default)]
pub struct Desk {
    pub runtimes: Vec<Runtime>,
    /// The runtime for browsers, for the page in an FMU.
    pub module: Option<Vec<u8>>,
}

/// What is wrong with a scene, the mechanism at its start, where its numbers are written.
pub fn look(text: &str) -> Vec<u8> {
    sketch::look(text).to_string().into_bytes()
}

/// A text and what shall change in it.
#[derive(Deserialize)]
struct Edits {
    text: String,
    edits: Vec<Edit>,
}

/// A text after edits, both in JSON.
///
/// # Errors
/// An edit that does not fit the text.
pub fn edit(request: &str) -> Answer {
    let Edits { text, edits } = serde_json::from_str(request).map_err(|error| failed(&error))?;
    edited(&text, &edits).map(String::into_bytes).map_err(|error| failed(&error))
}

/// The page of a scene, without its solver, which the page around it lends.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn page(text: &str) -> Answer {
    let scene = sketch::scene(text).map_err(|faults| faulty(&faults))?;
    let (_, page) = moving::page(&scene, Some(Vec::new())).map_err(|faults| faulty(&faults))?;
    page.map(|page| page.html().into_bytes()).map_err(|why| failed(&why))
}

/// The linkages for a task.
pub fn answers(text: &str) -> Vec<u8> {
    sketch::answers(text).to_string().into_bytes()
}

/// The scene of a file of another program: a robot, a drawing or a linkage. It is the first of the files that the page was given, each as its name, its length and its bytes,
/// with a zero byte after name and length; the others are those that it includes.
///
/// # Errors
/// Everything that keeps it from being read.
pub fn import(room: &[u8]) -> Answer {
    let files = files(room).ok_or_else(|| failed(&"the files of the page are cut short"))?;
    let [(main, bytes), others @ ..] = &files[..] else { return Err(failed(&"there is no file")) };
    let included = |path: &str| {
        let base = |name: &str| name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned();
        let file = others.iter().find(|(name, _)| name == path);
        file.or_else(|| others.iter().find(|(name, _)| base(name) == base(path))).map(|(_, bytes)| bytes.to_vec())
    };
    let name = identifier(main.split('.').next().unwrap_or(main));
    let imported = import_file(&name, main, bytes, &ImportOptions::default(), &included);
    let imported = imported.map_err(|refusals| {
        let fault = |refusal: &String| {
            let (message, help) = refusal.split_once("\n  help: ").unwrap_or((refusal, ""));
            let help = (!help.is_empty()).then_some(help);
            json!({ "severity": "error", "message": message, "help": help })
        };
        json!({ "faults": refusals.iter().map(fault).collect::<Vec<_>>(), "omitted": 0 })
    })?;
    Ok(json!({ "scene": imported.scene, "notes": imported.notes }).to_string().into_bytes())
}

/// Files one after another.
fn files(mut room: &[u8]) -> Option<Vec<(String, &[u8])>> {
    let mut files = Vec::new();
    while !room.is_empty() {
        let mut word = || {
            let (word, rest) = room.split_at(room.iter().position(|byte| *byte == 0)?);
            room = &rest[1..];
            Some(String::from_utf8_lossy(word).into_owned())
        };
        let (name, length) = (word()?, word()?.parse().ok()?);
        let (bytes, rest) = room.split_at_checked(length)?;
        files.push((name, bytes));
        room = rest;
    }
    Some(files)
}

/// The models that a drawing can start from.
pub fn gallery() -> Vec<u8> {
    let models = cotree::gallery::MODELS
        .iter()
        .filter(|(name, _)| cotree::gallery::FILES.iter().all(|(model, ..)| model != name));
    let models: Vec<Value> = models.map(|(name, text)| json!({ "name": name, "text": text })).collect();
    Value::Array(models).to_string().into_bytes()
}

impl Desk {
    /// The FMU of a scene, for the platforms of the runtimes.
    ///
    /// # Errors
    /// Everything that is wrong with the scene, or why there is no FMU of it.
    pub fn fmu(&self, text: &str, version: FmiVersion) -> Answer {
        let made = sketch::scene(text).and_then(|scene| Made::of(&scene, false)).map_err(|faults| faulty(&faults))?;
        let packed = made.extras(version, self.module.clone());
        let packed = packed.and_then(|extras| made.compiled.pack_fmu(version, extras, &self.runtimes));
        packed.map_err(|error| failed(&error))
    }
}

fn faulty(faults: &Faults) -> Value {
    sketch::told(Some(faults))
}

/// What is wrong beside the scene, as faults of one are told.
pub fn failed(what: &impl ToString) -> Value {
    json!({ "faults": [{ "severity": "error", "message": what.to_string() }], "omitted": 0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room(files: &[(&str, &str)]) -> Vec<u8> {
        files.iter().flat_map(|(name, text)| format!("{name}\0{}\0{text}", text.len()).into_bytes()).collect()
    }

    /// An included file is one that was given together with the main one; without it, its name is in the answer.
    #[test]
    fn robots_are_imported_with_the_files_that_they_include() {
        let arm = "<mujoco><include file=\"parts/weights.xml\"/><worldbody><body name=\"arm\"><joint name=\"pin\" axis=\"0 1 0\"/><geom size=\"0.1\"/></body></worldbody></mujoco>";
        let weights = "<mujoco><default><geom density=\"2000\"/></default></mujoco>";
        let answer = import(&room(&[("my arm.xml", arm), ("weights.xml", weights)])).unwrap();
        let answer: Value = serde_json::from_slice(&answer).unwrap();
        let scene = answer["scene"].as_str().unwrap();
        assert!(scene.contains("name   = \"my_arm\"") && scene.contains("mass    = 8.377"), "{scene}");
        assert!(answer["notes"][0].as_str().unwrap().starts_with("MJCF: 1 body"), "{answer}");
        let alone = import(&room(&[("arm.xml", arm)])).unwrap_err();
        assert!(
            alone["faults"][0]["message"].as_str().unwrap().contains("`parts/weights.xml` cannot be read"),
            "{alone}"
        );
        assert!(alone["faults"][0]["help"].as_str().unwrap().contains("beside"), "{alone}");
        for cut in [&b"arm.xml"[..], b"arm.xml\x0050\0<muj", b""] {
            assert!(import(cut).is_err());
        }
    }
}
