//! Couplings: gears, belts, racks, rolling discs and links of constant length.

use std::f64::consts::{PI, TAU};

use super::labels::Labels;
use super::shapes::{along, difference, dot, norm, normal, unit};
use super::symbols;
use super::view::View;
use crate::alike::Alike;
use crate::carrier::{Anchor, Band, CarriedLine, Carrier, LinePattern, Rail, Stretch, Track, Way};
use crate::svg::{Pixel, Svg, number, polyline};

#[derive(Clone, Debug, PartialEq)]
pub struct DrawnCoupling {
    pub name: String,
    /// Indices of the bodies; `None` is the ground.
    pub between: [Option<usize>; 2],
    pub kind: CouplingKind,
}

#[derive(Clone, Debug, PartialEq)]
pub enum CouplingKind {
    /// Two toothed wheels whose pitch circles touch; one of them is a ring if it contains the other's centre.
    Gears([Wheel; 2]),
    Band {
        wheels: [Wheel; 2],
        crossed: bool,
    },
    Rack {
        pinion: Wheel,
        /// The body of the bar; `None` is the ground.
        bar: Option<usize>,
        at: [f64; 2],
        foot: [f64; 2],
    },
    Rolling {
        disc: Wheel,
        /// The disc's angle \[rad\].
        angle: f64,
        /// The body of the line; `None` is the ground.
        line: Option<usize>,
        /// The point of the line that the displacement counts from.
        base: [f64; 2],
        /// The line's direction; the disc is on its left.
        axis: [f64; 2],
    },
    Link([[f64; 2]; 2]),
    Cam(DrawnCam),
}

/// A cam with its profile, and what of its follower touches it: a roller, a face, or only an edge.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnCam {
    /// The circle about its shaft that contains it.
    pub hub: Wheel,
    pub outline: Vec<[f64; 2]>,
    pub roller: Option<Wheel>,
    /// The body of the follower, and the ends of its face.
    pub face: Option<(Option<usize>, [[f64; 2]; 2])>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheel {
    /// Index of the body; `None` is the ground.
    pub body: Option<usize>,
    pub centre: [f64; 2],
    /// Its radius; of the pitch circle if it is toothed.
    pub radius: f64,
}

impl DrawnCoupling {
    pub fn is_finite(&self) -> bool {
        self.corners().iter().flatten().all(|x| x.is_finite())
    }

    pub fn corners(&self) -> Vec<[f64; 2]> {
        match &self.kind {
            CouplingKind::Gears(wheels) | CouplingKind::Band { wheels, .. } => {
                wheels.iter().flat_map(Wheel::corners).collect()
            }
            CouplingKind::Rack { pinion, at, .. } => pinion.corners().into_iter().chain([*at]).collect(),
            CouplingKind::Rolling { disc, base, .. } => disc.corners().into_iter().chain([*base]).collect(),
            CouplingKind::Link(ends) => ends.to_vec(),
            CouplingKind::Cam(cam) => {
                let wheels = [Some(cam.hub), cam.roller].into_iter().flatten();
                let face = cam.face.iter().flat_map(|(_, ends)| *ends);
                wheels.flat_map(|wheel| wheel.corners()).chain(cam.outline.iter().copied()).chain(face).collect()
            }
        }
    }

    /// The ends of a link, nothing for other couplings.
    pub fn link_ends(&self) -> Vec<[f64; 2]> {
        if let CouplingKind::Link(ends) = self.kind { ends.to_vec() } else { Vec::new() }
    }

    /// The body of the line (`None` is the ground) and that of the disc that rolls on it.
    pub fn rolling_bodies(&self) -> Option<(Option<usize>, usize)> {
        match &self.kind {
            CouplingKind::Rolling { disc, line, .. } => disc.body.map(|disc| (*line, disc)),
            _ => None,
        }
    }

