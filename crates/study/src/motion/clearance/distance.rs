//! Distances between regions of the plane. A region is all that is not farther than its reach from its core: a polygon, convex or not, a line between two
//! corners, or a point. The distance of two regions is that of their cores less both reaches, so only cores are looked at, side by side.

/// A point of the plane.
pub type Point = [f64; 2];

/// All that is not farther than `reach` from a core with these corners.
#[derive(Clone, Debug)]
pub struct OutlineRegion {
    pub corners: Vec<Point>,
    pub offset: f64,
}

/// How far two regions are apart.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Their distance; negative or zero where they overlap.
    pub gap: f64,
    /// Do they have more than their boundaries in common?
    pub overlaps: bool,
    /// The nearest points; where the cores overlap twice a common one.
    pub points: [Point; 2],
}

/// A side of a polygon, or the whole of a line.
type Side = [Point; 2];

impl OutlineRegion {
    /// The sides of the core; a point is a side without length.
    fn sides(&self) -> impl Iterator<Item = Side> + '_ {
        let count = self.corners.len();
        let sides = if count > 2 { count } else { 1 };
        (0..sides).map(move |side| [self.corners[side], self.corners[(side + 1) % count]])
    }

    /// Does the core have an area?
    fn is_closed(&self) -> bool {
        self.corners.len() > 2
    }

    /// Is a point within the core? A ray to the right crosses the boundary of what it starts in an odd number of times.
    fn holds(&self, [x, y]: Point) -> bool {
        let crossed = |[a, b]: &Side| (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
        self.is_closed() && self.sides().filter(crossed).count() % 2 == 1
    }

    /// Is a point within the core, and farther than this from its boundary?
    fn holds_by(&self, point: Point, margin: f64) -> bool {
        self.holds(point) && self.sides().all(|side| norm(difference(foot(point, side), point)) > margin)
    }

    /// A point within the core: in the triangle at its lowest corner, or on the line from there to the corner that is deepest in this triangle.
    fn inner_point(&self) -> Option<Point> {
        let count = self.corners.len();
        let lowest = (0..count).min_by(|&a, &b| {
            let [[ax, ay], [bx, by]] = [self.corners[a], self.corners[b]];
            ay.total_cmp(&by).then(ax.total_cmp(&bx))
        })?;
        let [before, corner, after] = [lowest + count - 1, lowest, lowest + 1].map(|index| self.corners[index % count]);
        let triangle = OutlineRegion { corners: vec![before, corner, after], offset: 0.0 };
        let depth = |point: &Point| cross(difference(after, before), difference(*point, before)).abs();
        let deepest = self.corners.iter().filter(|point| triangle.holds(**point) && **point != corner);
        let deepest =
            deepest.filter(|point| **point != before && **point != after).max_by(|a, b| depth(a).total_cmp(&depth(b)));
        Some(match deepest {
            Some(point) => between(corner, *point, 0.5),
            None => [0, 1].map(|axis| (before[axis] + corner[axis] + after[axis]) / 3.0),
        })
    }

    /// The middles of the pieces into which the boundary of another region cuts the boundary of this one.
    fn pieces<'a>(&'a self, other: &'a OutlineRegion, small: f64) -> impl Iterator<Item = Point> + 'a {
        self.sides().flat_map(move |[a, b]| {
            let length = norm(difference(b, a));
            let mut cuts = vec![0.0, 1.0];
            for side @ [c, d] in other.sides() {
                let ends = side.into_iter().filter(|end| norm(difference(foot(*end, [a, b]), *end)) <= small);
                cuts.extend(ends.map(|end| share(end, [a, b])));
                let across = cross(difference(b, a), difference(d, c));
                let cut = cross(difference(c, a), difference(d, c)) / across;
                if (0.0..=1.0).contains(&cut) {
                    cuts.push(cut);
                }
            }
            cuts.sort_by(f64::total_cmp);
            let middles: Vec<Point> = cuts
                .windows(2)
                .filter(|pair| (pair[1] - pair[0]) * length > small)
                .map(|pair| between(a, b, 0.5 * (pair[0] + pair[1])))
                .collect();
            middles
        })
    }
}

