//! Intersections of two conics of the projective plane.

use nalgebra::{Complex, Matrix3, Vector3};

use crate::random::RandomNumbers;

type Number = Complex<f64>;

/// The points that two conics have in common.
#[derive(Clone, Debug)]
pub(crate) enum Common {
    /// The real ones, at most four, each of length one.
    Points(Vec<Vector3<f64>>),
    /// A curve.
    Curve,
}

/// Below this the resultant of two conics of size one is nothing but rounding.
const NOTHING: f64 = 1e-11;
/// A point that is as near to a real one as this is polished as a real one.
const NEARLY_REAL: f64 = 1e-5;
/// How far the polished point may be from both conics, of size one.
const MET: f64 = 1e-11;
/// Two points of length one that are nearer than this are one.
const APART: f64 = 1e-7;

/// Resultant, roots, Newton's method.
///
/// The plane is turned at random first, so that no point lies far out and no two above each other.
pub(crate) fn common(first: &Matrix3<f64>, second: &Matrix3<f64>) -> Common {
    let turn = turned();
    let part = |conic: &Matrix3<f64>| {
        let turned = turn.transpose() * conic * turn;
        turned / turned.norm().max(f64::MIN_POSITIVE)
    };
    let [p, q] = [part(first), part(second)];
    let (resultant, above) = resultant(&p, &q);
    let largest = resultant.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    if largest < NOTHING {
        return Common::Curve;
    }
    let mut points: Vec<Vector3<f64>> = Vec::new();
    for x in roots(&resultant.map(Number::from)) {
        let Some(point) = above(x).and_then(|y| real(&p, &q, x, y)) else { continue };
        let same = |other: &Vector3<f64>| (point - other).norm().min((point + other).norm()) < APART;
        if !points.iter().any(same) {
            points.push(point);
        }
    }
    Common::Points(points.into_iter().map(|point| turn * point).collect())
}

fn turned() -> Matrix3<f64> {
    let mut random = RandomNumbers::new(5);
    Matrix3::from_fn(|_, _| random.between(-1.0, 1.0)).qr().q()
}

/// A polynomial of low order, the constant first.
fn product<const N: usize>(a: &[f64], b: &[f64]) -> [f64; N] {
    let mut c = [0.0; N];
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            if i + j < N {
                c[i + j] += a * b;
            }
        }
    }
    c
}

fn minus<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn value<T: Copy>(polynomial: &[T], x: Number) -> Number
where
    Number: std::ops::Add<T, Output = Number>,
{
    polynomial.iter().rev().fold(Number::new(0.0, 0.0), |sum, coefficient| sum * x + *coefficient)
}

/// The resultant of both conics in x, where y is eliminated and z = 1; and the y that belongs to a root.
fn resultant(p: &Matrix3<f64>, q: &Matrix3<f64>) -> ([f64; 5], impl Fn(Number) -> Option<Number>) {
    // a y^2 + b(x) y + c(x)
    let of =
        |m: &Matrix3<f64>| (m[(1, 1)], [2.0 * m[(1, 2)], 2.0 * m[(0, 1)]], [m[(2, 2)], 2.0 * m[(0, 2)], m[(0, 0)]]);
    let ((a, b, c), (d, e, f)) = (of(p), of(q));
    let t: [f64; 3] = minus(product(&[a], &f), product(&[d], &c));
    let u: [f64; 2] = minus(product(&[a], &e), product(&[d], &b));
    let v: [f64; 4] = minus(product(&b, &f), product(&e, &c));
    let above = move |x: Number| {
        let below = value(&u, x);
        let one = if below.norm() > 1e-12 { -value(&t, x) / below } else { -value(&b, x) / (2.0 * a) };
        one.is_finite().then_some(one)
    };
    (minus(product(&t, &t), product(&u, &v)), above)
}

/// All roots of a polynomial, by the method of Aberth and Ehrlich.
pub(crate) fn roots(polynomial: &[Number]) -> Vec<Number> {
    let size = polynomial.iter().fold(0.0, |most: f64, coefficient| most.max(coefficient.norm()));
    let order = (0..polynomial.len()).rev().find(|&i| polynomial[i].norm() > 1e-14 * size).unwrap_or(0);
    let slope: Vec<Number> =
        polynomial.iter().enumerate().skip(1).map(|(i, coefficient)| coefficient * i as f64).collect();
    let radius = (polynomial[0] / polynomial[order]).norm().powf(1.0 / order.max(1) as f64).clamp(1e-3, 1e3);
    let mut found: Vec<Number> = (0..order).map(|i| Number::from_polar(radius, 0.4 + 1.7 * i as f64)).collect();
    for _ in 0..200 {
        let mut moved: f64 = 0.0;
        for i in 0..order {
            let x = found[i];
            let here = value(&polynomial[..=order], x);
            let newton = here / value(&slope[..order], x);
            let others = (0..order).filter(|&j| j != i).map(|j| (x - found[j]).inv()).sum::<Number>();
            let change = newton / (Number::new(1.0, 0.0) - newton * others);
            if change.is_finite() {
                found[i] -= change;
                moved = moved.max(change.norm() / (1.0 + x.norm()));
            }
        }
        if moved < 1e-15 {
            break;
        }
    }
    found
}

/// The real point near a root, if there is one: Newton's method on both conics.
fn real(p: &Matrix3<f64>, q: &Matrix3<f64>, x: Number, y: Number) -> Option<Vector3<f64>> {
    let (p_, q_) = (p.map(Number::from), q.map(Number::from));
    let mut v = Vector3::new(x, y, Number::new(1.0, 0.0));
    v /= Number::from(v.norm());
    for _ in 0..12 {
        let [above, below] = [&p_, &q_].map(|conic| conic * v);
        let one = v.map(|entry| entry.conj());
        let jacobian = Matrix3::from_rows(&[
            (above * Number::from(2.0)).transpose(),
            (below * Number::from(2.0)).transpose(),
            one.transpose(),
        ]);
        let error = Vector3::new(v.dot(&above), v.dot(&below), Number::new(0.0, 0.0));
        let Some(change) = jacobian.lu().solve(&error) else { break };
        v -= change;
        v /= Number::from(v.norm());
        if change.norm() < 1e-15 {
            break;
        }
    }
    let most = v.iter().max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    let v = v / (most / Number::from(most.norm()));
    if v.map(|entry| entry.im).norm() > NEARLY_REAL {
        return None;
    }
    let start = v.map(|entry| entry.re).normalize();
    let mut point = start;
    for _ in 0..12 {
        let [above, below] = [p, q].map(|conic| conic * point);
        let jacobian = Matrix3::from_rows(&[2.0 * above.transpose(), 2.0 * below.transpose(), point.transpose()]);
        let error = Vector3::new(point.dot(&above), point.dot(&below), 0.0);
        let Some(change) = jacobian.lu().solve(&error).filter(|change| change.norm() < 0.1) else { break };
        point = (point - change).normalize();
        if change.norm() < 1e-16 {
            break;
        }
    }
    let error = |conic: &Matrix3<f64>| point.dot(&(conic * point)).abs();
    (error(p).max(error(q)) < MET && (point - start).norm() < 10.0 * NEARLY_REAL).then_some(point)
}
