//! The motion of a closed linkage of one freedom, found in another way: along the curve of its poses, with the time that energy gives to each piece.
//!
//! Three coordinates x and two closures f(x) = 0 make a curve in space. Each step goes along its tangent for a tenth of the distance to where the gradients become
//! parallel, and back to the curve across it: none is long enough to meet another branch. With u the way along the tangent, (du/dt)^2 T(x') = E - V, so the time of a
//! step is an integral over a smooth function. Nothing of the program is used.

use super::hard::four_bar::FourBar;

/// Longest step, and its share of the distance from where branches come close.
const LONGEST: f64 = 0.02;
const SHARE: f64 = 0.1;
/// Nodes and weights of Gauss' formula with five points, from 0 to 1.
const GAUSS: [[f64; 2]; 5] = [
    [0.046_910_077_030_668_0, 0.118_463_442_528_094_5],
    [0.230_765_344_947_158_5, 0.239_314_335_249_683_2],
    [0.5, 0.284_444_444_444_444_4],
    [0.769_234_655_052_841_5, 0.239_314_335_249_683_2],
    [0.953_089_922_969_332, 0.118_463_442_528_094_5],
];

type Point = [f64; 3];

/// A linkage, and what moves it.
#[derive(Clone, Copy, Debug)]
pub enum Linkage {
    /// Angles of crank, coupler and rocker.
    FourBar(FourBar),
    /// Angles of crank and rod, and the place of the slider on the X axis.
    Slider { crank: f64, rod: f64, masses: [f64; 3], gravity: f64 },
}

impl Linkage {
    /// How far the loop is open, and the gradients of that.
    fn closure(&self, [a, b, c]: Point) -> ([f64; 2], [Point; 2]) {
        match *self {
            Self::FourBar(FourBar { crank: p, coupler: q, rocker: r, base, .. }) => (
                [p * a.cos() + q * b.cos() - r * c.cos() - base, p * a.sin() + q * b.sin() - r * c.sin()],
                [[-p * a.sin(), -q * b.sin(), r * c.sin()], [p * a.cos(), q * b.cos(), -r * c.cos()]],
            ),
            Self::Slider { crank: p, rod: q, .. } => (
                [p * a.cos() + q * b.cos() - c, p * a.sin() + q * b.sin()],
                [[-p * a.sin(), -q * b.sin(), -1.0], [p * a.cos(), q * b.cos(), 0.0]],
            ),
        }
    }

    /// The kinetic energy at these rates.
    fn kinetic(&self, [a, b, c]: Point, [u, v, w]: Point) -> f64 {
        let (p, q, masses, (vx, vy, last)) = match *self {
            Self::FourBar(bars) => {
                let (x, y) = (-0.5 * bars.rocker * w * c.sin(), 0.5 * bars.rocker * w * c.cos());
                (bars.crank, bars.coupler, bars.masses, (x, y, bars.rocker * w))
            }
            Self::Slider { crank, rod, masses, .. } => (crank, rod, masses, (w, 0.0, 0.0)),
        };
        let tip = [-p * u * a.sin(), p * u * a.cos()];
        let middle = [tip[0] - 0.5 * q * v * b.sin(), tip[1] + 0.5 * q * v * b.cos()];
        let turning = [p * u, q * v, last].map(|speed| speed * speed / 12.0);
        let moving = [0.25 * p * p * u * u, middle[0].powi(2) + middle[1].powi(2), vx * vx + vy * vy];
        (0..3).map(|k| 0.5 * masses[k] * (moving[k] + turning[k])).sum()
    }

    fn potential(&self, [a, b, c]: Point) -> f64 {
        match *self {
            Self::FourBar(FourBar { crank: p, coupler: q, rocker: r, masses: [m, n, o], gravity, .. }) => {
                let heights = [0.5 * p * a.sin(), p * a.sin() + 0.5 * q * b.sin(), 0.5 * r * c.sin()];
                gravity * (m * heights[0] + n * heights[1] + o * heights[2])
            }
            Self::Slider { crank: p, rod: q, masses: [m, n, _], gravity } => {
                gravity * (m * 0.5 * p * a.sin() + n * (p * a.sin() + 0.5 * q * b.sin()))
            }
        }
    }
}

