//! What something slides or rolls on: as long as its way, in a drawing, in a film, and in each run of a page.

use super::shapes::{along, difference, dot, normal};
use super::symbols::{GROUND, HATCH, INK, PAPER, block_height, colour};
use super::view::View;
use super::{DrawnJoint, Hold, Stop};
use crate::carrier::{Anchor, Carrier, LinePattern, Rail, Track, Way};
use crate::svg::{Pixel, Svg, number, polyline};

impl Track {
    /// Makes it reach to the stops of what slides on it.
    pub fn cover(&mut self, stops: &[&Stop], view: &View) {
        let (base, axis) = (view.pixel(self.way.base.at), view.direction(self.way.axis));
        for reach in stops.iter().map(|stop| stop.reach(base, axis, view)).filter(|reach| reach.is_finite()) {
            for rail in &mut self.rails {
                let [low, high] = rail.about.unwrap_or([reach; 2]);
                rail.about = Some([low.min(reach), high.max(reach)]);
            }
        }
    }

    /// Draws it for a way that goes so far back and forth from here [m], if that is known. Returns the ends of the first line.
    pub fn draw(self, travel: Option<[f64; 2]>, view: &View, svg: &mut Svg) -> [Pixel; 2] {
        let Way { base, axis, moving } = self.way;
        let (base, axis) = (view.pixel(base.at), view.direction(axis));
        let now = dot(difference(view.pixel(moving.at), base), axis);
        let far = travel.map_or([-self.unknown, self.unknown], |far| far.map(|reach| view.length(reach)));
        let way = far.map(|reach| now + reach);
        svg.carry(Carrier::Track(self.clone()));
        let ends = self.rails.iter().map(|rail| rail.draw(base, axis, rail.reach(way), svg));
        ends.collect::<Vec<_>>().first().copied().unwrap_or([base; 2])
    }
}

impl Rail {
    pub fn line(beyond: [f64; 2], style: String) -> Self {
        Rail { about: Some([0.0; 2]), beyond, off: 0.0, pattern: LinePattern::Line, style }
    }

    /// A bar with an edge, as it is seen from above.
    pub fn bar(body: Option<usize>, beyond: [f64; 2], width: f64) -> [Self; 2] {
        let (fill, edge) = body.map_or((GROUND, INK), colour);
        [(width + 2.6, edge), (width, fill)].map(|(width, colour)| Rail::line(beyond, round(width, colour)))
    }

    /// The ground: a line with hatching behind it.
    pub fn earth(view: &View, beyond: f64, off: f64, side: f64) -> [Self; 2] {
        let hatch = LinePattern::Hatch { side, pitch: 1.15 * view.pin, depth: 1.2 * view.pin };
        [(hatch, round(1.1, HATCH)), (LinePattern::Line, round(1.8, INK))].map(|(pattern, style)| Rail {
            about: None,
            beyond: [beyond; 2],
            off,
            pattern,
            style,
        })
    }

    /// From where to where it goes, for the way between two places.
    fn reach(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let [from, to] = [low - self.beyond[0], high + self.beyond[1]];
        self.about.map_or([from, to], |[first, last]| [from.min(first), to.max(last)])
    }

