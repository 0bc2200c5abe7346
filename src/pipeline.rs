//! From a scene file to everything that the commands need.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Arc;

use cotree_fmu::check;
use cotree_fmu::model::Model;
use cotree_fmu::program::Program;

use crate::equations::Equations;
use crate::export::ExportError;
use crate::export::archive::{self, Package, SceneText};
use crate::export::describe::describe;
use crate::export::description::Description;
use crate::export::page::Page;
use crate::export::runtime::Runtime;
use crate::expr::Property;
use crate::formulate::{Formulated, formulate, formulate_written, lacking};
use crate::mechanism::Unit;
use crate::print::{self, Prose};
use crate::report::accuracy::{self, Accuracy};
use crate::report::assumptions::assumptions;
use crate::report::compare::{Comparison, compare};
use crate::report::drawing::Drawing;
use crate::report::figures::summarise;
use crate::report::graph::GraphDrawing;
use crate::report::pose::draw;
use crate::report::summary::Summary;
use crate::scene::{Fault, Faults, Reading, Resolved, Scene, Source, Span, Text, read};
use crate::simulation::{Run, RunError, reported};

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
    /// The equations of motion, as HTML.
    pub equations: String,
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
    /// A LaTeX document.
    Latex,
    /// A self-contained HTML page with MathML.
    Html,
    /// C99.
    C,
    /// A module in Fortran 2008.
    Fortran,
    /// Rust, without any crate.
    Rust,
    /// Python with numpy.
    Python,
    /// For other programs.
    Json,
}

/// Formulates the equations of a scene and lowers them.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn compile(scene: &Scene) -> Result<Compiled, Faults> {
    let Resolved { mechanism, mut warnings } = scene.resolve()?;
    let faults = |list: Vec<Fault>| Faults::new(scene.source.clone(), list);
    let mut formulated = formulate(&mechanism).map_err(faults)?;
    warnings.append(&mut formulated.warnings);
    let mut program = formulated.lowered.program.clone();
    let bytes = program.to_bytes().map_err(|error| faults(vec![internal(&error.to_string())]))?;
    program.guid = guid(&bytes);
    program.check().map_err(|fault| faults(vec![impossible(&fault)]))?;
    Ok(Compiled {
        description: describe(&formulated, &program.guid),
        drawing: draw(&mut formulated),
        equations: equations_for_the_page(&mut formulated.equations),
        summary: summarise(&formulated),
        assumptions: assumptions(&mut formulated),
        warnings: (!warnings.is_empty()).then(|| faults(warnings)),
        source: scene.source.clone(),
        program,
    })
}

/// As [`compile`], with every variable that can be computed among the outputs. A warning says which cannot, and why.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn compile_everything(scene: &Scene) -> Result<Compiled, Faults> {
    let mut whole = scene.with_every_output();
    let mechanism = whole.resolve()?.mechanism;
    let lacking = lacking(&mechanism).map_err(|list| Faults::new(scene.source.clone(), list))?;
    let mut left_out: BTreeMap<(usize, Property), Vec<&str>> = BTreeMap::new();
    for (output, body, property) in lacking {
        if !scene.outputs.variables.iter().any(|asked| asked.text == output.name) {
            whole.outputs.variables.retain(|variable| variable.text != output.name);
            left_out.entry((body, property)).or_default().push(&output.name);
        }
    }
    let mut compiled = compile(&whole)?;
    let warnings = left_out.iter().map(|(&(body, property), names)| {
        let key = if property == Property::Mass { "mass" } else { "inertia" };
        let owner = &mechanism.bodies[body];
        let message = format!("left out, because body `{}` has no `{key}`: {}", owner.name, listed(names));
        Fault::warning("scene::left_out", message, owner.span)
            .label(format!("has no `{key}`"))
            .help(format!("add `{key} = ...` to `[bodies.{}]` if you want them", owner.name))
    });
    let warnings: Vec<Fault> =
        compiled.warnings.take().into_iter().flat_map(|known| known.list).chain(warnings).collect();
    compiled.warnings = (!warnings.is_empty()).then(|| Faults::new(scene.source.clone(), warnings));
    Ok(compiled)
}

