//! Event indicators (switching functions) of a motion.

use crate::equations::Equations;
use crate::expr::{Expr, indicators};

/// Those of a motion: of its accelerations, and of the rates that drivers prescribe, for where these jump no acceleration does. None where drivers prescribe all.
pub fn motion_indicators(equations: &mut Equations, accelerations: &[Expr]) -> Vec<Expr> {
    if accelerations.is_empty() {
        return Vec::new();
    }
    let rates = (0..equations.constraints.len()).map(|index| equations.constraint_rate(index));
    let jumping: Vec<Expr> = accelerations.iter().copied().chain(rates.collect::<Vec<_>>()).collect();
    indicators(&mut equations.system.arena, &jumping)
}
