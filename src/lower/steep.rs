//! Arguments of functions in laws that may vary steeply within a step without any effect on the values at its ends.

use std::collections::BTreeSet;

use cotree_fmu::events::Steep;

use super::indicators::{indicators, moves};
use crate::expr::{Arena, Expr, Node, Unary};

/// How the functions that these results depend on are steep, and their arguments. Those that only parameters move are left out.
pub(super) fn steep(arena: &mut Arena, results: &[Expr]) -> Vec<(Steep, Expr)> {
    let reached = arena.reachable(results.iter().copied());
    let found: BTreeSet<(Steep, Expr)> = reached.into_iter().filter_map(|expr| argument(arena, expr)).collect();
    let switches = indicators(arena, results).into_iter().map(|argument| (Steep::Switching, argument));
    found.into_iter().filter(|(_, argument)| moves(arena, *argument)).chain(switches).collect()
}

/// Roots and poles are left to the control of the step, which sees them coming: they have no sides on which nothing tells of them.
fn argument(arena: &Arena, expr: Expr) -> Option<(Steep, Expr)> {
    let found = match arena.node(expr) {
        Node::Unary(Unary::Tanh, a) => (Steep::Saturating, a),
        Node::Unary(Unary::Exp, a) => (Steep::Growing, a),
        _ => return None,
    };
    Some(found)
}
