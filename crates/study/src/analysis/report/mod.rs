//! What analyses find, and the reports of it.

mod changes;
mod equilibrium;
mod linear;
mod modes;

use cotree::report::data::{Cell, Table, number, plain, unit};
use cotree::{line, row};
use serde_json::{Value, json};

use super::Closure;

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

/// Closed, and with what force; open, and by how much.
pub(crate) const MODES: [&str; 2] = ["closed", "open"];

/// The values and units of what is closed, or of what is open.
fn closures_of(closures: &[Closure], word: &str) -> Vec<(String, f64, String)> {
    let own = closures.iter().filter(|own| own.word() == word);
    own.map(|own| {
        let ([length, force], closed) = (own.units(), own.closed);
        let (value, si) = if closed { (own.force, force) } else { (own.gap, length) };
        (own.name.clone(), value, si.to_owned())
    })
    .collect()
}

/// What is closed and what is open, one table each.
fn closure_tables(closures: &[Closure]) -> impl Iterator<Item = Table> + '_ {
    let table = |word| {
        let rows = closures_of(closures, word);
        (!rows.is_empty())
            .then(|| Table::list(word, rows.iter().map(|(name, value, si)| row![name, number(*value, si), unit(si)])))
    };
    MODES.into_iter().filter_map(table)
}

/// The same as data, where anything is held on one side only.
fn closure_data(closures: &[Closure], data: &mut Value) {
    for word in MODES.into_iter().filter(|_| !closures.is_empty()) {
        data[word] = closures_of(closures, word).into_iter().map(|(name, value, _)| (name, json!(value))).collect();
    }
}