    /// Returns its ends.
    pub fn draw(&self, base: Pixel, axis: Pixel, [from, to]: [f64; 2], svg: &mut Svg) -> [Pixel; 2] {
        let place = |[x, y]: [f64; 2]| along(along(base, x, axis), self.off + y, normal(axis));
        let ends = [[from, 0.0], [to, 0.0]].map(place);
        match self.pattern {
            LinePattern::Line => svg.line(ends[0], ends[1], &self.style),
            LinePattern::Hatch { side, pitch, depth } => {
                let stroke = |step: usize| {
                    let x = if side > 0.0 { from } else { to } + side * pitch * (step as f64 + 0.9);
                    polyline(&[[x, 0.0], [x - side * depth, side * depth]].map(place))
                };
                svg.path(&(0..((to - from) / pitch) as usize).map(stroke).collect::<String>(), &self.style);
            }
            LinePattern::Teeth { pitch, first, height } => {
                let [low, high] = [from, to].map(|end| ((end - first) / pitch).round());
                let at = |share: f64, y: f64| place([first + share * pitch, y]);
                let gap = |gap: i32| {
                    [(0.17, height), (0.35, -height), (0.65, -height), (0.83, height)]
                        .map(|(share, y)| at(f64::from(gap) + share, y))
                };
                let mut corners = vec![at(high, 4.0 * height), at(low, 4.0 * height)];
                corners.extend((low as i32..high as i32).flat_map(gap));
                svg.path(&format!("{}Z", polyline(&corners)), &self.style);
            }
        }
        ends
    }
}

fn round(width: f64, colour: &str) -> String {
    format!(r#"stroke="{colour}" stroke-width="{}" stroke-linecap="round""#, number(width))
}

impl DrawnJoint {
    /// What slides goes along its first body, but for the ground, which stays where it is.
    pub(super) fn way(&self) -> Option<Way> {
        let (Hold::Slider(axis) | Hold::Slot(axis)) = self.kind else { return None };
        let side = usize::from(matches!(self.kind, Hold::Slider(_)) && self.between[1].is_none());
        let [base, moving] = [side, 1 - side].map(|side| Anchor::new(self.between[side], self.at[side]));
        Some(Way { base, axis, moving })
    }

    /// The ground under what slides, the rod that it slides on, or the slot of a pin: a bar with a channel.
    pub(super) fn track(&self, view: &View) -> Option<Track> {
        let way = self.way()?;
        let axis = view.direction(way.axis);
        let away = difference(view.pixel(way.moving.at), view.pixel(way.base.at));
        let rails = match self.kind {
            Hold::Slot(_) => {
                let [bar, channel] = [4.0, 2.0].map(|pins| [pins * view.pin; 2]);
                let lines = [
                    (2.0 * view.pin + 2.2, self.between[0].map_or(INK, |body| colour(body).1)),
                    (2.0 * view.pin, PAPER),
                ];
                let line = |(width, colour)| Rail { about: None, ..Rail::line(channel, round(width, colour)) };
                Rail::bar(way.base.body, bar, 3.6 * view.pin).into_iter().chain(lines.map(line)).collect()
            }
            _ if way.base.body.is_none() => {
                let down = normal(axis);
                // Right of a vertical axis, below any other.
                let up = down[1] < -1e-9 || (down[1].abs() <= 1e-9 && down[0] < 0.0);
                let side = if up { -1.0 } else { 1.0 };
                let off = dot(away, down) + side * (block_height(view) + 1.5);
                Rail::earth(view, 6.0 * view.pin, off, side).into()
            }
            _ => {
                let side = usize::from(dot(away, axis) >= 0.0);
                let beyond = [0, 1].map(|end| if end == side { 7.0 * view.pin } else { 0.0 });
                Rail::bar(way.base.body, beyond, 1.5 * view.pin).into()
            }
        };
        let unknown = match self.kind {
            Hold::Slot(_) => 4.0 * view.pin,
            _ if way.base.body.is_none() => 3.0 * view.pin,
            _ => 0.0,
        };
        Some(Track { way, unknown, rails })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hanging_guide_is_drawn_below_a_level_axis() {
        let view = View::fit(&super::super::Drawing::default());
        for axis in [[1.0, 0.0], [-1.0, 0.0]] {
            let joint = DrawnJoint {
                name: String::new(),
                kind: Hold::Slider(axis),
                between: [None, Some(0)],
                at: [[0.0; 2]; 2],
                open: false,
            };
            let base = view.pixel([0.0; 2])[1];
            let ends = joint.track(&view).unwrap().draw(None, &view, &mut Svg::default());
            assert!(ends.iter().all(|end| end[1] > base), "{ends:?}");
        }
    }
}
