//! What does not meet in a mechanism that cannot be assembled.

use cotree::formulate::explain::assembly::show;

use super::labels::Labels;
use super::view::View;
use super::{Drawing, DrawnJoint, Hold, is_finite, shapes, symbols};
use crate::alike::Alike;
use crate::carrier::Carrier;
use crate::svg::{Svg, number};

/// Gaps below this share of the largest are closed.
const CLOSED: f64 = 1e-3;

fn length([from, to]: [[f64; 2]; 2]) -> f64 {
    (to[0] - from[0]).length_with(to[1] - from[1])
}

impl DrawnJoint {
    /// The two places that should be one; of what slides those across its axis.
    fn gap(&self) -> [[f64; 2]; 2] {
        let [from, to] = self.at;
        let along = match self.kind {
            Hold::Pin | Hold::Fixed => [0.0; 2],
            Hold::Slider([x, y]) | Hold::Slot([x, y]) => {
                let share = ((to[0] - from[0]) * x + (to[1] - from[1]) * y) / (x * x + y * y);
                [share * x, share * y]
            }
        };
        [[from[0] + along[0], from[1] + along[1]], to]
    }
}

impl Drawing {
    /// Marks what is open.
    pub fn mark_gaps(&mut self) {
        let gaps: Vec<[[f64; 2]; 2]> = self.joints.iter().map(DrawnJoint::gap).collect();
        let largest = gaps.iter().map(|gap| length(*gap)).filter(|length| length.is_finite()).fold(0.0, f64::max);
        self.gaps = gaps.into_iter().filter(|gap| length(*gap) > CLOSED * largest).collect();
    }

    /// Over everything else.
    pub(super) fn draw_gaps(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        let red = symbols::FORCE;
        for gap in self.gaps.iter().filter(|gap| gap.iter().all(is_finite)) {
            svg.carry(Carrier::Name);
            let ends = gap.map(|end| view.pixel(end));
            let width = number(0.5 * view.pin);
            svg.line(
                ends[0],
                ends[1],
                &format!(r#"class="gap" stroke="{red}" stroke-width="{width}" stroke-dasharray="6 3""#),
            );
            for end in ends {
                svg.circle(end, 0.7 * view.pin, &format!(r#"fill="{red}""#));
            }
            labels.obstruct(&ends, view.pin);
            labels.load(&format!("gap of {}", show(length(*gap), false)), shapes::middle(&ends), 1.8 * view.pin, red);
        }
    }
}
