//! A program as bytes: the file `resources/program.bin` of an FMU.

use thiserror::Error;

use crate::program::Program;
use crate::program::seal::Mark;

const MARK: Mark = Mark { magic: *b"cotP", name: KIND };

/// What a runtime calls the programs that it reads. It is among the bytes of the runtime's shared library.
pub const KIND: &str = concat!("a cotree program of format ", env!("COTREE_FORMAT"));

/// Why a program cannot be loaded.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct LoadError(pub String);

impl LoadError {
    /// The payload is not a program.
    fn undecodable() -> Self {
        LoadError("the program cannot be decoded: the data has been changed".to_owned())
    }
}

impl Program {
    /// The program as bytes, the same for the same program everywhere.
    pub fn to_bytes(&self) -> Result<Vec<u8>, LoadError> {
        let payload = postcard::to_allocvec(self).map_err(|_| LoadError::undecodable())?;
        Ok(MARK.seal(&payload))
    }

    /// Reads and checks a program.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, LoadError> {
        let payload = MARK.open(bytes).map_err(|cause| LoadError(format!("the program cannot be read: {cause}")))?;
        let (program, rest) = postcard::take_from_bytes::<Self>(payload).map_err(|_| LoadError::undecodable())?;
        if !rest.is_empty() {
            return Err(LoadError::undecodable());
        }
        program.check().map_err(|cause| LoadError(format!("the program is damaged: {cause}")))?;
        Ok(program)
    }
}
