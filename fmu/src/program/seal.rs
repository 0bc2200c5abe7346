//! The envelope of everything that is stored: a mark, a version, a length and a checksum around a payload. It guards against accidents, not against
//! people: whoever changes the payload on purpose can compute the checksum, so what is read is checked as well.

use thiserror::Error;

/// The format of what is stored, from the sources that define it.
#[allow(clippy::panic, reason = "while the crate is compiled")]
pub const FORMAT: u32 = match u32::from_str_radix(env!("COTREE_FORMAT"), 16) {
    Ok(format) => format,
    Err(_) => panic!("the build script writes a hexadecimal number"),
};

/// Bytes before the payload.
const HEADER: usize = 24;

/// Why stored bytes are refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct FrameError(pub String);

/// What a kind of stored data is marked with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mark {
    /// The first bytes.
    pub magic: [u8; 4],
    /// What it is, for messages.
    pub name: &'static str,
}

impl Mark {
    /// Wraps a payload.
    pub fn seal(&self, payload: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER + payload.len());
        bytes.extend_from_slice(&self.magic);
        bytes.extend_from_slice(&FORMAT.to_le_bytes());
        bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&checksum(payload).to_le_bytes());
        bytes.extend_from_slice(payload);
        bytes
    }

    /// The payload, if nothing about the envelope is wrong.
    pub fn open<'a>(&self, bytes: &'a [u8]) -> Result<&'a [u8], FrameError> {
        let foreign = || FrameError(format!("this is not {}", self.name));
        let (magic, rest) = bytes.split_first_chunk::<4>().ok_or_else(foreign)?;
        let (version, rest) = rest.split_first_chunk::<4>().ok_or_else(foreign)?;
        let (length, rest) = rest.split_first_chunk::<8>().ok_or_else(foreign)?;
        let (sum, payload) = rest.split_first_chunk::<8>().ok_or_else(foreign)?;
        if *magic != self.magic {
            return Err(foreign());
        }
        let found = u32::from_le_bytes(*version);
        if found != FORMAT {
            return Err(FrameError(format!(
                "its format is {found:08x}, but this version reads {FORMAT:08x}: export again"
            )));
        }
        let (found, expected) = (payload.len() as u64, u64::from_le_bytes(*length));
        if found != expected {
            return Err(FrameError(format!(
                "{found} bytes instead of {expected}: the data is incomplete or has been changed"
            )));
        }
        if checksum(payload) != u64::from_le_bytes(*sum) {
            return Err(FrameError("the checksum does not agree: the data has been changed".to_owned()));
        }
        Ok(payload)
    }
}

/// FNV-1a, 64 bits. Each byte enters by a bijection, so that a single changed byte always shows.
pub(crate) fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xCBF2_9CE4_8422_2325, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3))
}
