//! The signs of the trade: pins, pedestals, sliders, springs, arrows.

use cotree::component::{IconStroke, RoundGlyph};

use super::DrawnSpring;
use super::shapes::{along, difference, extent, norm, normal, unit};
use super::view::View;
use crate::carrier::Rail;
use crate::svg::{Pixel, Svg, number, polyline};

pub const SPRING: &str = "#3d7a4a";
pub const FORCE: &str = "#c0392b";
pub const INK: &str = "#2b333d";
pub const GROUND: &str = "#dfe3e8";
pub const HATCH: &str = "#7c8794";
pub const PAPER: &str = "#ffffff";

const COLOURS: [(&str, &str); 8] = [
    ("#cfe1f6", "#2f6cab"),
    ("#fcdfc2", "#c06a1c"),
    ("#d5ebcf", "#4a8a3f"),
    ("#e5d9f2", "#7d55a8"),
    ("#f8d5d3", "#b8473f"),
    ("#cdebe8", "#2b8a84"),
    ("#f4eabd", "#9c8214"),
    ("#e2dcd6", "#75604c"),
];

/// The colours of a picture by their names in a page, which has them for the light and for the dark.
pub fn named(elements: &str) -> String {
    let bodies = COLOURS
        .iter()
        .enumerate()
        .flat_map(|(index, (fill, edge))| [(*fill, format!("f{index}")), (*edge, format!("e{index}"))]);
    let others = [(SPRING, "spring"), (INK, "ink"), (GROUND, "ground"), (HATCH, "hatch"), (PAPER, "card")];
    let names = bodies.chain(others.map(|(colour, name)| (colour, name.to_owned())));
    names.fold(elements.to_owned(), |text, (colour, name)| text.replace(colour, &format!("var(--{name})")))
}

pub fn colour(body: usize) -> (&'static str, &'static str) {
    COLOURS[body % COLOURS.len()]
}

/// The width of the bar along these corners of a body: none if it has no corners, or slides as a block that is no shorter.
pub fn bar_width(view: &View, outline: &[Pixel], slides: bool) -> Option<f64> {
    let long = extent(outline) > 2.0 * view.pin;
    let width = if long { 2.9 * view.pin } else { 5.0 * view.pin };
    (!outline.is_empty() && (long || !slides)).then_some(width)
}

