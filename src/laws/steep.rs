//! Arguments of functions in laws that may vary steeply within a step without any effect on the values at its ends.

use std::collections::BTreeSet;

use cotree_fmu::program::Steep;

use crate::expr::{Arena, Binary, Expr, ExprNode, Unary, indicators};

/// How the functions that these results depend on are steep, and their arguments. Those that only parameters move are left out.
pub(crate) fn steep(arena: &mut Arena, results: &[Expr]) -> Vec<(Steep, Expr)> {
    let expanded = arena.expanded(results);
    let reached = arena.reachable(expanded);
    let divisors = reached.iter().filter_map(|&expr| divisor(arena, expr));
    let divides: BTreeSet<Expr> = arena.reachable(divisors).into_iter().collect();
    let moves = depending(arena, &reached, |node| matches!(node, ExprNode::Symbol(symbol) if !symbol.is_parameter()));
    let exponential = depending(arena, &reached, |node| matches!(node, ExprNode::Unary(Unary::Exp | Unary::Tanh, _)));
    let vanishing = reached.iter().filter_map(|&expr| divisor(arena, expr));
    let vanishing = vanishing.filter(|&argument| !is_root(arena, argument) && !exponential.contains(&argument));
    let laws = reached.iter().flat_map(|&expr| laws(arena, expr, divides.contains(&expr)));
    let found: BTreeSet<(Steep, Expr)> = laws.chain(vanishing.map(|argument| (Steep::Vanishing, argument))).collect();
    let found = found.into_iter().filter(|(_, argument)| moves.contains(argument));
    found.chain(indicators(arena, results).into_iter().map(|argument| (Steep::Switching, argument))).collect()
}

/// An exponential in a divisor saturates: 1/(1 + exp a) is constant but for a layer about a = 0, as tanh is.
fn laws(arena: &Arena, expr: Expr, divides: bool) -> impl Iterator<Item = (Steep, Expr)> + use<> {
    let found = match arena.node(expr) {
        ExprNode::Unary(Unary::Tanh, a) => [Some((Steep::Saturating, a)), None],
        ExprNode::Unary(Unary::Exp, a) => [Some((Steep::Growing, a)), divides.then_some((Steep::Saturating, a))],
        _ => [None; 2],
    };
    found.into_iter().flatten()
}

/// What an expression divides by, raises to a power, or takes the root or the logarithm of.
pub(crate) fn divisor(arena: &Arena, expr: Expr) -> Option<Expr> {
    match arena.node(expr) {
        ExprNode::Binary(Binary::Divide, _, a) | ExprNode::Binary(Binary::Power, a, _) => Some(a),
        ExprNode::Unary(Unary::Sqrt | Unary::Log, a) => Some(a),
        _ => None,
    }
}

/// A root is small where its argument is.
fn is_root(arena: &Arena, expr: Expr) -> bool {
    matches!(arena.node(expr), ExprNode::Unary(Unary::Sqrt, _))
}

/// Which of these expressions, operands first, are such a node or depend on one.
fn depending(arena: &Arena, reached: &[Expr], is: impl Fn(ExprNode) -> bool) -> BTreeSet<Expr> {
    let mut found = BTreeSet::new();
    for &expr in reached {
        let node = arena.node(expr);
        if is(node) || node.operands().any(|operand| found.contains(&operand)) {
            found.insert(expr);
        }
    }
    found
}
