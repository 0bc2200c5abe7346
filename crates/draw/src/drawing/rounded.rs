//! The rim of what reaches beyond its corners, as a polygon.

use std::f64::consts::{PI, TAU};

use super::shapes::{along, difference, normal, unit};
use crate::alike::Alike;

/// Corners of a whole turn of an arc.
const TURN: f64 = 64.0;

/// The rim of all that is not farther than this from a polygon, or from the line between two corners. Arcs are polygons with many corners; where the
/// polygon is hollow, the sides that are moved outwards meet, which they do as long as they are longer than the reach.
pub fn widened(corners: &[[f64; 2]], offset: f64) -> Vec<[f64; 2]> {
    if corners.len() < 2 || offset.is_nan() || offset <= 0.0 {
        return corners.to_vec();
    }
    let mut corners = corners.to_vec();
    if area(&corners) < 0.0 {
        corners.reverse();
    }
    let count = corners.len();
    let mut rim = Vec::new();
    for index in 0..count {
        let [before, corner, after] = [index + count - 1, index, index + 1].map(|index| corners[index % count]);
        // Outwards is to the right of a side that goes counter-clockwise.
        let [first, second] =
            [difference(corner, before), difference(after, corner)].map(|side| normal(unit(side)).map(|part| -part));
        let turn = cross(first, second).angle_over(dot(first, second));
        // The ends of a line are half a turn.
        let turn = if count == 2 { PI } else { turn };
        if turn < 0.0 {
            rim.push(along(corner, offset / (1.0 + dot(first, second)).max(0.1), along(first, 1.0, second)));
            continue;
        }
        let steps = (turn / TAU * TURN).ceil().max(1.0);
        rim.extend((0..=steps as usize).map(|step| {
            let angle = turn * step as f64 / steps;
            let (sine, cosine) = angle.sine_and_cosine();
            let direction = [cosine * first[0] - sine * first[1], sine * first[0] + cosine * first[1]];
            along(corner, offset, direction)
        }));
    }
    rim
}

/// Twice the area, positive counter-clockwise.
fn area(corners: &[[f64; 2]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| cross(*a, *b)).sum()
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_those_of_closed_forms() {
        let arcs = PI * 0.5 * 0.5;
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
        let clockwise = [[0.0, 0.0], [0.0, 1.0], [2.0, 1.0], [2.0, 0.0]];
        for corners in [square, clockwise] {
            assert!((0.5 * area(&widened(&corners, 0.5)) - (2.0 + 6.0 * 0.5 + arcs)).abs() < 2e-3 * arcs);
        }
        let bar = widened(&[[0.0, 0.0], [3.0, 4.0]], 0.5);
        assert!((0.5 * area(&bar) - (5.0 + arcs)).abs() < 2e-3 * arcs);
        // A hollow corner: two squares of a 2 by 2 square's four, and one more.
        let angle = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let wide = 3.0 + 8.0 * 0.1 + (PI * 1.25 - 1.0) * 0.01;
        assert!((0.5 * area(&widened(&angle, 0.1)) - wide).abs() < 1e-4);
        assert_eq!(widened(&square, 0.0), square.to_vec());
    }
}
