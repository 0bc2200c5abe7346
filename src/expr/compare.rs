//! Comparisons that rounding errors would decide.
//!
//! The sides of `1 - exp(-t) < 1` come closer to each other than numbers are apart, and those of `poly4567(t) < 1` long before the rise is over. What is left between them is known exactly if it
//! is written so: exp(-t), and poly4567(1 - t), for the laws of cams are symmetric. Its sign is then the same in every method.

use super::{Arena, Binary, Expr, ExprNode, Unary};

/// Numbers that differ by less than this share of their sizes are meant to be the same.
const SAME: f64 = 4.0 * f64::EPSILON;
/// Sums are not looked into any deeper.
const DEEPEST: usize = 16;

/// constant + sum of factor x term, where the sizes of all constants add up to `size`.
#[derive(Default)]
struct WeightedSum {
    constant: f64,
    size: f64,
    terms: Vec<(f64, Expr)>,
}

impl Arena {
    /// `<` or `<=` of two expressions, by what is left between them where rounding errors would hide it.
    pub fn compare(&mut self, function: Binary, a: Expr, b: Expr) -> Expr {
        let Some(difference) = self.difference(a, b) else { return self.binary(function, a, b) };
        match self.sign(difference) {
            Some(true) => Expr::ONE,
            Some(false) => Expr::ZERO,
            None => self.binary(function, Expr::ZERO, difference),
        }
    }

    /// b - a without what cancels; none if nothing does.
    fn difference(&mut self, a: Expr, b: Expr) -> Option<Expr> {
        let mut sum = WeightedSum::default();
        self.gather(&mut sum, b, 1.0, 0);
        self.gather(&mut sum, a, -1.0, 0);
        let WeightedSum { constant, size, terms } = sum;
        let same = |one: f64, other: f64, size: f64| (one - other).abs() <= SAME * size;
        match terms[..] {
            [] => None,
            [(factor, term)] if size > 0.0 && same(constant.abs(), factor.abs(), size) => {
                let up = constant * factor < 0.0;
                let left = self.rest(term, up)?;
                let factor = self.constant(constant);
                Some(self.multiply(factor, left))
            }
            [(one, first), (other, second)] if size == 0.0 && one == -other => {
                let of_first = self.factor(second, first).is_some();
                let (number, whole, part) = if of_first { (one, first, second) } else { (other, second, first) };
                let term = self.factor(part, whole)?;
                let left = self.rest(term, true)?;
                let number = self.constant(number);
                let whole = self.multiply(number, whole);
                Some(self.multiply(whole, left))
            }
            _ if size > 0.0 && same(constant, 0.0, size) => {
                let mut difference = Expr::ZERO;
                for (factor, term) in terms {
                    let factor = self.constant(factor);
                    difference = self.add_product(difference, factor, term);
                }
                Some(difference)
            }
            _ => None,
        }
    }

    /// Adds a factor times an expression to a sum.
    fn gather(&self, sum: &mut WeightedSum, expr: Expr, factor: f64, depth: usize) {
        let deeper = |sum: &mut WeightedSum, inner: Expr, factor: f64| self.gather(sum, inner, factor, depth + 1);
        match self.node(expr) {
            ExprNode::Constant(bits) => {
                let value = factor * f64::from_bits(bits);
                sum.constant += value;
                sum.size += value.abs();
                return;
            }
            ExprNode::Unary(Unary::Negate, a) if depth < DEEPEST => return deeper(sum, a, -factor),
            ExprNode::Binary(Binary::Add, a, b) if depth < DEEPEST => {
                deeper(sum, a, factor);
                return deeper(sum, b, factor);
            }
            ExprNode::Binary(Binary::Subtract, a, b) if depth < DEEPEST => {
                deeper(sum, a, factor);
                return deeper(sum, b, -factor);
            }
            ExprNode::Binary(Binary::Multiply, a, b) if depth < DEEPEST => {
                for (number, rest) in [(a, b), (b, a)] {
                    if let Some(number) = self.as_constant(number) {
                        return deeper(sum, rest, factor * number);
                    }
                }
            }
            ExprNode::Binary(Binary::Divide, a, b) if depth < DEEPEST => {
                if let Some(number) = self.as_constant(b) {
                    return deeper(sum, a, factor / number);
                }
            }
            ExprNode::Symbol(_) | ExprNode::Unary(..) | ExprNode::Binary(..) | ExprNode::Select(..) => {}
        }
        match sum.terms.iter().position(|(_, term)| *term == expr) {
            Some(place) => {
                sum.terms[place].0 += factor;
                if sum.terms[place].0 == 0.0 {
                    sum.terms.remove(place);
                }
            }
            None => sum.terms.push((factor, expr)),
        }
    }

    /// The other factor of a product.
    fn factor(&self, product: Expr, of: Expr) -> Option<Expr> {
        match self.node(product) {
            ExprNode::Binary(Binary::Multiply, a, b) if a == of => Some(b),
            ExprNode::Binary(Binary::Multiply, a, b) if b == of => Some(a),
            _ => None,
        }
    }

