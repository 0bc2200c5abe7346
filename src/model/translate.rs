//! Formulas of the scene as expressions.

use super::formula::{Comparison, Formula};
use super::variable::Variable;
use crate::expr::{Arena, Binary, Expr, ExprNode, Function, Order, Symbol, Unary};

/// Translates a formula; `variable` gives the expression of a variable of the naming table.
pub fn translate(arena: &mut Arena, formula: &Formula, variable: &mut dyn FnMut(&mut Arena, Variable) -> Expr) -> Expr {
    match formula {
        Formula::Number(value) => arena.constant(*value),
        Formula::Time => arena.symbol(Symbol::Time),
        Formula::Parameter(id) => arena.symbol(Symbol::Parameter(id.0)),
        Formula::Input(id) => arena.symbol(Symbol::Input(id.0, Order::Position)),
        Formula::Discrete(id) => arena.symbol(Symbol::Discrete(id.0)),
        Formula::State(id) => arena.symbol(Symbol::State(id.0, Order::Position)),
        Formula::Variable(named) => variable(arena, *named),
        Formula::Call(function, arguments) => {
            let arguments: Vec<Expr> = arguments.iter().map(|argument| translate(arena, argument, variable)).collect();
            let of = |index: usize| arguments.get(index).copied().unwrap_or(Expr::ZERO);
            let exponent = match *function {
                Function::One(Unary::Sqrt) => Some(0.5),
                Function::Two(Binary::Power) => arena.as_constant(of(1)).filter(|exponent| exponent.fract() != 0.0),
                _ => None,
            };
            if let Some(power) = exponent.and_then(|exponent| power_of_square(arena, of(0), exponent)) {
                return power;
            }
            match *function {
                Function::One(function) => arena.apply_unary(function, of(0)),
                Function::Two(function) => arena.apply_binary(function, of(0), of(1)),
            }
        }
        Formula::If(comparison, parts) => {
            let [left, right, then, otherwise] = parts.each_ref().map(|part| translate(arena, part, variable));
            let condition = compare(arena, *comparison, left, right);
            arena.select(condition, then, otherwise)
        }
    }
}

/// A power of x^2 as one of |x|: at x = 0 that has a rate wherever there is one.
fn power_of_square(arena: &mut Arena, base: Expr, exponent: f64) -> Option<Expr> {
    let x = match arena.node(base) {
        ExprNode::Binary(Binary::Multiply, x, y) if x == y => x,
        _ => return None,
    };
    let (size, doubled) = (arena.unary(Unary::Abs, x), arena.constant(2.0 * exponent));
    Some(arena.power(size, doubled))
}

fn compare(arena: &mut Arena, comparison: Comparison, left: Expr, right: Expr) -> Expr {
    match comparison {
        Comparison::Less => arena.compare(Binary::Less, left, right),
        Comparison::LessEqual => arena.compare(Binary::LessEqual, left, right),
        Comparison::Greater => arena.compare(Binary::Less, right, left),
        Comparison::GreaterEqual => arena.compare(Binary::LessEqual, right, left),
    }
}