/// The distance of two regions; what is closer than `small` touches and does not overlap.
pub fn nearest(first: &OutlineRegion, second: &OutlineRegion, small: f64) -> Nearest {
    let (mut least, mut points) = (f64::INFINITY, [[f64::NAN; 2]; 2]);
    for one in first.sides() {
        for other in second.sides() {
            if box_distance(one, other) > least {
                continue;
            }
            if let Some(common) = crossing(one, other, small) {
                return overlapping(first, second, common);
            }
            for pair in ends_and_feet(one, other) {
                let distance = norm(difference(pair[1], pair[0]));
                if distance < least {
                    (least, points) = (distance, pair);
                }
            }
        }
    }
    if let Some(common) = common_point(first, second, least, small) {
        return overlapping(first, second, common);
    }
    let gap = least - first.offset - second.offset;
    let along = difference(points[1], points[0]).map(|part| if least > 0.0 { part / least } else { 0.0 });
    let moved = |point: Point, by: f64| [0, 1].map(|axis| point[axis] + by * along[axis]);
    Nearest { gap, overlaps: gap < -small, points: [moved(points[0], first.offset), moved(points[1], -second.offset)] }
}

/// Two regions whose cores have a point in common.
fn overlapping(first: &OutlineRegion, second: &OutlineRegion, common: Point) -> Nearest {
    Nearest { gap: -(first.offset + second.offset), overlaps: true, points: [common; 2] }
}

/// A point within both cores, whose sides do not cross: one of them is within the other, or they touch in sides and corners.
fn common_point(first: &OutlineRegion, second: &OutlineRegion, distance: f64, small: f64) -> Option<Point> {
    if distance > small {
        let corner = |of: &OutlineRegion, within: &OutlineRegion| {
            of.corners.first().copied().filter(|corner| within.holds(*corner))
        };
        return corner(first, second).or_else(|| corner(second, first));
    }
    let piece = |of: &OutlineRegion, within: &OutlineRegion| {
        of.pieces(within, small).find(|piece| within.holds_by(*piece, small))
    };
    let inner = || first.inner_point().filter(|inner| first.is_closed() && second.holds_by(*inner, small));
    piece(first, second).or_else(|| piece(second, first)).or_else(inner)
}

/// Where two sides cross: each has its ends on both sides of the other, farther from it than `small`.
fn crossing([a, b]: Side, [c, d]: Side, small: f64) -> Option<Point> {
    let distance_from = |[from, to]: Side, point: Point| {
        let along = difference(to, from);
        cross(along, difference(point, from)) / norm(along)
    };
    let apart = |p: f64, q: f64| p.min(q) < -small && p.max(q) > small;
    let [from_c, from_d] = [c, d].map(|point| distance_from([a, b], point));
    let crosses = apart(from_c, from_d) && apart(distance_from([c, d], a), distance_from([c, d], b));
    crosses.then(|| between(c, d, from_c / (from_c - from_d)))
}

/// Each end of two sides with the nearest point of the other: the nearest points of sides that do not cross are among these.
fn ends_and_feet(one: Side, other: Side) -> [[Point; 2]; 4] {
    let [a, b] = one.map(|end| [end, foot(end, other)]);
    let [c, d] = other.map(|end| [foot(end, one), end]);
    [a, b, c, d]
}

/// A distance that two sides have at least: that of their boxes.
fn box_distance(one: Side, other: Side) -> f64 {
    let apart = |axis: usize| {
        let ends = |[a, b]: Side| [a[axis].min(b[axis]), a[axis].max(b[axis])];
        let [[low, high], [other_low, other_high]] = [ends(one), ends(other)];
        (other_low - high).max(low - other_high).max(0.0)
    };
    norm([apart(0), apart(1)])
}

/// The point of a side that is nearest to a point.
fn foot(point: Point, side: Side) -> Point {
    match share(point, side) {
        share if share <= 0.0 => side[0],
        share if share >= 1.0 => side[1],
        share => between(side[0], side[1], share),
    }
}

/// Where the foot of a point on the line of a side is, from 0 to 1 along the side.
fn share(point: Point, [a, b]: Side) -> f64 {
    let along = difference(b, a);
    let square = dot(along, along);
    if square > 0.0 { dot(difference(point, a), along) / square } else { 0.0 }
}

fn between(a: Point, b: Point, share: f64) -> Point {
    [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]))
}

