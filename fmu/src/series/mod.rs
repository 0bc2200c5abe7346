//! Taylor series of motions from the arm form of a mechanism.
//!
//! * [`form`]: the mechanism as data: arms, masses between them, loop equations, loads.
//! * `jet`: the series of one motion, by one factorisation and one pass for each order.
//! * `switch`: laws in pieces.
//! * `tape`: scalar series for signals of time and the laws of loads.
//! * `columns`, `coupling`: sparse constants, and the masses among them.
//! * `chain`: what is simpler where frames follow each other in an open chain.
//! * `matrix`, `inverse`, `factors`: the matrix of a pose, as a whole or by its entries.
//! * `lane`, `turn`: four numbers and four angles at a time.

mod chain;
mod check;
mod columns;
mod coupling;
mod factors;
pub mod form;
mod inverse;
mod jet;
pub(crate) mod lane;
mod matrix;
mod switch;
mod tape;
pub(crate) mod turn;

pub use jet::{Jet, Singular};
pub use switch::{Choices, MAX_SWITCHES};

/// The highest order of positions.
pub const MAX_ORDER: usize = 28;
