//! The FMU file: a zip archive with the same bytes for the same contents.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::Path;
use std::sync::OnceLock;

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipArchive, ZipWriter};

use super::description::Description;
use super::runtime::{Platform, Runtime};
use super::scene_text::SceneText;
use super::universal::universal;
use super::xml::related::Related;
use super::{ExportError, FmiVersion, libraries, xml};
use crate::files;

const LICENSE: &str = include_str!("license.txt");
const APACHE: &str = include_str!("apache-2.0.txt");

/// What goes into an FMU.
#[derive(Clone, Debug)]
pub struct Package<'a> {
    pub version: FmiVersion,
    pub description: &'a Description,
    /// The program as the runtime reads it.
    pub program: &'a [u8],
    /// The text that the scene came from, if it came from a file.
    pub scene: Option<SceneText<'a>>,
    pub extras: Vec<Extra>,
    /// The runtimes, one for each platform that the FMU is to run on.
    pub runtimes: &'a [Runtime],
}

/// A file that an FMU carries in addition to the model: its page, a picture, a source.
#[derive(Clone, Debug)]
pub struct Extra {
    /// Where it is in the FMU.
    pub name: String,
    pub bytes: Vec<u8>,
}

/// Packs an FMU and writes it to a file: all of it or nothing.
pub fn write(package: &Package, path: &Path) -> Result<(), ExportError> {
    let bytes = pack(package)?;
    files::write(path, &bytes).map_err(|error| ExportError(format!("cannot write `{}`: {error}", path.display())))
}

/// The bytes of an FMU.
pub fn pack(package: &Package) -> Result<Vec<u8>, ExportError> {
    let options = options();
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in entries(package)? {
        let permissions = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        match content {
            MemberContent::Bytes(bytes) => {
                zip.start_file(name, options.unix_permissions(permissions))?;
                zip.write_all(&bytes).map_err(ZipError::from)?;
            }
            MemberContent::OwnRuntime => {
                let mut packed = ZipArchive::new(Cursor::new(packed()?))?;
                zip.raw_copy_file_rename(packed.by_index_raw(0)?, name)?;
            }
        }
    }
    Ok(zip.finish()?.into_inner())
}

/// An archive with nothing but the runtime that cotree was built with in it. It is most of an FMU: compressed once, however many are exported.
fn packed() -> Result<&'static [u8], ZipError> {
    static PACKED: OnceLock<Vec<u8>> = OnceLock::new();
    if let Some(packed) = PACKED.get() {
        return Ok(packed);
    }
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    zip.start_file("runtime", options().unix_permissions(0o755))?;
    zip.write_all(&Runtime::own_library())?;
    let archive = zip.finish()?.into_inner();
    Ok(PACKED.get_or_init(|| archive))
}

/// Wherever it is written: the same scene gives the same bytes.
fn options() -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .system(System::Unix)
        .last_modified_time(DateTime::DEFAULT)
}

/// A file of the FMU.
enum MemberContent<'a> {
    Bytes(Cow<'a, [u8]>),
    /// The runtime that cotree was built with, which is compressed already.
    OwnRuntime,
}

/// Every file of the FMU, by name.
fn entries<'a>(package: &'a Package) -> Result<BTreeMap<String, MemberContent<'a>>, ExportError> {
    let Package { description, extras, .. } = package;
    // Sources alone contain no library and read no program.
    let is_binary = !package.runtimes.is_empty() || description.sources.is_none();
    let notices = if is_binary { libraries::notices() } else { String::new() };
    let mut files: Vec<(&str, Cow<[u8]>)> = vec![
        ("documentation/licenses/license.txt", LICENSE.replace("{libraries}", &notices).into_bytes().into()),
        ("documentation/licenses/apache-2.0.txt", APACHE.as_bytes().into()),
    ];
    if is_binary {
        files.push(("resources/program.bin", package.program.into()));
        files.push(("documentation/licenses/sbom.cdx.json", libraries::bill_of_materials().into_bytes().into()));
    }
    let mut entries: BTreeMap<String, MemberContent> =
        files.into_iter().map(|(name, bytes)| (name.to_owned(), MemberContent::Bytes(bytes))).collect();
    entries.extend(extras.iter().map(|extra| (extra.name.clone(), MemberContent::Bytes((&*extra.bytes).into()))));
    let described = described(package)?.into_iter();
    entries.extend(described.map(|(name, bytes)| (name.to_owned(), MemberContent::Bytes(bytes.into()))));
    entries.extend(libraries(package)?);
    let scene = package.scene.map(SceneText::files).unwrap_or_default();
    let related = related(&scene, extras);
    if !related.is_empty() {
        let text = xml::related::manifest(&related).map_err(no_description)?;
        entries.insert(xml::related::PLACE.to_owned(), MemberContent::Bytes(text.into()));
    }
    entries.extend(scene.into_iter().map(|(name, text)| (name, MemberContent::Bytes(text.into_bytes().into()))));
    Ok(entries)
}

