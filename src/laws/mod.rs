//! Where laws are rough: jumps, breaks, steep places, the ends of their domains, and the indicators whose signs choose their pieces.

mod domains;
mod indicators;
mod jumps;
pub(crate) mod rough;
mod steep;
mod touches;

pub(crate) use domains::{domains, ranges};
pub use indicators::motion_indicators;
pub(crate) use jumps::{Jump, jumps, laws, without_rate};
pub(crate) use steep::steep;
pub(crate) use touches::touches;
