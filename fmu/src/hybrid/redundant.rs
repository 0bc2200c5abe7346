//! Contacts that others make redundant: a box on three feet stands on any two.
//!
//! More supports than hold a rigid body are statically indeterminate: how they share the load is not determined, and their loop equations depend on each other. So no more are closed than are independent;
//! the gaps of the others, which touch and are open, stay at zero because of those. They are noted here, and their gaps, which are rounding errors, are not looked at as those of others are.
//!
//! The motion does not depend on the choice, unless the supports differ in friction: then there is more than one motion, which is an error. The ways of sharing the load are combinations of those with
//! independent supports, so it is enough to exchange one support for a redundant one; and, where joints hold a body on its supports, of those with forces between joints and supports that are in equilibrium
//! by themselves, of any size: then friction is not determined.

use super::contact::{ContactValues, INDETERMINATE, PRELOADED, Place};
use crate::failure::Failure;
use crate::machine::CANCELLED;
use crate::math::maximum;
use crate::program::{Constraint, Role};

impl ContactValues {
    /// Notes which open contacts the chosen mode makes redundant: they touch, do not move apart, and closed they would hold something twice.
    pub(super) fn find_redundant(&mut self, context: &mut Place) {
        self.choices.concerned().for_each(|index| self.redundant[index] = false);
        let engages = |row: &Constraint| matches!(row.role, Role::Engaging { .. });
        let may_engage = context.model.program().constraints.iter().any(engages);
        if !may_engage && !self.choices.concerned().any(|index| context.is_closed(index)) {
            return;
        }
        for index in 0..self.redundant.len() {
            let touches = self.choices.includes(index) && context.slip(index).is_none();
            let stays = self.accelerations[index].abs() <= self.slack(context, index);
            if !touches || context.is_closed(index) || !stays {
                continue;
            }
            self.redundant[index] = self.is_held(context, index);
            self.accelerate(context);
        }
    }

    /// True if other parts hold something that is open, or does not stick: its loop equation would be redundant. Accelerations have to be found again after it.
    pub(super) fn is_held(&mut self, context: &mut Place, index: usize) -> bool {
        let (is_friction, mode) = (context.slip(index).is_some(), context.mode(index));
        let set = |context: &mut Place, closed: bool| match is_friction {
            true => context.slide(index, if closed { Some(0.0) } else { mode }),
            false => context.close(index, closed),
        };
        set(context, true);
        self.accelerate(context);
        set(context, false);
        self.twice
    }

    /// Looks whether the motion is the same however redundant supports with friction share the load.
    ///
    /// # Errors
    /// It is not.
    pub(super) fn check_determinate(&mut self, context: &mut Place) -> Result<(), Failure> {
        let n = context.model.coordinates();
        if !self.choices.concerned().any(|index| self.redundant[index]) {
            return Ok(());
        }
        self.reference.copy_from_slice(&self.solved[..n]);
        let mut determinate = true;
        for index in 0..self.redundant.len() {
            let is_redundant = self.redundant[index] && self.choices.includes(index);
            let Some(friction) = self.friction_of(context, index).filter(|_| is_redundant) else { continue };
            self.accelerate(context);
            let Some(way) = self.way(context, friction) else { continue };
            if self.may_be_preloaded(context, index) {
                return Err(context.failure(&self.choices, PRELOADED));
            }
            let before = context.mode(friction);
            context.close(index, true);
            context.slide(friction, Some(way));
            determinate &= self.exchanged_agree(context, index);
            context.close(index, false);
            context.slide(friction, before);
        }
        self.accelerate(context);
        if determinate { Ok(()) } else { Err(context.failure(&self.choices, INDETERMINATE)) }
    }

    /// True if forces that are in equilibrium by themselves may press a redundant contact: its row is a combination of those of joints and of closed contacts, of which none counts positively.
    fn may_be_preloaded(&mut self, context: &mut Place, index: usize) -> bool {
        let before = self.rates[index];
        self.rest.copy_from_slice(context.state.rates());
        let mut is_free = true;
        for other in 0..self.redundant.len() {
            if context.slip(other).is_some() || !context.is_closed(other) {
                continue;
            }
            // If the rate of that one falls by one, this one's falls by its share.
            self.requested.fill(0.0);
            self.requested[context.data.all[other].constraint as usize] = 1.0;
            self.apply_impulses(context);
            let share = before - self.rates[index];
            is_free &= share * context.scale(other) <= CANCELLED * context.scale(index);
            context.state.rates_mut().copy_from_slice(&self.rest);
        }
        self.find_rates(context);
        is_free
    }

    /// True if the accelerations are the same with each closed contact opened in the place of one that has been closed, where that is a mode.
    fn exchanged_agree(&mut self, context: &mut Place, closed: usize) -> bool {
        let mut agree = true;
        for other in 0..self.redundant.len() {
            let is_support = other != closed && context.slip(other).is_none() && context.is_closed(other);
            if !is_support || !self.choices.includes(other) {
                continue;
            }
            let friction = self.friction_of(context, other).map(|friction| (friction, context.mode(friction)));
            context.close(other, false);
            if let Some((friction, _)) = friction {
                context.slide(friction, None);
            }
            self.accelerate(context);
            if !self.twice && self.is_mode(context, false) {
                agree &= self.is_reference();
            }
            context.close(other, true);
            if let Some((friction, mode)) = friction {
                context.slide(friction, mode);
            }
        }
        agree
    }

    /// True if the accelerations are those of the reference, as far as an instant that was found knows them.
    fn is_reference(&self) -> bool {
        let size = self.reference.iter().chain(&self.solved[..self.reference.len()]);
        let size = size.fold(0.0, |most, value| maximum(most, value.abs()));
        let mut pairs = self.reference.iter().zip(&self.solved);
        pairs.all(|(value, other)| (value - other).abs() <= self.found() * size)
    }

    /// The friction of a contact, if it follows from what presses.
    fn friction_of(&self, context: &Place, contact: usize) -> Option<usize> {
        let on =
            |index: &usize| context.slip(*index).is_some_and(|slip| slip.follows && slip.on == Some(contact as u32));
        (0..self.redundant.len()).find(on)
    }

    /// In which direction a friction slides in the chosen mode, or begins to.
    fn way(&self, context: &Place, index: usize) -> Option<f64> {
        let (rate, acceleration) = (self.rates[index], self.accelerations[index]);
        if rate.abs() > self.least_rate(context, index) {
            Some(rate.signum())
        } else {
            (acceleration.abs() > self.slack(context, index)).then_some(acceleration.signum())
        }
    }
}