/// A motion along the curve.
#[derive(Clone, Debug)]
pub struct Motion {
    linkage: Linkage,
    place: Point,
    /// The way on.
    tangent: Point,
    time: f64,
    energy: f64,
}

impl Motion {
    /// From a pose, with this rate of the first coordinate.
    pub fn new(linkage: Linkage, place: Point, rate: f64) -> Self {
        let place = onto(&linkage, place, [1.0, 0.0, 0.0], place[0]);
        let (along, _) = tangent(&linkage, place, [rate, 0.0, 0.0]);
        let rates = along.map(|part| part * rate / along[0]);
        let energy = linkage.kinetic(place, rates) + linkage.potential(place);
        Self { linkage, place, tangent: along, time: 0.0, energy }
    }

    /// The coordinates at a later time; none if the motion turns back on its way.
    pub fn at(&mut self, time: f64) -> Option<Point> {
        loop {
            let (_, distance) = tangent(&self.linkage, self.place, self.tangent);
            let step = LONGEST.min(SHARE * distance);
            let (place, after) = (self.point(step), self.duration(step)?);
            if self.time + after > time {
                return self.within(step, time - self.time);
            }
            (self.tangent, _) = tangent(&self.linkage, place, self.tangent);
            (self.place, self.time) = (place, self.time + after);
        }
    }

    /// Where the motion is so long after the start of a step.
    fn within(&self, step: f64, wanted: f64) -> Option<Point> {
        let mut way = step * wanted / self.duration(step)?;
        for _ in 0..20 {
            way += (wanted - self.duration(way)?) / self.pace(way)?;
        }
        Some(self.point(way))
    }

    fn duration(&self, step: f64) -> Option<f64> {
        GAUSS.iter().map(|[node, weight]| Some(weight * step * self.pace(node * step)?)).sum()
    }

    /// dt/du; none where the motion turns back.
    fn pace(&self, way: f64) -> Option<f64> {
        let place = self.point(way);
        let (along, _) = tangent(&self.linkage, place, self.tangent);
        let rate = 1.0 / dot(along, self.tangent);
        let left = self.energy - self.linkage.potential(place);
        let slow = left < 0.02 * self.energy.abs();
        (!slow).then(|| (self.linkage.kinetic(place, along.map(|part| part * rate)) / left).sqrt())
    }

    fn point(&self, way: f64) -> Point {
        let ahead = [0, 1, 2].map(|k| self.place[k] + way * self.tangent[k]);
        onto(&self.linkage, ahead, self.tangent, dot(ahead, self.tangent))
    }
}

/// The point of the curve in the plane of this normal.
fn onto(linkage: &Linkage, mut place: Point, normal: Point, level: f64) -> Point {
    for _ in 0..10 {
        let (open, [g, h]) = linkage.closure(place);
        let right = [-open[0], -open[1], level - dot(place, normal)];
        // Cramer's rule, by the planes' common directions.
        let columns = [cross(h, normal), cross(normal, g), cross(g, h)];
        let volume = dot(g, columns[0]);
        for k in 0..3 {
            place[k] += (0..3).map(|j| right[j] * columns[j][k]).sum::<f64>() / volume;
        }
    }
    place
}

/// The direction of the curve that goes along another, and how far the gradients are from being parallel.
fn tangent(linkage: &Linkage, place: Point, ahead: Point) -> (Point, f64) {
    let (_, [g, h]) = linkage.closure(place);
    let common = cross(g, h);
    let size = dot(common, common).sqrt();
    let sign = if dot(common, ahead) < 0.0 { -1.0 } else { 1.0 };
    let largest = [g, h].iter().flatten().fold(1.0_f64, |most, part| most.max(part.abs()));
    (common.map(|part| sign * part / size), size / (3.0 * largest * largest))
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
