//! The row of what pushes two points apart (F): point -> point, a force along the line through them.

use super::course;
use crate::model::{Dimension, Formula, Part};
use crate::network::{Force, Rows, System, TranslationalRow};

/// The part's law pushes the points apart. In one dimension it acts on the second point along +x, and `letter` is its own.
pub(super) fn rows(system: &mut System, part: &Part, letter: &'static str) -> Rows {
    if let Some(rows) = course::rows(part, system) {
        return rows;
    }
    let law = part.law().unwrap_or(Formula::Number(0.0));
    let (letter, through) = match system.mechanism.dimension {
        Dimension::Two => ("F", Force::Line(law)),
        Dimension::One => (letter, Force::World([law, Formula::Number(0.0)])),
    };
    let ends = part.between.map(|place| system.t_node(place));
    Rows { letter, translation: Some(TranslationalRow::force(system, part, ends, through)), ..Rows::default() }
}
