//! Results of an analysis as a table for people, as JSON and as CSV.

mod changes;
mod equilibrium;
mod linear;
mod modes;

use cotree::columns;
use cotree::compile::shown;
use cotree::mechanism::Units;
use serde_json::Value;

pub use changes::Features;
pub use equilibrium::Statics;
pub use linear::Linearization;
pub use modes::Vibration;

pub trait Report {
    /// For people, in these units; ends with a line break, as CSV does.
    fn text(&self, units: &Units) -> String;
    /// In SI units.
    fn json(&self) -> Value;
    /// Where it names units, in these; else in SI units.
    fn csv(&self, units: &Units) -> String;
}

/// A table whose first column stands to the left, the others to the right.
pub(crate) fn align(rows: &[Vec<String>]) -> String {
    columns::aligned(rows, 1, "  ")
}

/// A table for spreadsheets.
fn csv(header: &str, lines: impl IntoIterator<Item = String>) -> String {
    std::iter::once(header.to_owned()).chain(lines).map(|line| line + "\n").collect()
}

/// A number beside the largest of its kind: less than rounding leaves of that is zero.
fn number(value: f64, largest: f64) -> String {
    columns::number(value, 1e-13 * largest)
}

/// `t = 2 s`
fn at(time: f64, units: &Units) -> String {
    let second = shown(units, "s");
    format!("t = {} {}", time / second.factor, second.name)
}

/// "in SI units", if nothing else is asked for.
fn told(units: &Units) -> &'static str {
    if *units == Units::default() { ", in SI units" } else { "" }
}

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |largest: f64, value| largest.max(value.abs()))
}
