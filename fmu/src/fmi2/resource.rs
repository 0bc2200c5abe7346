//! From the importer's resource location to the program.

use std::ffi::CStr;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::PROGRAM_FILE;
use crate::model::Model;
use crate::program::Program;

/// Largest program [bytes]: what is larger has been put there by somebody else.
const LARGEST: u64 = 1 << 31;

/// Reads the model from the folder that the importer unpacked.
pub fn load(location: &CStr) -> Result<Arc<Model>, String> {
    let mut path = folder(location.to_bytes())?;
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

/// The folder of a `file:` URI (RFC 8089), with or without authority; a bare path is taken as it is.
fn folder(location: &[u8]) -> Result<PathBuf, String> {
    let shown = String::from_utf8_lossy(location);
    if location.is_empty() {
        return Err("the resource location is empty, but the program of the FMU lies there".to_owned());
    }
    let scheme = location.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case(b"file:"));
    if !scheme {
        return match location.windows(3).any(|part| part == b"://") {
            true => Err(format!("the resource location `{shown}` is not a file: URI")),
            false => path(location.to_vec()),
        };
    }
    let rest = &location[5..];
    let absolute = match rest.strip_prefix(b"//") {
        None => rest,
        Some(authority) => {
            let end = authority.iter().position(|&byte| byte == b'/').unwrap_or(authority.len());
            match &authority[..end] {
                b"" | b"localhost" => &authority[end..],
                _ => {
                    return Err(format!("the resource location `{shown}` is on another machine"));
                }
            }
        }
    };
    path(decode(absolute).ok_or_else(|| format!("the resource location `{shown}` has a wrong % escape"))?)
}

/// Replaces %41 by A.
fn decode(text: &[u8]) -> Option<Vec<u8>> {
    let mut decoded = Vec::with_capacity(text.len());
    let mut bytes = text.iter();
    while let Some(&byte) = bytes.next() {
        if byte == b'%' {
            let mut digit = || char::from(*bytes.next()?).to_digit(16);
            let value = 16 * digit()? + digit()?;
            decoded.push(u8::try_from(value).ok().filter(|&value| value != 0)?);
        } else {
            decoded.push(byte);
        }
    }
    Some(decoded)
}

#[cfg(unix)]
fn path(bytes: Vec<u8>) -> Result<PathBuf, String> {
    use std::os::unix::ffi::OsStringExt;
    Ok(std::ffi::OsString::from_vec(bytes).into())
}

#[cfg(not(unix))]
fn path(bytes: Vec<u8>) -> Result<PathBuf, String> {
    let text = String::from_utf8(bytes).map_err(|_| "the resource location is not UTF-8".to_owned())?;
    // `/C:/folder` is how a URI writes `C:/folder`.
    let drive = text.strip_prefix('/').filter(|rest| rest.as_bytes().get(1) == Some(&b':'));
    Ok(drive.unwrap_or(&text).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_forms_of_a_file_uri_are_understood() {
        for (location, expected) in [
            ("file:///tmp/fmu/resources", "/tmp/fmu/resources"),
            ("file:/tmp/fmu/resources", "/tmp/fmu/resources"),
            ("FILE://localhost/tmp/x/", "/tmp/x/"),
            ("file:///tmp/a%20b/%C3%A9/100%25", "/tmp/a b/é/100%"),
            ("/tmp/a%20b", "/tmp/a%20b"),
        ] {
            assert_eq!(folder(location.as_bytes()), Ok(PathBuf::from(expected)), "{location}");
        }
        for wrong in ["", "http://a/b", "file://server/share", "file:///a%2", "file:///a%zz", "file:///a%00"] {
            assert!(folder(wrong.as_bytes()).is_err(), "{wrong}");
        }
    }
}
