//! What is held on one side only or sticks: stops at the ends of motions, rings where something is closed or sticks, stars where it strikes.

use serde::Serialize;

use super::labels::Labels;
use super::shapes::{along, difference, dot};
use super::view::View;
use super::{Drawing, is_finite, symbols};
use crate::alike::Alike;
use crate::carrier::{Anchor, Carrier};
use crate::svg::{PictureFrame, Pixel, Svg, number, polyline, text_width};

/// The colour of what is closed or sticks, and the line around it.
pub const HELD: &str = "#f2b600";
/// Radius of a ring [pins].
const RING: f64 = 1.75;
/// Half the length of a slider's block [pins], which a stop meets.
const BLOCK: f64 = 3.7;
/// Where the stop of a joint that turns is from its pin, and how far from the middle of the bar that it meets [pins].
const ARM: [f64; 2] = [6.2, 1.9];
/// Rays of a star, and its radii [pins].
const RAYS: usize = 8;
const STAR: [f64; 2] = [1.9, 4.0];

/// Where a limit ends the motion of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// The joint's name.
    pub joint: String,
    /// The body that carries it; `None` is the ground.
    pub on: Option<usize>,
    /// Where the moving point is when it meets it, or the pin of what turns.
    pub at: [f64; 2],
    /// The direction in which it is met.
    pub towards: [f64; 2],
    pub course: StopMotion,
    /// The parameters with which it would stand elsewhere.
    pub needs: Vec<String>,
}

/// How something comes to its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopMotion {
    /// A block that slides.
    Slides,
    /// A pin in a slot.
    InSlot,
    /// A bar that turns, and then lies along this direction.
    Turns([f64; 2]),
}

/// What has modes, with the variables that say which one.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldPart {
    /// Such as `guide.max`.
    pub name: String,
    pub spot: BodySpot,
    pub sticks: bool,
    /// True if it holds in the pose that is drawn.
    pub now: bool,
    /// Each with the value that it has while this holds.
    pub while_held: Vec<(String, f64)>,
    /// The impulse of the last impact: of a part it is that of all its sides.
    pub impulse: Option<String>,
}

/// A place of a body, and how far from it something is, in the axes of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodySpot {
    pub on: Option<usize>,
    pub at: [f64; 2],
    /// The body that this turns with, and how far it is in the world.
    pub off: Option<(Option<usize>, [f64; 2])>,
}

/// A stop for a page.
#[derive(Clone, Debug, Serialize)]
pub(super) struct StopForm {
    pub at: Anchor,
    pub needs: Vec<String>,
}

/// What has modes, for a page: places in the axes of their bodies.
#[derive(Clone, Debug, Serialize)]
pub(super) struct HeldForm {
    pub name: String,
    pub at: Anchor,
    pub off: Option<Anchor>,
    pub sticks: bool,
    #[serde(rename = "while")]
    pub while_held: Vec<(String, f64)>,
    pub impulse: Option<String>,
}

impl Stop {
    /// How far from a place it reaches along an axis [px].
    pub(super) fn reach(&self, from: Pixel, axis: Pixel, view: &View) -> f64 {
        let block = if self.course == StopMotion::Slides { BLOCK * view.pin } else { view.pin };
        let sense = dot(view.direction(self.towards), axis).signum();
        dot(difference(view.pixel(self.at), from), axis) + sense * (block + 2.0 * view.pin)
    }

    /// A piece of ground across the way.
    fn draw(&self, view: &View, svg: &mut Svg) -> Pixel {
        let (at, towards) = (view.pixel(self.at), view.direction(self.towards));
        let at = match self.course {
            StopMotion::Slides => along(at, BLOCK * view.pin, towards),
            StopMotion::InSlot => along(at, view.pin, towards),
            StopMotion::Turns(bar) => {
                let [far, beside] = ARM;
                along(along(at, far * view.pin, view.direction(bar)), beside * view.pin, towards)
            }
        };
        symbols::stop(svg, view, at, [-towards[0], -towards[1]]);
        at
    }
}

impl BodySpot {
    /// Where it is in the pose that is drawn.
    pub fn place(&self) -> [f64; 2] {
        let [x, y] = self.at;
        self.off.map_or([x, y], |(_, [u, v])| [x + u, y + v])
    }
}

