//! Names, put where they cover least.

use super::shapes::{along, difference, norm};
use crate::alike::Alike;
use crate::carrier::Carrier;
use crate::svg::{PictureFrame, Pixel, Svg, text_width};

#[derive(Clone, Debug)]
struct PlacedLabel {
    text: String,
    anchor: Pixel,
    clearance: f64,
    size: f64,
    style: String,
}

/// Names to place, and what they should not cover.
#[derive(Clone, Debug, Default)]
pub struct Labels {
    waiting: Vec<PlacedLabel>,
    obstacles: Vec<(PictureFrame, f64)>,
    placed: Vec<PictureFrame>,
}

impl Labels {
    pub fn body(&mut self, name: &str, anchor: Pixel, pin: f64, colour: &str) {
        self.add(name, anchor, 1.7 * pin, 13.5, format!(r#"fill="{colour}" font-weight="600""#));
    }

    pub fn joint(&mut self, name: &str, anchor: Pixel, clearance: f64) {
        self.add(name, anchor, clearance, 11.0, r##"fill="#5b6673""##.to_owned());
    }

    pub fn load(&mut self, name: &str, anchor: Pixel, clearance: f64, colour: &str) {
        self.add(name, anchor, clearance, 11.5, format!(r#"fill="{colour}" font-style="italic""#));
    }

    pub fn cover(&mut self, at: Pixel, radius: f64) {
        let frame = PictureFrame::centred(at, 2.0 * radius, 2.0 * radius);
        self.obstacles.push((frame, 3.0));
    }

    /// Keeps names away from the edges of a body, but not strictly.
    pub fn obstruct(&mut self, outline: &[Pixel], pin: f64) {
        let next = outline.iter().cycle().skip(1);
        for (&from, &to) in outline.iter().zip(next) {
            let side = difference(to, from);
            let steps = (norm(side) / (2.0 * pin)).ceil().clamp(1.0, 200.0);
            for step in 0..=steps as usize {
                let at = along(from, step as f64 / steps, side);
                let frame = PictureFrame::centred(at, 2.0 * pin, 2.0 * pin);
                self.obstacles.push((frame, 1.5));
            }
        }
    }

    pub fn place(&mut self, svg: &mut Svg) {
        svg.carry(Carrier::Name);
        let mut waiting = std::mem::take(&mut self.waiting);
        waiting.sort_by(|a, b| b.size.total_cmp(&a.size));
        for label in waiting {
            let frame = self.best_place(&label);
            let at = [frame.x + 0.5 * frame.width, frame.y + 0.78 * frame.height];
            let style = format!(r#"font-size="{}" text-anchor="middle""#, label.size);
            // A white halo, as a text of its own: not every viewer knows `paint-order`.
            let halo = r##"fill="none" stroke="#ffffff" stroke-width="3.2" stroke-linejoin="round""##;
            let weight = if label.style.contains("600") { r#" font-weight="600""# } else { "" };
            let slant = if label.style.contains("italic") { r#" font-style="italic""# } else { "" };
            svg.text(at, &format!("{style} {halo}{weight}{slant}"), &label.text);
            svg.text(at, &format!("{style} {}", label.style), &label.text);
            self.placed.push(frame);
        }
    }

    pub fn frame(&self, margin: f64) -> PictureFrame {
        PictureFrame::around(self.placed.iter().chain(self.obstacles.iter().map(|(frame, _)| frame))).widened(margin)
    }

    fn add(&mut self, text: &str, anchor: Pixel, clearance: f64, size: f64, style: String) {
        self.waiting.push(PlacedLabel { text: text.to_owned(), anchor, clearance, size, style });
    }

    /// Of sixteen directions and three distances, the place that covers least and is nearest.
    fn best_place(&self, label: &PlacedLabel) -> PictureFrame {
        let places = (0..3).flat_map(|ring| (0..16).map(move |turn| (ring, turn)));
        let frames = places.map(|(ring, turn)| {
            let gap = label.clearance + 11.0 * f64::from(ring);
            (label.frame(gap, f64::from(turn) * std::f64::consts::TAU / 16.0), gap)
        });
        let cost = |(frame, gap): &(PictureFrame, f64)| self.covered(frame) + 1.2 * gap;
        let best = frames.min_by(|a, b| cost(a).total_cmp(&cost(b)));
        best.map_or_else(|| label.frame(label.clearance, 0.0), |(frame, _)| frame)
    }

    fn covered(&self, frame: &PictureFrame) -> f64 {
        let obstacles = self.obstacles.iter().map(|(other, weight)| weight * frame.overlap(other)).sum::<f64>();
        let names = self.placed.iter().map(|other| 8.0 * frame.overlap(other)).sum::<f64>();
        0.25 * obstacles + names
    }
}

impl PlacedLabel {
    /// The text's box if it touches a circle of radius `gap` around the anchor in a direction.
    fn frame(&self, gap: f64, angle: f64) -> PictureFrame {
        let (width, height) = (text_width(&self.text, self.size), 1.15 * self.size);
        let (sin, cos) = angle.sine_and_cosine();
        let touching = along(self.anchor, gap, [cos, -sin]);
        let lean = |part: f64| (1.5 * part).clamp(-0.5, 0.5); // sideways texts touch with a side, others with a corner
        let centre = along(touching, 1.0, [lean(cos) * width, -lean(sin) * height]);
        PictureFrame::centred(centre, width, height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_cover_each_other() {
        let mut labels = Labels::default();
        for _ in 0..6 {
            labels.joint("wrist_pin", [0.0, 0.0], 8.0);
        }
        labels.place(&mut Svg::default());
        for (i, a) in labels.placed.iter().enumerate() {
            for b in &labels.placed[..i] {
                assert!(a.overlap(b) < 1e-9, "{a:?} {b:?}");
            }
        }
    }
}
