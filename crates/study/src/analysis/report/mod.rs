//! Results of an analysis as a table for people, as JSON and as CSV.

mod changes;
mod equilibrium;
mod linear;
mod modes;

use cotree::columns::{aligned, rounded};
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
    fn text(&self) -> String;
    fn json(&self) -> Value;
    fn csv(&self) -> String;

    /// In a style; ends with a line break.
    fn write(&self, style: Style) -> String {
        match style {
            Style::Text => self.text(),
            Style::Json => format!("{:#}\n", self.json()),
            Style::Csv => self.csv(),
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

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |largest: f64, value| largest.max(value.abs()))
}
