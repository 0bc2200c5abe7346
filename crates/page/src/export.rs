//! From a scene to an FMU with everything that it can carry.

use std::path::Path;

use cotree::compile::compile_with_equations;
use cotree::export::runtime::Runtime;
use cotree::export::{ExportError, FmiVersion};
use cotree::{ExportFailure, Scene};

use crate::accuracy;
use crate::documentation::Page;
use crate::moving::{self, Origin};
use crate::overview::overview;

/// Writes the scene as a self-contained FMU for the platform that this program runs on, with its page and its pictures.
///
/// # Errors
/// Everything that is wrong with the scene, or a file that cannot be written.
pub fn export_fmu(scene: &Scene, version: FmiVersion, path: impl AsRef<Path>) -> Result<(), ExportFailure> {
    let runtime = Runtime::embedded().map_err(ExportError::from)?;
    let (compiled, mut formulated) = compile_with_equations(scene)?;
    let overview = overview(&mut formulated);
    let accuracy = accuracy::of(&compiled);
    let live = moving::documentation(scene, &compiled, Origin::Stored(accuracy::affordable(&compiled, &accuracy)));
    let page = Page { drawing: &overview.drawing, facts: &overview.facts, accuracy: &accuracy, live: &live };
    let extras = page.files(&compiled.description, version)?;
    Ok(compiled.write_fmu(version, extras, &[runtime], path.as_ref())?)
}
