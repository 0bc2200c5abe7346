//! The numbers behind expressions, with the very functions of the runtime.

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
            let of = |e: Expr| results[e.index()];
            results[expr.index()] = match self.node(expr) {
                Node::Constant(bits) => f64::from_bits(bits),
                Node::Symbol(symbol) => values.value(symbol),
                Node::Unary(function, a) => apply_unary(function, of(a)),
                Node::Binary(function, a, b) => apply_binary(function, of(a), of(b)),
                Node::Select(a, b, c) => {
                    if of(a) != 0.0 {
                        of(b)
                    } else {
                        of(c)
                    }
                }
            };
        }
        roots.iter().map(|root| results[root.index()]).collect()
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
