//! Dyads: a bar or a slider that guides a point or a line of a body through given poses.
//!
//! A dyad is a vector `(A, B, C, D, E)` of eight numbers with `A |d|^2/2 + B.(R^T d) - C.d - D1 cos phi - D2 sin phi + E = 0` for each pose `(d, phi)` with
//! rotation `R`, and with `A D1 = B.C`, `A D2 = B1 C2 - B2 C1`. `A = 1` is a bar from `C` on the ground to `B` on the body, `A = B = 0` a point
//! of the body on a line of the ground, `A = C = 0` a line of the body through a point of the ground. No kind is assumed: five poses are five linear
//! equations, what is left is where two conics meet.
//!
//! Source: L. Burmester, *Lehrbuch der Kinematik*, 1888; J. M. McCarthy, G. S. Soh, *Geometric Design of Linkages*, 2011, chapter 5; the bilinear form:
//! M. J. D. Hayes, P. J. Zsombor-Murray, *Towards integrated type and dimensional synthesis of mechanisms for rigid body guidance*, 2004.

use nalgebra::{Matrix3, SMatrix, SVector};

use crate::conics::{Common, common};
use crate::least::{EndCriteria, TermResiduals, Terms, Unknowns, minimise};
use crate::poses::{Pose, UnitFrame, row};
use crate::{Point, cross, dot, polar};

/// What guides a body at one of its points or lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dyad {
    /// RR: a bar with a pin at each end.
    Bar {
        /// The pin in the body, in the body's frame \[m\].
        moving: Point,
        /// The pin in the ground \[m\].
        ground: Point,
        /// The length of the bar \[m\].
        length: f64,
    },
    /// PR: a point of the body stays on a line of the ground, `normal . x = offset`.
    Slider {
        /// The point, in the body's frame \[m\].
        moving: Point,
        /// The normal of the line, of length one.
        normal: Point,
        /// How far the line is from the origin, along the normal, zero or more \[m\].
        offset: f64,
    },
    /// RP: a line of the body passes through a point of the ground, `normal . x = offset` in the body's frame.
    Slot {
        /// The point of the ground \[m\].
        ground: Point,
        /// The normal of the line in the body's frame, of length one.
        normal: Point,
        /// How far the line is from the body's origin, along the normal \[m\].
        offset: f64,
    },
}

impl Dyad {
    /// Its kind: `RR`, `PR` or `RP`, from the ground on.
    pub fn kind(&self) -> &'static str {
        match self {
            Dyad::Bar { .. } => "RR",
            Dyad::Slider { .. } => "PR",
            Dyad::Slot { .. } => "RP",
        }
    }

    /// How far it is from being met at a pose \[m\], with sign.
    pub fn error(&self, pose: &Pose) -> f64 {
        match *self {
            Dyad::Bar { moving, ground, length } => (pose.carry(moving) - ground).norm() - length,
            Dyad::Slider { moving, normal, offset } => dot(normal, pose.carry(moving)) - offset,
            Dyad::Slot { ground, normal, offset } => dot(normal, pose.seen(ground)) - offset,
        }
    }

    /// Its largest error over poses \[m\].
    pub fn largest_error(&self, poses: &[Pose]) -> f64 {
        poses.iter().map(|pose| self.error(pose).abs()).fold(0.0, f64::max)
    }

    /// The same with body and ground exchanged.
    #[must_use]
    pub fn inverse(&self) -> Dyad {
        match *self {
            Dyad::Bar { moving, ground, length } => Dyad::Bar { moving: ground, ground: moving, length },
            Dyad::Slider { moving, normal, offset } => Dyad::Slot { ground: moving, normal, offset },
            Dyad::Slot { ground, normal, offset } => slider(ground, normal, offset),
        }
    }
}

fn slider(moving: Point, normal: Point, offset: f64) -> Dyad {
    let sign = if offset < 0.0 { -1.0 } else { 1.0 };
    Dyad::Slider { moving, normal: normal * sign, offset: offset * sign }
}

