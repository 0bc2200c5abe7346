//! Where a path runs between its points, and how far a curve leaves it.
//!
//! Points say where a path is, not how it gets from one to the next. It may go straight, or be as round there as the arcs through neighbouring points are: every side of the polygon
//! is permitted so much on both sides of it. Without that no smooth curve would follow points that are exactly on it.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::Point;

/// The sides of a path, and how far a curve may be from each.
#[derive(Clone, Debug)]
pub(crate) struct Corridor {
    sides: Vec<Side>,
    closed: bool,
}

#[derive(Clone, Debug)]
struct Side {
    from: Point,
    to: Point,
    bulge: f64,
}

/// A curve whose curvature changes leaves a side by more than the arcs do: curves of known four-bars through 12 to 36 points by at most this many times as much in 81 to 95 % of cases.
const ROUNDER: f64 = 1.5;
/// No side is permitted more than this share of the largest distance of two points.
const MOST: f64 = 0.02;
/// Places of a curve that are measured.
const MEASURED: usize = 360;

impl Corridor {
    pub fn of(points: &[Point], closed: bool) -> Corridor {
        let count = points.len();
        let point = |index: usize| points[index % count];
        let most = MOST * reach(points);
        let bulge = |index: usize| {
            let (from, to) = (point(index), point(index + 1));
            let before = (closed || index > 0).then(|| rise(from, to, point(index + count - 1)));
            let after = (closed || index + 2 < count).then(|| rise(from, to, point(index + 2)));
            (ROUNDER * before.unwrap_or(0.0).max(after.unwrap_or(0.0))).min(most)
        };
        let last = if closed { count } else { count.saturating_sub(1) };
        let side = |index: usize| Side { from: point(index), to: point(index + 1), bulge: bulge(index) };
        Corridor { sides: (0..last).map(side).collect(), closed }
    }

    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// How far a point is outside, and the direction in which that grows; none: it is inside.
    pub fn outside(&self, point: Point) -> Option<(f64, Point)> {
        let off = |side: &Side| {
            let along = side.to - side.from;
            let share = ((point - side.from) * along.conj()).re / along.norm_sqr().max(f64::MIN_POSITIVE);
            let away = point - side.from - along * share.clamp(0.0, 1.0);
            (away.norm() - side.bulge, away)
        };
        let (excess, away) = self.sides.iter().map(off).min_by(|a, b| a.0.total_cmp(&b.0))?;
        (excess > 0.0).then(|| (excess, away / away.norm().max(f64::MIN_POSITIVE)))
    }

    /// How far a curve is outside at most: between the inputs of its ends, or in a full turn if the path is closed.
    pub fn departure(&self, inputs: &[f64], mut at: impl FnMut(f64) -> Option<Point>) -> f64 {
        let (low, high) = ends(inputs);
        let way = if self.closed { TAU } else { high - low };
        let input = |place: usize| low + way * place as f64 / MEASURED as f64;
        let all = (0..=MEASURED).filter_map(|place| self.outside(at(input(place))?));
        all.map(|(excess, _)| excess).fold(0.0, f64::max)
    }
}

/// The smallest and the largest input.
pub(crate) fn ends(inputs: &[f64]) -> (f64, f64) {
    (inputs.iter().copied().fold(f64::INFINITY, f64::min), inputs.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

/// The largest distance of two points.
pub fn reach(points: &[Point]) -> f64 {
    let from = |a: &Point| points.iter().map(|b| (b - a).norm()).fold(0.0, f64::max);
    points.iter().map(from).fold(0.0, f64::max)
}

/// How far the arc through three points rises above the chord of the first two: half the chord times the tangent of half the angle under which the third one sees it.
fn rise(from: Point, to: Point, third: Point) -> f64 {
    let angle = ((from - third) * (to - third).conj()).arg().abs();
    0.5 * (to - from).norm() * (0.5 * angle.min(FRAC_PI_2)).tan()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polar;

    fn circle(count: usize) -> Vec<Point> {
        (0..count).map(|i| polar(1.0, TAU * i as f64 / count as f64)).collect()
    }

    #[test]
    fn the_circle_through_the_points_is_inside_and_a_larger_one_is_not() {
        for count in [16, 24, 60] {
            let corridor = Corridor::of(&circle(count), true);
            let on = |radius: f64| corridor.departure(&[0.0], |input| Some(polar(radius, input)));
            assert_eq!(on(1.0), 0.0, "{count}");
            // At a corner nothing is permitted but the bulge, which is at most 2 % of the diameter.
            assert!((0.1..=0.15).contains(&on(1.15)), "{count}: {}", on(1.15));
        }
    }

    #[test]
    fn a_straight_side_permits_nothing() {
        let line: Vec<Point> = (0..5).map(|i| Point::new(f64::from(i), 0.0)).collect();
        let corridor = Corridor::of(&line, false);
        let bow = corridor.departure(&[0.0, 4.0], |x| Some(Point::new(x, 0.01 * x * (4.0 - x))));
        assert!((bow - 0.04).abs() < 1e-12, "{bow}");
        // Beyond an end the distance is that from the end.
        assert_eq!(corridor.outside(Point::new(7.0, 4.0)).map(|(excess, _)| excess), Some(5.0));
    }

    #[test]
    fn a_loop_that_no_point_sees_is_outside() {
        let corridor = Corridor::of(&circle(24), true);
        let lobe = |input: f64| Some(polar(if (3.0..3.1).contains(&input) { 1.8 } else { 1.0 }, input));
        let found = corridor.departure(&[0.0], lobe);
        assert!((0.75..=0.8).contains(&found), "{found}");
    }
}
