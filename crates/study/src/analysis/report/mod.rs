//! Results of an analysis as a table for people, as JSON and as CSV.

mod changes;
mod equilibrium;
mod linear;
mod modes;

use cotree::columns::{aligned, rounded};
use cotree::compile::shown;
use cotree::mechanism::Units;
use serde_json::Value;

pub use changes::Features;
pub use equilibrium::Statics;
pub use linear::Linearization;
pub use modes::Vibration;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    #[default]
    Text,
    Json,
    Csv,
}

pub trait Report {
    /// For people, in these units.
    fn text(&self, units: &Units) -> String;
    /// In SI units.
    fn json(&self) -> Value;
    /// Where it names units, in these; else in SI units.
    fn csv(&self, units: &Units) -> String;

    /// In a style; ends with a line break.
    fn write(&self, style: Style, units: &Units) -> String {
        match style {
            Style::Text => self.text(units),
            Style::Json => format!("{:#}\n", self.json()),
            Style::Csv => self.csv(units),
        }
    }
}

/// Lines of cells in columns: the first to the left, the others to the right.
pub(crate) fn align(lines: &[Vec<String>]) -> String {
    aligned(lines, 1).iter().map(|line| format!("{}\n", format!("  {line}").trim_end())).collect()
}

/// Six significant digits; what is only rounding beside `largest` is zero.
fn number(value: f64, largest: f64) -> String {
    if value.abs() <= 1e-13 * largest { "0".to_owned() } else { rounded(value, 6, 1e-4..1e7) }
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
