//! Results of an analysis as a table for people, as JSON and as CSV.

mod changes;
mod equilibrium;
mod linear;
mod modes;

pub use changes::Features;
pub use equilibrium::Statics;
pub use linear::Linearization;
pub use modes::Vibration;

use serde_json::Value;

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
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let mut text = String::new();
    for line in lines {
        let cells = line.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| match column {
            0 => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        let cells: Vec<String> = cells.collect();
        text.push_str(format!("  {}", cells.join("  ")).trim_end());
        text.push('\n');
    }
    text
}

/// Six significant digits; what is only rounding beside `largest` is zero.
fn number(value: f64, largest: f64) -> String {
    let size = value.abs();
    if size <= 1e-13 * largest {
        return "0".to_owned();
    }
    if !(1e-4..1e7).contains(&size) {
        return format!("{value:.5e}");
    }
    let before = size.log10().floor() as i32 + 1;
    let text = format!("{value:.*}", usize::try_from(6 - before).unwrap_or(0));
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |largest: f64, value| largest.max(value.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits() {
        for (value, text) in [
            (0.0, "0"),
            (9.81, "9.81"),
            (-1.0 / 3.0, "-0.333333"),
            (123_456.789, "123457"),
            (1_234_567.8, "1234568"),
            (2e-5, "2.00000e-5"),
            (1e9, "1.00000e9"),
            (1e-17, "0"),
        ] {
            assert_eq!(number(value, 1.0), text);
        }
    }

    #[test]
    fn columns_are_aligned() {
        let lines = [vec!["a".to_owned(), "1".to_owned()], vec!["long".to_owned(), "20".to_owned()]];
        assert_eq!(align(&lines), "  a      1\n  long  20\n");
    }
}
