//! Closed-form positions of two bars that meet, through the poses in which they lie flat.

use super::closed_form::Pose;
use super::four_bar::FourBar;
use crate::support::jet::Jet;

/// A bar: its tip, and where it points.
#[derive(Clone, Copy)]
pub struct Arm {
    pub tip: [Jet; 2],
    pub direction: [Jet; 2],
    length: f64,
}

impl Arm {
    /// From a point along a direction.
    pub fn from([x, y]: [Jet; 2], direction: [Jet; 2], length: f64) -> Self {
        let (l, [c, s]) = (Jet::constant(length), direction);
        Self { tip: [x + l * c, y + l * s], direction, length }
    }

    /// From a fixed point to a tip.
    fn between([x, y]: [Jet; 2], tip: [Jet; 2], length: f64) -> Self {
        let scale = Jet::constant(1.0 / length);
        Self { tip, direction: [scale * (tip[0] - x), scale * (tip[1] - y)], length }
    }

    /// The pose of a body whose mass centre is in the middle.
    pub fn middle(&self) -> Pose {
        let (half, [c, s]) = (Jet::constant(0.5 * self.length), self.direction);
        [self.tip[0] - half * c, self.tip[1] - half * s, c, s]
    }
}

pub fn fixed([x, y]: [f64; 2]) -> [Jet; 2] {
    [Jet::constant(x), Jet::constant(y)]
}

/// d^2, (r + s)^2 - d^2 and d^2 - (r - s)^2 for points at a distance d.
fn reach(from: [Jet; 2], to: [Jet; 2], [r, s]: [f64; 2]) -> [Jet; 3] {
    let (x, y) = (to[0] - from[0], to[1] - from[1]);
    let square = x * x + y * y;
    [square, Jet::constant((r + s).powi(2)) - square, square - Jet::constant((r - s).powi(2))]
}

/// Bars of lengths r from one point and s from another; `root` is the square root of the product of the two reaches, with the sign of the
/// side on which they meet.
fn meet(from: [Jet; 2], to: [Jet; 2], [r, s]: [f64; 2], root: Jet) -> [Arm; 2] {
    let (x, y) = (to[0] - from[0], to[1] - from[1]);
    let [square, ..] = reach(from, to, [r, s]);
    let inverse = square.inverse();
    let half = Jet::constant(0.5);
    let along = half * (square + Jet::constant(r * r - s * s)) * inverse;
    let across = half * root * inverse;
    let tip = [from[0] + along * x - across * y, from[1] + along * y + across * x];
    [Arm::between(from, tip, r), Arm::between(to, tip, s)]
}

/// The same for bars that never lie flat; they meet left of the way from the one point to the other, or right.
pub fn dyad(from: [Jet; 2], to: [Jet; 2], lengths: [f64; 2], left: bool) -> [Arm; 2] {
    let [_, outer, inner] = reach(from, to, lengths);
    let sign = if left { 1.0 } else { -1.0 };
    meet(from, to, lengths, Jet::constant(sign) * outer.sqrt() * inner.sqrt())
}

/// A four-bar whose crank turns all the way round, on one branch through all its change points.
pub struct Loop {
    bars: FourBar,
    /// Does it lie flat with the crank along the base, or against it?
    flat: [bool; 2],
    sign: f64,
}

impl Loop {
    pub fn of(bars: &FourBar) -> Self {
        let FourBar { crank: a, base: b, coupler: r, rocker: s, .. } = *bars;
        let same = |x: f64, y: f64| (x - y).abs() < 1e-12;
        let flat = [same((r - s).abs(), (a - b).abs()), same(r + s, a + b)];
        let chain = Self { bars: *bars, flat, sign: 1.0 };
        let side = if bars.up { 1.0 } else { -1.0 };
        Self { sign: side * chain.root(Jet::constant(bars.angle)).0[0].signum(), ..chain }
    }

    /// Is no pose of the crank out of reach?
    pub fn turns(&self) -> bool {
        let FourBar { crank: a, base: b, coupler: r, rocker: s, .. } = self.bars;
        let clear = |more: f64, less: f64, flat: bool| flat || more - less > 0.05;
        clear(r + s, a + b, self.flat[1]) && clear((a - b).abs(), (r - s).abs(), self.flat[0]) && (a - b).abs() > 0.05
    }

    /// Where it lies flat one of the reaches is a square of the half angle's sine or cosine: its root changes sign there, and is analytic.
    fn root(&self, angle: Jet) -> Jet {
        let (tip, far) = (self.crank(angle).tip, fixed([self.bars.base, 0.0]));
        let [_, outer, inner] = reach(tip, far, [self.bars.coupler, self.bars.rocker]);
        let (sine, cosine) = (Jet::constant(0.5) * angle).sin_cos();
        let size = Jet::constant(self.sign * 2.0 * (self.bars.crank * self.bars.base).sqrt());
        let sign = Jet::constant(self.sign);
        match self.flat {
            [false, false] => sign * outer.sqrt() * inner.sqrt(),
            [true, false] => size * sine * outer.sqrt(),
            [false, true] => size * cosine * inner.sqrt(),
            [true, true] => sign * size * size * sine * cosine,
        }
    }

    fn crank(&self, angle: Jet) -> Arm {
        let (s, c) = angle.sin_cos();
        Arm::from(fixed([0.0, 0.0]), [c, s], self.bars.crank)
    }

    /// Crank, coupler and rocker.
    pub fn arms(&self, angle: Jet) -> [Arm; 3] {
        let crank = self.crank(angle);
        let lengths = [self.bars.coupler, self.bars.rocker];
        let [coupler, rocker] = meet(crank.tip, fixed([self.bars.base, 0.0]), lengths, self.root(angle));
        [crank, coupler, rocker]
    }
}
