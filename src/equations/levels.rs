//! The levels of friction that sticks: up to which a joint holds, and against which it slides.
//!
//! A level may follow from reactions: mu times what presses. The reactions are sums over accelerations and multipliers, so a level is a law of the solution of the equations of motion itself.

use std::collections::HashMap;

use super::{Equations, RowKind};
use crate::expr::{Arena, Binary, Expr, Symbol, Unary};
use crate::model::{Contact, Formula, Owner, Pressed, Quantity, Slip, Variable};

/// What turns or moves by less than this share of its scale in a second does not slide, nor is it about to where that changes by less: rounding errors of what is zero are smaller.
const STILL: f64 = 1e-12;

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
    /// The sizes of vectors, of one component or two.
    Sizes(Vec<Vec<Expr>>),
}

impl Pressing {
    /// Every sum in it.
    pub fn sums(&self) -> Vec<Expr> {
        match self {
            Pressing::Sum(signed) => signed.iter().map(|(_, sum)| *sum).collect(),
            Pressing::Sizes(vectors) => vectors.concat(),
        }
    }

    /// What presses where its sums have these values, whatever the signs.
    pub fn size(&self, sums: &[f64]) -> f64 {
        match self {
            Pressing::Sum(_) => sums.iter().map(|sum| sum.abs()).sum(),
            Pressing::Sizes(vectors) => {
                let mut rest = sums.iter();
                let mut size_of =
                    |vector: &Vec<Expr>| rest.by_ref().take(vector.len()).fold(0.0, |size: f64, sum| size.hypot(*sum));
                vectors.iter().map(&mut size_of).sum()
            }
        }
    }
}

impl Equations {
    /// True if anything rubs that may stick.
    pub fn rubs_dry(&self) -> bool {
        self.constraints.iter().any(|row| matches!(row.kind, RowKind::FrictionLimit))
    }

    /// The levels of everything that rubs, with the place of each in the mechanism.
    pub fn levels(&mut self) -> Vec<(usize, Level)> {
        let count = self.system.mechanism.contacts.len();
        (0..count).filter_map(|index| Some((index, self.level(index)?))).collect()
    }

    /// The friction limits that the scene gives as laws, by themselves.
    pub fn level_laws(&mut self) -> Vec<Expr> {
        let mechanism = self.system.mechanism.clone();
        let limits = mechanism.contacts.iter().filter_map(|contact| contact.slip.as_ref());
        let laws = |slip: &Slip| {
            let varying = [&slip.law.mu, &slip.law.ratio].into_iter().filter(|formula| formula.varies());
            std::iter::once(&slip.law.coulomb).chain(varying).cloned().collect::<Vec<Formula>>()
        };
        limits.flat_map(laws).map(|formula| self.formula(&formula)).collect()
    }

    /// The ratio of the static to the kinetic friction limit.
    pub fn static_ratio(&mut self, slip: &Slip) -> Expr {
        self.at_least(&slip.law.ratio, Expr::ONE)
    }

    /// A factor of friction, which a law does not make smaller than this: where it would, the run ends: the domain of that law.
    fn at_least(&mut self, factor: &Formula, least: Expr) -> Expr {
        if !factor.varies() {
            return self.system.value(factor);
        }
        let factor = self.formula(factor);
        self.system.arena.binary(Binary::Max, least, factor)
    }