/// One more linear equation, for fewer than five poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DyadCondition {
    /// The pin in the ground is on the line `direction . x = value` of the ground.
    Ground {
        /// Normal of the line.
        direction: Point,
        /// \[m\]
        value: f64,
    },
    /// The pin in the body is on the line `direction . x = value` of the body.
    Moving {
        /// Normal of the line.
        direction: Point,
        /// \[m\]
        value: f64,
    },
    /// No bar: a slider or a slot.
    NoBar,
}

impl DyadCondition {
    fn row(&self, frame: &UnitFrame) -> SMatrix<f64, 1, 8> {
        let mut row = SMatrix::<f64, 1, 8>::zeros();
        let mut line = |first: usize, direction: Point, value: f64| {
            (row[0], row[first], row[first + 1]) = (-value / frame.size, direction.re, direction.im);
        };
        match *self {
            DyadCondition::Ground { direction, value } => line(3, direction, value - dot(direction, frame.middle)),
            DyadCondition::Moving { direction, value } => line(1, direction, value),
            DyadCondition::NoBar => row[0] = 1.0,
        }
        row
    }
}

/// Why there are no single dyads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Poses and conditions leave so many more numbers free than five poses of the general kind; below zero: they are too many.
    Free(i64),
    /// A curve of dyads takes the body through all poses, such as a body that moves like the bar of a trammel.
    Curve,
}

/// Equations whose pivot is below this share of the largest depend on the others.
const DEPENDENT: f64 = 1e-10;
/// Below this share of the vector, `A` and then `B` or `C` are zero.
const NO_BAR: f64 = 1e-9;

/// All dyads that take a body through poses and meet the conditions: at most four, for five equations altogether.
///
/// # Errors
/// The equations do not determine single dyads.
pub fn dyads(poses: &[Pose], conditions: &[DyadCondition]) -> Result<Vec<Dyad>, Family> {
    let frame = UnitFrame::of(poses);
    let rows = poses
        .iter()
        .map(|pose| row(&frame.scaled(pose)))
        .chain(conditions.iter().map(|condition| condition.row(&frame)));
    let rows: Vec<SMatrix<f64, 1, 8>> = rows.collect();
    if rows.len() > 5 {
        return Err(Family::Free(5 - rows.len() as i64));
    }
    let mut equations = SMatrix::<f64, 8, 8>::zeros();
    rows.iter().enumerate().for_each(|(i, row)| equations.set_column(i, &row.normalize().transpose()));
    let split = equations.col_piv_qr();
    let r = split.r();
    let rank = (0..5).filter(|&i| r[(i, i)].abs() > DEPENDENT * r[(0, 0)].abs()).count();
    if rank < 5 {
        return Err(Family::Free(5 - rank as i64));
    }
    through(&split.q().fixed_columns::<3>(5).into_owned(), &frame).ok_or(Family::Curve)
}

/// The dyads in the space that three vectors span; none if they are a curve.
fn through(basis: &SMatrix<f64, 8, 3>, frame: &UnitFrame) -> Option<Vec<Dyad>> {
    let conic = |side: fn(&SVector<f64, 8>, &SVector<f64, 8>) -> f64| {
        Matrix3::from_fn(|i, j| side(&basis.column(i).into_owned(), &basis.column(j).into_owned()))
    };
    // A D1 - B.C and A D2 - B x C, as symmetric forms
    let along = conic(|w, v| 0.5 * (w[0] * v[5] + v[0] * w[5] - w[1] * v[3] - v[1] * w[3] - w[2] * v[4] - v[2] * w[4]));
    let across =
        conic(|w, v| 0.5 * (w[0] * v[6] + v[0] * w[6] - w[1] * v[4] - v[1] * w[4] + w[2] * v[3] + v[2] * w[3]));
    match common(&along, &across) {
        Common::Points(points) => Some(points.iter().map(|point| dyad(&(basis * point), frame)).collect()),
        Common::Curve => None,
    }
}

