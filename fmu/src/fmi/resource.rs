//! From the folder of the unpacked FMU's resources to the program.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use thiserror::Error;

use crate::PROGRAM_FILE;
use crate::model::Model;
use crate::program::Program;

/// Largest program [bytes]: what is larger has been put there by somebody else.
const LARGEST_PROGRAM: u64 = 1 << 31;

/// Why there is no model in the folder of the resources.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct ResourceError(pub String);

/// A path that is no text of the operating system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the path of the resources is not UTF-8")]
pub struct NotUtf8;

/// Reads the model from the folder that the importer unpacked.
#[inline(never)]
pub fn load(mut path: PathBuf) -> Result<Arc<Model>, ResourceError> {
    path.push(PROGRAM_FILE.rsplit('/').next().unwrap_or(PROGRAM_FILE));
    let named = |why: String| ResourceError(format!("`{}`{why}", path.display()));
    let bytes = read(&path).map_err(|cause| named(format!(" cannot be read: {cause}; unpack the FMU again")))?;
    let program = Program::from_bytes(&bytes).map_err(|cause| named(format!(": {cause}")))?;
    Model::new(program).map(Arc::new).map_err(|cause| named(format!(": {cause}")))
}

/// A file's content, if it is a file, and no larger than a program can be.
fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(std::io::Error::other("it is not a file"));
    }
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(LARGEST_PROGRAM + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > LARGEST_PROGRAM {
        true => Err(std::io::Error::other("it is larger than any program of cotree")),
        false => Ok(bytes),
    }
}

/// A path as the importer spells it.
#[cfg(unix)]
pub fn path(bytes: Vec<u8>) -> Result<PathBuf, NotUtf8> {
    use std::os::unix::ffi::OsStringExt;
    Ok(std::ffi::OsString::from_vec(bytes).into())
}

/// A path as the importer spells it.
#[cfg(not(unix))]
pub fn path(bytes: Vec<u8>) -> Result<PathBuf, NotUtf8> {
    let text = String::from_utf8(bytes).map_err(|_| NotUtf8)?;
    // `/C:/folder` is how a URI writes `C:/folder`.
    let drive = text.strip_prefix('/').filter(|rest| rest.as_bytes().get(1) == Some(&b':'));
    Ok(drive.unwrap_or(&text).into())
}