    fn level(&mut self, index: usize) -> Option<Level> {
        let mechanism = self.system.mechanism.clone();
        let contact = &mechanism.contacts[index];
        let slip = contact.slip.as_ref()?;
        let row = self.row_of_level(index)?;
        let coulomb = self.formula(&slip.law.coulomb);
        let mut free = self.system.arena.binary(Binary::Max, Expr::ZERO, coulomb);
        if let Some(there) = mechanism.there(contact.owner) {
            // What an event has removed does not rub; what pressed there is zero, too.
            let arena = &mut self.system.arena;
            let there = arena.symbol(Symbol::Discrete(there.0));
            free = arena.multiply(there, free);
        }
        let mut share = self.at_least(&slip.law.mu, Expr::ZERO);
        if let Some(wrap) = self.wrap_with_friction(contact.owner) {
            share = self.share_on_pulley(share, wrap);
        }
        let pressing = match slip.pressed {
            Pressed::Nothing | Pressed::Belt => Pressing::Sum(Vec::new()),
            Pressed::Pin => {
                let radius = slip.law.radius.as_ref().map_or(Expr::ZERO, |radius| self.system.value(radius));
                share = self.system.arena.multiply(share, radius);
                Pressing::Sizes(vec![
                    [Quantity::Fx, Quantity::Fy].map(|force| self.reaction(contact.owner, force)).to_vec(),
                ])
            }
            Pressed::Guide { .. } => {
                let normal = self.reaction(contact.owner, Quantity::Fn);
                let sums = match &slip.law.length {
                    Some(length) => self.at_both_ends(contact.owner, normal, length),
                    None => vec![normal],
                };
                self.signed(index, sums)
            }
            Pressed::Reaction(quantity) => {
                let reaction = self.reaction(contact.owner, quantity);
                self.signed(index, vec![reaction])
            }
            Pressed::Contact => {
                let presses = self.row_of_contact(slip.on?)?;
                let arena = &mut self.system.arena;
                let reaction = arena.symbol(Symbol::Reaction(presses));
                Pressing::Sum(vec![(Expr::ONE, arena.negate(reaction))])
            }
        };
        Some(Level { row, free, share, pressing })
    }

    /// What the mean of the tensions T before and behind a pulley has to do with their difference: T_2 <= T_1 exp(mu phi) and the other way round (Euler and Eytelwein) are together
    /// |T_2 - T_1| <= 2 tanh(mu phi/2) (T_1 + T_2)/2, which has no large numbers.
    fn share_on_pulley(&mut self, mu: Expr, wrap: Expr) -> Expr {
        let arena = &mut self.system.arena;
        let [half, two] = [0.5, 2.0].map(|number| arena.constant(number));
        let exponent = arena.multiply(mu, wrap);
        let exponent = arena.multiply(half, exponent);
        let share = arena.unary(Unary::Tanh, exponent);
        let share = arena.multiply(two, share);
        arena.binary(Binary::Max, share, Expr::ZERO)
    }

    /// Sums that press by their sizes. Events keep their signs; where drivers lead the motion there are none, and no step depends on a size.
    fn signed(&mut self, index: usize, sums: Vec<Expr>) -> Pressing {
        let signs = self.system.mechanism.contacts[index].state.signs.clone();
        if self.is_led(index) {
            return Pressing::Sizes(sums.into_iter().take(signs.len()).map(|sum| vec![sum]).collect());
        }
        let signs = signs.iter().map(|sign| self.system.arena.symbol(Symbol::Discrete(sign.0)));
        Pressing::Sum(signs.zip(sums).collect())
    }

    /// Which way things slide that drivers lead, with these accelerations of the coordinates: v/|v|, where they turn around as they go on, a/|a|, and where they rest not a number.
    pub(crate) fn known_directions(&mut self, accelerations: &[Expr], length: f64) -> HashMap<Symbol, Expr> {
        let mechanism = self.system.mechanism.clone();
        let sliding = mechanism.contacts.iter().enumerate();
        let known = |(index, contact): (usize, &Contact)| {
            let direction = contact.state.direction.filter(|_| self.is_led(index))?;
            let row = &self.constraints[self.row_of_contact(index)?];
            let (gap, least) = (row.contact()?, STILL * row.scale(length));
            let arena = &mut self.system.arena;
            let rate = gap.rate(arena);
            let second = gap.acceleration(arena, |_, index| accelerations[index]);
            let least = arena.constant(least);
            let [(way, moves), (next, goes_on)] = [rate, second].map(|value| {
                let size = arena.unary(Unary::Abs, value);
                (arena.divide(value, size), arena.subtract(size, least))
            });
            let (moves, goes_on) = (arena.binary(Binary::Max, moves, Expr::ZERO), if_positive(arena, goes_on));
            let next = arena.add(next, goes_on);
            Some((Symbol::Discrete(direction.0), arena.select(moves, way, next)))
        };
        sliding.filter_map(known).collect()
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

/// Zero while a value is positive, else not a number.
pub(crate) fn if_positive(arena: &mut Arena, value: Expr) -> Expr {
    let below = arena.binary(Binary::Min, value, Expr::ZERO);
    arena.unary(Unary::Sqrt, below)
}
