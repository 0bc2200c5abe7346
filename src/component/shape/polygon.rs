//! A flat polygon. Its area, mass centre and second moment are sums over the triangles between its first corner and its sides, each with the
//! sign of its turn, so it need not be convex; taken from that corner, a polygon far from the origin loses no digits.

use super::{Flaw, Shape, Solid, difference, square};
use crate::model::{Formula, Outline};
use crate::scene::key::{Form, Key};
use crate::scene::{Corner, Shape as Built};

/// Beyond so many corners all pairs of sides are too many to test.
const MOST: usize = 1000;

pub(super) const POLYGON: Shape = Shape {
    about: "a flat polygon",
    equations: "m = density area, I = m (integral of r^2 over the area)/area about the mass centre",
    example: "{ polygon = [\"inner\", [0.3, -0.05], \"outer\"], thickness = \"5 mm\", density = \"2700 kg/m3\" }",
    flaw,
    ..Shape::flat(Key::one_of("polygon", Form::Corners(3, MOST), "its corners, counter-clockwise"), solid)
};

fn solid(corners: &[[Formula; 2]], _value: &dyn Fn(&str) -> Formula) -> Solid {
    let arms: Vec<[Formula; 2]> = corners[1..].iter().map(|corner| difference([corner, &corners[0]])).collect();
    // Of a triangle with the sides a and b from the first corner: area a x b/2, mass centre (a + b)/3, second moment about the corner
    // (a.a + a.b + b.b)/6 times its area.
    let triangles = || arms.windows(2).map(|pair| (&pair[0], &pair[1]));
    let total = |part: &dyn Fn(&[Formula; 2], &[Formula; 2]) -> Formula| {
        sum(triangles().map(|(a, b)| cross(a, b) * part(a, b)).collect())
    };
    let doubled = sum(triangles().map(|(a, b)| cross(a, b)).collect());
    let mean = |sum: Formula, share: f64| sum / (Formula::Number(share) * doubled.clone());
    let offset = [0, 1].map(|axis| mean(total(&|a, b| a[axis].clone() + b[axis].clone()), 3.0));
    let second = mean(total(&|a, b| square(a.clone()) + dot(a, b) + square(b.clone())), 6.0);
    let [x, y] = corners[0].clone();
    Solid {
        size: doubled.clone() / Formula::Number(2.0),
        centre: [x + offset[0].clone(), y + offset[1].clone()],
        gyration: second - square(offset),
        outline: Outline::Polygon(corners.to_vec()),
    }
}

fn flaw(corners: &[[f64; 2]]) -> Option<Flaw> {
    if let Some(flaw) = flaw_of_boundary(corners) {
        return Some(flaw);
    }
    let area = (1..corners.len() - 1).map(|i| turn(corners[0], corners[i], corners[i + 1])).sum::<f64>();
    let clockwise = "list its corners counter-clockwise: in the other order";
    (area < 0.0).then(|| (0, "has its corners clockwise".to_string(), clockwise))
}

/// What is wrong with a boundary in either direction.
pub(super) fn flaw_of_boundary(corners: &[[f64; 2]]) -> Option<Flaw> {
    let count = corners.len();
    let side = |i: usize| [corners[i], corners[(i + 1) % count]];
    if let Some(twice) = (0..count).find(|&i| side(i)[0] == side(i)[1]) {
        return Some(((twice + 1) % count, "has the same corner twice".to_string(), "name each corner once"));
    }
    if are_on_a_line(corners) {
        return Some((0, "has no area".to_string(), "its corners must not lie on one line"));
    }
    for i in 0..count {
        if let Some(j) = (i + 1..count).find(|&j| meet(side(i), side(j), (j + 1) % count == i, j == i + 1)) {
            let message = format!("crosses or touches itself: its sides {} and {}", i + 1, j + 1);
            return Some((j, message, "list the corners in their order along the boundary"));
        }
    }
    None
}

impl Built {
    /// A flat polygon with its corners counter-clockwise.
    pub fn polygon<C: Into<Corner>>(corners: impl IntoIterator<Item = C>) -> Built {
        Built::new("polygon", corners.into_iter().map(Into::into).collect())
    }
}

fn cross(a: &[Formula; 2], b: &[Formula; 2]) -> Formula {
    a[0].clone() * b[1].clone() - a[1].clone() * b[0].clone()
}

fn dot(a: &[Formula; 2], b: &[Formula; 2]) -> Formula {
    a[0].clone() * b[0].clone() + a[1].clone() * b[1].clone()
}

/// The sum of some terms; in halves, so that the formula is not deep.
fn sum(mut terms: Vec<Formula>) -> Formula {
    match terms.len() {
        0 => Formula::Number(0.0),
        1 => terms.swap_remove(0),
        count => {
            let rest = terms.split_off(count / 2);
            sum(terms) + sum(rest)
        }
    }
}

/// Are all corners on one line, up to rounding?
fn are_on_a_line(corners: &[[f64; 2]]) -> bool {
    let away = |corner: &[f64; 2]| (corner[0] - corners[0][0]).hypot(corner[1] - corners[0][1]);
    let Some(far) = corners.iter().max_by(|a, b| away(a).total_cmp(&away(b))) else { return true };
    corners.iter().all(|corner| turn(corners[0], *far, *corner).abs() <= 1e-12 * away(far).powi(2))
}

/// Twice the area of a triangle, positive if its corners are counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Do two sides meet? Neighbours may share the corner between them and nothing else.
fn meet(first: [[f64; 2]; 2], second: [[f64; 2]; 2], before: bool, after: bool) -> bool {
    if before || after {
        // They share a corner; beyond it they must not run back into each other.
        let (shared, a, b) = if after { (first[1], first[0], second[1]) } else { (first[0], first[1], second[0]) };
        let along = (a[0] - shared[0]) * (b[0] - shared[0]) + (a[1] - shared[1]) * (b[1] - shared[1]);
        return turn(a, shared, b) == 0.0 && along > 0.0;
    }
    let sides = |[a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]| [turn(a, b, c), turn(a, b, d)];
    let apart = |[p, q]: [f64; 2]| (p > 0.0 && q > 0.0) || (p < 0.0 && q < 0.0);
    let overlap = |axis: usize| {
        let span = |[a, b]: [[f64; 2]; 2]| [a[axis].min(b[axis]), a[axis].max(b[axis])];
        let ([low, high], [other_low, other_high]) = (span(first), span(second));
        low <= other_high && other_low <= high
    };
    overlap(0) && overlap(1) && !apart(sides(first, second)) && !apart(sides(second, first))
}
