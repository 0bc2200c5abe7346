//! Taylor series of motions from the arm form of a mechanism.
//!
//! * [`form`]: the mechanism as data: arms, masses between them, loop equations, loads.
//! * `jet`: the series of one motion, by one factorisation and one pass for each order.
//! * `tape`: scalar series for signals of time and the laws of loads.
//! * `columns`, `inverse`, `lane`: sparse constants, the factorisation, four numbers at a time.

mod check;
mod columns;
pub mod form;
mod inverse;
mod jet;
mod lane;
mod tape;

pub use jet::{Jet, Singular};

/// The highest order of positions.
pub const MAX_ORDER: usize = 20;
