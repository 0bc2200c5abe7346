//! The profile of a contact, and the disc that touches it.

use std::f64::consts::TAU;

use cotree::component::{Glyph, IconStroke};
use cotree::model::Part;

use super::PoseValues;
use crate::alike::Alike;
use crate::drawing::DrawnSpring;

/// Chords of a disc.
const CHORDS: usize = 24;

fn line(length: f64) -> Vec<IconStroke> {
    vec![IconStroke::open(vec![[0.0, 0.0], [length, 0.0]])]
}

impl PoseValues<'_> {
    /// The lines and arcs of a profile on its body, and the disc on the other.
    pub(super) fn profile(&mut self, part: &Part) -> Vec<DrawnSpring> {
        let Some(contour) = part.contour() else { return Vec::new() };
        let [first, second] = part.between;
        let [on, other] = part.bodies();
        let (origin, centre) = (self.at(first), self.at(second));
        let (sine, cosine) = self.angle(on).sine_and_cosine();
        let in_world = |[x, y]: [f64; 2]| [origin[0] + cosine * x - sine * y, origin[1] + sine * x + cosine * y];
        let places: Vec<[f64; 2]> = contour.places().into_iter().map(in_world).collect();
        let around = |chord: usize| {
            let (sine, cosine) = (TAU * chord as f64 / CHORDS as f64).sine_and_cosine();
            [centre[0] + contour.radius * cosine, centre[1] + contour.radius * sine]
        };
        let disc: Vec<[f64; 2]> = match contour.radius > 0.0 {
            true => (0..=CHORDS).map(around).collect(),
            false => Vec::new(),
        };
        let mut drawn = Vec::new();
        for (body, places) in [(on, &places), (other, &disc)] {
            let between = [body.map(|body| body.0); 2];
            for pair in places.windows(2) {
                let name = if drawn.is_empty() { part.name.clone() } else { String::new() };
                drawn.push(DrawnSpring::alone(name, between, [pair[0], pair[1]], line as Glyph));
            }
        }
        drawn
    }
}
