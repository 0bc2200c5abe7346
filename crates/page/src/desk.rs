//! From a text to what a drawing page asks about it: what is wrong, the page that moves, linkages, the FMU. An answer is bytes: a JSON text, a page or an FMU; or what is wrong, as JSON.
//!
//! The WebAssembly module in `tools/front` answers with these inside a page, the server in the folder `serve` beside it.

use cotree::export::FmiVersion;
use cotree::export::runtime::Runtime;
use cotree::scene::Faults;
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

/// The models that a drawing can start from.
pub fn gallery() -> Vec<u8> {
    let models =
        cotree::gallery::MODELS.iter().filter(|(name, _)| cotree::gallery::FILES.iter().all(|(own, ..)| own != name));
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
