//! Which expressions are affine by the way they are built. A derivative cannot tell: that of `sign(x)`, `floor(x)` or `if(x > 1, 2, 0)` is zero wherever it exists, and the functions are not constant.

use super::{Arena, Binary, Expr, ExprNode, Symbol, Unary};

/// How a value depends on chosen symbols.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Degree {
    Constant,
    Affine,
    Other,
}

impl Arena {
    /// True if each root is a constant plus constant multiples of the chosen symbols, for all their values.
    pub fn is_affine(&self, roots: &[Expr], chosen: impl Fn(Symbol) -> bool) -> bool {
        let mut degrees = vec![Degree::Constant; roots.iter().max().map_or(0, |root| root.index() + 1)];
        for expr in self.reachable(roots.iter().copied()) {
            degrees[expr.index()] = self.degree(expr, &degrees, &chosen);
        }
        roots.iter().all(|root| degrees[root.index()] != Degree::Other)
    }

    fn degree(&self, expr: Expr, known: &[Degree], chosen: &impl Fn(Symbol) -> bool) -> Degree {
        let of = |operand: Expr| known[operand.index()];
        let is_constant = |operand: Expr| of(operand) == Degree::Constant;
        match self.node(expr) {
            ExprNode::Symbol(symbol) if chosen(symbol) => Degree::Affine,
            node if node.operands().all(is_constant) => Degree::Constant,
            ExprNode::Unary(Unary::Negate, a) => of(a),
            ExprNode::Binary(Binary::Add | Binary::Subtract, a, b) => of(a).max(of(b)),
            ExprNode::Binary(Binary::Multiply, a, b) if is_constant(a) || is_constant(b) => of(a).max(of(b)),
            ExprNode::Binary(Binary::Divide, a, b) if is_constant(b) => of(a),
            ExprNode::Select(condition, a, b) if is_constant(condition) => of(a).max(of(b)),
            _ => Degree::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Order;

    #[test]
    fn pieces_are_not_affine_where_their_slopes_are_zero() {
        let mut arena = Arena::default();
        let [x, p] = [Symbol::Coordinate(0, Order::Position), Symbol::Parameter(0)].map(|symbol| arena.symbol(symbol));
        let positive = arena.compare(Binary::Less, Expr::ZERO, x);
        let chosen = arena.compare(Binary::Less, Expr::ZERO, p);
        let (sum, square) = (arena.add(x, p), arena.square(x));
        let of_x = |symbol: Symbol| symbol == Symbol::Coordinate(0, Order::Position);
        for affine in [p, x, sum, arena.multiply(p, x), arena.divide(sum, p), arena.select(chosen, x, p)] {
            assert!(arena.is_affine(&[affine], of_x), "{:?}", arena.node(affine));
        }
        let pieces = [
            arena.unary(Unary::Sign, x),
            arena.unary(Unary::Floor, sum),
            arena.unary(Unary::Abs, x),
            arena.binary(Binary::Min, x, p),
            arena.select(positive, p, Expr::ZERO),
        ];
        for other in pieces.into_iter().chain([square, arena.divide(p, x)]) {
            assert!(!arena.is_affine(&[p, other], of_x), "{:?}", arena.node(other));
        }
    }
}
