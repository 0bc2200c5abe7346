//! From the importer's resource location to the folder of the resources.

use std::path::PathBuf;

use thiserror::Error;

use crate::fmi::resource::{NotUtf8, path};

/// Why a resource location leads to no folder.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LocationError {
    /// The importer gives none.
    #[error("the resource location is empty, but it contains the program of the FMU")]
    Empty,
    /// The URI of something else than a file.
    #[error("the resource location `{0}` is not a file: URI")]
    OtherScheme(String),
    /// The URI of a file that is not here.
    #[error("the resource location `{0}` is on another machine")]
    OtherMachine(String),
    /// A `%` without two hexadecimal digits.
    #[error("the resource location `{0}` has a wrong % escape")]
    Escape(String),
    /// A path that is no text of the operating system.
    #[error(transparent)]
    NotUtf8(#[from] NotUtf8),
}

/// The folder of a `file:` URI (RFC 8089), with or without authority; a bare path is taken as it is.
pub fn folder(location: &[u8]) -> Result<PathBuf, LocationError> {
    let shown = || String::from_utf8_lossy(location).into_owned();
    if location.is_empty() {
        return Err(LocationError::Empty);
    }
    let scheme = location.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case(b"file:"));
    if !scheme {
        return match location.windows(3).any(|part| part == b"://") {
            true => Err(LocationError::OtherScheme(shown())),
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
                _ => return Err(LocationError::OtherMachine(shown())),
            }
        }
    };
    Ok(path(decode(absolute).ok_or_else(|| LocationError::Escape(shown()))?)?)
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
