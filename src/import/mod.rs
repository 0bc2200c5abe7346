//! Linkages of other programs as scenes to go on with.

mod linkage;
mod number;
mod pmks;
mod pmks_older;
mod pylinkage;
mod text;
mod trial;

pub use text::Imported;

/// A scene from the file of another program: of PMKS+ (`.pmks`, or a shared address), or of pylinkage (JSON).
///
/// # Errors
/// Everything that keeps it from being read.
pub fn import(name: &str, file: &str) -> Result<Imported, Vec<String>> {
    let file = file.trim();
    let linkage = if file.starts_with('{') { pylinkage::read(file)? } else { pmks::read(file)? };
    let imported = text::scene(name, &linkage, None)?;
    match trial::of(&imported.scene) {
        trial::Trial::Runs => Ok(imported),
        trial::Trial::Stays(why) => Ok(imported.with(format!("it does not move: {why}"))),
        trial::Trial::Ends(time, why) => {
            let shorter = text::scene(name, &linkage, Some(time))?;
            Ok(shorter.with(format!("the run is cut at {time:.4} s, where the motion ends: {why}")))
        }
    }
}
