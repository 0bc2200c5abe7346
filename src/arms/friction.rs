//! Friction limits by arms: what they act on, and the normal forces that they follow from, as affine functions of what is solved for at each order.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use cotree_fmu::program::arm_form::{Friction, NormalForce, Slope, Solved, SolvedSum};

use super::form::{Lowering, unknowns_of};
use super::{ArmFriction, NoSeries, Turning};
use crate::equations::{Equations, Level, Pressing};
use crate::expr::{Arena, Binary, Expr, ExprNode, Order, Symbol, Unary};
use crate::solve::{AffineSum, solved_sums};

/// The number of random states in which an identity is tested, and its greatest error there, relative to the terms.
const STATES: u64 = 4;
const EQUAL: f64 = 1e-10;

/// A friction limit with the sums that its normal force is made of.
pub(super) struct ArmLimit {
    /// The loop equation of the friction.
    contact: usize,
    level: Level,
    /// With the rest of each where nothing moves.
    sums: Vec<(AffineSum, Expr)>,
}

impl Equations {
    pub(super) fn friction_limits(&mut self) -> Vec<ArmLimit> {
        let coordinates = self.coordinates.len();
        let levels = self.levels();
        let read: Vec<Expr> = levels.iter().flat_map(|(_, level)| level.pressing.sums()).collect();
        let sums = solved_sums(&mut self.system.arena, &read, coordinates);
        let rests: Vec<Expr> = sums.iter().map(|sum| sum.rest).collect();
        let is_rate = |symbol: Symbol| matches!(symbol, Symbol::Coordinate(_, Order::Velocity));
        let at_rest = self.system.arena.without(&rests, is_rate);
        let mut sums = sums.into_iter().zip(at_rest);
        let limit = |(index, level): (usize, Level)| {
            let sums = sums.by_ref().take(level.pressing.sums().len()).collect();
            Some(ArmLimit { contact: self.row_of_contact(index)?, level, sums })
        };
        levels.into_iter().filter_map(limit).collect()
    }
}

