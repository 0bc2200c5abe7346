//! Building expressions: constants are folded and neutral elements dropped as they are made, and sums and products have
//! one order of operands, so that equal things meet.

use super::{Arena, Binary, Expr, ExprNode, Unary};

impl Arena {
    pub fn add(&mut self, a: Expr, b: Expr) -> Expr {
        if a == Expr::ZERO {
            return b;
        }
        if b == Expr::ZERO {
            return a;
        }
        if let Some(b) = self.negated(b) {
            return self.subtract(a, b);
        }
        if let Some(a) = self.negated(a) {
            return self.subtract(b, a);
        }
        if let Some((x, y, term)) = self.like_terms(a, b) {
            let factor = self.constant(x + y);
            return self.multiply(factor, term);
        }
        self.commutative(Binary::Add, a, b)
    }

    /// a + b for components of vectors and their products, which carry rounding errors of their own: numbers that cancel up to those leave
    /// nothing. What 0.1 + 0.2 - 0.3 leaves is no length, and m x y - m y x no moment.
    pub fn merge(&mut self, a: Expr, b: Expr) -> Expr {
        const ROUNDING: f64 = 4.0 * f64::EPSILON;
        let ((x, left), (y, right)) = (self.signed_term(a), self.signed_term(b));
        let largest = x.abs().max(y.abs());
        // What is too large for a number is no rounding error of another.
        let cancel = left == right && largest.is_finite() && (x + y).abs() <= ROUNDING * largest;
        if cancel { Expr::ZERO } else { self.add(a, b) }
    }

    pub fn subtract(&mut self, a: Expr, b: Expr) -> Expr {
        if a == b {
            return Expr::ZERO;
        }
        if b == Expr::ZERO {
            return a;
        }
        if a == Expr::ZERO {
            return self.negate(b);
        }
        if let Some(b) = self.negated(b) {
            return self.add(a, b);
        }
        if let Some(a) = self.negated(a) {
            let sum = self.add(a, b);
            return self.negate(sum);
        }
        if let Some((x, y, term)) = self.like_terms(a, b) {
            let factor = self.constant(x - y);
            return self.multiply(factor, term);
        }
        if let Some(opposite) = self.existing(ExprNode::Binary(Binary::Subtract, b, a)) {
            return self.negate(opposite);
        }
        self.binary(Binary::Subtract, a, b)
    }

    pub fn negate(&mut self, a: Expr) -> Expr {
        if let Some(value) = self.as_constant(a) {
            return self.constant(-value);
        }
        match self.node(a) {
            ExprNode::Unary(Unary::Negate, inner) => inner,
            _ => self.intern(ExprNode::Unary(Unary::Negate, a)),
        }
    }

    /// a + b c
    pub fn add_product(&mut self, a: Expr, b: Expr, c: Expr) -> Expr {
        let product = self.multiply(b, c);
        self.add(a, product)
    }

    /// a - b c
    pub fn subtract_product(&mut self, a: Expr, b: Expr, c: Expr) -> Expr {
        let product = self.multiply(b, c);
        self.subtract(a, product)
    }

    pub fn multiply(&mut self, a: Expr, b: Expr) -> Expr {
        if a == Expr::ZERO || b == Expr::ZERO {
            return Expr::ZERO;
        }
        if a == Expr::ONE {
            return b;
        }
        if b == Expr::ONE {
            return a;
        }
        if let Some(product) = self.multiply_signed(a, b) {
            return product;
        }
        if let Some(product) = self.multiply_scaled(a, b) {
            return product;
        }
        self.commutative(Binary::Multiply, a, b)
    }

