//! From the folder of the unpacked FMU's resources to the program.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::PROGRAM_FILE;
use crate::model::Model;
use crate::program::Program;

/// Largest program [bytes]: what is larger has been put there by somebody else.
const LARGEST: u64 = 1 << 31;

/// Reads the model from the folder that the importer unpacked.
#[inline(never)]
pub fn load(mut path: PathBuf) -> Result<Arc<Model>, String> {
    path.push(PROGRAM_FILE.rsplit('/').next().unwrap_or(PROGRAM_FILE));
    let shown = path.display();
    let bytes = read(&path).map_err(|why| format!("`{shown}` cannot be read: {why}; unpack the FMU again"))?;
    let program = Program::from_bytes(&bytes).map_err(|error| format!("`{shown}`: {error}"))?;
    let model = Model::new(program).map_err(|error| format!("`{shown}`: {error}"))?;
    Ok(Arc::new(model))
}

/// A file's content, if it is a file, and no larger than a program can be.
fn read(path: &Path) -> Result<Vec<u8>, String> {
    let about = std::fs::metadata(path).map_err(|error| error.to_string())?;
    if !about.is_file() {
        return Err("it is not a file".to_owned());
    }
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(|error| error.to_string())?;
    file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > LARGEST { Err("it is larger than any program".to_owned()) } else { Ok(bytes) }
}

/// A path as the importer spells it.
#[cfg(unix)]
pub fn path(bytes: Vec<u8>) -> Result<PathBuf, String> {
    use std::os::unix::ffi::OsStringExt;
    Ok(std::ffi::OsString::from_vec(bytes).into())
}

/// A path as the importer spells it.
#[cfg(not(unix))]
pub fn path(bytes: Vec<u8>) -> Result<PathBuf, String> {
    let text = String::from_utf8(bytes).map_err(|_| "the place of the resources is not UTF-8".to_owned())?;
    // `/C:/folder` is how a URI writes `C:/folder`.
    let drive = text.strip_prefix('/').filter(|rest| rest.as_bytes().get(1) == Some(&b':'));
    Ok(drive.unwrap_or(&text).into())
}
