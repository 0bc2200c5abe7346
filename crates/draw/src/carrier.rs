//! What carries the parts of a picture: by this films and pages move what is drawn once.

use serde::Serialize;

/// What carries a part of a picture.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Carrier {
    /// A body, or the ground.
    Body {
        body: Option<usize>,
    },
    /// A place of one; what it carries turns with it.
    At {
        at: Anchor,
    },
    /// A body's bar along its points, if it is drawn.
    Bar {
        body: usize,
        drawn: bool,
    },
    /// The mark of a mass centre.
    Centre {
        body: usize,
    },
    /// A place; what it carries does not turn.
    Point {
        at: Anchor,
    },
    /// The same of a torque; it is an arrow if it has no sign of its own.
    Turn {
        name: String,
        at: Anchor,
        arrow: bool,
    },
    Stretch(Stretch),
    Band(Band),
    Track(Track),
    /// Names, and arrows that are true at the start only.
    Name,
}

/// A place at the start, and the body that carries it; `None` is the ground.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Anchor {
    pub body: Option<usize>,
    pub at: [f64; 2],
    /// Which point of the body it is, if one of those with a name: these may move when a parameter changes.
    pub point: Option<usize>,
}

/// A sign between two places, such as a spring.
#[derive(Clone, Debug, Serialize)]
pub struct Stretch {
    pub name: String,
    pub ends: [Anchor; 2],
    /// How far it stays away from its ends [px].
    pub retreat: [f64; 2],
    /// The length that its lines are drawn for [pins].
    pub length: f64,
    pub lines: Vec<CarriedLine>,
}

/// A line of a sign: where its points are, and how far they go along if the sign becomes longer by one [pins].
#[derive(Clone, Debug, Serialize)]
pub struct CarriedLine {
    pub closed: bool,
    pub points: Vec<[f64; 3]>,
    /// How it is drawn, first behind all others, then before them.
    #[serde(skip)]
    pub styles: [String; 2],
}

/// The free parts of a band around two circles [px]; the second radius is negative if the band is crossed.
#[derive(Clone, Debug, Serialize)]
pub struct Band {
    pub ends: [Anchor; 2],
    pub radii: [f64; 2],
}

/// Where something goes: along a line that a body carries.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Way {
    /// A point of the line.
    pub base: Anchor,
    pub axis: [f64; 2],
    /// What goes along it.
    pub moving: Anchor,
}

/// The lines that are drawn along a way.
#[derive(Clone, Debug, Serialize)]
pub struct Track {
    #[serde(flatten)]
    pub way: Way,
    /// How far it may go from where it is, if nobody knows [px].
    #[serde(skip)]
    pub unknown: f64,
    pub rails: Vec<Rail>,
}

/// A line along a way [px].
#[derive(Clone, Debug, Serialize)]
pub struct Rail {
    /// The part about the base that it covers in any case.
    pub about: Option<[f64; 2]>,
    /// How far it reaches beyond the way at either end.
    pub beyond: [f64; 2],
    /// How far it lies to the right of the base.
    pub off: f64,
    pub pattern: LinePattern,
    #[serde(skip)]
    pub style: String,
}

/// What a line along a way is made of [px].
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LinePattern {
    Line,
    /// Strokes on its right, or on its left if the side is -1.
    Hatch {
        side: f64,
        pitch: f64,
        depth: f64,
    },
    /// A bar with teeth; one of its gaps begins here.
    Teeth {
        pitch: f64,
        first: f64,
        height: f64,
    },
}

impl Anchor {
    pub fn new(body: Option<usize>, at: [f64; 2]) -> Self {
        Anchor { body, at, point: None }
    }
}

impl Carrier {
    /// The body that it moves and turns with, if it is rigid.
    pub fn rigid(&self) -> Option<Option<usize>> {
        match self {
            Carrier::Body { body } => Some(*body),
            Carrier::At { at } => Some(at.body),
            Carrier::Bar { body, .. } | Carrier::Centre { body } => Some(Some(*body)),
            Carrier::Track(track) => Some(track.way.base.body),
            _ => None,
        }
    }

    /// The same, if it is the body itself and none of its places.
    pub fn whole(&self) -> Option<Option<usize>> {
        self.rigid().filter(|_| matches!(self, Carrier::Body { .. } | Carrier::Bar { .. } | Carrier::Centre { .. }))
    }

    /// The places that it follows.
    pub fn anchors(&mut self) -> Vec<&mut Anchor> {
        match self {
            Carrier::At { at } | Carrier::Point { at } | Carrier::Turn { at, .. } => vec![at],
            Carrier::Stretch(Stretch { ends, .. }) | Carrier::Band(Band { ends, .. }) => ends.iter_mut().collect(),
            Carrier::Track(track) => vec![&mut track.way.base, &mut track.way.moving],
            Carrier::Body { .. } | Carrier::Bar { .. } | Carrier::Centre { .. } | Carrier::Name => Vec::new(),
        }
    }
}

/// Neighbours that one body carries, as one part.
pub fn joined<'a>(
    parts: impl Iterator<Item = (&'a Carrier, String)>,
    body: fn(&Carrier) -> Option<Option<usize>>,
) -> Vec<(&'a Carrier, String)> {
    let mut joined: Vec<(&Carrier, String)> = Vec::new();
    for (carrier, elements) in parts {
        match joined.last_mut() {
            Some((last, together)) if body(carrier).is_some() && body(carrier) == body(last) => *together += &elements,
            _ => joined.push((carrier, elements)),
        }
    }
    joined
}
