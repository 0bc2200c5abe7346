//! Lengths without a unit that are too large for metres in a linkage: read in metres, as all bare lengths are, they are mostly meant in millimetres.

use super::fault::Fault;
use super::span::Span;

/// Links are hardly ever longer \[m\].
const LONGEST: f64 = 10.0;

/// What all warnings of a scene are about: one of them is enough.
pub(crate) const SUBJECT: &str = "lengths in metres";

/// Is a length too large to be meant in metres?
pub(crate) fn is_unusual(length: f64) -> bool {
    length.is_finite() && length.abs() > LONGEST
}

/// The first length of a list or column that is.
pub(crate) fn among(lengths: &[f64]) -> Option<f64> {
    lengths.iter().copied().find(|length| is_unusual(*length))
}

/// Warns of such a length.
pub(crate) fn warning(what: &str, length: f64, span: Span) -> Fault {
    let help = format!("write `\"{length} mm\"` for millimetres, or `\"{length} m\"` for metres");
    of(what, length, span).help(help)
}

/// Warns of such lengths in a column, which is called so in its first line.
pub(crate) fn of_column(what: &str, name: &str, length: f64, span: Span) -> Fault {
    let help = format!("write `{name} [mm]` in the first line for millimetres, or `{name} [m]` for metres");
    of(what, length, span).help(help)
}

fn of(what: &str, length: f64, span: Span) -> Fault {
    let message = format!("{what} is {length} metres: lengths without a unit are in metres");
    Fault::warning("scene::metres", message, span).label("millimetres?")
}
