//! Friction limits by arms: what they act on, and the normal forces that they follow from, as affine functions of what is solved for at each order.

use std::collections::BTreeMap;

use cotree_fmu::program::arm_form::{Friction, NormalForce, Place, Slope, Solved, SolvedSum};

use super::form::Lowering;
use super::{ArmFriction, NoSeries};
use crate::equations::{Equations, Level, Pressing};
use crate::expr::Expr;
use crate::solve::{AffineSum, solved_sums};

/// A friction limit with the sums that its normal force is made of.
pub(super) struct ArmLimit {
    /// The loop equation of the friction.
    contact: usize,
    level: Level,
    sums: Vec<AffineSum>,
}

impl Equations {
    pub(super) fn friction_limits(&mut self) -> Vec<ArmLimit> {
        let coordinates = self.coordinates.len();
        let levels = self.levels();
        let read: Vec<Expr> = levels.iter().flat_map(|(_, level)| level.pressing.sums()).collect();
        let mut sums = solved_sums(&mut self.system.arena, &read, coordinates).into_iter();
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
                return Err(NoSeries("friction acts on what is no constant combination of arms".to_owned()));
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
            free: self.builder.slot(self.arena, &mut self.coefficients, limit.level.free)?,
            share: self.builder.slot(self.arena, &mut self.coefficients, limit.level.share)?,
            ..Friction::default()
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

    fn solved_sum(&mut self, sum: AffineSum, limits: &BTreeMap<usize, u32>) -> Result<SolvedSum, NoSeries> {
        let rest = self.builder.slot(self.arena, &mut self.coefficients, sum.rest)?;
        let mut slopes: BTreeMap<Solved, Expr> = BTreeMap::new();
        for (index, slope) in sum.slopes {
            for (solved, factor) in self.solved(index, limits)? {
                let entry = slopes.entry(solved).or_insert(Expr::ZERO);
                *entry = self.arena.add_product(*entry, factor, slope);
            }
        }
        slopes.retain(|_, slope| *slope != Expr::ZERO);
        let term = |(solved, slope): (Solved, Expr)| {
            let slope = match self.builder.is_constant(self.arena, slope) {
                true => Slope::Constant(self.coefficients.place(slope)),
                false => Slope::Series(self.builder.slot(self.arena, &mut self.coefficients, slope)?),
            };
            Ok((solved, slope))
        };
        Ok(SolvedSum { rest, terms: slopes.into_iter().map(term).collect::<Result<_, NoSeries>>()? })
    }

    /// What an acceleration or a multiplier of the program is made of, with factors.
    fn solved(&mut self, index: usize, limits: &BTreeMap<usize, u32>) -> Result<Vec<(Solved, Expr)>, NoSeries> {
        let Some(row) = index.checked_sub(self.mechanical) else {
            return Ok(match self.form.coordinates[index] {
                Place::Displacement { arm } => vec![(Solved::Unknown(arm), Expr::ONE)],
                Place::Angle { arm, parent, reversed } => {
                    let minus = self.arena.constant(-1.0);
                    let [plus, minus] = if reversed { [minus, Expr::ONE] } else { [Expr::ONE, minus] };
                    let parent = parent.map(|parent| (Solved::Unknown(parent), minus));
                    [(Solved::Unknown(arm), plus)].into_iter().chain(parent).collect()
                }
            });
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
