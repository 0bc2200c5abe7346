//! `buildDescription.xml`: how an importer compiles the sources of an FMU (FMI 3.0, 2.5.3).

use std::io;

use super::{document, element, leaf};
use crate::export::description::{Description, SourceSolver};

/// The document.
pub fn build_description(description: &Description, sources: &SourceSolver) -> io::Result<Vec<u8>> {
    document("fmiBuildDescription", vec![("fmiVersion", "3.0".to_owned())], |out| {
        let model = ("modelIdentifier", description.identifier.clone());
        element(out, "BuildConfiguration", vec![model], |out| {
            element(out, "SourceFileSet", vec![("language", "C99".to_owned())], |out| {
                leaf(out, "SourceFile", vec![("name", sources.compiled.to_owned())])
            })
        })
    })
}
