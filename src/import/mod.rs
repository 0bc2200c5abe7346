//! Linkages of other programs, robots and drawings as scenes to go on with.
//!
//! A reader sees texts only: what a file includes comes by a callback, so that a page without files can import, too.

mod drake;
mod dxf;
mod levels;
mod linkage;
mod mjcf;
mod number;
mod options;
mod pmks;
mod pmks_older;
mod pylinkage;
mod refusal;
mod report;
mod robot;
mod sdf;
mod text;
mod trial;
mod urdf;
mod xml;

pub use mjcf::attributes::{AttributeClass, class_of};
pub use options::{ContactChoice, DxfOptions, ImportOptions, WorldPlane};
pub use text::Imported;

use refusal::ImportRefusal;
use report::ImportReport;

/// Gives the bytes of a file that another one includes, by the path that it has there; none if it is not there.
pub type Includes<'a> = &'a dyn Fn(&str) -> Option<Vec<u8>>;

/// A scene from the text of a file without includes and with no options, as [`import_file`].
///
/// # Errors
/// Everything that keeps it from being read.
pub fn import(name: &str, file: &str) -> Result<Imported, Vec<String>> {
    import_file(name, "file", file.as_bytes(), &ImportOptions::default(), &|_| None)
}

/// A scene of this name from the file of another program: of PMKS+ (`.pmks`, or a shared address), of pylinkage (JSON), of robots (MJCF, URDF, SDF), or a
/// drawing (DXF). Its kind is found from its content; `file` is what messages call it.
///
/// # Errors
/// Everything that keeps it from being read, each with its place and what to do.
pub fn import_file(
    name: &str,
    file: &str,
    bytes: &[u8],
    options: &ImportOptions,
    includes: Includes,
) -> Result<Imported, Vec<String>> {
    if let Some(refusal) = binary(bytes) {
        return Err(vec![refusal.to_string()]);
    }
    let text = xml::decode(bytes).map_err(|why| vec![why.to_owned()])?;
    let trimmed = text.trim();
    if trimmed.starts_with('<') {
        return robot(name, file, &text, options, includes);
    }
    if dxf::looks_like_it(trimmed) {
        let linkage = dxf::read(file, &text, options).map_err(|refusal| vec![refusal.to_string()])?;
        return Ok(drawn(text::scene(name, &linkage, None)?));
    }
    let linkage = if trimmed.starts_with('{') { pylinkage::read(trimmed)? } else { pmks::read(trimmed)? };
    tried(name, &linkage)
}

/// The scene of a linkage, after a run of it.
fn tried(name: &str, linkage: &linkage::ImportedLinkage) -> Result<Imported, Vec<String>> {
    let imported = text::scene(name, linkage, None)?;
    match trial::of(&imported.scene) {
        trial::Trial::Runs => Ok(imported),
        trial::Trial::Stays(why) => Ok(imported.with(format!("it does not move: {why}"))),
        trial::Trial::Ends(time, why) => {
            let shorter = text::scene(name, linkage, Some(time))?;
            Ok(shorter.with(format!("the run stops at {time:.4} s, where the motion ends: {why}")))
        }
    }
}

/// The scene of a drawing, with a drive to begin with.
fn drawn(imported: Imported) -> Imported {
    let pivot = imported
        .scene
        .split("\n[joints.")
        .skip(1)
        .find(|joint| joint.contains("\"revolute\"") && joint.contains("\"ground."));
    let Some(name) = pivot.and_then(|joint| joint.split(']').next()) else { return imported };
    let drive = format!(
        "\n# To drive it:\n# [drivers.drive]\n# joint = \"{name}\"\n# angle = \"2*pi*t\"                     # rad, t in s\n"
    );
    Imported { scene: imported.scene.clone() + &drive, ..imported }
}

/// What is no text, and how to save it as one.
fn binary(bytes: &[u8]) -> Option<ImportRefusal> {
    let refuse = |what: &str, help: &str| Some(ImportRefusal::new(what).help(help));
    match bytes {
        _ if bytes.starts_with(b"AutoCAD Binary DXF") => refuse("it is a binary DXF file", "save it as ASCII DXF"),
        _ if bytes.starts_with(b"AC10") => refuse("it is a DWG file", "save it as ASCII DXF"),
        _ if bytes.starts_with(b"PK\x03\x04") => {
            refuse("it is a ZIP archive", "unpack it and import the file that is in it")
        }
        [] => refuse("it is empty", "give a file with a mechanism"),
        _ => None,
    }
}

fn robot(
    name: &str,
    file: &str,
    text: &str,
    options: &ImportOptions,
    includes: Includes,
) -> Result<Imported, Vec<String>> {
    let one = |refusal: ImportRefusal| vec![refusal.to_string()];
    let mut root = xml::parse(file, text).map_err(one)?;
    let mut report = ImportReport::default();
    let model = match root.name.as_str() {
        "mujoco" => mjcf::read(&mut root, options, includes, &mut report),
        "robot" => urdf::read(&root, options, &mut report),
        "sdf" => sdf::read(&mut root, options, includes, &mut report),
        other => {
            let message =
                format!("its root element is <{other}>, but must be <mujoco> (MJCF), <robot> (URDF) or <sdf>");
            return Err(one(root.refuse(message)));
        }
    };
    let mut said = Vec::new();
    match model {
        Ok(model) if report.refused.is_empty() => {
            if let Some(scene) = robot::scene(name, model, options, &mut report)
                && report.refused.is_empty()
            {
                return Ok(Imported { scene, notes: report.lines() });
            }
        }
        Ok(_) => {}
        Err(refusal) => said.push(refusal.to_string()),
    }
    said.extend(report.refused.iter().map(ImportRefusal::to_string));
    Err(said)
}
