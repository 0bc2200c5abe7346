//! Linkages of other programs as scenes to go on with.

mod linkage;
mod number;
mod pmks;
mod pmks_older;
mod pylinkage;
mod text;

pub use text::Imported;

/// A scene from the file of another program: of PMKS+ (`.pmks`, or a shared address), or of pylinkage (JSON).
///
/// # Errors
/// Everything that keeps it from being read.
pub fn import(name: &str, file: &str) -> Result<Imported, Vec<String>> {
    let file = file.trim();
    let linkage = if file.starts_with('{') { pylinkage::read(file)? } else { pmks::read(file)? };
    text::scene(name, &linkage)
}
