//! From a compiled mechanism to an FMU file.

pub mod archive;
pub mod describe;
pub mod description;
mod libraries;
pub mod runtime;
pub mod scene_text;
mod terminals;
mod universal;
pub mod xml;

/// A version of FMI. Both have the same program and the same runtime inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FmiVersion {
    /// FMI 2.0
    #[default]
    V2,
    /// FMI 3.0
    V3,
}

impl FmiVersion {
    /// The words for them, and what each means.
    pub const WORDS: [(&'static str, &'static str, Self); 2] = [("2", "FMI 2.0", Self::V2), ("3", "FMI 3.0", Self::V3)];

    /// As descriptions spell it.
    pub fn number(self) -> &'static str {
        match self {
            Self::V2 => "2.0",
            Self::V3 => "3.0",
        }
    }
}

/// Why no FMU could be made.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ExportError(pub String);

crate::diagnostic::from_messages!(ExportError as ExportError: runtime::RuntimeError);

impl From<cotree_fmu::program::storage::LoadError> for ExportError {
    fn from(error: cotree_fmu::program::storage::LoadError) -> Self {
        ExportError(format!("cannot write the program: {error}"))
    }
}

impl From<zip::result::ZipError> for ExportError {
    fn from(error: zip::result::ZipError) -> Self {
        ExportError(format!("cannot pack the FMU: {error}"))
    }
}