/// A dyad by its eight numbers in a frame of size one.
fn dyad(w: &SVector<f64, 8>, frame: &UnitFrame) -> Dyad {
    let w = w.normalize();
    let (size, middle) = (frame.size, frame.middle);
    let pair = |first: usize| Point::new(w[first], w[first + 1]);
    let (a, b, c, d, e) = (w[0], pair(1), pair(3), pair(5), w[7]);
    if a.abs() > NO_BAR {
        let (moving, ground) = (b / a, c / a);
        let length = (moving.norm_sqr() + ground.norm_sqr() - 2.0 * e / a).max(0.0).sqrt();
        return Dyad::Bar { moving: moving * size, ground: ground * size + middle, length: length * size };
    }
    if b.norm() < c.norm() {
        let normal = c / c.norm();
        // n . R p = D1 cos + D2 sin
        let d = d / c.norm();
        let moving = Point::new(d.re * normal.re + d.im * normal.im, d.re * normal.im - d.im * normal.re);
        return slider(moving * size, normal, e / c.norm() * size + dot(normal, middle));
    }
    let normal = b / b.norm();
    let d = d / b.norm();
    let ground = Point::new(d.re * normal.re - d.im * normal.im, d.im * normal.re + d.re * normal.im);
    Dyad::Slot { ground: ground * size + middle, normal, offset: e / b.norm() * size }
}

/// The bar whose pin in the body is given, through three poses; none if the pin's places are on a line.
pub fn circle_dyad(moving: Point, poses: &[Pose; 3]) -> Option<Dyad> {
    let [p, q, r] = poses.map(|pose| pose.carry(moving));
    let (u, v) = (q - p, r - p);
    let twice = 2.0 * cross(u, v);
    // The centre is as far from all three: x.u = |u|^2/2, x.v = |v|^2/2.
    let from_first =
        Point::new(v.im, -v.re) * (u.norm_sqr() / twice) + Point::new(-u.im, u.re) * (v.norm_sqr() / twice);
    if !from_first.is_finite() || twice.abs() < 1e-12 * u.norm() * v.norm() {
        return None;
    }
    Some(Dyad::Bar { moving, ground: p + from_first, length: from_first.norm() })
}

/// The dyads from which poses are nearest, each a local minimum of the weighted sum of squared errors; best first.
///
/// `weights` are one for each pose: one over its tolerance \[m\].
pub fn nearest_dyads(poses: &[Pose], weights: &[f64]) -> Vec<(Dyad, f64)> {
    let frame = UnitFrame::of(poses);
    let scaled: Vec<Pose> = poses.iter().map(|pose| frame.scaled(pose)).collect();
    let mean = weights.iter().sum::<f64>() / weights.len().max(1) as f64;
    let mut square = SMatrix::<f64, 8, 8>::zeros();
    for (pose, weight) in scaled.iter().zip(weights) {
        let row = row(pose) * (weight / mean);
        square += row.transpose() * row;
    }
    let eigen = square.symmetric_eigen();
    let mut order: Vec<usize> = (0..8).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let basis = SMatrix::<f64, 8, 3>::from_fn(|i, j| eigen.eigenvectors[(i, order[j])]);
    let mut found: Vec<(Dyad, f64)> = Vec::new();
    for start in through(&basis, &frame).unwrap_or_default() {
        let polished = polished(&start, poses, weights, &frame);
        if polished.1.is_finite() && !found.iter().any(|(other, _)| alike(other, &polished.0, frame.size)) {
            found.push(polished);
        }
    }
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    found
}

/// Are two dyads the same up to a millionth of the size?
fn alike(a: &Dyad, b: &Dyad, size: f64) -> bool {
    let near = |a: Point, b: Point| (a - b).norm() < 1e-6 * size;
    match (a, b) {
        (Dyad::Bar { moving, ground, .. }, Dyad::Bar { moving: other, ground: pin, .. }) => {
            near(*moving, *other) && near(*ground, *pin)
        }
        _ => a == b,
    }
}