impl Drawing {
    /// The stops that are somewhere, in the order in which they are drawn after all joints.
    pub(super) fn placed_stops(&self) -> impl Iterator<Item = &Stop> {
        self.stops.iter().filter(|stop| is_finite(&stop.at) && is_finite(&stop.towards))
    }

    pub(super) fn draw_stops(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for stop in self.placed_stops() {
            svg.carry(Carrier::At { at: Anchor::new(stop.on, stop.at) });
            let at = stop.draw(view, svg);
            labels.cover(at, 2.0 * view.pin);
        }
    }

    /// Rings around what is closed or sticks in the pose that is drawn.
    pub(super) fn draw_held(&self, view: &View, svg: &mut Svg) {
        for held in self.held.iter().filter(|held| held.now && is_finite(&held.spot.place())) {
            svg.carry(Carrier::Name);
            ring(svg, view, view.pixel(held.spot.place()), held.sticks);
        }
    }
}

/// What a film explains below it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Legend {
    pub closed: bool,
    pub sticks: bool,
    pub strikes: bool,
}

/// Size of its words [px], and space between them and their signs [pins].
const WORDS: f64 = 12.0;
const SPACE: f64 = 2.6;

impl Legend {
    pub fn is_empty(self) -> bool {
        !(self.closed || self.sticks || self.strikes)
    }

    /// A line below the picture; returns the frame with it.
    pub fn draw(self, svg: &mut Svg, view: &View, frame: PictureFrame) -> PictureFrame {
        let space = SPACE * view.pin;
        let (mut x, y) = (frame.x + space, frame.y + frame.height);
        let signs = [(self.closed, "closed"), (self.sticks, "sticks"), (self.strikes, "strikes")];
        for (_, word) in signs.into_iter().filter(|(is_there, _)| *is_there) {
            match word {
                "strikes" => star(svg, view, [x, y], 0.6),
                _ => ring(svg, view, [x, y], word == "sticks"),
            }
            svg.text([x + space, y + 0.35 * WORDS], &format!(r#"{NAME} text-anchor="start""#), word);
            x += 2.0 * space + text_width(word, WORDS) + view.pin;
        }
        PictureFrame { height: frame.height + space, width: frame.width.max(x - frame.x), ..frame }
    }
}

/// How names of what has modes are written.
const NAME: &str = r##"font-size="12" fill="#2b333d""##;

pub(super) fn ring_with_name(svg: &mut Svg, view: &View, at: Pixel, held: &HeldPart) {
    ring(svg, view, at, held.sticks);
    name(svg, view, at, &held.name);
}

pub(super) fn star_with_name(svg: &mut Svg, view: &View, at: Pixel, name_of: &str) {
    star(svg, view, at, 1.0);
    name(svg, view, at, name_of);
}

fn name(svg: &mut Svg, view: &View, [x, y]: Pixel, text: &str) {
    let style = format!(
        r##"{NAME} text-anchor="middle" stroke="#ffffff" stroke-width="3" paint-order="stroke" stroke-linejoin="round""##
    );
    svg.text([x, y - 4.6 * view.pin], &style, text);
}

/// Something is closed, or sticks: then the ring is broken.
fn ring(svg: &mut Svg, view: &View, at: Pixel, sticks: bool) {
    let dash = if sticks {
        format!(r#" stroke-dasharray="{0} {0}""#, number(RING * view.pin * std::f64::consts::PI / 6.0))
    } else {
        String::new()
    };
    for (width, colour) in [(0.95, symbols::INK), (0.65, HELD)] {
        let style = format!(r#"fill="none" stroke="{colour}" stroke-width="{}"{dash}"#, number(width * view.pin));
        svg.circle(at, RING * view.pin, &style);
    }
}

/// Something strikes.
fn star(svg: &mut Svg, view: &View, at: Pixel, size: f64) {
    let corner = |index: usize| {
        let (sine, cosine) = (std::f64::consts::PI * index as f64 / RAYS as f64).sine_and_cosine();
        along(at, size * STAR[1 - index % 2] * view.pin, [cosine, sine])
    };
    let corners: Vec<Pixel> = (0..2 * RAYS).map(corner).collect();
    let style = format!(r#"fill="{HELD}" stroke="{}" stroke-width="1" stroke-linejoin="round""#, symbols::INK);
    svg.path(&format!("{}Z", polyline(&corners)), &style);
}
