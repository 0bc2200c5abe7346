//! The pieces of a table: polynomials between its places and beyond.

use super::Table;
use crate::scene::expression::Lookup;

/// A polynomial in x - origin that holds from a place on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PolynomialPiece {
    pub start: f64,
    pub origin: f64,
    pub coefficients: [f64; 4],
}

/// More pieces would make a law that is slower than the mechanism.
const MOST: usize = 1000;
/// The last value of a periodic table is the first up to this share of its values.
const CLOSED: f64 = 1e-9;

/// The pieces in their order, the first from minus infinity on; or the row that is at fault, and why.
pub(super) fn pieces(table: &Table, lookup: Lookup) -> Result<Vec<PolynomialPiece>, (usize, String)> {
    let (x, y) = (&table.x, &table.y);
    let last = x.len() - 1;
    let least = if lookup.smooth { 2 } else { 1 } + usize::from(lookup.smooth && lookup.periodic);
    if last < least {
        return Err((last, format!("has {} rows; at least {} are needed", last + 1, least + 1)));
    }
    if last > MOST {
        return Err((MOST + 1, format!("has {} rows; at most {} can be used", last + 1, MOST + 1)));
    }
    let largest = y.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    if lookup.periodic && (y[0] - y[last]).abs() > CLOSED * largest {
        return Err((last, format!("does not close: its last value is {}, but its first is {}", y[last], y[0])));
    }
    let inner = match (lookup.smooth, lookup.periodic) {
        (false, _) => lines(x, y),
        (true, false) => cubics(x, y, &natural(x, y)),
        (true, true) => cubics(x, y, &periodic(x, y)),
    };
    Ok(if lookup.periodic { inner } else { with_ends(inner, x[last], y[last], lookup.smooth) })
}

fn lines(x: &[f64], y: &[f64]) -> Vec<PolynomialPiece> {
    let piece = |(x, y): (&[f64], &[f64])| {
        let coefficients = [y[0], (y[1] - y[0]) / (x[1] - x[0]), 0.0, 0.0];
        PolynomialPiece { start: x[0], origin: x[0], coefficients }
    };
    x.windows(2).zip(y.windows(2)).map(piece).collect()
}

/// The cubics of a spline, given its second derivatives.
fn cubics(x: &[f64], y: &[f64], second: &[f64]) -> Vec<PolynomialPiece> {
    let piece = |k: usize| {
        let h = x[k + 1] - x[k];
        let slope = (y[k + 1] - y[k]) / h - h * (2.0 * second[k] + second[k + 1]) / 6.0;
        let coefficients = [y[k], slope, second[k] / 2.0, (second[k + 1] - second[k]) / (6.0 * h)];
        PolynomialPiece { start: x[k], origin: x[k], coefficients }
    };
    (0..x.len() - 1).map(piece).collect()
}

/// Before its first and after its last place a table keeps its value, a spline its slope: its second derivative is zero there, so that it stays
/// twice differentiable.
fn with_ends(mut pieces: Vec<PolynomialPiece>, end: f64, value: f64, smooth: bool) -> Vec<PolynomialPiece> {
    let (first, last) = (pieces[0].clone(), pieces[pieces.len() - 1].clone());
    let [.., c1, c2, c3] = last.coefficients;
    let h = end - last.origin;
    let slope = |slope: f64| if smooth { slope } else { 0.0 };
    let [c0, before, ..] = first.coefficients;
    pieces.insert(
        0,
        PolynomialPiece { start: f64::NEG_INFINITY, origin: first.origin, coefficients: [c0, slope(before), 0.0, 0.0] },
    );
    let after = c1 + h * (2.0 * c2 + h * 3.0 * c3);
    pieces.push(PolynomialPiece { start: end, origin: end, coefficients: [value, slope(after), 0.0, 0.0] });
    pieces
}

/// h[k-1] m[k-1] + 2 (h[k-1] + h[k]) m[k] + h[k] m[k+1] = 6 (d[k] - d[k-1]) (de Boor, *A Practical Guide to Splines*, ch. IV), with the lengths h and
/// the mean slopes d before and after each place.
fn row(x: &[f64], y: &[f64], before: [usize; 2], after: [usize; 2]) -> ([f64; 3], f64) {
    let length = |[a, b]: [usize; 2]| x[b] - x[a];
    let slope = |[a, b]: [usize; 2]| (y[b] - y[a]) / (x[b] - x[a]);
    let (h, next) = (length(before), length(after));
    ([h, 2.0 * (h + next), next], 6.0 * (slope(after) - slope(before)))
}

/// Second derivatives of the natural spline: none at its ends.
fn natural(x: &[f64], y: &[f64]) -> Vec<f64> {
    let rows: Vec<_> = (1..x.len() - 1).map(|k| row(x, y, [k - 1, k], [k, k + 1])).collect();
    let inner = tridiagonal(&rows, |k| rows[k].1);
    std::iter::once(0.0).chain(inner).chain([0.0]).collect()
}

