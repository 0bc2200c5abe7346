//! From the world to the picture.

use super::{Drawing, DrawnShape, is_finite, shapes};
use crate::svg::Pixel;

/// Largest width and height of the mechanism itself [px].
const SIZE: [f64; 2] = [680.0, 420.0];

/// Scale and origin of a drawing, and the size of its symbols.
#[derive(Clone, Copy, Debug)]
pub struct View {
    scale: f64,
    origin: [f64; 2],
    /// Radius of a revolute joint [px]; every symbol follows it.
    pub pin: f64,
}

impl View {
    pub fn fit(drawing: &Drawing) -> Self {
        let points = points(drawing);
        let [low, high] = bounds(&points);
        let span = [high[0] - low[0], high[1] - low[1]];
        let scale = (SIZE[0] / span[0]).min(SIZE[1] / span[1]);
        let scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
        Self { scale, origin: [low[0], high[1]], pin: pin_radius(drawing, scale) }
    }

    /// With the world's origin in the corner.
    pub fn in_world(self) -> Self {
        View { origin: [0.0; 2], ..self }
    }

    pub fn pixel(&self, [x, y]: [f64; 2]) -> Pixel {
        [(x - self.origin[0]) * self.scale, (self.origin[1] - y) * self.scale]
    }

    /// Is it in the picture, or not far from it?
    pub fn holds(at: Pixel) -> bool {
        at.iter().zip(SIZE).all(|(&x, size)| x > -0.5 * size && x < 1.5 * size)
    }

    pub fn length(&self, length: f64) -> f64 {
        length * self.scale
    }

    /// How far two places of the world lie apart in the picture.
    pub fn distance(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        shapes::norm(shapes::difference(self.pixel(a), self.pixel(b)))
    }

    /// A direction of the world in the picture, of length 1.
    pub fn direction(&self, [x, y]: [f64; 2]) -> Pixel {
        shapes::unit([x, -y])
    }
}

fn points(drawing: &Drawing) -> Vec<[f64; 2]> {
    let bodies = drawing.bodies.iter().flat_map(|body| body.extent());
    let ground = drawing.ground_shapes.iter().flat_map(DrawnShape::rim);
    let joints = drawing.joints.iter().map(|joint| joint.moving().1);
    let couplings = drawing.couplings.iter().flat_map(|coupling| coupling.corners());
    let springs = drawing.springs.iter().flat_map(|spring| spring.ends);
    let reached = drawing.range.corners.iter().copied();
    let gaps = drawing.gaps.iter().flatten().copied();
    bodies
        .chain(ground)
        .chain(gaps)
        .chain(joints)
        .chain(couplings)
        .chain(springs)
        .chain(reached)
        .filter(is_finite)
        .collect()
}

fn bounds(points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let fold =
        |axis: usize, pick: fn(f64, f64) -> f64| points.iter().map(|point| point[axis]).reduce(pick).unwrap_or(0.0);
    [[fold(0, f64::min), fold(1, f64::min)], [fold(0, f64::max), fold(1, f64::max)]]
}

/// Small enough that a short body is still longer than its pins are wide.
fn pin_radius(drawing: &Drawing, scale: f64) -> f64 {
    let mut lengths: Vec<f64> = drawing.bodies.iter().map(|body| scale * shapes::extent(&body.points)).collect();
    lengths.retain(|length| length.is_finite() && *length > 1.0);
    lengths.sort_by(f64::total_cmp);
    lengths.get(lengths.len() / 5).map_or(7.0, |length| (0.12 * length).clamp(3.5, 7.0))
}
