//! Plane geometry for the drawing.

use crate::alike::Alike;
use crate::svg::Pixel;

pub fn difference(b: Pixel, a: Pixel) -> Pixel {
    [b[0] - a[0], b[1] - a[1]]
}

/// a + s b
pub fn along(a: Pixel, s: f64, b: Pixel) -> Pixel {
    [a[0] + s * b[0], a[1] + s * b[1]]
}

pub fn norm([x, y]: Pixel) -> f64 {
    x.length_with(y)
}

/// The same direction with length 1; to the right if there is none.
pub fn unit(a: Pixel) -> Pixel {
    let length = norm(a);
    if length > 0.0 { [a[0] / length, a[1] / length] } else { [1.0, 0.0] }
}

pub fn normal([x, y]: Pixel) -> Pixel {
    [-y, x]
}

pub fn middle(points: &[Pixel]) -> Pixel {
    let count = points.len().max(1) as f64;
    let sum = points.iter().fold([0.0, 0.0], |sum, &point| along(sum, 1.0, point));
    sum.map(|x| x / count)
}

pub fn extent(points: &[Pixel]) -> f64 {
    let span = |axis: usize| {
        let values = points.iter().map(|point| point[axis]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    if points.is_empty() { 0.0 } else { span(0).length_with(span(1)) }
}

/// Is a point inside a polygon, or nearer to its rim than this?
pub fn covers(rim: &[Pixel], point: Pixel, margin: f64) -> bool {
    let sides = || rim.iter().zip(rim.iter().cycle().skip(1));
    let near = sides().any(|(&a, &b)| {
        let side = difference(b, a);
        let share = dot(difference(point, a), side) / dot(side, side).max(f64::MIN_POSITIVE);
        norm(difference(point, along(a, share.clamp(0.0, 1.0), side))) <= margin
    });
    // A ray to the right crosses the rim of what it starts in an odd number of times.
    let crossed = sides().filter(|(a, b)| {
        (a[1] > point[1]) != (b[1] > point[1]) && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    });
    near || crossed.count() % 2 == 1
}

pub fn dot(a: Pixel, b: Pixel) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Corners of the convex hull, in order (Andrew's monotone chain); of points in line, whatever their direction and their rounding errors, the two ends.
pub fn hull(mut points: Vec<Pixel>) -> Vec<Pixel> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    if let Some(ends) = ends_of_line(&points) {
        return ends.to_vec();
    }
    let mut corners = half_hull(points.iter().copied());
    let upper = half_hull(points.iter().rev().copied());
    corners.pop();
    corners.extend(&upper[..upper.len() - 1]);
    corners
}

/// The ends, if all points lie on one line but for rounding errors.
fn ends_of_line(points: &[Pixel]) -> Option<[Pixel; 2]> {
    let farthest = |from: Pixel| {
        let distance = |point: &Pixel| norm(difference(*point, from));
        points.iter().copied().max_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let end = farthest(*points.first()?)?;
    let start = farthest(end)?;
    let line = difference(end, start);
    let off = |point: &Pixel| dot(normal(unit(line)), difference(*point, start)).abs();
    points.iter().all(|point| off(point) <= 1e-9 * norm(line)).then_some([start, end])
}

fn half_hull(points: impl Iterator<Item = Pixel>) -> Vec<Pixel> {
    let mut corners: Vec<Pixel> = Vec::new();
    for point in points {
        while let [.., a, b] = corners[..] {
            // Without a tolerance: along an upright side the order of the points is that of their rounding errors, and an end would be dropped.
            if dot(normal(difference(b, a)), difference(point, a)) > 0.0 {
                break;
            }
            corners.pop();
        }
        corners.push(point);
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_drops_inner_points() {
        let hull = hull(vec![[0.0, 0.0], [2.0, 0.0], [1.0, 0.5], [1.0, 2.0], [1.0, 0.0]]);
        assert_eq!(hull, [[0.0, 0.0], [2.0, 0.0], [1.0, 2.0]]);
    }

    #[test]
    fn the_hull_of_a_line_is_its_ends() {
        assert_eq!(hull(vec![[1.0, 1.0]; 4]), [[1.0, 1.0]]);
        assert!(hull(vec![]).is_empty());
        // In all directions, with the rounding errors of a turned body, in any order.
        for turn in 0..720 {
            let (sine, cosine) = (0.5 * f64::from(turn)).to_radians().sine_and_cosine();
            let at = |s: f64| [300.0 + s * cosine, 200.0 + s * sine];
            for middle in [[3.0, 80.0, 61.0], [99.0, 1.0, 50.0]] {
                let points = [100.0, middle[0], 0.0, middle[1], middle[2]].map(at);
                let found = hull(points.to_vec());
                assert!(found == [at(0.0), at(100.0)] || found == [at(100.0), at(0.0)], "{turn}: {found:?}");
            }
        }
    }

    #[test]
    fn an_upright_side_keeps_its_ends() {
        let (top, bottom) = ([1e-15, 10.0], [0.0, 0.0]);
        let found = hull(vec![bottom, top, [2e-15, 5.0], [-5.0, 3.0]]);
        assert!(found.contains(&top) && found.contains(&bottom), "{found:?}");
    }
}
