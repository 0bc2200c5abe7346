//! Roberts' cognates: three four-bars draw each coupler curve.
//!
//! Source: S. Roberts, *On three-bar motion in plane space*, 1875. With `lambda = (P - A)/(B - A)` the third pivot is `A0 + lambda (B0 - A0)`.

use crate::Point;
use crate::dyad::Dyad;
use crate::linkage::Linkage;
use crate::poses::Pose;

/// Five points of a four-bar in one pose: pivots in the ground, pins in the coupler, point of the coupler.
pub type Places = [Point; 5];

/// The two cognates of a four-bar in one of its poses.
pub fn cognates([a0, b0, a, b, p]: Places) -> [Places; 2] {
    let one = Point::new(1.0, 0.0);
    let lambda = (p - a) / (b - a);
    let c0 = a0 + lambda * (b0 - a0);
    let left = a0 + (p - a);
    let right = b0 + (p - b);
    [[a0, c0, left, left + lambda * (a - a0), p], [b0, c0, right, right + (one - lambda) * (b - b0), p]]
}

/// The two cognates of a four-bar for a point of its coupler, with that point as the origin of the coupler's frame; none if it is no four-bar or if
/// the point is one of its pins.
pub fn coupler_cognates(linkage: &Linkage, point: Point, pose: &Pose) -> Option<[(Linkage, Pose); 2]> {
    let (Dyad::Bar { moving: a, ground: a0, .. }, Dyad::Bar { moving: b, ground: b0, .. }) =
        (linkage.first, linkage.second)
    else {
        return None;
    };
    let places = [a0, b0, pose.carry(a), pose.carry(b), pose.carry(point)];
    let size = (b0 - a0).norm() + (a - b).norm();
    let near = 1e-9 * size;
    if (point - a).norm() < near || (point - b).norm() < near || (b - a).norm() < near {
        return None;
    }
    let built = |[a0, b0, a, b, p]: Places| {
        let bar = |pin: Point, ground: Point| Dyad::Bar { moving: pin - p, ground, length: (pin - ground).norm() };
        (Linkage { first: bar(a, a0), second: bar(b, b0) }, Pose { at: p, angle: 0.0 })
    };
    Some(cognates(places).map(built))
}
