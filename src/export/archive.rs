//! The FMU file: a zip archive with the same bytes for the same contents.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::Path;

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipArchive, ZipWriter};

use super::description::Description;
use super::page::Page;
use super::runtime::{PACKED, Platform, Runtime};
use super::{ExportError, FmiVersion, icon, libraries, xml};
use crate::files;

const LICENSE: &str = include_str!("license.txt");
const APACHE: &str = include_str!("apache-2.0.txt");

/// What goes into an FMU.
#[derive(Clone, Debug)]
pub struct Package<'a> {
    /// The version of FMI.
    pub version: FmiVersion,
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
        // Wherever it is written: the same scene gives the same bytes.
        .system(System::Unix)
        .last_modified_time(DateTime::DEFAULT);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in entries(package)? {
        let permissions = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        match content {
            Content::Bytes(bytes) => {
                zip.start_file(name, options.unix_permissions(permissions))?;
                zip.write_all(&bytes).map_err(ZipError::from)?;
            }
            Content::OwnRuntime => {
                let mut packed = ZipArchive::new(Cursor::new(PACKED))?;
                zip.raw_copy_file_rename(packed.by_index_raw(0)?, name)?;
            }
        }
    }
    Ok(zip.finish()?.into_inner())
}

/// A file of the FMU.
enum Content<'a> {
    Bytes(Cow<'a, [u8]>),
    /// The runtime that cotree was built with, which is compressed already.
    OwnRuntime,
}

/// Every file of the FMU, by name.
fn entries<'a>(package: &'a Package) -> Result<BTreeMap<String, Content<'a>>, ExportError> {
    let Package { version, description, page, .. } = package;
    let files: [(&str, Cow<[u8]>); 5] = [
        ("resources/program.bin", package.program.into()),
        ("documentation/index.html", page.html(description, *version).into_bytes().into()),
        (
            "documentation/licenses/license.txt",
            LICENSE.replace("{libraries}", &libraries::notices()).into_bytes().into(),
        ),
        ("documentation/licenses/sbom.cdx.json", libraries::bill_of_materials().into_bytes().into()),
        ("documentation/licenses/apache-2.0.txt", APACHE.as_bytes().into()),
    ];
    let mut entries: BTreeMap<String, Content> =
        files.into_iter().map(|(name, bytes)| (name.to_owned(), Content::Bytes(bytes))).collect();
    let described = described(package)?.into_iter();
    entries.extend(described.map(|(name, bytes)| (name.to_owned(), Content::Bytes(bytes.into()))));
    for runtime in package.runtimes {
        let (folder, Platform { extension, .. }) = (runtime.platform.folder(*version), runtime.platform);
        let name = format!("binaries/{folder}/{}.{extension}", description.identifier);
        let content = if runtime.is_own() { Content::OwnRuntime } else { Content::Bytes((&*runtime.library).into()) };
        entries.insert(name, content);
    }
    if let Some(scene) = package.scene {
        let name = format!("resources/scene.{}", scene.extension);
        entries.insert(name, Content::Bytes(scene.text.as_bytes().into()));
    }
    Ok(entries)
}

/// The descriptions and pictures, which each version has its own places for.
fn described(package: &Package) -> Result<Vec<(&'static str, Vec<u8>)>, ExportError> {
    let description = package.description;
    let picture = icon::png(package.page.drawing)?;
    Ok(match package.version {
        FmiVersion::V2 => {
            let text = xml::fmi2::model_description(description).map_err(ExportError::Description)?;
            vec![("modelDescription.xml", text), ("model.png", picture)]
        }
        FmiVersion::V3 => {
            let text = xml::fmi3::model_description(description).map_err(ExportError::Description)?;
            let terminals = xml::terminals::terminals(description).map_err(ExportError::Description)?;
            let mut files = vec![
                ("modelDescription.xml", text),
                ("documentation/diagram.png", picture.clone()),
                ("documentation/diagram.svg", package.page.drawing.svg().into_bytes()),
                ("terminalsAndIcons/icon.png", picture),
            ];
            files.extend(terminals.map(|text| ("terminalsAndIcons/terminalsAndIcons.xml", text)));
            files
        }
    })
}
