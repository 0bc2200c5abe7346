//! The geometry of profiles: how far a point is from each feature of one, and where on it.
//!
//! With r from the middle of a feature, its normal n there and its curvature kappa, positive where it is convex: y = n.r, b = 2 y + kappa r.r and the distance b/(1 + sqrt(1 + kappa b)), without a
//! difference of large numbers for a flat arc and the same for a line.

use crate::math::{maximum, minimum};
use crate::model::State;
use crate::program::contour::{Contour, Feature, HELD, Joint, PARKED, Slot};

/// A point that a profile is looked at from.
pub(crate) type Point = [f64; 2];

impl Feature {
    /// The distance of the centre of a disc from where it touches, positive on the free side; of the whole line or circle.
    pub fn gap(&self, point: Point) -> f64 {
        let r = minus(point, self.at);
        let b = 2.0 * dot(self.normal, r) + self.curvature * dot(r, r);
        b / (1.0 + maximum(1.0 + self.curvature * b, 0.0).sqrt())
    }

    /// How far from its middle the point of it is that is nearest, along it.
    pub fn foot(&self, point: Point) -> f64 {
        let (r, [nx, ny]) = (minus(point, self.at), self.normal);
        let tangent = [ny, -nx];
        if self.curvature == 0.0 {
            return dot(tangent, r);
        }
        let towards = 1.0 + self.curvature * dot(self.normal, r);
        libm::atan2(self.curvature * dot(tangent, r), towards) / self.curvature
    }

    /// The end beyond which a point is, if it is beyond one by more than this.
    pub fn beyond(&self, point: Point, least: f64) -> Option<usize> {
        let foot = self.foot(point);
        (foot.abs() > self.half + least).then_some(usize::from(foot > 0.0))
    }

    /// How far the foot of a point is beyond an end at which something is to be done: negative within, smooth, and without such an end far from zero.
    pub fn left(&self, point: Point) -> f64 {
        let foot = self.foot(point);
        match [0, 1].map(|end| self.ends[end].joint == Joint::Concave) {
            [false, false] => (foot * foot - self.half * self.half) / (2.0 * self.half),
            [true, false] => foot - self.half,
            [false, true] => -foot - self.half,
            [true, true] => -self.half,
        }
    }

    /// How far the disc is from it, on either side of it, where its nearest point is; infinite where another feature is nearer.
    pub fn distance(&self, point: Point, radius: f64) -> f64 {
        match self.beyond(point, 0.0) {
            None => {
                let gap = self.gap(point);
                maximum(gap, -gap - 2.0 * radius)
            }
            Some(end) => match self.ends[end].joint {
                Joint::Smooth(_) => f64::INFINITY,
                Joint::Concave | Joint::Free => distance(point, self.ends[end].at) - radius,
            },
        }
    }

    /// True if a disc within a distance `least` of the feature touches it there, and not one of its neighbours.
    pub fn is_touched(&self, point: Point, least: f64) -> bool {
        let is_near = || self.beyond(point, 2.0 * least).is_none();
        self.beyond(point, 0.0).is_none_or(|end| self.ends[end].joint != Joint::Free && is_near())
    }
}

impl Contour {
    /// How far the disc is from the nearest feature that counts.
    pub fn distance(&self, point: Point, counts: impl Fn(usize) -> bool) -> f64 {
        let counting = self.features.iter().enumerate().filter(|(index, _)| counts(*index));
        counting.fold(f64::INFINITY, |least, (_, feature)| minimum(least, feature.distance(point, self.radius)))
    }

    /// True for a feature that goes on where another ends, with the same tangent.
    pub fn are_joined(&self, feature: usize, other: usize) -> bool {
        self.features[feature].ends.iter().any(|end| end.joint == Joint::Smooth(other as u32))
    }

    /// How far inside the disc is in the profile; negative outside. The nearest feature tells on which side of the profile its centre is.
    pub fn depth(&self, point: Point) -> f64 {
        let mut nearest = (f64::INFINITY, f64::NEG_INFINITY);
        for feature in &self.features {
            let (gap, is_beside) = (feature.gap(point), feature.beyond(point, 0.0).is_none());
            let to_centre = (gap + self.radius).abs();
            if is_beside && to_centre < nearest.0 {
                nearest = (to_centre, -gap);
            }
            for end in &feature.ends {
                let corner = distance(point, end.at);
                if corner < nearest.0 {
                    match end.joint {
                        // On the free side of a concave corner one of its features is nearer.
                        Joint::Concave => nearest = (corner, corner + self.radius),
                        Joint::Free => nearest = (corner, self.radius - corner),
                        Joint::Smooth(_) => {}
                    }
                }
            }
        }
        nearest.1
    }
}

fn distance(a: Point, b: Point) -> f64 {
    let [x, y] = minus(a, b);
    (x * x + y * y).sqrt()
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl Slot {
    /// The discrete variable with the number of its feature.
    pub fn number(&self) -> usize {
        self.held[HELD - 1] as usize
    }
}

/// Gives a slot a feature.
pub(crate) fn write(slot: &Slot, index: usize, feature: &Feature, state: &mut State) {
    let Feature { at, normal, curvature, .. } = feature;
    let values = [normal[0], normal[1], at[0], at[1], *curvature, 0.0, index as f64 + 1.0];
    hold(slot, values, state);
}

/// Takes a slot its feature: its gap is then one metre.
pub(crate) fn park(slot: &Slot, state: &mut State) {
    hold(slot, PARKED, state);
}

fn hold(slot: &Slot, values: [f64; HELD], state: &mut State) {
    for (place, value) in slot.held.iter().zip(values) {
        state.discrete_mut()[*place as usize] = value;
    }
}