    pub fn wheels(&self) -> Vec<Wheel> {
        match &self.kind {
            CouplingKind::Gears(wheels) | CouplingKind::Band { wheels, .. } => wheels.to_vec(),
            CouplingKind::Rack { pinion: wheel, .. } | CouplingKind::Rolling { disc: wheel, .. } => vec![*wheel],
            CouplingKind::Link(_) => Vec::new(),
            CouplingKind::Cam(cam) => [Some(cam.hub), cam.roller].into_iter().flatten().collect(),
        }
    }

    /// Draws what lies behind the bodies; what rolls goes so far back and forth, if that is known. Returns where its name belongs.
    pub fn draw(&self, travel: Option<[f64; 2]>, view: &View, svg: &mut Svg, labels: &mut Labels) -> Pixel {
        match &self.kind {
            CouplingKind::Gears(wheels) => draw_gears(*wheels, view, svg, labels),
            CouplingKind::Band { wheels, crossed } => self.draw_band(*wheels, *crossed, view, svg, labels),
            CouplingKind::Rack { pinion, foot, .. } => {
                let teeth = Teeth::of_pinion(pinion, *foot, view);
                let height = teeth.height(view.length(pinion.radius).max(1.0));
                self.draw_track(travel, 3.0 * height, view, svg, labels);
                pinion.draw(view, svg, labels, Some(teeth));
                view.pixel(along(pinion.centre, 1.0, *foot))
            }
            CouplingKind::Rolling { disc, angle, axis, .. } => {
                self.draw_track(travel, 1.3 * view.pin, view, svg, labels);
                disc.draw_turning(*angle, view, svg, labels);
                // To the right of the axis; the picture's y points down.
                along(view.pixel(disc.centre), view.length(disc.radius), normal(view.direction(*axis)))
            }
            CouplingKind::Cam(cam) => cam.draw(view, svg, labels),
            CouplingKind::Link(ends) => {
                let ends = ends.map(|end| view.pixel(end));
                labels.obstruct(&ends, view.pin);
                along(ends[0], 0.5, difference(ends[1], ends[0]))
            }
        }
    }

    pub fn draw_front(&self, view: &View, svg: &mut Svg) {
        let CouplingKind::Link(ends) = self.kind else { return };
        let at = ends.map(|end| view.pixel(end));
        let length = norm(difference(at[1], at[0])) / view.pin;
        let styles = symbols::link_styles(view);
        let line = CarriedLine { closed: false, points: vec![[0.0; 3], [length, 0.0, 1.0]], styles: styles.clone() };
        let ends = [0, 1].map(|side| Anchor::new(self.between[side], ends[side]));
        svg.carry(Carrier::Stretch(Stretch {
            name: self.name.clone(),
            ends,
            retreat: [0.0; 2],
            length,
            lines: vec![line],
        }));
        styles.iter().for_each(|style| svg.line(at[0], at[1], style));
        for at in ends {
            svg.carry(Carrier::At { at });
            symbols::pin(svg, view, view.pixel(at.at));
        }
    }

    /// Where a disc rolls, and where a pinion goes on its rack.
    pub fn way(&self) -> Option<Way> {
        match self.kind {
            CouplingKind::Rolling { disc, line, base, axis, .. } => {
                Some(Way { base: Anchor::new(line, base), axis, moving: disc.anchor() })
            }
            // With the pinion on its left.
            CouplingKind::Rack { pinion, bar, at, foot } => {
                Some(Way { base: Anchor::new(bar, at), axis: normal(foot), moving: pinion.anchor() })
            }
            _ => None,
        }
    }

