//! What carries the parts of a picture: by this films and pages move what is drawn once.

use serde::Serialize;

use super::Turn;
use super::track::Track;

/// What carries a part of a picture; `None` is the ground, places are those at the start.
#[derive(Clone, Debug)]
pub enum Carrier {
    Body(Option<usize>),
    /// A place of a body, which turns with it; a parameter may move it.
    At(Option<usize>, [f64; 2]),
    /// The same of a revolute joint.
    Pin(Option<usize>, [f64; 2]),
    /// The bar along the points of a body, and how far it reaches around them [px]: none if it is not drawn.
    Bar(usize, Option<f64>),
    /// The mark of a mass centre.
    Centre(usize),
    /// A place of a body; what it carries does not turn.
    Point(Option<usize>, [f64; 2]),
    Turn(Turn),
    Stretch(Stretch),
    Band(Band),
    Track(Track),
    /// Names, and arrows that are true at the start only.
    Name,
}

impl Carrier {
    /// The body that it moves and turns with, if it is rigid.
    pub fn rigid(&self) -> Option<Option<usize>> {
        match self {
            Carrier::Body(body) | Carrier::At(body, _) | Carrier::Pin(body, _) => Some(*body),
            Carrier::Bar(body, _) | Carrier::Centre(body) => Some(Some(*body)),
            Carrier::Track(track) => Some(track.way.body),
            _ => None,
        }
    }
}

/// A sign between two places, such as a spring.
#[derive(Clone, Debug)]
pub struct Stretch {
    pub name: String,
    pub between: [Option<usize>; 2],
    pub ends: [[f64; 2]; 2],
    /// How far it stays away from its ends [px].
    pub retreat: [f64; 2],
    /// The length that its lines are drawn for [pins].
    pub length: f64,
    pub lines: Vec<Line>,
}

/// A line of a sign: where its points are, and how far they go along if the sign becomes longer by one [pins].
#[derive(Clone, Debug, Serialize)]
pub struct Line {
    pub closed: bool,
    pub points: Vec<[f64; 3]>,
    /// How it is drawn, first behind all others, then before them.
    #[serde(skip)]
    pub styles: [String; 2],
}

/// The free parts of a band around two circles [px]; the second radius is negative if the band is crossed.
#[derive(Clone, Debug)]
pub struct Band {
    pub between: [Option<usize>; 2],
    pub centres: [[f64; 2]; 2],
    pub radii: [f64; 2],
}
