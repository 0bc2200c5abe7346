//! The pictures of studies.

pub mod bench;
pub mod fit;
pub mod motion;
pub mod optimize;
pub mod sweep;
pub mod synthesis;