    /// The line that a disc rolls on, from the base to beyond the contact: the ground, or a bar of a body; or a rack.
    fn track(&self, view: &View) -> Option<Track> {
        let way = self.way()?;
        let rails = match &self.kind {
            CouplingKind::Rack { pinion, foot, .. } => vec![rack(&way, pinion, *foot, view)],
            CouplingKind::Rolling { disc, .. } => {
                let beyond = view.length(disc.radius).max(6.0 * view.pin);
                let (rails, off) = match way.base.body {
                    None => (Rail::earth(view, beyond, 0.0, 1.0), 0.0),
                    Some(_) => (Rail::bar(way.base.body, [beyond; 2], 1.5 * view.pin), 0.75 * view.pin + 1.3),
                };
                rails.map(|rail| Rail { about: Some([-beyond, beyond]), off, ..rail }).into()
            }
            _ => Vec::new(),
        };
        Some(Track { way, unknown: 0.0, rails })
    }

    fn draw_track(&self, travel: Option<[f64; 2]>, room: f64, view: &View, svg: &mut Svg, labels: &mut Labels) {
        if let Some(track) = self.track(view) {
            let ends = track.draw(travel, view, svg);
            labels.obstruct(&ends, room);
        }
    }

    /// The wheels and the common tangents of their circles: the outer ones, or the inner ones if the band is crossed. Returns the middle of one.
    fn draw_band(&self, wheels: [Wheel; 2], crossed: bool, view: &View, svg: &mut Svg, labels: &mut Labels) -> Pixel {
        wheels.iter().for_each(|wheel| wheel.draw_turning(0.0, view, svg, labels));
        let [first, second] = wheels.map(|wheel| view.length(wheel.radius));
        let radii = [first, if crossed { -second } else { second }];
        svg.carry(Carrier::Band(Band { ends: wheels.map(|wheel| wheel.anchor()), radii }));
        let centres = wheels.map(|wheel| view.pixel(wheel.centre));
        let mut middle = centres[0];
        for ends in tangents(centres, radii).into_iter().flatten() {
            svg.line(ends[0], ends[1], &symbols::band_style());
            labels.obstruct(&ends, view.pin);
            middle = along(ends[0], 0.5, difference(ends[1], ends[0]));
        }
        middle
    }
}

