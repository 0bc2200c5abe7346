//! Poses of a body, and special sets of poses that need no general linkage.

use std::f64::consts::{PI, TAU};

use nalgebra::SMatrix;

use crate::{Point, polar};

/// Where a body is: the origin of its frame \[m\] and the angle of its frame \[rad\], both in the frame of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The origin of the body's frame.
    pub at: Point,
    /// The angle of the body's frame.
    pub angle: f64,
}

impl Pose {
    /// A pose by its three numbers.
    pub fn new(x: f64, y: f64, angle: f64) -> Pose {
        Pose { at: Point::new(x, y), angle }
    }

    /// The turn of the body as a number of size one.
    pub fn turn(&self) -> Point {
        polar(1.0, self.angle)
    }

    /// Where a point of the body is.
    pub fn carry(&self, point: Point) -> Point {
        self.at + self.turn() * point
    }

    /// Where a point of the ground is, seen from the body.
    pub fn seen(&self, point: Point) -> Point {
        (point - self.at) * self.turn().conj()
    }

    /// The same motion with body and ground exchanged.
    #[must_use]
    pub fn inverse(&self) -> Pose {
        Pose { at: self.seen(Point::new(0.0, 0.0)), angle: -self.angle }
    }
}

/// What is special about poses: five of them then determine less than in general.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Special {
    /// Two are the same; their numbers.
    Alike(usize, usize),
    /// The body does not turn; is it moved along a line?
    Translation {
        /// Do all origins lie on one line?
        on_a_line: bool,
    },
    /// All are turns about one point of the ground.
    OneCentre(Point),
}

/// Poses are the same, and points on a line, up to this share of the size.
const SAME: f64 = 1e-9;

/// The way from one angle to another, at most half a turn.
pub fn way(from: f64, to: f64) -> f64 {
    let turn = (to - from).rem_euclid(TAU);
    if turn > PI { turn - TAU } else { turn }
}

/// The middle of points and their size: the largest distance from it, 1 if there is none.
pub fn extent(points: impl Iterator<Item = Point> + Clone) -> (Point, f64) {
    let count = points.clone().count().max(1) as f64;
    let middle = points.clone().sum::<Point>() / count;
    let size = points.map(|point| (point - middle).norm()).fold(0.0, f64::max);
    (middle, if size > 0.0 { size } else { 1.0 })
}

/// What is special about poses, if anything is.
///
/// Two poses turn about one centre always, and one translation is always on a line: neither is special.
pub fn special(poses: &[Pose]) -> Option<Special> {
    let (_, size) = extent(poses.iter().map(|pose| pose.at));
    let near = |a: Point, b: Point| (a - b).norm() <= SAME * size;
    let alike = |a: &Pose, b: &Pose| near(a.at, b.at) && way(a.angle, b.angle).abs() <= SAME;
    for (second, pose) in poses.iter().enumerate() {
        if let Some(first) = poses[..second].iter().position(|other| alike(pose, other)) {
            return Some(Special::Alike(first, second));
        }
    }
    let (first, rest) = poses.split_first()?;
    if rest.len() < 2 {
        return None;
    }
    let farthest =
        rest.iter().max_by(|a, b| way(first.angle, a.angle).abs().total_cmp(&way(first.angle, b.angle).abs()))?;
    if way(first.angle, farthest.angle).abs() <= SAME {
        let along = rest.iter().map(|pose| pose.at - first.at).max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        let offset = |pose: &Pose| ((pose.at - first.at) * along.conj()).im.abs() / along.norm();
        return Some(Special::Translation { on_a_line: rest.iter().all(|pose| offset(pose) <= SAME * size) });
    }
    let centre = pole(first, farthest);
    let held = first.seen(centre);
    let radius = size.max((centre - first.at).norm());
    let stays = |pose: &Pose| (pose.carry(held) - centre).norm() <= SAME * radius;
    rest.iter().all(stays).then_some(Special::OneCentre(centre))
}

/// The point about which a body is turned from one pose to another.
pub(crate) fn pole(from: &Pose, to: &Pose) -> Point {
    let turn = polar(1.0, to.angle - from.angle);
    (to.at - turn * from.at) / (Point::new(1.0, 0.0) - turn)
}

/// A frame in which poses have coordinates of size one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UnitFrame {
    pub middle: Point,
    pub size: f64,
}

impl UnitFrame {
    pub fn of(poses: &[Pose]) -> UnitFrame {
        let (middle, _) = extent(poses.iter().map(|pose| pose.at));
        let square = poses.iter().map(|pose| (pose.at - middle).norm_sqr()).sum::<f64>();
        let size = (square / poses.len().max(1) as f64).sqrt();
        UnitFrame { middle, size: if size > 0.0 { size } else { 1.0 } }
    }

    pub fn scaled(&self, pose: &Pose) -> Pose {
        Pose { at: (pose.at - self.middle) / self.size, angle: pose.angle }
    }
}

/// The linear equation of dyads at a pose, in the eight numbers A, B, C, D, E.
pub(crate) fn row(pose: &Pose) -> SMatrix<f64, 1, 8> {
    let (d, turn) = (pose.at, pose.turn());
    let seen = turn.conj() * d;
    SMatrix::from([[d.norm_sqr() / 2.0], [seen.re], [seen.im], [-d.re], [-d.im], [-turn.re], [-turn.im], [1.0]])
}
