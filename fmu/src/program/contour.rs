//! Profiles of bodies that a point, or a disc about it, touches: chains of lines and arcs.
//!
//! The centre of a disc touches the profile moved outwards by the radius of the disc. Lines stay lines, an arc keeps its centre, and a convex corner becomes an arc about it, so that the moved
//! profile has a corner only where the profile is concave: there the disc touches two features at once.

use serde::{Deserialize, Serialize};

use crate::tape::Tape;

/// The number of discrete variables that say which feature a slot has.
pub const HELD: usize = 7;
/// What they are in a slot without a feature: the gap is one metre.
pub const PARKED: [f64; HELD] = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// The profiles of all contacts that have one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contours {
    /// One for each such contact.
    pub all: Vec<Contour>,
    /// Where the second point of each is, x and y, from the first point in the axes of its body [m]. Reads time, inputs, followers, q.
    pub places: Tape,
}

/// A profile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contour {
    /// The user's name of the contact.
    pub name: String,
    /// In their order; the free side is on the left.
    pub features: Vec<Feature>,
    /// True for an outline, whose last feature leads to the first.
    pub closed: bool,
    /// The radius of the disc [m].
    pub radius: f64,
    /// Where it touches: so many at once.
    pub slots: Vec<Slot>,
    /// The discrete variable that is 0 once an event has removed the contact.
    pub there: Option<u32>,
}

/// A place where a disc may touch: a contact with the feature that its discrete variables say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slot {
    /// Its place among the contacts.
    pub contact: u32,
    /// The discrete variables with its feature: the normal, a point of it, its curvature, 1 while it has none, and its number from 1 on, else 0.
    pub held: [u32; HELD],
}

/// A line or an arc of a moved profile, seen from its middle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Feature {
    /// Its middle [m].
    pub at: [f64; 2],
    /// Its normal there, towards the free side.
    pub normal: [f64; 2],
    /// Its curvature, positive where it is convex [1/m].
    pub curvature: f64,
    /// From its middle to its ends, along it [m].
    pub half: f64,
    /// What follows before it and behind it.
    pub ends: [End; 2],
}

/// An end of a feature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct End {
    /// Where it is on the profile that has not been moved [m].
    pub at: [f64; 2],
    /// What is there.
    pub joint: Joint,
}

/// What is at an end of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Joint {
    /// Another feature goes on with the same tangent.
    Smooth(u32),
    /// A concave corner: another feature is touched before it.
    Concave,
    /// The profile ends.
    Free,
}

impl Contour {
    /// True if its numbers are those of lines and arcs, and its features follow others of it.
    pub(super) fn is_sound(&self) -> bool {
        let is_feature = |feature: &Feature| {
            let ends = feature.ends.iter();
            let numbers = [feature.at, feature.normal].concat();
            let all = numbers.into_iter().chain([feature.curvature, feature.half]);
            let follows = |end: &End| match end.joint {
                Joint::Smooth(other) => (other as usize) < self.features.len(),
                Joint::Concave | Joint::Free => true,
            };
            all.chain(ends.clone().flat_map(|end| end.at)).all(f64::is_finite)
                && feature.half > 0.0
                && ends.clone().all(follows)
        };
        let is_radius = self.radius >= 0.0 && self.radius.is_finite();
        is_radius && !self.slots.is_empty() && self.features.iter().all(is_feature)
    }
}
