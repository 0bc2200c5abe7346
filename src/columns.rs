//! Numbers and columns as people read them.

use std::ops::Range;

/// A number of so many digits without zeros at its end; as a power of ten outside the range.
pub fn rounded(value: f64, digits: usize, plain: Range<f64>) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let last = digits - 1;
    if !plain.contains(&value.abs()) {
        return format!("{value:.last$e}");
    }
    let decimals = last as i32 - value.abs().log10().floor() as i32;
    without_zeros(&format!("{value:.*}", decimals.max(0) as usize)).to_owned()
}

/// Decimals without zeros at their end.
pub fn without_zeros(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

/// `time [s]`
pub fn titled(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// Lines of cells in columns: the first `left` of them to the left, the others to the right.
pub fn aligned(lines: &[Vec<String>], left: usize) -> Vec<String> {
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let line = |line: &Vec<String>| {
        let cells = line.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| match column < left {
            true => format!("{cell:<width$}"),
            false => format!("{cell:>width$}"),
        });
        cells.collect::<Vec<String>>().join("  ").trim_end().to_owned()
    };
    lines.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_so_many_digits() {
        for (value, text) in [
            (0.0, "0"),
            (9.81, "9.81"),
            (-1.0 / 3.0, "-0.333333"),
            (123_456.789, "123457"),
            (1_234_567.8, "1234568"),
            (2e-5, "2.00000e-5"),
            (1e9, "1.00000e9"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(rounded(value, 6, 1e-4..1e7), text);
        }
    }

    #[test]
    fn columns_are_aligned() {
        let lines = [vec!["a".to_owned(), "1".to_owned()], vec!["long".to_owned(), "20".to_owned()]];
        assert_eq!(aligned(&lines, 1), ["a      1", "long  20"]);
        assert_eq!(aligned(&lines, 2), ["a     1", "long  20"]);
    }
}
