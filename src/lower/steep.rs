//! Arguments of functions in laws that may vary steeply within a step without any effect on the values at its ends.

use std::collections::BTreeSet;

use cotree_fmu::events::Steep;

use super::indicators::{indicators, moves};
use crate::expr::{Arena, Binary, Expr, Node, Unary};

/// How the functions that these results depend on are steep, and their arguments. Those that only parameters move are left out.
pub(super) fn steep(arena: &mut Arena, results: &[Expr]) -> Vec<(Steep, Expr)> {
    let expanded = arena.expanded(results);
    let reached = arena.reachable(expanded);
    let divisors = reached.iter().filter_map(|&expr| divisor(arena, expr));
    let divides: BTreeSet<Expr> = arena.reachable(divisors).into_iter().collect();
    let laws = reached.into_iter().flat_map(|expr| laws(arena, expr, divides.contains(&expr)));
    let found: BTreeSet<(Steep, Expr)> = laws.collect();
    let switches = indicators(arena, results).into_iter().map(|argument| (Steep::Switching, argument));
    found.into_iter().filter(|(_, argument)| moves(arena, *argument)).chain(switches).collect()
}

/// Roots and poles are left to the control of the step. An exponential in a divisor saturates: 1/(1 + exp a) is constant but for a layer about a = 0, as
/// tanh is.
fn laws(arena: &Arena, expr: Expr, divides: bool) -> impl Iterator<Item = (Steep, Expr)> + use<> {
    let found = match arena.node(expr) {
        Node::Unary(Unary::Tanh, a) => [Some((Steep::Saturating, a)), None],
        Node::Unary(Unary::Exp, a) => [Some((Steep::Growing, a)), divides.then_some((Steep::Saturating, a))],
        _ => [None; 2],
    };
    found.into_iter().flatten()
}

/// What an expression divides by, or raises to a power.
fn divisor(arena: &Arena, expr: Expr) -> Option<Expr> {
    match arena.node(expr) {
        Node::Binary(Binary::Divide, _, divisor) | Node::Binary(Binary::Power, divisor, _) => Some(divisor),
        _ => None,
    }
}
