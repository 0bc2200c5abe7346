//! What the formats have in common: pins in one pose, and links through them.

/// A linkage in the pose that its file has. SI.
#[derive(Clone, Debug, Default)]
pub struct Linkage {
    /// The program that it comes from.
    pub program: &'static str,
    /// What the file calls it; may be empty.
    pub title: String,
    pub gravity: bool,
    pub pins: Vec<Pin>,
    pub links: Vec<Link>,
    pub drives: Vec<Drive>,
    pub forces: Vec<Force>,
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
    /// Is its path of interest?
    pub traced: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PinKind {
    Turning,
    /// The one link here slides along this direction of the ground, and does not turn.
    Sliding([f64; 2]),
    /// What is pinned here slides along this direction of the ground, and turns.
    Slot([f64; 2]),
}

#[derive(Clone, Debug)]
pub struct Link {
    pub name: String,
    pub pins: Vec<usize>,
    pub mass: Option<f64>,
    pub inertia: Option<f64>,
    pub centre: Option<[f64; 2]>,
}

/// A link that is turned against the ground at a constant rate.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    pub pin: usize,
    pub link: usize,
    /// In rad/s.
    pub rate: f64,
}

#[derive(Clone, Debug)]
pub struct Force {
    pub name: String,
    pub link: usize,
    pub at: [f64; 2],
    pub vector: [f64; 2],
    /// Does it turn with the link?
    pub turns: bool,
}
