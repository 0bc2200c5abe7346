//! From a scene to an FMU with everything that it can carry.

use std::path::Path;

use cotree::compile::{Compiled, compile_asking, everything};
use cotree::export::archive::Extra;
use cotree::export::runtime::Runtime;
use cotree::export::{ExportError, FmiVersion};
use cotree::scene::{Faults, Requested};
use cotree::{ExportFailure, Scene};

use crate::MotionlessError;
use crate::accuracy::{self, Accuracy};
use crate::documentation::DocumentationPage;
use crate::moving::{self, MotionOrigin};
use crate::overview::{Overview, overview};

/// An FMU but for its libraries: what the command, the Python package and the drawing page write, each from the same scene the same bytes.
#[derive(Clone, Debug)]
pub struct Made {
    /// With all that is odd about it.
    pub compiled: Compiled,
    /// What accuracy costs, or why that could not be measured.
    pub accuracy: Result<Accuracy, MotionlessError>,
    overview: Overview,
    scene: Scene,
}

impl Made {
    /// The model of a scene and what its accuracy costs; with `all`, every variable.
    ///
    /// # Errors
    /// Everything that is wrong with the scene.
    pub fn of(scene: &Scene, all: bool) -> Result<Self, Faults> {
        let (more, left_out) = if all { everything(scene)? } else { Default::default() };
        let (mut compiled, mut formulated) = compile_asking(scene, &Requested::Also(more))?;
        let overview = overview(&mut formulated);
        compiled.warn(left_out);
        let accuracy = accuracy::of(&compiled);
        accuracy::warn_of_growth(&mut compiled, &accuracy);
        accuracy::warn_of_end(&mut compiled, accuracy.as_ref().err().map(ToString::to_string));
        Ok(Made { compiled, accuracy, overview, scene: scene.clone() })
    }

    /// What it carries beside the model: its page, with the solver inside if there is a module for it, and its pictures.
    ///
    /// # Errors
    /// A picture cannot be drawn.
    pub fn extras(&self, version: FmiVersion, module: Option<Vec<u8>>) -> Result<Vec<Extra>, ExportError> {
        let Made { compiled, accuracy, overview: Overview { drawing, facts }, scene } = self;
        // A stored run may cost as much as the measurement of accuracy.
        let origin =
            module.map_or_else(|| MotionOrigin::Stored(accuracy::affordable(compiled, accuracy)), MotionOrigin::Solver);
        let live = &moving::documentation(scene, compiled, origin);
        DocumentationPage { drawing, facts, accuracy, live }.files(&compiled.description, version)
    }
}

/// Writes the scene as a self-contained FMU for the platform that this program runs on, with its page and its pictures.
///
/// # Errors
/// Everything that is wrong with the scene, or a file that cannot be written.
pub fn export_fmu(scene: &Scene, version: FmiVersion, path: impl AsRef<Path>) -> Result<(), ExportFailure> {
    let runtime = Runtime::embedded().map_err(ExportError::from)?;
    let made = Made::of(scene, false)?;
    let extras = made.extras(version, None)?;
    Ok(made.compiled.write_fmu(version, extras, &[runtime], path.as_ref())?)
}
