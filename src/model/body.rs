//! Points and the bodies that carry them.

use super::{BodyId, Formula};
use crate::diagnostic::Span;

/// A point with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The user's name within its body.
    pub name: String,
    /// Position relative to the body's mass centre in the body's axes; relative to the origin for the ground.
    pub at: [Formula; 2],
    /// Where it stands in the file.
    pub span: Span,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    /// The user's name.
    pub name: String,
    /// Mass \[kg\]; a kinematic scene needs none.
    pub mass: Option<Formula>,
    /// Inertia about the mass centre [kg.m2]; a body that cannot turn needs none.
    pub inertia: Option<Formula>,
    /// Does gravity leave it alone?
    pub weightless: bool,
    pub points: Vec<Point>,
    /// Its shape, relative to the mass centre.
    pub outline: Option<Outline>,
    /// Where it stands in the file.
    pub span: Span,
}

/// The shape of a body in its axes.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// Its corners in order; two are a thin rod.
    Polygon(Vec<[Formula; 2]>),
    /// Centre and radius.
    Disc([Formula; 2], Formula),
    /// All that is not farther than this from the polygon with these corners, from the line between two, or from one.
    Rounded(Vec<[Formula; 2]>, Formula),
}

impl Outline {
    /// The same with every place changed.
    pub fn map(self, mut place: impl FnMut([Formula; 2]) -> [Formula; 2]) -> Outline {
        match self {
            Outline::Polygon(corners) => Outline::Polygon(corners.into_iter().map(place).collect()),
            Outline::Disc(centre, radius) => Outline::Disc(place(centre), radius),
            Outline::Rounded(corners, offset) => Outline::Rounded(corners.into_iter().map(place).collect(), offset),
        }
    }
}

/// A point that an element uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Place {
    /// The origin of the ground (`ground`).
    Origin,
    /// Index into `Mechanism::ground` (`ground.bearing`).
    Ground(usize),
    /// A body's mass centre (`rod`).
    Centre(BodyId),
    /// Index into the body's points (`rod.big_end`).
    Point(BodyId, usize),
}

impl Place {
    /// The body that the point is fixed to, if not the ground.
    pub fn body(self) -> Option<BodyId> {
        match self {
            Place::Origin | Place::Ground(_) => None,
            Place::Centre(body) | Place::Point(body, _) => Some(body),
        }
    }
}
