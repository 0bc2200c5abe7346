//! Taylor series of motions from the arm form of a mechanism.
//!
//! * [`form`]: the mechanism as data: arms, masses between them, loop equations, loads.
//! * `jet`: the series of one motion, by one factorisation and one pass for each order.
//! * `tape`, `fused`, `products`: scalar series for signals of time and the laws of loads.
//! * `coupling`: the masses among sparse constants.

mod check;
pub(crate) mod coupling;
pub mod form;
mod fused;
mod jet;
mod products;
mod tape;

pub(crate) use jet::{Begun, DIRECTIONS, Members, Tangents, Variations, variations};
pub use jet::{Jet, Singular};

/// The highest order of positions.
pub const MAX_ORDER: usize = 28;
/// Coefficients of a series.
const ORDERS: usize = MAX_ORDER + 1;
