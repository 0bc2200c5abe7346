//! Taylor series of motions from the arm form of a mechanism.
//!
//! * `jet`: the series of one motion, alone or with its derivatives, by one factorisation and one pass for each order.
//! * `tape`, `fused`, `products`: scalar series for signals of time and the laws of loads.
//! * `along`: a tape of numbers, run on the polynomials of a step.
//! * `coupling`: the masses among sparse constants.

mod along;
pub(crate) mod coupling;
mod fused;
mod jet;
mod products;
mod tape;

pub(crate) use along::TapeAlong;
pub(crate) use jet::{
    Batch, CLOSED, FrictionAlong, MEMBERS, SERIES_SAFETY, Tangents, VARIED_DIRECTIONS, Variations, variations,
};
pub use jet::{Changes, Jet, Singular};
