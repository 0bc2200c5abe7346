//! Four-bars from the sextic equation of the coupler curve through the points.
//!
//! The curve of a coupler point is a tricircular sextic: in z = x + i y and its conjugate w it is a sum of c z^j w^k with j, k up to 3, sixteen real numbers up to a factor, which
//! points without noise determine if there are enough of them and they do not lie too close together. The roots of what stands before w^3 are its singular foci: the pivots of the
//! four-bar and of its cognates, and the triangle of the coupler is similar to theirs. What is left, the size of that triangle and both bars, is linear in their squares and products.
//!
//! Source: S. Roberts, *On three-bar motion in plane space*, Proc. London Math. Soc. 7, 1875; the elimination of the coupler's angle: C. W. Wampler, A. P. Morgan, A. J. Sommese, *Complete
//! solution of the nine-point path synthesis problem for four-bar linkages*, J. Mech. Des. 114, 1992.

use nalgebra::{DMatrix, DVector};

use crate::atlas::Start;
use crate::conics::roots;
use crate::least::Unknowns;
use crate::{Point, dot};

/// The highest power of z and of its conjugate.
const ORDER: usize = 3;
const COEFFICIENTS: usize = (ORDER + 1) * (ORDER + 1);
/// Equations that are looked at: those that the points meet best.
const LOOKED_AT: usize = 3;

/// Starts from the equations of the curve, for each pair of the foci.
pub(crate) fn starts(points: &[Point]) -> Vec<Start> {
    if points.len() < COEFFICIENTS {
        return Vec::new();
    }
    let foci = equations(points).into_iter().filter_map(|equation| foci(&equation));
    foci.flat_map(|[a, b, c]| {
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().filter_map(|foci| start(points, foci)).collect::<Vec<_>>()
    })
    .collect()
}

/// The coefficients of z^j w^k, k not above j, of the equations that the points meet best; those of equal powers are real.
fn equations(points: &[Point]) -> Vec<[[Point; ORDER + 1]; ORDER + 1]> {
    let powers: Vec<(usize, usize, bool)> = (0..=ORDER)
        .flat_map(|j| (0..=j).flat_map(move |k| [false, true].into_iter().map(move |turned| (j, k, turned))))
        .filter(|(j, k, turned)| j != k || !turned)
        .collect();
    let mut rows = DMatrix::from_fn(points.len(), COEFFICIENTS, |row, column| {
        let (j, k, turned) = powers[column];
        let term = points[row].powu(j as u32) * points[row].conj().powu(k as u32);
        if turned { -term.im } else { term.re }
    });
    let sizes: Vec<f64> = (0..COEFFICIENTS).map(|column| rows.column(column).norm().max(f64::MIN_POSITIVE)).collect();
    (0..COEFFICIENTS).for_each(|column| rows.column_mut(column).unscale_mut(sizes[column]));
    let Some(turns) = rows.svd(false, true).v_t else { return Vec::new() };
    let equation = |row: usize| {
        let mut found = [[Point::new(0.0, 0.0); ORDER + 1]; ORDER + 1];
        for (column, &(j, k, turned)) in powers.iter().enumerate() {
            let value = turns[(row, column)] / sizes[column] * if j == k { 1.0 } else { 0.5 };
            found[j][k] += if turned { Point::new(0.0, value) } else { Point::new(value, 0.0) };
        }
        found
    };
    (0..LOOKED_AT).map(|index| equation(COEFFICIENTS - 1 - index)).collect()
}

/// The singular foci.
fn foci(equation: &[[Point; ORDER + 1]; ORDER + 1]) -> Option<[Point; 3]> {
    let before: [Point; 4] =
        std::array::from_fn(|j| if j == ORDER { equation[ORDER][ORDER] } else { equation[ORDER][j].conj() });
    let found: [Point; 3] = roots(&before).try_into().ok()?;
    found.iter().all(|focus| focus.is_finite()).then_some(found)
}