/// Second derivatives of the periodic spline: the corners of its matrix by Sherman's and Morrison's formula.
fn periodic(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len() - 1;
    let mut rows: Vec<_> =
        (0..n).map(|k| row(x, y, if k == 0 { [n - 1, n] } else { [k - 1, k] }, [k, k + 1])).collect();
    let (corner, other) = (rows[0].0[0], rows[n - 1].0[2]);
    let gamma = -rows[0].0[1];
    rows[0].0[1] -= gamma;
    rows[n - 1].0[1] -= corner * other / gamma;
    let plain = tridiagonal(&rows, |k| rows[k].1);
    let unit = |k: usize| {
        if k == 0 {
            gamma
        } else if k == n - 1 {
            other
        } else {
            0.0
        }
    };
    let correction = tridiagonal(&rows, unit);
    let along = |m: &[f64]| m[0] + corner / gamma * m[n - 1];
    let factor = along(&plain) / (1.0 + along(&correction));
    let mut second: Vec<f64> = plain.iter().zip(&correction).map(|(a, b)| a - factor * b).collect();
    second.push(second[0]);
    second
}

/// Solves a tridiagonal system whose diagonal is dominant.
fn tridiagonal(rows: &[([f64; 3], f64)], right: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut above: Vec<f64> = Vec::with_capacity(rows.len());
    let mut solution: Vec<f64> = Vec::with_capacity(rows.len());
    for (k, ([lower, diagonal, upper], _)) in rows.iter().enumerate() {
        let (before, value) = if k == 0 { (0.0, 0.0) } else { (above[k - 1], solution[k - 1]) };
        let lower = if k == 0 { 0.0 } else { *lower };
        let pivot = diagonal - lower * before;
        above.push(upper / pivot);
        solution.push((right(k) - lower * value) / pivot);
    }
    for k in (1..rows.len()).rev() {
        solution[k - 1] -= above[k - 1] * solution[k];
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(x: &[f64], y: &[f64]) -> Table {
        Table { x: x.to_vec(), y: y.to_vec(), units: [None; 2], places: Vec::new() }
    }

    fn value(pieces: &[PolynomialPiece], x: f64, derivative: usize) -> f64 {
        let piece = pieces.iter().rev().find(|piece| x >= piece.start).unwrap_or(&pieces[0]);
        let (d, [c0, c1, c2, c3]) = (x - piece.origin, piece.coefficients);
        match derivative {
            0 => c0 + d * (c1 + d * (c2 + d * c3)),
            1 => c1 + d * (2.0 * c2 + d * 3.0 * c3),
            _ => 2.0 * c2 + 6.0 * d * c3,
        }
    }

    /// Value, slope and curvature agree where pieces meet, also around the period; and the values are those of the table.
    #[test]
    fn splines_are_twice_differentiable_everywhere() {
        let x = [-1.0, 0.0, 0.4, 1.5, 2.0, 3.5];
        let y = [2.0, -1.0, 0.5, 0.7, 3.0, 2.0];
        for periodic in [false, true] {
            let pieces = pieces(&table(&x, &y), Lookup { smooth: true, periodic }).unwrap();
            for (x, y) in x.iter().zip(&y).take(if periodic { 5 } else { 6 }) {
                assert!((value(&pieces, *x, 0) - y).abs() < 1e-13);
            }
            let period = if periodic { 4.5 } else { 0.0 };
            for (index, x) in x.iter().enumerate() {
                let (before, after) = if periodic && index % 5 == 0 { (3.5, -1.0) } else { (*x, *x) };
                let before = before - 1e-12;
                for derivative in 0..3 {
                    let jump = value(&pieces, after, derivative) - value(&pieces, before, derivative);
                    assert!(jump.abs() < 1e-9, "{periodic} {period} {x} {derivative}: {jump}");
                }
            }
        }
    }

    /// A spline through values of a parabola with the parabola's second derivatives would be the parabola; the natural one is it in the middle.
    #[test]
    fn many_places_give_the_function() {
        let x: Vec<f64> = (0..=60).map(|k| f64::from(k) / 60.0 * std::f64::consts::TAU).collect();
        let mut y: Vec<f64> = x.iter().map(|x| x.sin()).collect();
        y[60] = 0.0;
        let pieces = pieces(&table(&x, &y), Lookup { smooth: true, periodic: true }).unwrap();
        for x in [0.03, 1.234, 3.0, 6.2] {
            assert!((value(&pieces, x, 0) - x.sin()).abs() < 1e-6);
            assert!((value(&pieces, x, 1) - x.cos()).abs() < 2e-5);
        }
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let closed = Lookup { smooth: true, periodic: true };
        assert_eq!(pieces(&table(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 2.0, 3.0]), closed).unwrap_err().0, 3);
        let open = Lookup { smooth: true, periodic: false };
        assert_eq!(pieces(&table(&[0.0, 1.0], &[0.0, 1.0]), open).unwrap_err().0, 1);
    }
}