    pub fn divide(&mut self, a: Expr, b: Expr) -> Expr {
        if a == Expr::ZERO || b == Expr::ONE {
            return a;
        }
        if a == b {
            return Expr::ONE;
        }
        if let Some(a) = self.negated(a) {
            let quotient = self.divide(a, b);
            return self.negate(quotient);
        }
        if let Some(inverse) = self.exact_inverse(b) {
            return self.multiply(a, inverse);
        }
        if let ExprNode::Binary(Binary::Multiply, x, y) = self.node(a) {
            if x == b {
                return y;
            }
            if y == b {
                return x;
            }
        }
        self.binary(Binary::Divide, a, b)
    }

    pub fn square(&mut self, a: Expr) -> Expr {
        match self.negated(a) {
            Some(a) => self.multiply(a, a),
            None => self.multiply(a, a),
        }
    }

    /// a^b; small whole exponents become products.
    pub fn power(&mut self, a: Expr, b: Expr) -> Expr {
        match self.as_constant(b) {
            Some(exponent) if exponent.fract() == 0.0 && exponent.abs() <= 16.0 => {
                let product = self.whole_power(a, exponent.abs() as u32);
                if exponent < 0.0 { self.divide(Expr::ONE, product) } else { product }
            }
            Some(0.5) => self.unary(Unary::Sqrt, a),
            _ => self.binary(Binary::Power, a, b),
        }
    }

    fn whole_power(&mut self, base: Expr, exponent: u32) -> Expr {
        match exponent {
            0 => Expr::ONE,
            1 => base,
            _ => {
                let half = self.whole_power(base, exponent / 2);
                let even = self.square(half);
                if exponent.is_multiple_of(2) { even } else { self.multiply(even, base) }
            }
        }
    }

    pub fn sin(&mut self, a: Expr) -> Expr {
        match self.negated(a) {
            Some(a) => {
                let sine = self.unary(Unary::Sin, a);
                self.negate(sine)
            }
            None => self.unary(Unary::Sin, a),
        }
    }

    pub fn cos(&mut self, a: Expr) -> Expr {
        let a = self.negated(a).unwrap_or(a);
        self.unary(Unary::Cos, a)
    }

    pub fn unary(&mut self, function: Unary, a: Expr) -> Expr {
        if function == Unary::Negate {
            return self.negate(a);
        }
        let value = self.as_constant(a).map(|value| function.definition().value([value]));
        self.folded(value, ExprNode::Unary(function, a))
    }

    /// Any function of two arguments, without the rules of [`Arena::add`] and its kin.
    pub fn binary(&mut self, function: Binary, a: Expr, b: Expr) -> Expr {
        let value = match (self.as_constant(a), self.as_constant(b)) {
            (Some(x), Some(y)) => Some(function.definition().value([x, y])),
            _ => None,
        };
        self.folded(value, ExprNode::Binary(function, a, b))
    }

    /// A number that is known. What has none, such as 1/0, stays as it is written: whoever evaluates it sees that, and nobody else needs to.
    fn folded(&mut self, value: Option<f64>, node: ExprNode) -> Expr {
        match value {
            Some(value) if value.is_finite() => self.constant(value),
            _ => self.intern(node),
        }
    }

    /// b if a is not zero, else c
    pub fn select(&mut self, condition: Expr, then: Expr, otherwise: Expr) -> Expr {
        if then == otherwise {
            return then;
        }
        match self.as_constant(condition) {
            Some(0.0) => otherwise,
            Some(_) => then,
            None => self.intern(ExprNode::Select(condition, then, otherwise)),
        }
    }

    /// x, if the expression is -x (a negative number counts as one).
    fn negated(&mut self, expr: Expr) -> Option<Expr> {
        match self.node(expr) {
            ExprNode::Unary(Unary::Negate, inner) => Some(inner),
            ExprNode::Constant(bits) if f64::from_bits(bits) < 0.0 => Some(self.constant(-f64::from_bits(bits))),
            _ => None,
        }
    }