pub fn difference(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub fn norm([x, y]: Point) -> f64 {
    x.hypot(y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const SMALL: f64 = 1e-12;

    fn region(corners: &[Point], offset: f64) -> OutlineRegion {
        OutlineRegion { corners: corners.to_vec(), offset }
    }

    fn square(x: f64, y: f64, half: f64) -> OutlineRegion {
        region(&[[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]], 0.0)
    }

    #[track_caller]
    fn check(first: &OutlineRegion, second: &OutlineRegion, gap: f64, overlaps: bool) {
        for (a, b) in [(first, second), (second, first)] {
            let found = nearest(a, b, SMALL);
            assert!((found.gap - gap).abs() < 1e-12 && found.overlaps == overlaps, "{found:?}");
            let between = norm(difference(found.points[1], found.points[0]));
            assert!(overlaps || (between - gap.abs()).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn distances_are_those_of_closed_forms() {
        check(&square(0.0, 0.0, 1.0), &square(3.0, 4.0, 1.0), 5f64.sqrt(), false);
        check(&square(0.0, 0.0, 1.0), &square(0.5, 3.0, 1.0), 1.0, false);
        check(&region(&[[0.0, 0.0]], 0.5), &region(&[[3.0, 4.0]], 1.5), 3.0, false);
        check(&region(&[[-1.0, 1.0], [1.0, 1.0]], 0.25), &region(&[[0.0, 0.0]], 0.5), 0.25, false);
        check(&region(&[[0.0, 0.0], [1.0, 0.0]], 0.0), &region(&[[0.0, 0.5], [1.0, 1.0]], 0.1), 0.4, false);
        // A point in the mouth of a hollow polygon.
        let hollow = region(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 4.0], [3.0, 1.0], [0.0, 1.0]], 0.0);
        check(&hollow, &region(&[[1.0, 3.0]], 0.5), 1.5, false);
        check(&hollow, &region(&[[2.5, 3.0]], 0.25), 0.25, false);
    }

    #[test]
    fn what_overlaps_is_told_from_what_touches() {
        let unit = square(0.0, 0.0, 1.0);
        check(&unit, &square(2.0, 0.0, 1.0), 0.0, false);
        check(&unit, &square(2.0, 2.0, 1.0), 0.0, false);
        check(&unit, &square(1.9, 0.0, 1.0), 0.0, true);
        check(&unit, &square(1.5, 1.5, 1.0), 0.0, true);
        check(&unit, &unit, 0.0, true);
        check(&unit, &square(0.0, 0.0, 0.25), 0.0, true);
        // Corners in common, and no side that crosses another.
        check(&unit, &region(&[[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]], 0.0), 0.0, true);
        check(&unit, &region(&[[-5.0, -1.0], [5.0, -1.0], [5.0, 1.0], [-5.0, 1.0]], 0.0), 0.0, true);
        // Thin lines: through two corners, along a side, across, and with an end on a side.
        check(&unit, &region(&[[-2.0, -2.0], [2.0, 2.0]], 0.0), 0.0, true);
        check(&unit, &region(&[[-2.0, 1.0], [2.0, 1.0]], 0.0), 0.0, false);
        check(&unit, &region(&[[-2.0, 0.3], [2.0, 0.4]], 0.0), 0.0, true);
        check(&unit, &region(&[[0.0, 1.0], [0.0, 2.0]], 0.0), 0.0, false);
        check(&unit, &region(&[[0.0, 0.0], [0.5, 0.5]], 0.0), 0.0, true);
        // Reaches that overlap by a known depth.
        check(&region(&[[0.0, 0.0]], 1.0), &region(&[[1.5, 0.0]], 1.0), -0.5, true);
        check(&region(&[[0.0, 0.0]], 1.0), &region(&[[2.0, 0.0]], 1.0), 0.0, false);
    }

    #[test]
    fn a_hollow_polygon_around_another_does_not_overlap_it() {
        let c = region(
            &[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [3.0, 2.0], [3.0, 3.0], [0.0, 3.0]],
            0.0,
        );
        check(&c, &square(2.0, 1.5, 0.25), 0.25, false);
        check(&c, &square(2.0, 1.5, 0.5), 0.0, false);
        assert!(c.holds(c.inner_point().expect("a polygon")));
        check(&c, &c, 0.0, true);
    }

    /// Two polygons with many sides are nearly discs.
    #[test]
    fn many_sides_are_nearly_a_disc() {
        let round = |x: f64, y: f64, radius: f64| {
            let corner = |k: u32| TAU * f64::from(k) / 400.0;
            let corners: Vec<Point> =
                (0..400).map(|k| [x + radius * corner(k).cos(), y + radius * corner(k).sin()]).collect();
            region(&corners, 0.0)
        };
        let found = nearest(&round(0.0, 0.0, 1.0), &round(3.0, 1.0, 0.5), SMALL);
        assert!((found.gap - (10f64.sqrt() - 1.5)).abs() < 1e-4 && found.gap >= 10f64.sqrt() - 1.5, "{found:?}");
    }
}
