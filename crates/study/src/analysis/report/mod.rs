//! Results of an analysis as a table for people, as JSON and as CSV.

mod changes;
mod equilibrium;
mod linear;
mod modes;

use cotree::columns;
use cotree::compile::shown;
use cotree::mechanism::Units;
use cotree::output::csv::field;
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

/// A heading, which may be empty, and the rows below it.
pub(crate) type Table = (&'static str, Vec<Vec<String>>);

/// A result for people: its title, tables whose first column stands to the left, the others to the right, and notes.
pub(crate) fn page(title: &str, tables: impl IntoIterator<Item = Table>, notes: &str) -> String {
    let table = |(heading, rows): Table| {
        let heading = if heading.is_empty() { String::new() } else { format!("{heading}\n") };
        format!("\n{heading}{}", columns::aligned(&rows, 1, "  "))
    };
    format!("{title}\n{}{notes}", tables.into_iter().map(table).collect::<String>())
}

/// A table for spreadsheets.
fn csv(header: &str, rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |row: Vec<String>| row.iter().map(|cell| field(cell)).collect::<Vec<_>>().join(",");
    std::iter::once(header.to_owned()).chain(rows.into_iter().map(line)).map(|line| line + "\n").collect()
}

/// The shortest text that reads back as the same number.
fn exact(value: f64) -> String {
    format!("{value:?}")
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