    /// (x, y, e) if the operands are x e and y e with numbers x and y.
    fn like_terms(&self, a: Expr, b: Expr) -> Option<(f64, f64, Expr)> {
        let ((x, left), (y, right)) = (self.scaled_term(a), self.scaled_term(b));
        (left == right).then_some((x, y, left))
    }

    fn scaled_term(&self, expr: Expr) -> (f64, Expr) {
        let ExprNode::Binary(Binary::Multiply, a, b) = self.node(expr) else { return (1.0, expr) };
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(factor), None) => (factor, b),
            (None, Some(factor)) => (factor, a),
            _ => (1.0, expr),
        }
    }

    /// As [`Arena::scaled_term`], with the sign in the number; a number is itself x 1.
    fn signed_term(&self, expr: Expr) -> (f64, Expr) {
        match self.node(expr) {
            ExprNode::Unary(Unary::Negate, inner) => {
                let (number, rest) = self.signed_term(inner);
                (-number, rest)
            }
            _ => self.split_factor(expr),
        }
    }

    /// 1/b, if b is a number whose inverse is exact: a power of two.
    fn exact_inverse(&mut self, b: Expr) -> Option<Expr> {
        let value = self.as_constant(b)?;
        let exact = value.is_normal() && value.to_bits().trailing_zeros() >= 52 && value.recip().is_normal();
        exact.then(|| self.constant(value.recip()))
    }

    fn commutative(&mut self, function: Binary, a: Expr, b: Expr) -> Expr {
        self.binary(function, a.min(b), a.max(b))
    }

    fn multiply_signed(&mut self, a: Expr, b: Expr) -> Option<Expr> {
        let (unsigned_a, unsigned_b) = (self.negated(a), self.negated(b));
        if unsigned_a.is_none() && unsigned_b.is_none() {
            return None;
        }
        let product = self.multiply(unsigned_a.unwrap_or(a), unsigned_b.unwrap_or(b));
        let positive = unsigned_a.is_some() == unsigned_b.is_some();
        Some(if positive { product } else { self.negate(product) })
    }

    /// Gathers numeric factors in front: (x d) (y e) = (x y) (d e).
    fn multiply_scaled(&mut self, a: Expr, b: Expr) -> Option<Expr> {
        let ((x, left), (y, right)) = (self.split_factor(a), self.split_factor(b));
        // One number stays with its factor, where it may be part of a constant of the motion.
        if left == a || right == b {
            return None;
        }
        let number = self.constant(x * y);
        let rest = self.multiply(left, right);
        Some(self.multiply(number, rest))
    }

    /// As [`Arena::scaled_term`]; a number is itself x 1.
    fn split_factor(&self, expr: Expr) -> (f64, Expr) {
        self.as_constant(expr).map_or_else(|| self.scaled_term(expr), |value| (value, Expr::ONE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Symbol;

    #[test]
    fn what_cancels_up_to_rounding_is_nothing_and_all_else_stays() {
        let mut arena = Arena::default();
        let length = arena.symbol(Symbol::Parameter(0));
        let numbers = |arena: &mut Arena, x: f64, y: f64| {
            let [a, b] = [x, y].map(|value| arena.constant(value));
            let merged = arena.merge(a, b);
            let [a, b] = [a, b].map(|number| arena.multiply(number, length));
            (arena.as_constant(merged).unwrap(), arena.merge(a, b))
        };
        let (plain, scaled) = numbers(&mut arena, 0.1 + 0.2, -0.3);
        assert_eq!((plain, scaled), (0.0, Expr::ZERO));
        let tiny = 1e-14;
        let (plain, scaled) = numbers(&mut arena, 1.0 + tiny, -1.0);
        assert_eq!(plain, 1.0 + tiny - 1.0);
        assert_ne!(scaled, Expr::ZERO);
        assert_eq!(numbers(&mut arena, 0.1, 0.2).0, 0.1 + 0.2);
        let minus = arena.negate(length);
        assert_eq!(arena.merge(length, minus), Expr::ZERO);
    }
}
