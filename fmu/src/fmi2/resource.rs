//! From the importer's resource location to the folder of the resources.

use std::path::PathBuf;

use thiserror::Error;

use crate::fmi::resource::{NotUtf8, path};

/// Why a resource location leads to no folder.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct LocationError(pub String);

impl From<NotUtf8> for LocationError {
    fn from(error: NotUtf8) -> Self {
        LocationError(error.to_string())
    }
}

/// The folder of a `file:` URI (RFC 8089), with or without authority; a bare path is taken as it is.
pub fn folder(location: &[u8]) -> Result<PathBuf, LocationError> {
    let refused =
        |why: &str| LocationError(format!("the resource location `{}` {why}", String::from_utf8_lossy(location)));
    if location.is_empty() {
        let why = "the resource location is empty, but it contains the program of the FMU";
        return Err(LocationError(why.to_owned()));
    }
    let scheme = location.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case(b"file:"));
    if !scheme {
        return match location.windows(3).any(|part| part == b"://") {
            true => Err(refused("is not a file: URI")),
            false => Ok(path(location.to_vec())?),
        };
    }
    let rest = &location[5..];
    let absolute = match rest.strip_prefix(b"//") {
        None => rest,
        Some(authority) => {
            let end = authority.iter().position(|&byte| byte == b'/').unwrap_or(authority.len());
            match &authority[..end] {
                b"" | b"localhost" => &authority[end..],
                _ => return Err(refused("is on another machine")),
            }
        }
    };
    Ok(path(decode(absolute).ok_or_else(|| refused("has a wrong % escape"))?)?)
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
