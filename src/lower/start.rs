//! What determines the start: the loop equations together with the conditions of `[initial]`.

use super::initial::Conditions;
use crate::expr::{Expr, Order, Symbol};

#[derive(Clone, Copy, Debug)]
pub(super) struct Beginning<'a> {
    /// Phi, its rate, gamma.
    pub constraints: [&'a [Expr]; 3],
    pub conditions: [&'a Conditions; 2],
    /// Which loop equations are independent.
    pub active: &'a [bool],
    /// Accelerations, then reactions, in terms of the state; nothing if the drivers determine the motion.
    pub solved: Option<&'a [Expr]>,
    pub coordinates: usize,
}

impl Beginning<'_> {
    /// What is solved for where loads determine the motion: accelerations, then reactions.
    pub fn symbols(&self) -> impl Iterator<Item = Symbol> {
        let coordinates = self.coordinates;
        (0..).map(move |index: usize| match index.checked_sub(coordinates) {
            None => Symbol::Coordinate(index, Order::Acceleration),
            Some(reaction) => Symbol::Reaction(reaction),
        })
    }
}