/// The four-bar between the first two foci, whose coupler's triangle is similar to that of all.
fn start(points: &[Point], [a, b, c]: [Point; 3]) -> Option<Start> {
    let share = (c - a) / (b - a);
    let pins = [-share, Point::new(1.0, 0.0) - share];
    // With the pins k times as far from the point: n = |p - pivot|^2 - rest, of both bars n = -2 k Re(u t), where t turns the coupler.
    let arms = |point: &Point| [(point - a, pins[0]), (point - b, pins[1])].map(|(way, pin)| way.conj() * pin);
    let row = |point: &Point| -> ([f64; 6], f64) {
        let [u, v] = arms(point);
        let [m, n] = [(point - a).norm_sqr(), (point - b).norm_sqr()];
        let across = 2.0 * (u * v.conj()).im;
        let (uu, vv, uv) = (u.norm_sqr(), v.norm_sqr(), dot(u, v));
        let known = m * m * vv + n * n * uu - 2.0 * m * n * uv;
        ([2.0 * (n * uv - m * vv), 2.0 * (m * uv - n * uu), vv, -2.0 * uv, uu, -across * across], -known)
    };
    let mut rows = DMatrix::zeros(points.len(), 6);
    let mut right = DVector::zeros(points.len());
    for (index, point) in points.iter().enumerate() {
        let (values, known) = row(point);
        (0..6).for_each(|column| rows[(index, column)] = values[column]);
        right[index] = known;
    }
    let sizes: Vec<f64> = (0..6).map(|column| rows.column(column).norm().max(f64::MIN_POSITIVE)).collect();
    (0..6).for_each(|column| rows.column_mut(column).unscale_mut(sizes[column]));
    let found = rows.svd(true, true).solve(&right, 1e-14).ok()?;
    let [one, other, square] = [0, 1, 5].map(|index| found[index] / sizes[index]);
    let size = square.max(1e-6).sqrt();
    let lengths =
        [(one, pins[0]), (other, pins[1])].map(|(rest, pin)| (rest + square * pin.norm_sqr()).max(1e-6).sqrt());
    let turn = |point: &Point| {
        let [u, v] = arms(point).map(|arm| arm * size);
        let [m, n] = [(point - a).norm_sqr() - one, (point - b).norm_sqr() - other];
        [(n * u.conj() - m * v.conj()) / (u * v.conj() - u.conj() * v)].map(|turn| turn.arg())
    };
    let [p, q] = pins.map(|pin| pin * size);
    let shared = [p.re, p.im, q.re, q.im, a.re, a.im, b.re, b.im, lengths[0], lengths[1]];
    let local: Vec<[f64; 1]> = points.iter().map(turn).collect();
    let is_finite = shared.iter().chain(local.iter().flatten()).all(|value| value.is_finite());
    is_finite.then_some(Unknowns { shared, local })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dyad::Dyad;
    use crate::linkage::Linkage;
    use crate::polar;

    /// Points on a third of the curve of a known four-bar: one start has its pivots and its lengths, others those of its cognates.
    #[test]
    fn the_equation_of_a_curve_has_its_four_bar() {
        let tracer = Point::new(0.5, 0.4);
        let first = Dyad::Bar { moving: -tracer, ground: Point::new(0.0, 0.0), length: 0.3 };
        let second = Dyad::Bar { moving: Point::new(0.9, 0.0) - tracer, ground: Point::new(0.8, 0.1), length: 0.7 };
        let linkage = Linkage { first, second };
        let at = |k: i32| linkage.pose(0.3 + 0.1 * f64::from(k), 1.0).expect("a crank turns").at;
        let points: Vec<Point> = (0..24).map(at).collect();
        let error = |start: &Start| {
            let unknowns = &start.shared;
            let near = |order: [usize; 6], known: [f64; 6]| {
                order.iter().zip(known).map(|(&index, known)| (unknowns[index] - known).abs()).fold(0.0, f64::max)
            };
            let known = [0.0, 0.0, 0.8, 0.1, 0.3, 0.7];
            near([4, 5, 6, 7, 8, 9], known).min(near([6, 7, 4, 5, 9, 8], known))
        };
        let best = starts(&points).iter().map(error).fold(f64::INFINITY, f64::min);
        assert!(best < 1e-6, "{best:e}");
    }

    #[test]
    fn roots_of_a_cubic_are_its_roots() {
        let known = [Point::new(0.3, -0.2), polar(2.0, 1.0), Point::new(-1.0, 0.5)];
        let [a, b, c] = known;
        let found = roots(&[-a * b * c, a * b + b * c + c * a, -(a + b + c), Point::new(1.0, 0.0)]);
        for expected in known {
            assert!(found.iter().any(|other| (expected - other).norm() < 1e-12), "{expected} in {found:?}");
        }
    }
}
