//! What has no value in rows of a run, while the motion goes on.

use std::collections::BTreeMap;

use crate::scene::{Fault, Span};

/// The variables without a value in rows of a run: those rows have NaN in their place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gaps {
    rows: u64,
    /// Of each column: when it first has none \[s\], and in how many rows.
    found: BTreeMap<usize, (f64, u64)>,
}

/// More variables than this are counted, not named.
const MOST_NAMED: usize = 4;

impl Gaps {
    /// What helps.
    pub const HELP: &'static str = "the cells are empty there; a division by zero, a root or logarithm of a negative number, a reaction in a singular configuration, and dry friction of a driven motion that is at rest or locks have no value; guard the expression, for example by `if`, or remove the output";

    /// Looks at the next row.
    pub fn note(&mut self, time: f64, values: &[f64]) {
        self.rows += 1;
        for (column, _) in values.iter().enumerate().filter(|(_, value)| value.is_nan()) {
            self.found.entry(column).or_insert((time, 0)).1 += 1;
        }
    }

    /// The first column that has any.
    fn first(&self) -> Option<usize> {
        self.found.keys().next().copied()
    }

    /// Which variables have no value and when; nothing if all have one in every row.
    pub fn message(&self, names: &[&str]) -> Option<String> {
        let rows = self.rows;
        let one = |(&column, (time, count)): (&usize, &(f64, u64))| {
            let name = names.get(column).copied().unwrap_or_default();
            format!("`{name}` has no value at t = {time} s ({count} of {rows} rows)")
        };
        let further = self.found.len().saturating_sub(MOST_NAMED);
        let more = (further > 0).then(|| format!("and {further} other outputs"));
        let parts: Vec<String> = self.found.iter().take(MOST_NAMED).map(one).chain(more).collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// The same as a warning, at the place where the first of these variables is asked for.
    pub fn warning(&self, names: &[&str], place: impl Fn(&str) -> Span) -> Option<Fault> {
        let first = self.first().and_then(|first| names.get(first));
        let span = first.map_or_else(Span::default, |name| place(name));
        Some(Fault::warning("solver::no_value", self.message(names)?, span).help(Gaps::HELP))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_time_and_the_number_of_rows_are_told() {
        let mut gaps = Gaps::default();
        gaps.note(0.0, &[1.0, 2.0]);
        assert_eq!((gaps.first(), gaps.message(&["a", "b"])), (None, None));
        gaps.note(0.5, &[1.0, f64::NAN]);
        gaps.note(1.0, &[f64::NAN, f64::NAN]);
        let told = "`a` has no value at t = 1 s (1 of 3 rows), `b` has no value at t = 0.5 s (2 of 3 rows)";
        assert_eq!((gaps.first(), gaps.message(&["a", "b"]).as_deref()), (Some(0), Some(told)));
    }
}
