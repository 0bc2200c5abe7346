//! `fmi-ls-manifest.xml` of the layered standard FMI-LS-REF: which files of an FMU are the model's source and which report on it. Tools that know nothing
//! of cotree find them by their roles.

use std::fmt::Write;
use std::io;

use super::{document, leaf};

/// Where it is in the FMU, and how far up from there the other files are.
pub const PLACE: &str = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml";
const UP: &str = "../../";

/// A file with a role.
pub struct Related<'a> {
    /// Its name in the FMU.
    pub name: &'a str,
    /// The standard's word for what it is to the model.
    pub role: &'static str,
    pub description: &'static str,
}

/// The document.
pub fn manifest(files: &[Related]) -> io::Result<Vec<u8>> {
    let head = [
        ("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest"),
        ("fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-ref"),
        // That of the text of 1.0.0-beta.1, which has kept this number.
        ("fmi-ls:fmi-ls-version", "1.0.0-alpha.1"),
        ("fmi-ls:fmi-ls-description", "Layered Standard providing information on related files included in an FMU."),
    ];
    document("fmiReferences", head.map(|(key, text)| (key, text.to_owned())).into(), |out| {
        files.iter().try_for_each(|file| {
            let attributes = [
                ("type", media_type(file.name).to_owned()),
                ("source", format!("{UP}{}", reference(file.name))),
                ("role", file.role.to_owned()),
                ("description", file.description.to_owned()),
            ];
            leaf(out, "Related", attributes.into())
        })
    })
}

fn media_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map(|(_, extension)| extension) {
        Some("toml") => "application/toml",
        Some("json") => "application/json",
        Some("csv") => "text/csv",
        Some("html") => "text/html",
        _ => "application/octet-stream",
    }
}

/// A name as a relative URI (RFC 3986).
fn reference(name: &str) -> String {
    name.bytes().fold(String::new(), |mut text, byte| {
        match byte {
            b'/' | b'-' | b'.' | b'_' | b'~' => text.push(byte.into()),
            _ if byte.is_ascii_alphanumeric() => text.push(byte.into()),
            // Writing to a text cannot fail.
            _ => _ = write!(text, "%{byte:02X}"),
        }
        text
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_of_files_become_relative_uris() {
        assert_eq!(super::reference("resources/scene.toml"), "resources/scene.toml");
        assert_eq!(super::reference("resources/a b/100%\u{e9}.csv"), "resources/a%20b/100%25%C3%A9.csv");
    }
}