/// Names, unless they are many: then some of them.
fn listed(names: &[&str]) -> String {
    const MOST: usize = 12;
    match names.len().checked_sub(MOST) {
        None | Some(0) => names.join(", "),
        Some(more) => format!("{} and {more} more", names[..MOST].join(", ")),
    }
}

/// More equations than this nobody reads on a page.
const MOST_EQUATIONS: usize = 40;

/// The equations of motion as MathML, if they are few enough to be read.
fn equations_for_the_page(equations: &mut Equations) -> String {
    let count = equations.coordinates.len() + equations.constraints.len();
    if count > MOST_EQUATIONS { String::new() } else { print::mathml(equations) }
}

/// The equations of a scene.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn equations(scene: &Scene, notation: Notation) -> Result<String, Faults> {
    let mechanism = scene.resolve()?.mechanism;
    let formulated = formulate_written(&mechanism).map_err(|list| Faults::new(scene.source.clone(), list))?;
    let Formulated { mut equations, lowered, redundant, .. } = formulated;
    Ok(match notation {
        Notation::Text => print::motion(&mut equations, Prose::Text),
        Notation::Latex => print::motion(&mut equations, Prose::Latex),
        Notation::Html => print::motion(&mut equations, Prose::Html),
        Notation::C => print::code(&mut equations, &lowered.solved, &redundant, &print::C),
        Notation::Fortran => print::code(&mut equations, &lowered.solved, &redundant, &print::Fortran),
        Notation::Rust => print::code(&mut equations, &lowered.solved, &redundant, &print::Rust),
        Notation::Python => print::code(&mut equations, &lowered.solved, &redundant, &print::Python),
        Notation::Json => print::json(&mut equations),
    })
}

/// How a scene derives its equations, as a lesson.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn steps(scene: &Scene, prose: Prose) -> Result<String, Faults> {
    let mechanism = scene.resolve()?.mechanism;
    let formulated = formulate_written(&mechanism).map_err(|list| Faults::new(scene.source.clone(), list));
    Ok(print::steps(&mut formulated?.equations, prose))
}

/// The linear graphs of a scene with their trees, and the mechanism at its start.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn graph(scene: &Scene) -> Result<(GraphDrawing, Drawing), Faults> {
    let mechanism = scene.resolve()?.mechanism;
    let mut formulated = formulate(&mechanism).map_err(|list| Faults::new(scene.source.clone(), list))?;
    Ok((GraphDrawing::new(&mut formulated), draw(&mut formulated)))
}

/// What the scene costs in other coordinates.
///
/// # Errors
/// Everything that is wrong with the scene; trees that do not work are part of the comparison.
pub fn comparison(scene: &Scene) -> Result<Comparison, Faults> {
    Ok(compare(&scene.resolve()?.mechanism))
}

/// A name for these very bytes: their 128-bit FNV-1a hash, written as a GUID.
fn guid(bytes: &[u8]) -> String {
    const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    let hash = bytes.iter().fold(OFFSET, |hash, &byte| (hash ^ u128::from(byte)).wrapping_mul(PRIME));
    let digits = format!("{hash:032x}");
    let parts = [&digits[..8], &digits[8..12], &digits[12..16], &digits[16..20], &digits[20..]];
    format!("{{{}}}", parts.join("-"))
}

/// What the runtime would refuse.
fn impossible(fault: &check::Fault) -> Fault {
    let check::Fault::Value { what } = fault else {
        return internal(&fault.to_string());
    };
    let message = format!("the numbers of this scene are too large or too small to compute with: {what} is not finite");
    Fault::new("scene::out_of_range", message, Span::default())
        .help("look for a mass, an inertia, a length or a stiffness with a wrong unit or power of ten")
}

/// Something that no scene should be able to cause.
fn internal(what: &str) -> Fault {
    Fault::new("cotree::internal", format!("the program cannot be written: {what}"), Span::default())
        .help("this is a fault of cotree, not of the scene: please report it with the scene file")
}

