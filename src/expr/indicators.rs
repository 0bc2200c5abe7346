//! Event indicators (switching functions): they change sign where a law or its derivative is discontinuous.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use super::{Arena, Binary, Expr, ExprNode, Unary};

/// Indicators of all subexpressions of the given results: differences of compared expressions, arguments of absolute values and
/// signs. Those that only parameters move are left out.
pub fn indicators(arena: &mut Arena, results: &[Expr]) -> Vec<Expr> {
    let results = arena.expanded(results);
    let reached = arena.reachable(results);
    let found: BTreeSet<Expr> = reached.into_iter().filter_map(|expr| indicator(arena, expr)).collect();
    found.into_iter().filter(|&expr| moves(arena, expr)).collect()
}

fn indicator(arena: &mut Arena, expr: Expr) -> Option<Expr> {
    match arena.node(expr) {
        ExprNode::Binary(Binary::Less | Binary::LessEqual | Binary::Min | Binary::Max, a, b) => {
            Some(arena.subtract(a, b))
        }
        ExprNode::Unary(Unary::Abs | Unary::Sign, a) => Some(a),
        ExprNode::Unary(Unary::Floor, a) => {
            // Changes sign at every whole number.
            let pi = arena.constant(PI);
            let turns = arena.multiply(pi, a);
            Some(arena.sin(turns))
        }
        _ => None,
    }
}

fn moves(arena: &Arena, expr: Expr) -> bool {
    arena.symbols([expr]).into_iter().any(|symbol| !symbol.is_parameter())
}
