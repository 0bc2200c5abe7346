//! From a scene file to everything that the commands need.

use std::path::Path;

use cotree_fmu::program::Program;

use crate::export::archive::{Package, SceneText};
use crate::export::description::Description;
use crate::mechanism::Unit;
use crate::report::drawing::Drawing;
use crate::report::summary::Summary;
use crate::scene::{Fault, Faults, Reading, Scene, Source, Span, Text, read};

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

/// Reads a scene file, TOML or JSON.
pub fn load(path: &Path) -> Result<Scene, Faults> {
    Scene::read(path)
}

/// Formulates the equations of a scene and lowers them.
pub fn compile(scene: &Scene) -> Result<Compiled, Faults> {
    let resolved = scene.resolve()?;
    Err(Faults::new(
        scene.source.clone(),
        vec![Fault::new(
            "pipeline::compile",
            format!(
                "the equations of `{}` are not formulated yet",
                resolved.mechanism.name
            ),
            Span::default(),
        )],
    ))
}

/// The equations of a scene.
pub fn equations(scene: &Scene, notation: Notation) -> Result<String, Faults> {
    compile(scene).map(|compiled| format!("{notation:?} {}", compiled.summary.name))
}

/// Reads a number, alone (SI) or with a unit, for a variable of the given unit; the empty unit takes any.
pub fn quantity(text: &str, unit: &Unit) -> Result<f64, String> {
    let reading = read(&Text::from(text)).map_err(|fault| fault.message)?;
    match reading {
        Reading::Number(value) => Ok(value),
        Reading::Measure(value, given)
            if given.exponents == unit.exponents || unit.si.is_empty() =>
        {
            Ok(value)
        }
        Reading::Measure(..) => Err(format!(
            "`{text}` is not in {} or a unit of the same kind",
            unit.si
        )),
        Reading::Expression => Err(format!("`{text}` is not a number, alone or with a unit")),
    }
}

impl Compiled {
    /// What goes into the FMU; `program` is the program as bytes.
    pub fn package<'a>(&'a self, program: &'a [u8]) -> Package<'a> {
        let is_json = self.source.text.trim_start().starts_with('{');
        let extension = if is_json { "json" } else { "toml" };
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

#[cfg(test)]
mod tests {
    use super::*;

    fn metre() -> Unit {
        Unit {
            exponents: [0, 1, 0, 0],
            si: "m".into(),
            display: None,
        }
    }

    #[test]
    fn quantities_are_numbers_with_the_right_unit() {
        assert_eq!(quantity("1.5", &metre()), Ok(1.5));
        assert_eq!(quantity("120 mm", &metre()), Ok(0.12));
        for (text, message) in [
            ("3 kg", "not in m"),
            ("2*l", "not a number"),
            ("", "not a number"),
            ("2 furlong", "furlong"),
        ] {
            let error = quantity(text, &metre()).unwrap_err();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
