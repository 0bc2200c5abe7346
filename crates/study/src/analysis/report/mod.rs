//! What analyses find, and the reports of it.

mod changes;
mod equilibrium;
mod linear;
mod modes;

use cotree::line;
use cotree::report::data::{Cell, number, plain};

pub use changes::Features;
pub use equilibrium::Statics;
pub use linear::Linearization;
pub use modes::Vibration;

/// `t = 2 s`
fn at(time: f64) -> Cell {
    line!["t = ", number(time, "s")]
}

/// A number without unit as it is.
fn exact(value: f64) -> Cell {
    plain(value, 0.0)
}
