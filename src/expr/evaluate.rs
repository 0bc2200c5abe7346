//! The numbers behind expressions, with the very functions of the runtime.

use std::collections::HashMap;

use cotree_fmu::math;

use super::{Arena, Binary, Expr, Node, Symbol, Unary};

/// Values of symbols.
pub trait Values {
    /// The value of one symbol.
    fn value(&self, symbol: Symbol) -> f64;
}

impl<F: Fn(Symbol) -> f64> Values for F {
    fn value(&self, symbol: Symbol) -> f64 {
        self(symbol)
    }
}

impl Arena {
    /// The values of several expressions.
    pub fn evaluate(&self, roots: &[Expr], values: &impl Values) -> Vec<f64> {
        let mut results = vec![0.0; self.len()];
        for expr in self.reachable(roots.iter().copied()) {
            results[expr.index()] = self.value(expr, values, |operand| results[operand.index()]);
        }
        roots.iter().map(|root| results[root.index()]).collect()
    }

    /// The same for many questions about one state: what is known from before is not evaluated again.
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
            Node::Constant(bits) => f64::from_bits(bits),
            Node::Symbol(symbol) => values.value(symbol),
            Node::Unary(function, a) => apply_unary(function, of(a)),
            Node::Binary(function, a, b) => apply_binary(function, of(a), of(b)),
            Node::Select(a, b, c) => of(if of(a) != 0.0 { b } else { c }),
        }
    }
}

pub(super) fn apply_unary(function: Unary, a: f64) -> f64 {
    match function {
        Unary::Negate => -a,
        Unary::Sqrt => a.sqrt(),
        Unary::Sin => math::sin_cos(a).0,
        Unary::Cos => math::sin_cos(a).1,
        Unary::Tan => libm::tan(a),
        Unary::Asin => libm::asin(a),
        Unary::Acos => libm::acos(a),
        Unary::Atan => libm::atan(a),
        Unary::Exp => libm::exp(a),
        Unary::Log => libm::log(a),
        Unary::Tanh => libm::tanh(a),
        Unary::Abs => a.abs(),
        Unary::Sign => math::sign(a),
        Unary::Floor => a.floor(),
    }
}

pub(super) fn apply_binary(function: Binary, a: f64, b: f64) -> f64 {
    match function {
        Binary::Add => a + b,
        Binary::Subtract => a - b,
        Binary::Multiply => a * b,
        Binary::Divide => a / b,
        Binary::Power => libm::pow(a, b),
        Binary::Atan2 => libm::atan2(a, b),
        Binary::Min => math::minimum(a, b),
        Binary::Max => math::maximum(a, b),
        Binary::Less => f64::from(u8::from(a < b)),
        Binary::LessEqual => f64::from(u8::from(a <= b)),
    }
}
