//! Expressions of one arena in another.

use std::collections::HashMap;

use super::{Arena, Binary, Expr, ExprNode, Symbol, Unary};

impl Arena {
    /// The same expressions with zero in the place of some symbols.
    pub fn without(&mut self, roots: &[Expr], is_zero: impl Fn(Symbol) -> bool) -> Vec<Expr> {
        let symbols = self.symbols(roots.iter().copied()).into_iter().filter(|symbol| is_zero(*symbol));
        let zero: HashMap<Symbol, Expr> = symbols.map(|symbol| (symbol, Expr::ZERO)).collect();
        let before = self.clone();
        self.import(&before, roots, &zero)
    }

    /// The same expressions in this arena, with substitutions for symbols.
    pub fn import(&mut self, from: &Arena, roots: &[Expr], given: &HashMap<Symbol, Expr>) -> Vec<Expr> {
        let mut here: HashMap<Expr, Expr> = HashMap::new();
        for expr in from.reachable(roots.iter().copied()) {
            let copy = match from.node(expr) {
                ExprNode::Constant(bits) => self.constant(f64::from_bits(bits)),
                ExprNode::Symbol(symbol) => given.get(&symbol).copied().unwrap_or_else(|| self.symbol(symbol)),
                ExprNode::Unary(function, a) => self.apply_unary(function, here[&a]),
                ExprNode::Binary(function, a, b) => self.apply_binary(function, here[&a], here[&b]),
                ExprNode::Select(a, b, c) => self.select(here[&a], here[&b], here[&c]),
            };
            here.insert(expr, copy);
        }
        roots.iter().map(|root| here[root]).collect()
    }

    pub fn apply_unary(&mut self, function: Unary, a: Expr) -> Expr {
        match function {
            Unary::Sin => self.sin(a),
            Unary::Cos => self.cos(a),
            other => self.unary(other, a),
        }
    }

    pub fn apply_binary(&mut self, function: Binary, a: Expr, b: Expr) -> Expr {
        match function {
            Binary::Add => self.add(a, b),
            Binary::Subtract => self.subtract(a, b),
            Binary::Multiply => self.multiply(a, b),
            Binary::Divide => self.divide(a, b),
            Binary::Power => self.power(a, b),
            other => self.binary(other, a, b),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Order;

    #[test]
    fn an_imported_expression_has_the_value_of_the_original_at_the_given_symbols() {
        let mut from = Arena::default();
        let [x, t] = [Symbol::Coordinate(0, Order::Position), Symbol::Time].map(|symbol| from.symbol(symbol));
        let (sine, square) = (from.sin(x), from.square(x));
        let condition = from.binary(Binary::Less, sine, t);
        let choice = from.select(condition, square, t);
        let sum = from.subtract(choice, sine);

        let mut to = Arena::default();
        let q = to.symbol(Symbol::Coordinate(7, Order::Position));
        let two = to.constant(2.0);
        let double = to.multiply(two, q);
        let given = HashMap::from([(Symbol::Coordinate(0, Order::Position), double)]);
        let copy = to.import(&from, &[sum], &given)[0];
        for (q, t) in [(0.3, 0.9), (0.7, 0.1)] {
            let before = from.evaluate(&[sum], &|symbol| if symbol == Symbol::Time { t } else { 2.0 * q })[0];
            let after = to.evaluate(&[copy], &|symbol| if symbol == Symbol::Time { t } else { q })[0];
            assert_eq!(before, after);
        }
    }
}
