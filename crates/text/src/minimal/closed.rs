//! Dependent coordinates in closed form: loop equations with one unknown are linear in a displacement or in the cosine and sine of an angle.

use cotree::equations::Equations;
use cotree::expr::{Binary, Expr, Order, Symbol, Unary};

use crate::steps::Moment;

/// What the loop equations give one after the other.
#[derive(Debug, Default)]
pub struct Closed {
    pub positions: Vec<(usize, Expr)>,
    /// Coordinates that are left.
    pub open: Vec<usize>,
    /// Loop equations that are left: their numbers among those that constrain the motion, and their indices.
    pub rows: Vec<(usize, usize)>,
}

impl Closed {
    pub fn new(equations: &mut Equations, start: &Moment, rows: &[usize], dependent: &[usize]) -> Closed {
        let numbers: Vec<usize> = equations.loops().map(|(index, _)| index).collect();
        let number = |index: &usize| numbers.iter().position(|number| number == index).unwrap_or_default();
        let mut closed = Closed {
            positions: Vec::new(),
            open: dependent.to_vec(),
            rows: rows.iter().map(|index| (number(index), *index)).collect(),
        };
        while let Some((place, column, value)) = closed.next(equations, start) {
            closed.rows.remove(place);
            closed.open.retain(|other| *other != column);
            closed.positions.push((column, value));
        }
        closed
    }

    /// A loop equation with one unknown, that unknown, and its value.
    fn next(&self, equations: &mut Equations, start: &Moment) -> Option<(usize, usize, Expr)> {
        (0..self.rows.len()).find_map(|place| {
            let (_, index) = self.rows[place];
            let jacobian = equations.constraints[index].jacobian.clone();
            let unknown: Vec<usize> =
                jacobian.iter().map(|(at, _)| *at).filter(|jacobian| self.open.contains(jacobian)).collect();
            let [column] = unknown[..] else { return None };
            Some((place, column, solved(equations, start, index, column)?))
        })
    }
}

/// C + B u = 0, or C + A cos u + B sin u = 0, if the equation is that.
fn solved(equations: &mut Equations, start: &Moment, index: usize, column: usize) -> Option<Expr> {
    let symbol = Symbol::Coordinate(column, Order::Position);
    let phi = equations.constraints[index].value;
    let arena = &mut equations.system.arena;
    let slope = arena.derivative(phi, symbol);
    let second = arena.derivative(slope, symbol);
    let [phi_0, b, second_0] = [phi, slope, second].map(|expr| arena.substituted(expr, symbol, Expr::ZERO));
    if arena.is_affine(&[phi], |of| of == symbol) {
        let quotient = arena.divide(phi_0, b);
        return Some(arena.negate(quotient));
    }
    let a = arena.negate(second_0);
    let c = arena.add(phi_0, second_0);
    if !equations.coordinates[column].angular || !is_trigonometric(equations, start, index, column, [a, b, c]) {
        return None;
    }
    let candidates = angles(equations, [a, b, c]);
    // Of the two assemblies that of the start, but for whole turns.
    let values = start.of(equations, &candidates);
    let known = start.positions.get(column).copied()?;
    let gap = |value: f64| 1.0 - (value - known).cos();
    let best = (0..candidates.len()).min_by(|&i, &j| gap(values[i]).total_cmp(&gap(values[j])))?;
    (gap(values[best]) < 1e-9).then(|| candidates[best])
}

/// Is the equation C + A cos u + B sin u for other values of u too?
fn is_trigonometric(equations: &Equations, start: &Moment, index: usize, column: usize, [a, b, c]: [Expr; 3]) -> bool {
    let phi = equations.constraints[index].value;
    [0.3, 1.1, 2.9, 4.6].into_iter().all(|u: f64| {
        let mut values = start.clone();
        values.positions[column] = u;
        let found = values.of(equations, &[phi, a, b, c]);
        let size = found.iter().fold(1e-12_f64, |size, value| size.max(value.abs()));
        (found[0] - found[3] - found[1] * u.cos() - found[2] * u.sin()).abs() <= 1e-9 * size
    })
}

/// Both solutions of C + A cos u + B sin u = 0.
fn angles(equations: &mut Equations, [a, b, c]: [Expr; 3]) -> Vec<Expr> {
    let arena = &mut equations.system.arena;
    let [minus_a, minus_b, minus_c] = [a, b, c].map(|expr| arena.negate(expr));
    if c == Expr::ZERO {
        return [[minus_a, b], [a, minus_b]].map(|[y, x]| arena.binary(Binary::Atan2, y, x)).to_vec();
    }
    let pi = arena.constant(std::f64::consts::PI);
    if a == Expr::ZERO {
        let sine = arena.divide(minus_c, b);
        let angle = arena.unary(Unary::Asin, sine);
        return vec![angle, arena.subtract(pi, angle)];
    }
    if b == Expr::ZERO {
        let cosine = arena.divide(minus_c, a);
        let angle = arena.unary(Unary::Acos, cosine);
        return vec![angle, arena.negate(angle)];
    }
    let (aa, bb) = (arena.square(a), arena.square(b));
    let square = arena.add(aa, bb);
    let size = arena.unary(Unary::Sqrt, square);
    let middle = arena.binary(Binary::Atan2, b, a);
    let cosine = arena.divide(minus_c, size);
    let half = arena.unary(Unary::Acos, cosine);
    vec![arena.add(middle, half), arena.subtract(middle, half)]
}
