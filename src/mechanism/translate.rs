//! Formulas of the scene as expressions.

use crate::expr::{Arena, Binary, Expr, Function, Order, Symbol};
use crate::mechanism::{Comparison, Formula, Variable};

/// Translates a formula; `variable` gives the expression of a variable of the naming table.
pub fn translate(arena: &mut Arena, formula: &Formula, variable: &mut dyn FnMut(&mut Arena, Variable) -> Expr) -> Expr {
    match formula {
        Formula::Number(value) => arena.constant(*value),
        Formula::Time => arena.symbol(Symbol::Time),
        Formula::Parameter(id) => arena.symbol(Symbol::Parameter(id.0)),
        Formula::Input(id) => arena.symbol(Symbol::Input(id.0, Order::Position)),
        Formula::Variable(named) => variable(arena, *named),
        Formula::Call(function, arguments) => {
            let arguments: Vec<Expr> = arguments.iter().map(|argument| translate(arena, argument, variable)).collect();
            let of = |index: usize| arguments.get(index).copied().unwrap_or(Expr::ZERO);
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

fn compare(arena: &mut Arena, comparison: Comparison, left: Expr, right: Expr) -> Expr {
    match comparison {
        Comparison::Less => arena.binary(Binary::Less, left, right),
        Comparison::LessEqual => arena.binary(Binary::LessEqual, left, right),
        Comparison::Greater => arena.binary(Binary::Less, right, left),
        Comparison::GreaterEqual => arena.binary(Binary::LessEqual, right, left),
    }
}