/// A body: the rounded hull of its corners.
pub fn bar(svg: &mut Svg, index: usize, outline: &[Pixel], width: Option<f64>) {
    let (fill, edge) = colour(index);
    if let Some(width) = width {
        let data = match outline {
            [point] => format!("{}l0 0", polyline(&[*point])), // a dot
            [_, _] => polyline(outline),
            _ => format!("{}Z", polyline(outline)),
        };
        let round = r#"stroke-linejoin="round" stroke-linecap="round""#;
        let outer = number(width + 2.6);
        svg.path(&data, &format!(r#"fill="{edge}" stroke="{edge}" stroke-width="{outer}" {round}"#));
        let inner = number(width);
        svg.path(&data, &format!(r#"fill="{fill}" stroke="{fill}" stroke-width="{inner}" {round}"#));
    }
}

/// A body that slides.
pub fn block(svg: &mut Svg, view: &View, index: usize, at: Pixel, axis: Pixel) {
    let (fill, edge) = colour(index);
    let style = format!(r#"fill="{fill}" stroke="{edge}" stroke-width="1.4" stroke-linejoin="round""#);
    svg.path(&format!("{}Z", polyline(&block_corners(view, at, axis))), &style);
}

/// A body of which the shape is known: what lies behind it, such as a wheel or a bar of its own, shows through a little.
pub fn plate(svg: &mut Svg, index: usize, rim: &[Pixel]) {
    let (fill, edge) = colour(index);
    let style =
        format!(r#"fill="{fill}" fill-opacity="0.9" stroke="{edge}" stroke-width="1.3" stroke-linejoin="round""#);
    svg.path(&format!("{}Z", polyline(rim)), &style);
}

/// An outline of the ground.
pub fn ground_plate(svg: &mut Svg, rim: &[Pixel]) {
    let style = format!(r#"fill="{GROUND}" stroke="{INK}" stroke-width="1.3" stroke-linejoin="round""#);
    svg.path(&format!("{}Z", polyline(rim)), &style);
}

pub fn block_length(view: &View) -> f64 {
    3.7 * view.pin
}

pub fn block_height(view: &View) -> f64 {
    2.3 * view.pin
}

fn block_corners(view: &View, at: Pixel, axis: Pixel) -> [Pixel; 4] {
    let (length, height) = (block_length(view), block_height(view));
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| along(along(at, x * length, axis), y * height, normal(axis)))
}

/// A mass centre: a circle in quarters, of a radius in pins.
pub fn centre(svg: &mut Svg, view: &View, index: usize, at: Pixel, radius: f64) {
    let (_, edge) = colour(index);
    let radius = radius * view.pin;
    svg.circle(at, radius, &format!(r##"fill="#ffffff" stroke="{edge}" stroke-width="1.1""##));
    let ([x, y], r) = (at.map(number), number(radius));
    let quarter = |sweep: &str| format!("M{x} {y}{sweep}Z");
    svg.path(&quarter(&format!("v-{r}a{r} {r} 0 0 1 {r} {r}")), &format!(r#"fill="{edge}""#));
    svg.path(&quarter(&format!("v{r}a{r} {r} 0 0 1 -{r} -{r}")), &format!(r#"fill="{edge}""#));
}

pub fn pin(svg: &mut Svg, view: &View, at: Pixel) {
    svg.circle(at, 0.85 * view.pin, &format!(r##"fill="#ffffff" stroke="{INK}" stroke-width="1.7""##));
    svg.circle(at, 0.2 * view.pin, &format!(r#"fill="{INK}""#));
}

pub fn weld(svg: &mut Svg, view: &View, at: Pixel) {
    let s = 0.8 * view.pin;
    let corners = [[-s, -s], [s, -s], [s, s], [-s, s]].map(|corner| along(at, 1.0, corner));
    svg.path(&format!("{}Z", polyline(&corners)), &format!(r#"fill="{INK}""#));
}

/// A joint that is not engaged: a ring of dashes, with nothing in it.
pub fn open(svg: &mut Svg, view: &View, at: Pixel) {
    let dash = number(0.6 * view.pin);
    svg.circle(
        at,
        1.1 * view.pin,
        &format!(r##"fill="none" stroke="{INK}" stroke-width="1.4" stroke-dasharray="{dash}""##),
    );
}

/// A support below a revolute joint that is fixed to the ground.
pub fn pedestal(svg: &mut Svg, view: &View, at: Pixel) {
    let p = view.pin;
    let (x, y) = (at[0], at[1]);
    let base = y + 3.6 * p;
    let [left, right, foot_left, foot_right] = [x - 1.7 * p, x + 1.7 * p, x - 2.7 * p, x + 2.7 * p].map(number);
    let (top, bottom, round) = (number(y), number(base), number(1.7 * p));
    let data = format!("M{foot_left} {bottom}L{left} {top}A{round} {round} 0 0 1 {right} {top}L{foot_right} {bottom}Z");
    svg.path(&data, &format!(r#"fill="{GROUND}" stroke="{INK}" stroke-width="1.4" stroke-linejoin="round""#));
    hatch(svg, view, [x, base], [0.0, -1.0], 4.2 * p);
}

/// A piece of ground at `at` whose free side faces along `outward`.
pub fn wall(svg: &mut Svg, view: &View, at: Pixel, outward: Pixel) {
    hatch(svg, view, at, outward, 2.6 * view.pin);
}

/// A stop whose free side faces along `outward`.
pub fn stop(svg: &mut Svg, view: &View, at: Pixel, outward: Pixel) {
    hatch(svg, view, at, outward, 1.9 * view.pin);
}

/// A line with hatching behind it: the ground. `half` is half its length.
fn hatch(svg: &mut Svg, view: &View, at: Pixel, outward: Pixel, half: f64) {
    for rail in Rail::earth(view, 0.0, 0.0, 1.0) {
        rail.draw(at, normal(outward), [-half, half], svg);
    }
}

/// A sign at its length, if it has one: else there is nothing to see. A piece of a line has no name and may be as short as it likes.
pub fn spring(svg: &mut Svg, view: &View, ends: [Pixel; 2], spring: &DrawnSpring) {
    let length = norm(difference(ends[1], ends[0]));
    if length >= view.pin || spring.name.is_empty() && length > 0.0 {
        let axis = unit(difference(ends[1], ends[0]));
        let place = |[x, y]: &[f64; 2]| along(along(ends[0], x * view.pin, axis), y * view.pin, normal(axis));
        strokes(svg, &spring.strokes(length / view.pin), &place);
    }
}

/// A sign around a point.
pub fn round_glyph(svg: &mut Svg, view: &View, at: Pixel, glyph: RoundGlyph) {
    strokes(svg, &glyph(), &|[x, y]| [at[0] + x * view.pin, at[1] - y * view.pin]);
}

/// The strokes of a sign, all halos behind all strokes.
fn strokes(svg: &mut Svg, strokes: &[IconStroke], place: &dyn Fn(&[f64; 2]) -> Pixel) {
    for front in [false, true] {
        for stroke in strokes {
            let points: Vec<Pixel> = stroke.points.iter().map(place).collect();
            let close = if stroke.closed { "Z" } else { "" };
            svg.path(&format!("{}{close}", polyline(&points)), &stroke_style(front, stroke.closed));
        }
    }
}

/// The style of a stroke, or of the halo behind it.
pub fn stroke_style(front: bool, closed: bool) -> String {
    let (colour, width, opacity) = if front { (SPRING, 1.7, "") } else { ("#ffffff", 4.0, r#" stroke-opacity="0.8""#) };
    let fill = if closed && !front { "#ffffff" } else { "none" };
    let line = format!(r#"fill="{fill}" stroke-linejoin="round" stroke-linecap="round""#);
    format!(r#"{line} stroke="{colour}" stroke-width="{}"{opacity}"#, number(width))
}

/// The styles of the bar of a link: its edges, and what is between them.
pub fn link_styles(view: &View) -> [String; 2] {
    [(0.9 * view.pin + 2.0, INK), (0.9 * view.pin, PAPER)]
        .map(|(width, colour)| format!(r#"stroke="{colour}" stroke-width="{}""#, number(width)))
}

/// The style of the free parts of a band.
pub fn band_style() -> String {
    format!(r#"stroke="{INK}" stroke-width="2.4""#)
}

/// A force: an arrow that starts at its point, or ends there if it `pushes`. Returns its ends.
pub fn force(svg: &mut Svg, view: &View, at: Pixel, direction: Pixel, pushes: bool) -> [Pixel; 2] {
    let (from, to) = if pushes { (-12.5, -4.2) } else { (1.2, 9.5) };
    let [start, tip] = [from, to].map(|pins| along(at, pins * view.pin, direction));
    svg.line(start, along(tip, -1.4 * view.pin, direction), &format!(r#"stroke="{FORCE}" stroke-width="2.2""#));
    arrow_head(svg, view, tip, direction);
    [start, tip]
}

/// A torque or a motor: three quarters of a circle, counter-clockwise.
pub fn turn(svg: &mut Svg, view: &View, at: Pixel) {
    let radius = 2.9 * view.pin;
    let start = along(at, radius, [0.0, 1.0]);
    let tip = along(at, radius, [-1.0, 0.0]);
    let ([x, y], [u, v], r) = (start.map(number), along(tip, -0.7 * view.pin, [0.0, 1.0]).map(number), number(radius));
    let style = format!(r#"fill="none" stroke="{FORCE}" stroke-width="1.8""#);
    svg.path(&format!("M{x} {y}A{r} {r} 0 1 0 {u} {v}"), &style);
    arrow_head(svg, view, along(tip, 1.0 * view.pin, [0.0, 1.0]), [0.0, 1.0]);
}

/// A driven point: a ring with cross hairs, around a pin if there is one.
pub fn target(svg: &mut Svg, view: &View, at: Pixel) {
    let radius = 1.6 * view.pin;
    svg.circle(at, radius, &format!(r#"fill="none" stroke="{FORCE}" stroke-width="1.8""#));
    for direction in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
        let [inner, outer] = [1.1, 2.4].map(|pins| along(at, pins * view.pin, direction));
        svg.line(inner, outer, &format!(r#"stroke="{FORCE}" stroke-width="1.8""#));
    }
}

/// The direction of a driven point: a dashed arrow, unlike a force. Returns its ends.
pub fn departure(svg: &mut Svg, view: &View, at: Pixel, direction: Pixel) -> [Pixel; 2] {
    let [start, tip] = [2.6, 10.5].map(|pins| along(at, pins * view.pin, direction));
    let style = format!(r#"stroke="{FORCE}" stroke-width="1.8" stroke-dasharray="5 3""#);
    svg.line(start, along(tip, -1.4 * view.pin, direction), &style);
    arrow_head(svg, view, tip, direction);
    [start, tip]
}

fn arrow_head(svg: &mut Svg, view: &View, tip: Pixel, direction: Pixel) {
    let base = along(tip, -2.0 * view.pin, direction);
    let side = normal(direction);
    let corners = [tip, along(base, 0.8 * view.pin, side), along(base, -0.8 * view.pin, side)];
    svg.path(&format!("{}Z", polyline(&corners)), &format!(r#"fill="{FORCE}""#));
}