    /// What is left between a function and its upper limit 1, or its lower one, -1: a positive number stands for what never vanishes. None if it has no such limit.
    fn rest(&mut self, expr: Expr, up: bool) -> Option<Expr> {
        match self.node(expr) {
            ExprNode::Unary(Unary::Tanh, _) => Some(Expr::ONE),
            ExprNode::Unary(function, a) if up && function.is_rise() => {
                let rest = match self.node(a) {
                    ExprNode::Unary(inner, _) if inner.is_rise() => self.rest(a, true)?,
                    _ => self.subtract(Expr::ONE, a),
                };
                Some(self.apply_unary(function, rest))
            }
            _ => None,
        }
    }

    /// Is an expression positive, or negative, everywhere?
    fn sign(&self, expr: Expr) -> Option<bool> {
        match self.node(expr) {
            ExprNode::Constant(bits) => Some(f64::from_bits(bits) > 0.0),
            ExprNode::Unary(Unary::Exp | Unary::Cosh, _) => Some(true),
            ExprNode::Unary(Unary::Negate, a) => self.sign(a).map(|positive| !positive),
            ExprNode::Binary(Binary::Multiply, a, b) => Some(self.sign(a)? == self.sign(b)?),
            _ => None,
        }
    }
}

impl Unary {
    /// Does it rise from 0 to 1 as it falls from 1 to 0, turned by half a turn, and stay at both?
    fn is_rise(self) -> bool {
        matches!(
            self,
            Self::Smoothstep
                | Self::Harmonic
                | Self::Cycloidal
                | Self::Poly345
                | Self::Poly4567
                | Self::ModifiedSine
                | Self::ModifiedTrapezoid
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Symbol;

    /// `left < right`, both functions of time.
    fn less(sides: impl FnOnce(&mut Arena, Expr) -> [Expr; 2]) -> (Arena, Expr) {
        let mut arena = Arena::default();
        let time = arena.symbol(Symbol::Time);
        let [a, b] = sides(&mut arena, time);
        let found = arena.compare(Binary::Less, a, b);
        (arena, found)
    }

    #[test]
    fn what_never_vanishes_decides_for_good() {
        let (_, found) = less(|arena, time| {
            let decay = arena.unary(Unary::Exp, time);
            [arena.subtract(Expr::ONE, decay), Expr::ONE]
        });
        assert_eq!(found, Expr::ONE);
        for (factor, limit, expected) in [(3.0, 3.0, Expr::ONE), (3.0, -3.0, Expr::ZERO), (-3.0, 3.0, Expr::ONE)] {
            let (_, found) = less(|arena, time| {
                let (tanh, factor) = (arena.unary(Unary::Tanh, time), arena.constant(factor));
                [arena.multiply(factor, tanh), arena.constant(limit)]
            });
            assert_eq!(found, expected, "{factor} {limit}");
        }
    }

    #[test]
    fn a_rise_is_below_its_end_until_it_is_over() {
        let rises: Vec<Unary> = Unary::ALL.iter().copied().filter(|function| function.is_rise()).collect();
        assert_eq!(rises.len(), 7);
        for function in rises {
            for (factor, offset) in [(1.0, 0.0), (0.02, 0.01), (-3.0, 1.0)] {
                let (arena, found) = less(|arena, time| {
                    let [factor, offset, end] = [factor, offset, offset + factor].map(|number| arena.constant(number));
                    let rise = arena.apply_unary(function, time);
                    let law = arena.add_product(offset, factor, rise);
                    [law, end]
                });
                let at = |time: f64| arena.evaluate(&[found], &|_| time)[0];
                let before = if factor > 0.0 { 1.0 } else { 0.0 };
                assert_eq!(
                    [at(0.5), at(1.0 - 1e-5), at(1.0), at(1.5)],
                    [before, before, 0.0, 0.0],
                    "{function:?} {factor}"
                );
            }
        }
    }

    #[test]
    fn a_parameter_may_be_the_height() {
        let (arena, found) = less(|arena, time| {
            let (rise, height) = (arena.unary(Unary::Poly4567, time), arena.symbol(Symbol::Parameter(0)));
            [arena.multiply(height, rise), height]
        });
        let at = |height: f64, time: f64| {
            arena.evaluate(&[found], &|symbol| if symbol == Symbol::Time { time } else { height })[0]
        };
        assert_eq!([at(2.0, 1.0 - 1e-5), at(2.0, 1.0), at(-2.0, 0.5)], [1.0, 0.0, 0.0]);
    }

    #[test]
    fn all_else_stays_as_it_is() {
        let (arena, found) = less(|arena, time| {
            let sine = arena.sin(time);
            [sine, arena.constant(0.5)]
        });
        assert!(matches!(arena.node(found), ExprNode::Binary(Binary::Less, ..)));
        assert_eq!(arena.evaluate(&[found], &|_| 0.1)[0], 1.0);
        let (arena, found) = less(|arena, time| {
            let half = arena.constant(0.5);
            [arena.add(half, time), Expr::ONE]
        });
        assert_eq!([0.4, 0.6].map(|time| arena.evaluate(&[found], &|_| time)[0]), [1.0, 0.0]);
    }
}
