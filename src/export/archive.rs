//! The FMU file: a zip archive with the same bytes for the same contents.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::description::Description;
use super::page::Page;
use super::runtime::Runtime;
use super::{ExportError, icon, xml};
use crate::files;

const LICENSE: &str = include_str!("license.txt");
const APACHE: &str = include_str!("apache-2.0.txt");

/// What goes into an FMU.
#[derive(Clone, Debug)]
pub struct Package<'a> {
    /// Its description.
    pub description: &'a Description,
    /// The program as the runtime reads it.
    pub program: &'a [u8],
    /// The text that the scene came from, if it came from a file.
    pub scene: Option<SceneText<'a>>,
    /// What its documentation shows.
    pub page: Page<'a>,
    /// The runtimes, one for each platform that the FMU is to run on.
    pub runtimes: &'a [Runtime],
}

/// The text of a scene file.
#[derive(Clone, Copy, Debug)]
pub struct SceneText<'a> {
    /// `toml` or `json`.
    pub extension: &'a str,
    /// The text.
    pub text: &'a str,
}

/// Packs an FMU and writes it to a file: all of it or nothing.
pub fn write(package: &Package, path: &Path) -> Result<(), ExportError> {
    let bytes = pack(package)?;
    files::write(path, &bytes).map_err(|error| ExportError::Write { path: path.display().to_string(), error })
}

/// The bytes of an FMU.
pub fn pack(package: &Package) -> Result<Vec<u8>, ExportError> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::DEFAULT);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in entries(package)? {
        let permissions = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        zip.start_file(name, options.unix_permissions(permissions))?;
        zip.write_all(&content).map_err(zip::result::ZipError::from)?;
    }
    Ok(zip.finish()?.into_inner())
}

/// Every file of the FMU, by name.
fn entries(package: &Package) -> Result<BTreeMap<String, Vec<u8>>, ExportError> {
    let description = xml::model_description(package.description).map_err(ExportError::Description)?;
    let mut entries = BTreeMap::from([
        ("modelDescription.xml".to_owned(), description),
        ("model.png".to_owned(), icon::png(package.page.drawing)?),
        ("resources/program.bin".to_owned(), package.program.to_vec()),
        ("documentation/index.html".to_owned(), package.page.html(package.description).into_bytes()),
        ("documentation/licenses/license.txt".to_owned(), LICENSE.into()),
        ("documentation/licenses/apache-2.0.txt".to_owned(), APACHE.into()),
    ]);
    for Runtime { platform, library } in package.runtimes {
        let identifier = &package.description.identifier;
        let name = format!("binaries/{}/{identifier}.{}", platform.folder, platform.extension);
        entries.insert(name, library.to_vec());
    }
    if let Some(scene) = package.scene {
        entries.insert(format!("resources/scene.{}", scene.extension), scene.text.into());
    }
    Ok(entries)
}
