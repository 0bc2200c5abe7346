//! Numerical evaluation of expressions, with the functions of the runtime.

use std::collections::HashMap;

use cotree_fmu::model::State;

use super::{Arena, Expr, ExprNode, Order, Symbol};

pub trait Values {
    fn value(&self, symbol: Symbol) -> f64;
}

impl<F: Fn(Symbol) -> f64> Values for F {
    fn value(&self, symbol: Symbol) -> f64 {
        self(symbol)
    }
}

/// A state has no accelerations, no rates of its own states, no reactions and no masses that are missing: they count as zero.
impl Values for State {
    fn value(&self, symbol: Symbol) -> f64 {
        let of = |list: &[f64], index: usize| list.get(index).copied().unwrap_or_default();
        match symbol {
            Symbol::Time => self.time(),
            Symbol::Parameter(i) => of(self.parameters(), i),
            Symbol::Discrete(i) => of(self.discrete(), i),
            Symbol::Input(i, order) if i < self.inputs().len() => self.input_polynomial(i)[order as usize],
            Symbol::Follower(i, Order::Position) => of(self.follower_positions(), i),
            Symbol::Follower(i, Order::Velocity) => of(self.follower_rates(), i),
            Symbol::Coordinate(i, Order::Position) => of(self.positions(), i),
            Symbol::Coordinate(i, Order::Velocity) => of(self.rates(), i),
            Symbol::State(i, Order::Position) => of(self.states(), i),
            Symbol::Input(..) | Symbol::Coordinate(..) | Symbol::Follower(..) | Symbol::State(..) => 0.0,
            Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => 0.0,
        }
    }
}

impl Arena {
    pub fn evaluate(&self, roots: &[Expr], values: &impl Values) -> Vec<f64> {
        let order = self.reachable(roots.iter().copied());
        self.evaluate_in(&order, roots, values)
    }

    /// The same for many evaluations: `order` has all subexpressions, operands first.
    pub fn evaluate_in(&self, order: &[Expr], roots: &[Expr], values: &impl Values) -> Vec<f64> {
        let mut results = vec![0.0; self.len()];
        for &expr in order {
            results[expr.index()] = self.value(expr, values, |operand| results[operand.index()]);
        }
        roots.iter().map(|root| results[root.index()]).collect()
    }

    /// The same for repeated evaluations at one state: known values are not evaluated again.
    pub fn evaluate_more(&self, roots: &[Expr], values: &impl Values, known: &mut HashMap<Expr, f64>) -> Vec<f64> {
        let mut stack: Vec<Expr> = roots.to_vec();
        while let Some(&expr) = stack.last() {
            let before = stack.len();
            if !known.contains_key(&expr) {
                stack.extend(self.node(expr).operands().filter(|operand| !known.contains_key(operand)));
            }
            if stack.len() == before {
                stack.pop();
                if !known.contains_key(&expr) {
                    let value = self.value(expr, values, |operand| known.get(&operand).copied().unwrap_or(f64::NAN));
                    known.insert(expr, value);
                }
            }
        }
        roots.iter().map(|root| known.get(root).copied().unwrap_or(f64::NAN)).collect()
    }

    /// The value of an expression from those of its operands.
    fn value(&self, expr: Expr, values: &impl Values, of: impl Fn(Expr) -> f64) -> f64 {
        match self.node(expr) {
            ExprNode::Constant(bits) => f64::from_bits(bits),
            ExprNode::Symbol(symbol) => values.value(symbol),
            ExprNode::Unary(function, a) => function.definition().value([of(a)]),
            ExprNode::Binary(function, a, b) => function.definition().value([of(a), of(b)]),
            ExprNode::Select(a, b, c) => of(if of(a) != 0.0 { b } else { c }),
        }
    }
}