/// Reads a number, alone (SI) or with a unit, for a variable of the given unit; the empty unit takes any.
///
/// # Errors
/// What is wrong with the text.
pub fn quantity(text: &str, unit: &Unit) -> Result<f64, String> {
    let reading = read(&Text::from(text)).map_err(|fault| fault.message)?;
    match reading {
        Reading::Number(value) => Ok(value),
        Reading::Measure(value, given) if given.exponents == unit.exponents || unit.si.is_empty() => Ok(value),
        Reading::Measure(..) => Err(format!("`{text}` is not in {} or a unit of the same kind", unit.si)),
        Reading::Expression => Err(format!("`{text}` is not a number, alone or with a unit")),
    }
}

impl Scene {
    /// Writes the scene as a self-contained FMU for the platform that this program runs on.
    ///
    /// # Errors
    /// Everything that is wrong with the scene, or a file that cannot be written.
    pub fn export_fmu(&self, path: impl AsRef<Path>) -> Result<(), ExportFailure> {
        let runtime = Runtime::embedded().map_err(ExportError::from)?;
        Ok(compile(self)?.write_fmu(&[runtime], path.as_ref())?)
    }
}

/// Why there is no FMU.
#[derive(Debug, thiserror::Error)]
pub enum ExportFailure {
    /// The scene is at fault.
    #[error(transparent)]
    Scene(#[from] Faults),
    /// The file is.
    #[error(transparent)]
    File(#[from] ExportError),
}

impl Compiled {
    /// Writes the FMU, for the platforms of the runtimes.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_fmu(&self, runtimes: &[Runtime], path: &Path) -> Result<(), ExportError> {
        let is_json = self.source.text.trim_start().starts_with('{');
        let extension = if is_json { "json" } else { "toml" };
        let package = Package {
            description: &self.description,
            program: &self.program.to_bytes()?,
            scene: (!self.source.text.is_empty()).then_some(SceneText { extension, text: &self.source.text }),
            page: Page { drawing: &self.drawing, equations: &self.equations, accuracy: &self.accuracy() },
            runtimes,
        };
        archive::write(&package, path)
    }

    /// Runs the experiment of the scene with the code that runs in the FMU: hands over time and the values of
    /// [`Compiled::reported`] at every communication point.
    ///
    /// # Errors
    /// The motion cannot be continued, or `report` fails.
    pub fn simulate(&self, report: impl FnMut(f64, &[f64]) -> io::Result<()>) -> Result<(), RunError> {
        let model = Arc::new(Model::new(self.program.clone())?);
        let (experiment, reported) = (self.description.experiment, self.reported());
        Run { description: &self.description, experiment, settings: Vec::new(), inputs: None, reported }
            .start(model, report)
    }

    /// What a simulation reports: indices of variables of the description.
    pub fn reported(&self) -> Vec<usize> {
        reported(&self.description)
    }

    /// What accuracy costs with this model.
    ///
    /// # Errors
    /// Why it cannot be measured.
    pub fn accuracy(&self) -> Result<Accuracy, String> {
        let model = Model::new(self.program.clone()).map_err(|fault| fault.to_string())?;
        let measured = accuracy::measure(&Arc::new(model), &self.reported(), self.description.experiment);
        measured.map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metre() -> Unit {
        Unit { exponents: [0, 1, 0, 0], si: "m".into(), display: None }
    }

    #[test]
    fn masses_beyond_all_bounds_are_faults_of_the_scene() {
        let text = include_str!("../models/slider_crank/scene.toml").replace("mass = 3.0", "mass = 1e308");
        let faults = compile(&Scene::from_toml(&text).unwrap()).unwrap_err().to_json().to_string();
        assert!(faults.contains("scene::out_of_range") && faults.contains("power of ten"), "{faults}");
    }

    #[test]
    fn quantities_are_numbers_with_the_right_unit() {
        assert_eq!(quantity("1.5", &metre()), Ok(1.5));
        assert_eq!(quantity("120 mm", &metre()), Ok(0.12));
        for (text, message) in
            [("3 kg", "not in m"), ("2*l", "not a number"), ("", "not a number"), ("2 furlong", "furlong")]
        {
            let error = quantity(text, &metre()).unwrap_err();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
