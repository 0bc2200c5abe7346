//! Comparison with other trees: numbers of coordinates and loop equations.

use cotree::formulate::equations;
use cotree::model::CoordinateChoice;

use super::{Lesson, heading};
use crate::document::{DocumentBlock, Piece};

impl Lesson<'_> {
    pub fn gain(&self) -> Vec<DocumentBlock> {
        let mechanism = &self.source.equations.system.mechanism;
        let counts = (self.equations.coordinates.len(), self.equations.loops().count());
        let mut rows = Vec::new();
        for (text, choice) in [
            ("all bodies in both (absolute coordinates)", CoordinateChoice::Absolute),
            ("joints in both (joint coordinates)", CoordinateChoice::Joint),
        ] {
            if let Ok(other) = equations(mechanism, &choice) {
                rows.push((text, (other.coordinates.len(), other.loops().count())));
            }
        }
        rows.push(("these", counts));
        let row = |(text, (n, m)): &(&str, (usize, usize))| {
            [(*text).to_owned(), n.to_string(), m.to_string(), (n + m).to_string()].map(Piece::words).to_vec()
        };
        let head = ["trees", "coordinates", "loop equations", "together"].map(str::to_owned);
        vec![
            heading("12. What was gained?"),
            DocumentBlock::captioned("What other trees would cost", head.into(), rows.iter().map(row).collect()),
        ]
    }
}