impl Lowering<'_> {
    /// The loop equations and their contacts are known.
    pub(super) fn frictions(&mut self, limits: Vec<ArmLimit>) -> Result<(), NoSeries> {
        let contacts: BTreeMap<usize, usize> = self
            .form
            .contacts
            .iter()
            .enumerate()
            .map(|(place, contact)| (self.form.rows[contact.row as usize].constraint as usize, place))
            .collect();
        let places: BTreeMap<usize, u32> =
            limits.iter().filter_map(|limit| Some((limit.level.row, *contacts.get(&limit.contact)? as u32))).collect();
        for limit in limits {
            let place = contacts.get(&limit.contact).copied();
            let acts = place.and_then(|place| self.arms.rows[self.form.contacts[place].row as usize].friction.clone());
            let (Some(place), Some(acts)) = (place, acts) else {
                return Err(NoSeries(
                    "a friction force acts along what is not a constant combination of arms".to_owned(),
                ));
            };
            let friction = self.friction(acts, limit, &places)?;
            self.form.contacts[place].friction = Some(friction);
        }
        Ok(())
    }

    fn friction(
        &mut self,
        acts: ArmFriction,
        limit: ArmLimit,
        limits: &BTreeMap<usize, u32>,
    ) -> Result<Friction, NoSeries> {
        let mut friction = Friction {
            constraint: limit.level.row as u32,
            free: self.factor(limit.level.free)?,
            share: self.factor(limit.level.share)?,
            arms: Vec::new(),
            unknowns: Vec::new(),
            normal: Vec::new(),
        };
        // Reactions resist.
        for (arm, along) in &acts.arms {
            let along = along.map(|part| self.arena.negate(part));
            friction.arms.push((self.numbers[arm], along.map(|part| self.mass(part))));
        }
        for (index, factor) in acts.displacements {
            let factor = self.arena.negate(factor);
            friction.unknowns.push((self.displacements[&index], self.mass(factor)));
        }
        for (frame, factor) in acts.angles {
            if let Some(unknown) = self.angle(frame) {
                let factor = self.arena.negate(factor);
                friction.unknowns.push((unknown, self.mass(factor)));
            }
        }
        let mut sums = limit.sums.into_iter();
        let vectors: Vec<(Option<Expr>, usize)> = match limit.level.pressing {
            Pressing::Sum(signed) => signed.into_iter().map(|(sign, _)| (Some(sign), 1)).collect(),
            Pressing::Sizes(vectors) => vectors.into_iter().map(|vector| (None, vector.len())).collect(),
        };
        for (sign, count) in vectors {
            let components = sums.by_ref().take(count).map(|sum| self.solved_sum(sum, limits));
            let mut components = components.collect::<Result<Vec<SolvedSum>, NoSeries>>()?;
            friction.normal.push(match sign {
                Some(sign) => NormalForce::Signed(self.coefficients.place(sign), components.swap_remove(0)),
                None => NormalForce::Magnitude(components),
            });
        }
        Ok(friction)
    }

    fn factor(&mut self, expr: Expr) -> Result<Slope, NoSeries> {
        Ok(match self.builder.is_constant(self.arena, expr) {
            true => Slope::Constant(self.coefficients.place(expr)),
            false => Slope::Series(self.builder.slot(self.arena, &mut self.coefficients, expr)?),
        })
    }

    fn solved_sum(
        &mut self,
        (sum, at_rest): (AffineSum, Expr),
        limits: &BTreeMap<usize, u32>,
    ) -> Result<SolvedSum, NoSeries> {
        let mut slopes: BTreeMap<Solved, Expr> = BTreeMap::new();
        for (index, slope) in sum.slopes {
            for (solved, factor) in self.solved(index, limits)? {
                let entry = slopes.entry(solved).or_insert(Expr::ZERO);
                *entry = self.arena.add_product(*entry, factor, slope);
            }
        }
        slopes.retain(|_, slope| *slope != Expr::ZERO);
        let (rest, slopes) = match self.by_arms(&slopes, [sum.rest, at_rest]) {
            Some(slopes) => (at_rest, slopes),
            None => (sum.rest, slopes),
        };
        let rest = self.builder.slot(self.arena, &mut self.coefficients, rest)?;
        let term = |(solved, slope): (Solved, Expr)| Ok((solved, self.factor(slope)?));
        Ok(SolvedSum { rest, terms: slopes.into_iter().map(term).collect::<Result<_, NoSeries>>()? })
    }

    /// The same sum by second derivatives of arms, whose slopes are constant: of A x'' + B y'' the angle's second derivative has the slope B x - A y, and -omega^2 (A x + B y) is left. None if the
    /// rest has anything else that depends on rates. It must be analytic: a function in pieces, such as a load that begins at a rate, may be zero in all states that are tried.
    fn by_arms(
        &mut self,
        slopes: &BTreeMap<Solved, Expr>,
        [rest, at_rest]: [Expr; 2],
    ) -> Option<BTreeMap<Solved, Expr>> {
        if !is_analytic(self.arena, rest) {
            return None;
        }
        let mut by_arms = BTreeMap::new();
        let mut difference = self.arena.subtract(rest, at_rest);
        for (&solved, &slope) in slopes {
            let Solved::Unknown(arm) = solved else {
                by_arms.insert(solved, slope);
                continue;
            };
            if self.builder.is_constant(self.arena, slope) {
                by_arms.insert(solved, slope);
                continue;
            }
            let [x, y] = self.builder.in_frame(self.arena, &mut self.coefficients, slope, arm)?;
            let components = [self.arena.negate(y), x];
            let turning = self.turns_alone(arm)?;
            let omega = turning.coordinates.iter().fold(Expr::ZERO, |sum, (&index, &sign)| {
                let rate = self.arena.symbol(Symbol::Coordinate(index, Order::Velocity));
                let sign = self.arena.constant(sign);
                self.arena.add_product(sum, sign, rate)
            });
            let square = self.arena.square(omega);
            for ((component, unit), of) in
                components.into_iter().zip(turning.unit).zip([Solved::X(arm), Solved::Y(arm)])
            {
                let part = self.arena.multiply(component, unit);
                difference = self.arena.add_product(difference, square, part);
                by_arms.insert(of, component);
            }
        }
        by_arms.retain(|_, slope| *slope != Expr::ZERO);
        is_zero(self.arena, difference, rest).then_some(by_arms)
    }

    /// A frame whose angle is an unknown, which turns no other frame, and has no signal.
    fn turns_alone(&self, arm: u32) -> Option<Turning> {
        let frame = *self.form.frames.get(arm as usize)?;
        let users = self.form.frames.iter().filter(|other| other.unknown == Some(arm)).count();
        (frame.unknown == Some(arm) && frame.signal.is_none() && users == 1).then_some(())?;
        self.arms.frames.get(arm as usize).cloned()
    }

    /// What an acceleration or a multiplier of the program is made of, with factors.
    fn solved(&mut self, index: usize, limits: &BTreeMap<usize, u32>) -> Result<Vec<(Solved, Expr)>, NoSeries> {
        let Some(row) = index.checked_sub(self.layout.coordinates().len()) else {
            let unknowns = unknowns_of(self.form.coordinates[index]).into_iter();
            return Ok(unknowns.map(|(arm, sign)| (Solved::Unknown(arm), self.arena.constant(sign))).collect());
        };
        if let Some(&contact) = limits.get(&row) {
            return Ok(vec![(Solved::Limit(contact), Expr::ONE)]);
        }
        let is_of = |place: &usize| self.form.rows[*place].constraint as usize == row;
        let rows: Vec<usize> = (0..self.form.rows.len()).filter(is_of).collect();
        let is_contact = |place: usize| self.form.contacts.iter().any(|contact| contact.row as usize == place);
        match rows[..] {
            [] => Ok(Vec::new()),
            [.., last] if rows.len() == 1 || is_contact(last) => {
                let unit = self.arena.divide(Expr::ONE, self.per_unit);
                Ok(vec![(Solved::Row(last as u32), unit)])
            }
            _ => Err(NoSeries("a normal force turns with a joint".to_owned())),
        }
    }
}

/// True for an expression of sums, products, quotients, sines and cosines: if such a function is zero in random states, it is zero.
fn is_analytic(arena: &Arena, expr: Expr) -> bool {
    arena.reachable([expr]).into_iter().all(|expr| match arena.node(expr) {
        ExprNode::Constant(_) | ExprNode::Symbol(_) => true,
        ExprNode::Unary(function, _) => matches!(function, Unary::Negate | Unary::Sin | Unary::Cos),
        ExprNode::Binary(function, ..) => {
            matches!(function, Binary::Add | Binary::Subtract | Binary::Multiply | Binary::Divide)
        }
        ExprNode::Select(..) => false,
    })
}

/// True if an expression is zero in random states, in comparison with another one.
fn is_zero(arena: &Arena, expr: Expr, size: Expr) -> bool {
    (1..=STATES).all(|seed| {
        let values = |symbol: Symbol| {
            let mut hasher = DefaultHasher::new();
            (seed, symbol).hash(&mut hasher);
            // Between 1/2 and 3/2, so that lengths and masses are positive.
            0.5 + (hasher.finish() >> 11) as f64 / (1_u64 << 53) as f64
        };
        match arena.evaluate(&[expr, size], &values)[..] {
            [value, size] => value.abs() <= EQUAL * size.abs().max(1.0),
            _ => false,
        }
    })
}
