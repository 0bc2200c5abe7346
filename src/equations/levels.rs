//! The levels of friction that sticks: up to which a joint holds, and against which it slides.
//!
//! A level may follow from reactions: mu times what presses. The reactions are sums over accelerations and multipliers, so a level is a law of the solution of the equations of motion itself.

use super::Equations;
use crate::expr::{Binary, Expr, Symbol};
use crate::model::{Owner, Pressed, Quantity, Variable};

/// A level: free + share x pressing.
#[derive(Clone, Debug)]
pub struct Level {
    /// Its row among the loop equations, whose multiplier it is.
    pub row: usize,
    /// What does not depend on reactions; never negative.
    pub free: Expr,
    pub share: Expr,
    pub pressing: Pressing,
}

/// What presses, in terms of sums over accelerations and multipliers.
#[derive(Clone, Debug)]
pub enum Pressing {
    /// A sum of sign x sum: each is its own size while it has its sign.
    Sum(Vec<(Expr, Expr)>),
    /// The size of a vector.
    Size([Expr; 2]),
}

impl Equations {
    /// The levels of everything that rubs, with the place of each in the mechanism.
    pub fn levels(&mut self) -> Vec<(usize, Level)> {
        let count = self.system.mechanism.unilaterals.len();
        (0..count).filter_map(|index| Some((index, self.level(index)?))).collect()
    }

    fn level(&mut self, index: usize) -> Option<Level> {
        let mechanism = self.system.mechanism.clone();
        let own = &mechanism.unilaterals[index];
        let slip = own.slip.as_ref()?;
        let row = self.row_of_unilateral(index)? + 1;
        let coulomb = self.formula(&slip.law.coulomb);
        let free = self.system.arena.binary(Binary::Max, Expr::ZERO, coulomb);
        let mut share = self.system.value(&slip.law.mu);
        let pressing = match slip.pressed {
            Pressed::Nothing => Pressing::Sum(Vec::new()),
            Pressed::Pin => {
                let radius = slip.law.radius.as_ref().map_or(Expr::ZERO, |radius| self.system.value(radius));
                share = self.system.arena.multiply(share, radius);
                Pressing::Size([Quantity::Fx, Quantity::Fy].map(|quantity| self.reaction(own.owner, quantity)))
            }
            Pressed::Guide { .. } => {
                let normal = self.reaction(own.owner, Quantity::Fn);
                let sums = match &slip.law.length {
                    Some(length) => self.at_both_ends(own.owner, normal, length),
                    None => vec![normal],
                };
                let signs = slip.signs.iter().map(|sign| self.system.arena.symbol(Symbol::Parameter(sign.0)));
                Pressing::Sum(signs.zip(sums).collect())
            }
            Pressed::Reaction(quantity) => {
                let reaction = self.reaction(own.owner, quantity);
                let signs = slip.signs.iter().map(|sign| self.system.arena.symbol(Symbol::Parameter(sign.0)));
                Pressing::Sum(signs.map(|sign| (sign, reaction)).collect())
            }
            Pressed::Contact => {
                let presses = self.row_of_unilateral(slip.on?)?;
                let arena = &mut self.system.arena;
                let reaction = arena.symbol(Symbol::Reaction(presses));
                Pressing::Sum(vec![(Expr::ONE, arena.negate(reaction))])
            }
        };
        Some(Level { row, free, share, pressing })
    }

    /// The forces at the ends of a guide that holds the angle: fn/2 + T/length and fn/2 - T/length.
    fn at_both_ends(&mut self, owner: Owner, normal: Expr, length: &crate::model::Formula) -> Vec<Expr> {
        let torque = self.reaction(owner, Quantity::Torque);
        let length = self.system.value(length);
        let arena = &mut self.system.arena;
        let half = arena.constant(0.5);
        let (half, tilting) = (arena.multiply(half, normal), arena.divide(torque, length));
        vec![arena.add(half, tilting), arena.subtract(half, tilting)]
    }

    fn reaction(&mut self, owner: Owner, quantity: Quantity) -> Expr {
        self.variable(Variable { owner, quantity })
    }
}
