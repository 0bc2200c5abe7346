//! What the formats have in common: pins in one pose, and links through them.

/// A linkage in the pose that its file has. SI.
#[derive(Clone, Debug, Default)]
pub struct ImportedLinkage {
    /// The program that it comes from.
    pub program: &'static str,
    /// What the file calls it; may be empty.
    pub title: String,
    /// m/s2; none if the file has none.
    pub gravity: Option<[f64; 2]>,
    pub pins: Vec<Pin>,
    pub links: Vec<ImportedLink>,
    pub drives: Vec<Drive>,
    pub forces: Vec<LinkForce>,
    /// What the file does not say and was assumed, or what was left out.
    pub notes: Vec<String>,
}

#[derive(Clone, Debug)]
pub struct Pin {
    pub name: String,
    pub at: [f64; 2],
    pub kind: PinKind,
    /// Is it held by the ground?
    pub grounded: bool,
    /// Are the links here one piece?
    pub welded: bool,
    /// Is its path of interest?
    pub traced: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PinKind {
    Turning,
    /// The one link here slides along the guide, and does not turn against it.
    Sliding(ImportedGuide),
    /// What is pinned here slides along the guide, and turns.
    Slot(ImportedGuide),
}

impl PinKind {
    pub fn guide(self) -> Option<ImportedGuide> {
        match self {
            PinKind::Turning => None,
            PinKind::Sliding(guide) | PinKind::Slot(guide) => Some(guide),
        }
    }
}

/// A straight line of the ground or of a link, in its direction in the pose of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportedGuide {
    /// The link that it is cut into; none for the ground.
    pub on: Option<usize>,
    pub along: [f64; 2],
}

#[derive(Clone, Debug)]
pub struct ImportedLink {
    pub name: String,
    pub pins: Vec<usize>,
    pub mass: Option<f64>,
    pub inertia: Option<f64>,
    pub centre: Option<[f64; 2]>,
}

/// The motion of a link at a pin against what it is joined to there: an angle, or the way along a guide.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    pub pin: usize,
    pub link: usize,
    pub course: DriveLaw,
}

/// How a drive goes on from the pose of the file, in radians or metres and a second.
#[derive(Clone, Copy, Debug)]
pub enum DriveLaw {
    Steady(f64),
    /// To and fro between two places, at this rate to the upper one first.
    ToAndFro {
        rate: f64,
        from: f64,
        to: f64,
    },
}

#[derive(Clone, Debug)]
pub struct LinkForce {
    pub name: String,
    pub link: usize,
    pub at: [f64; 2],
    pub vector: [f64; 2],
    /// Does it turn with the link?
    pub turns: bool,
}
