//! What is drawn over a mechanism to explain it: angles, nodes of its graph, free bodies, closed paths.

use super::labels::Labels;
use super::shapes::{along, difference, hull, middle, norm, normal, unit};
use super::view::View;
use super::{Drawing, is_finite};
use crate::alike::Alike;
use crate::carrier::Carrier;
use crate::svg::{Pixel, Svg, number, polyline};

/// A sign that explains.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// A closed path, walked in this order.
    Circuit(Vec<[f64; 2]>),
    /// A line around these places: a free body, or one of several that are one.
    Cut(Vec<[f64; 2]>),
    /// An angle from the x axis of the ground, where it is drawn, and its name.
    Angle { at: [f64; 2], angle: f64, name: String },
    /// A node of the graph and its name.
    Node { at: [f64; 2], name: String },
}

const COLOUR: &str = "#c2255c";

impl Drawing {
    pub(super) fn draw_marks(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for mark in &self.marks {
            svg.carry(Carrier::Name);
            match mark {
                Mark::Circuit(places) => circuit(&pixels(places, view), view, svg, labels),
                Mark::Cut(places) => cut(pixels(places, view), view, svg, labels),
                Mark::Angle { at, angle, name } if is_finite(at) && angle.is_finite() => {
                    arc((view.pixel(*at), *angle, name), view, svg, labels);
                }
                Mark::Angle { .. } | Mark::Node { .. } => {}
            }
        }
        for (at, names) in self.nodes(view) {
            svg.carry(Carrier::Name);
            svg.circle(at, 0.32 * view.pin, &format!(r##"fill="{COLOUR}" stroke="#ffffff" stroke-width="0.8""##));
            labels.cover(at, 0.6 * view.pin);
            labels.load(&names.join(", "), at, 1.5 * view.pin, COLOUR);
        }
    }

    /// Where there are nodes, with the names of those that lie there together.
    fn nodes(&self, view: &View) -> Vec<(Pixel, Vec<&str>)> {
        let mut found: Vec<(Pixel, Vec<&str>)> = Vec::new();
        for mark in &self.marks {
            let Mark::Node { at, name } = mark else { continue };
            if !is_finite(at) {
                continue;
            }
            let at = view.pixel(*at);
            if !View::holds(at) {
                continue; // a datum far away: the mechanism would be a dot beside it
            }
            let near = |(place, _): &&mut (Pixel, Vec<&str>)| norm(difference(at, *place)) < 0.5 * view.pin;
            match found.iter_mut().find(near) {
                Some((_, names)) => names.push(name),
                None => found.push((at, vec![name])),
            }
        }
        found
    }
}

fn pixels(places: &[[f64; 2]], view: &View) -> Vec<Pixel> {
    places.iter().filter(|place| is_finite(place)).map(|place| view.pixel(*place)).collect()
}

fn circuit(places: &[Pixel], view: &View, svg: &mut Svg, labels: &mut Labels) {
    let mut corners: Vec<Pixel> = Vec::new();
    for &place in places {
        // Pins have no length.
        if corners.last().is_none_or(|last| norm(difference(place, *last)) > 0.5 * view.pin) {
            corners.push(place);
        }
    }
    let line =
        format!(r#"fill="none" stroke="{COLOUR}" stroke-width="{}" stroke-linejoin="round""#, number(0.4 * view.pin));
    svg.path(&format!("{}Z", polyline(&corners)), &line);
    labels.obstruct(&corners, view.pin);
    let next = corners.iter().cycle().skip(1);
    for (&from, &to) in corners.iter().zip(next).filter(|(from, to)| norm(difference(**to, **from)) > 5.0 * view.pin) {
        let ahead = unit(difference(to, from));
        let at = middle(&[from, to]);
        let side = normal(ahead);
        let [tip, back] = [1.1, -1.1].map(|share| along(at, share * view.pin, ahead));
        let wings = [0.9, -0.9].map(|share| along(back, share * view.pin, side));
        svg.path(&format!("{}Z", polyline(&[tip, wings[0], wings[1]])), &format!(r#"fill="{COLOUR}""#));
    }
}

/// The convex hull with a margin.
fn cut(places: Vec<Pixel>, view: &View, svg: &mut Svg, labels: &mut Labels) {
    let corners = hull(places);
    let margin = 2.6 * view.pin;
    let style =
        format!(r#"fill="none" stroke="{COLOUR}" stroke-width="{}" stroke-dasharray="7 4""#, number(0.35 * view.pin));
    if let [only] = corners[..] {
        svg.circle(only, margin, &style);
        labels.cover(only, margin);
        return;
    }
    let outline = around(&corners, margin);
    svg.path(&format!("{}Z", polyline(&outline)), &format!("{style} stroke-linejoin=\"round\""));
    labels.obstruct(&outline, 0.3 * view.pin);
}

/// The sides of a convex polygon, moved outwards; its corners go round as [`hull`] gives them.
fn around(corners: &[Pixel], margin: f64) -> Vec<Pixel> {
    let next = corners.iter().cycle().skip(1);
    let side = |(&from, &to): (&Pixel, &Pixel)| {
        let inwards = normal(unit(difference(to, from)));
        [from, to].map(|corner| along(corner, -margin, inwards))
    };
    corners.iter().zip(next).flat_map(side).collect()
}

fn arc((at, angle, name): (Pixel, f64, &str), view: &View, svg: &mut Svg, labels: &mut Labels) {
    use std::f64::consts::{PI, TAU};
    let angle = angle - TAU * ((angle + PI) / TAU).floor();
    let radius = 4.6 * view.pin;
    let towards = |angle: f64, radius: f64| along(at, radius, [angle.cosine(), -angle.sine()]);
    let thin = format!(r##"stroke="#5b6673" stroke-width="{}" stroke-dasharray="4 3""##, number(0.16 * view.pin));
    for direction in [0.0, angle] {
        svg.line(at, towards(direction, 1.35 * radius), &thin);
    }
    let [[x0, y0], [x1, y1]] =
        [0.0, angle].map(|angle| towards(angle, radius).map(|value| (value * 100.0).round() / 100.0));
    let (radius_text, large, sweep) = (number(radius), u8::from(angle.abs() > PI), u8::from(angle < 0.0));
    let style = format!(r#"fill="none" stroke="{COLOUR}" stroke-width="{}""#, number(0.28 * view.pin));
    svg.path(&format!("M{x0} {y0}A{radius_text} {radius_text} 0 {large} {sweep} {x1} {y1}"), &style);
    labels.load(name, towards(0.5 * angle, radius), 1.4 * view.pin, COLOUR);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::shapes::covers;

    #[test]
    fn the_line_of_a_cut_lies_around_its_places_with_the_margin() {
        for places in [vec![[0.0, 0.0], [40.0, 10.0]], vec![[0.0, 0.0], [40.0, 10.0], [5.0, 30.0], [12.0, 9.0]]] {
            let outline = around(&hull(places.clone()), 5.0);
            assert!(places.iter().all(|&place| covers(&outline, place, 0.0)), "{outline:?}");
            let nearest =
                |corner: &Pixel| places.iter().map(|&place| norm(difference(*corner, place))).fold(f64::MAX, f64::min);
            assert!(outline.iter().all(|corner| (nearest(corner) - 5.0).abs() < 1e-9), "{outline:?}");
        }
    }
}
