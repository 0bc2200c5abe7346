//! From a scene file to everything that the commands need.

use std::path::Path;

use cotree_fmu::program::Program;

use crate::export::archive::{Package, SceneText};
use crate::export::description::Description;
use crate::mechanism::Unit;
use crate::report::drawing::Drawing;
use crate::report::summary::Summary;
use crate::scene::{Fault, Faults, Scene, Source, Span};

/// A scene, compiled.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// What the runtime runs.
    pub program: Program,
    /// What an importer is told; the same variables in the same order as in the program.
    pub description: Description,
    /// The mechanism at its start.
    pub drawing: Drawing,
    /// Its figures.
    pub summary: Summary,
    /// What was assumed because the scene does not say it, one sentence each.
    pub assumptions: Vec<String>,
    /// What is odd but no error.
    pub warnings: Option<Faults>,
    /// The text that the scene came from; empty if it was built in Rust.
    pub source: Source,
}

/// How equations are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// For people.
    Text,
    /// C99.
    C,
}

/// Reads a scene file: JSON if its name ends in `.json`, otherwise TOML.
pub fn load(path: &Path) -> Result<Scene, Faults> {
    let _ = path;
    Err(Faults::new(
        Source::default(),
        vec![Fault::new("pipeline::load", "not yet", Span::default())],
    ))
}

/// Formulates the equations of a scene and lowers them.
pub fn compile(scene: &Scene) -> Result<Compiled, Faults> {
    Err(Faults::new(
        scene.source.clone(),
        vec![Fault::new("pipeline::compile", "not yet", Span::default())],
    ))
}

/// The equations of a scene.
pub fn equations(scene: &Scene, notation: Notation) -> Result<String, Faults> {
    compile(scene).map(|compiled| format!("{notation:?} {}", compiled.summary.name))
}

/// Reads a number, alone (SI) or with a unit, for a variable of the given unit.
pub fn quantity(text: &str, unit: &Unit) -> Result<f64, String> {
    text.trim()
        .parse()
        .map_err(|_| format!("`{text}` is not a number in {}", unit.si))
}

impl Compiled {
    /// What goes into the FMU; `program` is the program as bytes.
    pub fn package<'a>(&'a self, program: &'a [u8]) -> Package<'a> {
        let extension = if self.source.name.ends_with(".json") {
            "json"
        } else {
            "toml"
        };
        let scene = (!self.source.text.is_empty()).then_some(SceneText {
            extension,
            text: &self.source.text,
        });
        Package {
            description: &self.description,
            program,
            scene,
            drawing: &self.drawing,
        }
    }
}
