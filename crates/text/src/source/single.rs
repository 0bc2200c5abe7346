//! The C text in single precision: other types, other functions of `math.h`, and constants that are rounded once.

/// Functions of `math.h` that the text calls.
const FUNCTIONS: [&str; 13] =
    ["sqrt", "fabs", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "tanh", "pow"];

/// A text whose numbers are `float`; comments and strings stay.
///
/// # Errors
/// A constant, as it is written, that `float` does not hold: too large, or a divisor next to zero.
pub(super) fn in_single_precision(text: &str) -> Result<String, String> {
    let mut single = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = token(rest, first);
        let (word, after) = rest.split_at(length);
        rest = after;
        match word {
            "double" => single += "float",
            "floor" => single += "floorf",
            _ if FUNCTIONS.contains(&word) => single.extend([word, "f"]),
            _ if first.is_ascii_digit() && word.contains(['.', 'e']) => single += &constant(word, divides(&single))?,
            _ => single += word,
        }
    }
    Ok(single)
}

/// The length of the comment, string, name, number or character with which a text begins.
fn token(text: &str, first: char) -> usize {
    let up_to = |end: &str, from: usize| text[from..].find(end).map_or(text.len(), |at| from + at + end.len());
    let while_of = |belongs: &dyn Fn(char) -> bool| text.find(|next| !belongs(next)).unwrap_or(text.len());
    match first {
        '/' if text.starts_with("/*") => up_to("*/", 2),
        '"' => up_to("\"", 1),
        '#' => up_to("\n", 1),
        '0'..='9' => {
            let digits = while_of(&|next| next.is_ascii_digit() || next == '.' || next == 'e');
            // Up to the sign of an exponent.
            match text[..digits].strip_suffix('e').and(text.get(digits + 1..)) {
                Some(exponent) => digits + 1 + exponent.bytes().take_while(u8::is_ascii_digit).count(),
                None => digits,
            }
        }
        _ if first.is_alphabetic() || first == '_' => while_of(&|next| next.is_alphanumeric() || next == '_'),
        _ => first.len_utf8(),
    }
}

/// True if what follows this text divides.
fn divides(before: &str) -> bool {
    before.trim_end_matches(['(', '-']).ends_with("/ ")
}

/// Rounding leaves factors and sums of less than the smallest number where there should be nothing: they become zero.
fn constant(written: &str, divides: bool) -> Result<String, String> {
    let value: f64 = written.parse().map_err(|_| written.to_owned())?;
    let rounded = value as f32;
    let is_tiny = value.abs() < f64::from(f32::MIN_POSITIVE);
    match (rounded.is_finite(), is_tiny && divides) {
        (true, false) => Ok(if is_tiny { "0.0f".to_owned() } else { format!("{rounded:?}f") }),
        _ => Err(written.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_functions_and_constants_become_single_and_nothing_else_does() {
        let text = "/* a double of 1.5 */ static double f(const double x2) { return sqrt(x2) + 0.1 * x[2] + 1.5e-10 - 2.5e8; } \"1.0 double\"\n#include <math.h>\n";
        let single = "/* a double of 1.5 */ static float f(const float x2) { return sqrtf(x2) + 0.1f * x[2] + 1.5e-10f - 250000000.0f; } \"1.0 double\"\n#include <math.h>\n";
        assert_eq!(in_single_precision(text).unwrap(), single);
    }

    #[test]
    fn constants_that_single_precision_does_not_hold_are_named() {
        assert_eq!(in_single_precision("x = 1e300;"), Err("1e300".to_owned()));
        assert_eq!(in_single_precision("x = a / (-1e-50);"), Err("1e-50".to_owned()));
        assert_eq!(in_single_precision("x = a * 1e-50;").unwrap(), "x = a * 0.0f;");
        assert_eq!(in_single_precision("x = 0.0 + 1e30;").unwrap(), "x = 0.0f + 1e30f;");
    }
}
