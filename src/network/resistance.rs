//! Viscous and dry friction of a joint: -c v - f tanh(v / v0), a force or a torque. The hyperbolic tangent stands for the
//! sign of the velocity, so that the law is smooth; a joint at rest under less than the level f creeps.

use super::System;
use crate::expr::{Arena, Expr, Unary};
use crate::model::Part;

/// A law that resists the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resistance {
    /// c
    damping: Expr,
    /// f and v0
    friction: Option<[Expr; 2]>,
}

impl Resistance {
    /// The law of a joint with the keys `damping` and `friction`, if it has one.
    pub(crate) fn of(system: &mut System, part: &Part) -> Option<Resistance> {
        let damping = system.value(part.formula("damping"));
        let friction = part.friction();
        let friction = friction.and_then(|friction| Some([&friction.coulomb, friction.velocity.as_ref()?]));
        let friction = friction.map(|smooth| smooth.map(|formula| system.value(formula)));
        (damping != Expr::ZERO || friction.is_some()).then_some(Resistance { damping, friction })
    }

    /// The coefficient c, if the law is a damper and nothing else.
    pub fn damper(self) -> Option<Expr> {
        self.friction.is_none().then_some(self.damping)
    }

    /// The force or torque at a velocity.
    pub fn at(self, arena: &mut Arena, velocity: Expr) -> Expr {
        let mut resisting = arena.multiply(self.damping, velocity);
        if let Some([level, transition]) = self.friction {
            let ratio = arena.divide(velocity, transition);
            let sign = arena.unary(Unary::Tanh, ratio);
            resisting = arena.add_product(resisting, level, sign);
        }
        arena.negate(resisting)
    }
}