/// The shared libraries, each in the folder where importers look for it.
fn libraries<'a>(package: &'a Package) -> Result<Vec<(String, MemberContent<'a>)>, ExportError> {
    let Package { version, description, runtimes, .. } = package;
    let name = |folder, extension| format!("binaries/{folder}/{}.{extension}", description.identifier);
    let content = |runtime: &'a Runtime| match runtime.is_own() {
        true => MemberContent::OwnRuntime,
        false => MemberContent::Bytes((&*runtime.library).into()),
    };
    let place = |own: &Runtime| name(own.platform.folder(*version), own.platform.extension);
    let mut libraries: Vec<_> = runtimes.iter().map(|own| (place(own), content(own))).collect();
    // With FMI 2.0, importers on Apple silicon load what lies in the folder that the standard names for Macs; by its text they look in `aarch64-darwin`.
    let macs: Vec<&Runtime> = runtimes.iter().filter(|own| own.platform.is_mac()).collect();
    if let (FmiVersion::V2, Some(&first)) = (version, macs.first()) {
        let all = match macs.len() {
            1 => content(first),
            _ => MemberContent::Bytes(for_all_macs(&macs)?.into()),
        };
        let place = name(Platform::MAC_FOLDER, first.platform.extension);
        libraries.retain(|(other, _)| *other != place);
        libraries.push((place, all));
    }
    Ok(libraries)
}

fn for_all_macs(macs: &[&Runtime]) -> Result<Vec<u8>, ExportError> {
    let libraries: Vec<Cow<[u8]>> = macs.iter().map(|runtime| runtime.packed_library()).collect();
    let libraries: Vec<&[u8]> = libraries.iter().map(|library| &**library).collect();
    let failed = || ExportError("the runtimes for macOS cannot be put into one library".to_owned());
    universal(&libraries).ok_or_else(failed)
}

/// The files that others may want to know the role of.
fn related<'a>(scene: &'a [(String, String)], extras: &'a [Extra]) -> Vec<Related<'a>> {
    let source = scene.iter().enumerate().map(|(index, (name, _))| {
        let description =
            if index == 0 { "the scene from which the FMU was made" } else { "a file that the scene uses" };
        Related { name, role: "model", description }
    });
    let page = extras.iter().filter(|extra| extra.name.ends_with(".html"));
    let report = "the model in motion, its equations and variables, and its measured accuracy";
    source.chain(page.map(|extra| Related { name: &extra.name, role: "report", description: report })).collect()
}

/// The descriptions, of which each version has its own.
fn described(package: &Package) -> Result<Vec<(&'static str, Vec<u8>)>, ExportError> {
    let description = package.description;
    Ok(match package.version {
        FmiVersion::V2 => {
            let text = xml::fmi2::model_description(description).map_err(no_description)?;
            vec![("modelDescription.xml", text)]
        }
        FmiVersion::V3 => {
            let text = xml::fmi3::model_description(description).map_err(no_description)?;
            let terminals = xml::terminals::terminals(description).map_err(no_description)?;
            let mut files = vec![("modelDescription.xml", text)];
            if let Some(sources) = &description.sources {
                let text = xml::source_files::build_description(description, sources).map_err(no_description)?;
                files.push(("sources/buildDescription.xml", text));
            }
            files.extend(terminals.map(|text| ("terminalsAndIcons/terminalsAndIcons.xml", text)));
            files
        }
    })
}

fn no_description(error: impl std::fmt::Display) -> ExportError {
    ExportError(format!("cannot write the model description: {error}"))
}