/// A bar with teeth, one of which stands in each gap of the pinion.
fn rack(way: &Way, pinion: &Wheel, foot: [f64; 2], view: &View) -> Rail {
    let radius = view.length(pinion.radius).max(1.0);
    let teeth = Teeth::of_pinion(pinion, foot, view);
    let (pitch, axis) = (TAU * radius / teeth.count, view.direction(way.axis));
    let away = difference(view.pixel(along(pinion.centre, 1.0, foot)), view.pixel(way.base.at));
    let (fill, edge) = way.base.body.map_or((symbols::GROUND, symbols::INK), symbols::colour);
    let reach = 0.3 * teeth.count * pitch;
    Rail {
        about: Some([-reach, reach]),
        beyond: [reach; 2],
        off: dot(away, normal(axis)),
        pattern: LinePattern::Teeth { pitch, first: dot(away, axis), height: teeth.height(radius) },
        style: format!(r#"fill="{fill}" stroke="{edge}" stroke-width="1.3" stroke-linejoin="round""#),
    }
}

impl DrawnCam {
    /// Draws the profile and what touches it. Returns where its name belongs.
    fn draw(&self, view: &View, svg: &mut Svg, labels: &mut Labels) -> Pixel {
        let corners: Vec<Pixel> = self.outline.iter().map(|&corner| view.pixel(corner)).collect();
        let (fill, edge) = self.hub.colours();
        svg.carry(Carrier::Body { body: self.hub.body });
        let style = format!(r#"fill="{fill}" fill-opacity="0.75" stroke="{edge}" stroke-width="1.3""#);
        svg.path(&format!("{}Z", polyline(&corners)), &format!(r#"{style} stroke-linejoin="round""#));
        labels.obstruct(&corners, view.pin);
        if let Some(roller) = &self.roller {
            roller.draw_turning(0.0, view, svg, labels);
        }
        if let Some((body, ends)) = self.face {
            let ends = ends.map(|end| view.pixel(end));
            let edge = body.map_or(symbols::INK, |body| symbols::colour(body).1);
            svg.carry(Carrier::Body { body });
            svg.line(ends[0], ends[1], &format!(r#"stroke="{edge}" stroke-width="3.2" stroke-linecap="round""#));
            labels.obstruct(&ends, view.pin);
        }
        corners.into_iter().min_by(|a, b| a[0].total_cmp(&b[0])).unwrap_or_else(|| view.pixel(self.hub.centre))
    }
}

/// How a circle is toothed: how many teeth, the direction in which one has its middle \[rad\], and are they inside?
struct Teeth {
    count: f64,
    phase: f64,
    inside: bool,
}

impl Wheel {
    fn anchor(&self) -> Anchor {
        Anchor::new(self.body, self.centre)
    }

    fn corners(&self) -> Vec<[f64; 2]> {
        let [x, y] = self.centre;
        vec![[x - self.radius, y - self.radius], [x + self.radius, y + self.radius]]
    }

    /// With a spoke in this direction, by which it is seen to turn.
    fn draw_turning(&self, angle: f64, view: &View, svg: &mut Svg, labels: &mut Labels) {
        self.draw(view, svg, labels, None);
        let rim = along(self.centre, self.radius, [angle.cosine(), angle.sine()]);
        let [hub, rim] = [self.centre, rim].map(|point| view.pixel(point));
        svg.line(hub, rim, &format!(r#"stroke="{}" stroke-width="1.6""#, self.colours().1));
    }

    fn colours(&self) -> (&'static str, &'static str) {
        self.body.map_or((symbols::GROUND, symbols::INK), symbols::colour)
    }

    fn draw(&self, view: &View, svg: &mut Svg, labels: &mut Labels, teeth: Option<Teeth>) {
        let (at, radius) = (view.pixel(self.centre), view.length(self.radius));
        let (fill, edge) = self.colours();
        svg.carry(Carrier::At { at: self.anchor() });
        let style = format!(r#"fill="{fill}" fill-opacity="0.75" stroke="{edge}" stroke-width="1.3""#);
        match teeth {
            None => svg.circle(at, radius, &style),
            Some(teeth) => {
                let mut data = teeth.outline(at, radius);
                if teeth.inside {
                    data += &circle(at, radius + 2.2 * teeth.height(radius));
                }
                svg.path(&data, &format!(r#"{style} fill-rule="evenodd" stroke-linejoin="round""#));
                let dashes = format!(r#"fill="none" stroke="{edge}" stroke-width="0.8" stroke-dasharray="7 3 1.5 3""#);
                svg.circle(at, radius, &dashes);
            }
        }
        let rim: Vec<Pixel> = (0..24).map(|step| along(at, radius, direction(TAU * f64::from(step) / 24.0))).collect();
        labels.obstruct(&rim, view.pin);
    }
}

impl Teeth {
    /// On a rack: one tooth is where they touch.
    fn of_pinion(pinion: &Wheel, foot: [f64; 2], view: &View) -> Self {
        let radius = view.length(pinion.radius).max(1.0);
        Teeth { count: teeth(radius, radius, view.pin), phase: foot[1].angle_over(foot[0]), inside: false }
    }

    /// From the pitch circle to the tip, and a little less than to the root.
    fn height(&self, radius: f64) -> f64 {
        1.8 * radius / self.count
    }

    fn outline(&self, centre: Pixel, radius: f64) -> String {
        let side = if self.inside { -1.0 } else { 1.0 };
        let (tip, root) = (radius + side * self.height(radius), radius - 1.1 * side * self.height(radius));
        let corners = (0..self.count as usize).flat_map(|tooth| {
            let middle = self.phase + TAU * tooth as f64 / self.count;
            [(-0.33, root), (-0.15, tip), (0.15, tip), (0.33, root)]
                .map(|(share, reach)| along(centre, reach, direction(middle + share * TAU / self.count)))
        });
        format!("{}Z", polyline(&corners.collect::<Vec<_>>()))
    }
}

/// In the picture, y down; angles are counter-clockwise.
fn direction(angle: f64) -> Pixel {
    [angle.cosine(), -angle.sine()]
}

fn circle([x, y]: Pixel, radius: f64) -> String {
    let ([left, right, y], r) = ([x - radius, x + radius, y].map(number), number(radius));
    format!("M{left} {y}A{r} {r} 0 1 0 {right} {y}A{r} {r} 0 1 0 {left} {y}Z")
}

/// Teeth of about the same size on both wheels, a gap of the second where the first has a tooth.
fn toothed([a, b]: &[Wheel; 2], view: &View) -> [Teeth; 2] {
    let away = difference(b.centre, a.centre);
    let towards_b = away[1].angle_over(away[0]);
    let inner = a.radius.min(b.radius);
    let is_inside = norm(away) < a.radius.max(b.radius);
    let count = |wheel: &Wheel| teeth(view.length(wheel.radius).max(1.0), view.length(inner), view.pin);
    // Inside a ring the pitch point lies behind the smaller wheel's centre, seen from the ring's.
    let towards_pitch = if is_inside && b.radius > a.radius { towards_b + PI } else { towards_b };
    let half = |wheel: &Wheel| PI / count(wheel);
    let of_a = Teeth { count: count(a), phase: towards_pitch, inside: is_inside && a.radius > b.radius };
    let facing = if is_inside { towards_pitch } else { towards_b + PI };
    let of_b = Teeth { count: count(b), phase: facing + half(b), inside: is_inside && b.radius > a.radius };
    [of_a, of_b]
}

/// Draws two wheels that mesh. Returns the pitch point.
fn draw_gears(wheels: [Wheel; 2], view: &View, svg: &mut Svg, labels: &mut Labels) -> Pixel {
    let [a, b] = wheels;
    let [of_a, of_b] = toothed(&wheels, view);
    let towards_pitch = of_a.phase;
    let both = if a.radius > b.radius { [(a, of_a), (b, of_b)] } else { [(b, of_b), (a, of_a)] };
    for (wheel, teeth) in both {
        wheel.draw(view, svg, labels, Some(teeth));
    }
    view.pixel(along(a.centre, a.radius, [towards_pitch.cosine(), towards_pitch.sine()]))
}

/// The free parts of a band: none if one circle lies in the other; they cross if one radius is negative.
pub fn tangents([a, b]: [Pixel; 2], [first, opposite]: [f64; 2]) -> Option<[[Pixel; 2]; 2]> {
    let (distance, axis) = (norm(difference(b, a)), unit(difference(b, a)));
    // The radius to where a tangent touches, along the line of centres and across it.
    let cosine = (first - opposite) / distance;
    let apart = cosine.abs() < 1.0;
    let sine = (1.0 - cosine * cosine).sqrt();
    let touch = |centre: Pixel, radius: f64, side: f64| {
        along(along(centre, radius * cosine, axis), side * radius * sine, normal(axis))
    };
    apart.then(|| [1.0, -1.0].map(|side| [touch(a, first, side), touch(b, opposite, side)]))
}

/// The number of teeth of a wheel, if a wheel of radius `smallest` has as many as are visible, at least eight.
fn teeth(radius: f64, smallest: f64, pin: f64) -> f64 {
    let fewest = (TAU * smallest / (2.6 * pin)).round().clamp(8.0, 24.0);
    (fewest * radius / smallest.max(1.0)).round().clamp(8.0, 240.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{Drawing, DrawnBody};

    fn wheel(body: usize, x: f64, radius: f64) -> Wheel {
        Wheel { body: Some(body), centre: [x, 0.0], radius }
    }

    fn picture(kind: CouplingKind) -> (View, String) {
        let coupling = DrawnCoupling { name: "mesh".into(), between: [None; 2], kind };
        let body = DrawnBody::default();
        let drawing = Drawing { bodies: vec![body.clone(), body], couplings: vec![coupling], ..Drawing::default() };
        (View::fit(&drawing), drawing.svg())
    }

    fn outlines(svg: &str) -> Vec<Vec<Pixel>> {
        let paths = svg.split("<path d=\"M").skip(1).filter_map(|rest| rest.split_once('Z').map(|(path, _)| path));
        let corner = |text: &str| -> Option<Pixel> {
            let (x, y) = text.split_once(' ')?;
            Some([x.parse().ok()?, y.parse().ok()?])
        };
        let paths = paths.map(|path| path.split('L').filter_map(corner).collect::<Vec<_>>());
        paths.filter(|outline| outline.len() > 16).collect()
    }

    /// Seen from a centre, is a corner on the line to the other centre a tip (beyond the pitch circle)?
    fn tip_faces(outline: &[Pixel], centre: Pixel, radius: f64, towards: f64) -> bool {
        let off = |corner: &Pixel| {
            let [x, y] = difference(*corner, centre);
            let angle = (-y).angle_over(x) - towards;
            angle.sine().angle_over(angle.cosine()).abs()
        };
        let nearest = outline.iter().min_by(|a, b| off(a).total_cmp(&off(b))).expect("a wheel has corners");
        norm(difference(*nearest, centre)) > radius
    }

    #[test]
    fn a_tooth_of_one_wheel_stands_in_a_gap_of_the_other() {
        for (a, b) in [(wheel(0, 0.0, 2.0), wheel(1, 3.0, 1.0)), (wheel(0, 0.0, 0.4), wheel(1, 1.7, 1.3))] {
            let (view, svg) = picture(CouplingKind::Gears([a, b]));
            let mut outlines = outlines(&svg);
            outlines.sort_by_key(Vec::len);
            let [small, large] = &outlines[..] else { panic!("{} outlines", outlines.len()) };
            let (of_a, of_b) = if a.radius < b.radius { (small, large) } else { (large, small) };
            assert!(tip_faces(of_a, view.pixel(a.centre), view.length(a.radius), 0.0));
            assert!(!tip_faces(of_b, view.pixel(b.centre), view.length(b.radius), PI));
            let ratio = large.len() as f64 / small.len() as f64;
            let expected = a.radius.max(b.radius) / a.radius.min(b.radius);
            assert!((ratio / expected - 1.0).abs() < 0.05, "{ratio} is not the ratio of the radii {expected}");
        }
    }

    #[test]
    fn a_wheel_inside_a_ring_has_its_teeth_outside_and_the_ring_inside() {
        let (ring, pinion) = (wheel(0, 0.0, 3.0), wheel(1, 2.0, 1.0));
        let (view, svg) = picture(CouplingKind::Gears([ring, pinion]));
        let outlines = outlines(&svg);
        // The larger wheel is drawn first, behind the other.
        assert!(!tip_faces(&outlines[0], view.pixel(ring.centre), view.length(ring.radius), 0.0));
        assert!(!tip_faces(&outlines[1], view.pixel(pinion.centre), view.length(pinion.radius), 0.0));
    }

    #[test]
    fn every_coupling_is_named_and_what_is_not_finite_is_left_out() {
        let disc = wheel(0, 0.0, 1.0);
        let kinds = |x: f64| {
            [
                CouplingKind::Gears([wheel(0, x, 1.0), wheel(1, 3.0, 2.0)]),
                CouplingKind::Rack { pinion: disc, bar: None, at: [x, -1.0], foot: [0.0, -1.0] },
                CouplingKind::Rolling { disc, angle: 0.3, line: Some(1), base: [x, 0.0], axis: [1.0, 0.0] },
                CouplingKind::Link([[x, 0.0], [2.0, 1.0]]),
            ]
        };
        for kind in kinds(0.5) {
            let (_, svg) = picture(kind);
            assert!(svg.contains(">mesh</text>") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
        for kind in kinds(f64::NAN) {
            assert!(!picture(kind).1.contains("mesh"));
        }
    }
}
