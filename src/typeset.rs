//! Numbers, counts and tables as people read them.

/// A number of so many digits without zeros at its end; as a power of ten if it is very small or very large.
pub fn rounded(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let last = digits - 1;
    if !(1e-4..1e7).contains(&value.abs()) {
        return format!("{value:.last$e}");
    }
    let decimals = last as i32 - value.abs().log10().floor() as i32;
    without_zeros(&format!("{value:.*}", decimals.max(0) as usize)).to_owned()
}

/// A place with six decimals. What they do not show of zero has no sign.
pub fn fixed(value: f64) -> String {
    let text = format!("{value:.6}");
    let is_zero = text.trim_start_matches('-').chars().all(|digit| matches!(digit, '0' | '.'));
    if is_zero { text.trim_start_matches('-').to_owned() } else { text }
}

/// A number as it was written; what arithmetic has made of many digits has six.
pub fn short(value: f64) -> String {
    const WRITTEN: usize = 10;
    let all = format!("{value:?}");
    if all.len() > WRITTEN { rounded(value, 6) } else { all }
}

/// A result: six digits; zero up to the noise, which is what rounding errors may leave of zero.
pub fn number(value: f64, noise: f64) -> String {
    if value.abs() <= noise { "0".to_owned() } else { rounded(value, 6) }
}

/// A measured number: two digits more than its standard error has before its first; ten without one.
pub fn measured(value: f64, error: Option<f64>) -> String {
    let exponent = |value: f64| if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    let last = match error.filter(|error| *error > 0.0 && error.is_finite()) {
        Some(error) => exponent(error) - 2,
        None => exponent(value) - 9,
    };
    // Fifteen digits are all there are.
    let last = last.max(exponent(value) - 14);
    match (-6..=6).contains(&exponent(value)) && last <= 0 {
        true => format!("{value:.*}", last.unsigned_abs() as usize),
        false => format!("{value:.*e}", (exponent(value) - last).max(0) as usize),
    }
}

/// Decimals without zeros at their end.
pub fn without_zeros(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

/// `1 row`, `2 rows`, `2 bodies`
pub fn counted(count: usize, word: &str) -> String {
    match (count, word.strip_suffix("dy")) {
        (1, _) => format!("1 {word}"),
        (_, Some(stem)) => format!("{count} {stem}dies"),
        (_, None) => format!("{count} {word}s"),
    }
}

/// `1 to 2`, `at least 1`, `at most 2`; nothing where there is no end.
pub fn between(ends: [Option<String>; 2]) -> Option<String> {
    match ends {
        [Some(least), Some(most)] => Some(format!("{least} to {most}")),
        [Some(least), None] => Some(format!("at least {least}")),
        [None, Some(most)] => Some(format!("at most {most}")),
        [None, None] => None,
    }
}

/// `time [s]`
pub fn titled(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// A row of a table, of whatever can be displayed.
#[doc(hidden)]
#[macro_export]
macro_rules! cells {
    ($($cell:expr),+ $(,)?) => { vec![$(($cell).to_string()),+] };
}

/// A table as lines that begin with `indent`: the first `left` columns to the left, the others to the right. What ends a row early, such as a
/// reason why there are no figures, makes no column wider.
pub fn aligned(rows: &[Vec<String>], left: usize, indent: &str) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let fills = |row: &&Vec<String>, column: usize| column + 1 < row.len() || row.len() == columns;
    let cells =
        |column: usize| rows.iter().filter(move |row| fills(row, column)).filter_map(move |row| row.get(column));
    let widths: Vec<usize> =
        (0..columns).map(|column| cells(column).map(|cell| cell.chars().count()).max().unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| match column < left {
            true => format!("{cell:<width$}"),
            false => format!("{cell:>width$}"),
        });
        format!("{}\n", format!("{indent}{}", cells.collect::<Vec<String>>().join("  ")).trim_end())
    };
    rows.iter().map(line).collect()
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
            assert_eq!(rounded(value, 6), text);
        }
    }

    #[test]
    fn values_have_the_digits_that_their_errors_permit() {
        for (value, error, text) in [
            (1.234_567, Some(0.001), "1.23457"),
            (0.001, Some(0.001), "0.00100"),
            (123_456.0, Some(20.0), "123456.0"),
            (1.5e9, Some(1e6), "1.50000e9"),
            (-0.5, None, "-0.5000000000"),
        ] {
            assert_eq!(measured(value, error), text);
        }
    }

    #[test]
    fn zeros_have_no_sign_and_times_few_digits() {
        for (value, text) in [(-1e-9, "0.000000"), (-0.0, "0.000000"), (-6e-7, "-0.000001"), (12.5, "12.500000")] {
            assert_eq!(fixed(value), text);
        }
        for (value, text) in [(0.0, "0.0"), (0.001, "0.001"), (1.0 / 75.0, "0.0133333"), (0.1 + 0.2, "0.3")] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn columns_are_aligned() {
        let rows = [cells!["a", 1, "x"], cells!["long", 20, "y"], cells!["b", "why"]];
        assert_eq!(aligned(&rows, 1, ""), "a      1  x\nlong  20  y\nb     why\n");
        assert_eq!(aligned(&rows[..2], 2, "  "), "  a     1   x\n  long  20  y\n");
    }
}
