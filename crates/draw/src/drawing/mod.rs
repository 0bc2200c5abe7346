//! A drawing of the mechanism in one position, as a textbook would draw it.

mod coupling;
mod film;
mod gap;
mod geometry;
mod held;
mod labels;
mod layout;
mod marks;
mod paint;
mod rounded;
mod shapes;
mod symbols;
#[cfg(test)]
mod tests;
mod track;
mod view;

use cotree::component::{Glyph, RoundGlyph};

use super::svg::{PictureFrame, Svg, number};
pub use coupling::{CouplingKind, DrawnCam, DrawnCoupling, Wheel};
pub use film::{Film, Shows};
pub use geometry::Geometry;
pub use held::{BodySpot, HeldPart, Stop, StopMotion};
use labels::Labels;
pub use marks::Mark;
pub use rounded::widened;
use view::View;

/// What is drawn, in the world \[m\]. What has a coordinate that is not finite is left out.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    pub title: String,
    pub bodies: Vec<DrawnBody>,
    /// Points of the ground that something is fixed to.
    pub ground: Vec<[f64; 2]>,
    /// The outlines of the ground.
    pub ground_shapes: Vec<DrawnShape>,
    pub joints: Vec<DrawnJoint>,
    pub couplings: Vec<DrawnCoupling>,
    pub springs: Vec<DrawnSpring>,
    pub forces: Vec<DrawnForce>,
    pub turns: Vec<Turn>,
    pub targets: Vec<Target>,
    /// Where limits end the motion of joints.
    pub stops: Vec<Stop>,
    /// What is held on one side only, or sticks.
    pub held: Vec<HeldPart>,
    /// Places that should be one where the mechanism cannot be assembled.
    pub gaps: Vec<[[f64; 2]; 2]>,
    /// What explains it.
    pub marks: Vec<Mark>,
    pub range: FilmRange,
}

/// How far everything moves in a film; nothing of a still picture.
#[derive(Clone, Debug, Default)]
pub struct FilmRange {
    /// Every place that is reached.
    pub corners: Vec<[f64; 2]>,
    /// How far each joint slides from here, back and forth.
    pub joints: Vec<[f64; 2]>,
    /// The same of what rolls.
    pub couplings: Vec<[f64; 2]>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnBody {
    pub name: String,
    pub points: Vec<[f64; 2]>,
    pub centre: [f64; 2],
    /// Its shape, if it is known; else it is drawn as a bar along its points.
    pub shape: Option<DrawnShape>,
}

/// The shape of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum DrawnShape {
    /// Its corners in order.
    Polygon(Vec<[f64; 2]>),
    /// Centre and radius.
    Disc([f64; 2], f64),
}

#[derive(Clone, Debug, PartialEq)]
pub struct DrawnJoint {
    /// The user's name; empty for one that is drawn but not there.
    pub name: String,
    pub kind: Hold,
    /// Indices of the bodies; `None` is the ground.
    pub between: [Option<usize>; 2],
    /// Where the joint is on either body: the same place for a revolute joint.
    pub at: [[f64; 2]; 2],
    /// True if it holds nothing now: events engage it.
    pub open: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    Pin,
    Slider([f64; 2]),
    /// Sliding along this direction in the world, and turning.
    Slot([f64; 2]),
    Fixed,
}

/// A sign along the line between two points, such as a spring.
#[derive(Clone, Debug)]
pub struct DrawnSpring {
    pub name: String,
    /// Indices of the bodies; `None` is the ground.
    pub between: [Option<usize>; 2],
    pub ends: [[f64; 2]; 2],
    pub(crate) glyph: Glyph,
    /// How far its sign lies to the right of the line between the ends, seen along it in the picture [pins]: others have the same ends.
    pub(crate) beside: f64,
}

impl DrawnSpring {
    /// One without another between the same ends.
    pub(crate) fn alone(name: String, between: [Option<usize>; 2], ends: [[f64; 2]; 2], glyph: Glyph) -> DrawnSpring {
        DrawnSpring { name, between, ends, glyph, beside: 0.0 }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct DrawnForce {
    pub name: String,
    /// Index of the body; `None` is the ground.
    pub on: Option<usize>,
    pub at: [f64; 2],
    /// Its direction in the world; the length is not used.
    pub direction: [f64; 2],
}

#[derive(Clone, Debug)]
pub struct Turn {
    pub name: String,
    /// Index of the body that carries the place; `None` is the ground.
    pub on: Option<usize>,
    /// Where to draw it: the joint, or the mass centre.
    pub at: [f64; 2],
    /// Its strokes; a round arrow if it has none.
    pub(crate) glyph: Option<RoundGlyph>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    pub name: String,
    /// Index of the body; `None` is the ground.
    pub on: Option<usize>,
    pub at: [f64; 2],
    /// The direction of its motion, if it moves; the length is not used.
    pub direction: Option<[f64; 2]>,
}

type Layer = fn(&Drawing, &View, &mut Svg, &mut Labels);
/// The mechanism from back to front; a page has the same layers.
const LAYERS: [(&str, Layer); 5] = [
    ("couplings", Drawing::draw_couplings),
    ("ground", Drawing::draw_ground),
    ("bodies", Drawing::draw_bodies),
    ("springs", Drawing::draw_loads),
    ("pins", Drawing::draw_joints),
];
/// Space around the drawing [px].
const MARGIN: f64 = 20.0;

impl Drawing {
    pub fn svg(&self) -> String {
        let (svg, frame) = self.picture();
        svg.finish(frame, &self.title)
    }

    /// The picture without names, which could not be read where it is small.
    pub fn svg_without_names(&self) -> String {
        let mut labels = Labels::default();
        let svg = self.unlabelled(&View::fit(self), &mut labels);
        svg.finish(labels.frame(MARGIN), &self.title)
    }

    /// The picture as a group of elements with its upper left corner at the origin, to be put into another; width and height.
    pub fn nested(&self) -> (String, [f64; 2]) {
        let (svg, PictureFrame { x, y, width, height }) = self.picture();
        let shift = [-x, -y].map(number);
        (format!("<g transform=\"translate({} {})\">\n{}</g>", shift[0], shift[1], svg.elements()), [width, height])
    }

    fn picture(&self) -> (Svg, PictureFrame) {
        let mut labels = Labels::default();
        let mut svg = self.unlabelled(&View::fit(self), &mut labels);
        labels.place(&mut svg);
        let frame = labels.frame(MARGIN);
        (svg, frame)
    }

    /// The picture without names.
    fn elements(&self, view: &View) -> Svg {
        self.unlabelled(view, &mut Labels::default())
    }

    fn unlabelled(&self, view: &View, labels: &mut Labels) -> Svg {
        let mut svg = Svg::default();
        LAYERS.into_iter().for_each(|(_, draw)| draw(self, view, &mut svg, labels));
        self.draw_targets(view, &mut svg, labels);
        self.draw_held(view, &mut svg);
        self.draw_gaps(view, &mut svg, labels);
        self.draw_marks(view, &mut svg, labels);
        svg
    }
}

fn is_finite(point: &[f64; 2]) -> bool {
    point.iter().all(|x| x.is_finite())
}