/// Errors of bars: B, C and the length shared.
struct BarErrors<'p> {
    poses: &'p [Pose],
    weights: &'p [f64],
}

impl Terms<5, 0, 1> for BarErrors<'_> {
    fn count(&self) -> usize {
        self.poses.len()
    }

    fn at(&self, term: usize, shared: &[f64; 5], _: &[f64; 0]) -> TermResiduals<5, 0, 1> {
        let [bx, by, cx, cy, length] = *shared;
        let (pose, weight) = (&self.poses[term], self.weights[term]);
        let bar = pose.carry(Point::new(bx, by)) - Point::new(cx, cy);
        let along = bar / bar.norm().max(f64::MIN_POSITIVE);
        let seen = along * pose.turn().conj();
        let slopes = [seen.re, seen.im, -along.re, -along.im, -1.0].map(|slope| slope * weight);
        TermResiduals { value: [(bar.norm() - length) * weight], by_shared: [slopes], by_local: [[]] }
    }
}

/// Errors of sliders: the point, the angle of the normal and the offset shared.
struct Sliders<'p> {
    poses: &'p [Pose],
    weights: &'p [f64],
}

impl Terms<4, 0, 1> for Sliders<'_> {
    fn count(&self) -> usize {
        self.poses.len()
    }

    fn at(&self, term: usize, shared: &[f64; 4], _: &[f64; 0]) -> TermResiduals<4, 0, 1> {
        let [bx, by, angle, offset] = *shared;
        let (pose, weight) = (&self.poses[term], self.weights[term]);
        let (normal, place) = (polar(1.0, angle), pose.carry(Point::new(bx, by)));
        let seen = normal * pose.turn().conj();
        let slopes = [seen.re, seen.im, cross(normal, place), -1.0].map(|slope| slope * weight);
        TermResiduals { value: [(dot(normal, place) - offset) * weight], by_shared: [slopes], by_local: [[]] }
    }
}

/// The nearest local minimum from a dyad on, and the weighted sum of squares there.
fn polished(start: &Dyad, poses: &[Pose], weights: &[f64], frame: &UnitFrame) -> (Dyad, f64) {
    let local = || vec![[]; poses.len()];
    let end = EndCriteria { sum: 0.0, share: 1e-14, ..EndCriteria::after(400) };
    match *start {
        Dyad::Bar { moving, ground, length } => {
            let scaled: Vec<Pose> = poses.iter().map(|pose| frame.scaled(pose)).collect();
            let (b, c) = (moving / frame.size, (ground - frame.middle) / frame.size);
            let mut at = Unknowns { shared: [b.re, b.im, c.re, c.im, length / frame.size], local: local() };
            let sum = minimise(&BarErrors { poses: &scaled, weights }, &mut at, end);
            let [bx, by, cx, cy, length] = at.shared.map(|shared| shared * frame.size);
            let ground = Point::new(cx, cy) + frame.middle;
            (Dyad::Bar { moving: Point::new(bx, by), ground, length: length.abs() }, sum * frame.size * frame.size)
        }
        Dyad::Slider { moving, normal, offset } => {
            let mut at = Unknowns { shared: [moving.re, moving.im, normal.arg(), offset], local: local() };
            let sum = minimise(&Sliders { poses, weights }, &mut at, end);
            let [x, y, angle, offset] = at.shared;
            (slider(Point::new(x, y), polar(1.0, angle), offset), sum)
        }
        Dyad::Slot { .. } => {
            let inverted: Vec<Pose> = poses.iter().map(Pose::inverse).collect();
            let (dyad, sum) = polished(&start.inverse(), &inverted, weights, frame);
            (dyad.inverse(), sum)
        }
    }
}
