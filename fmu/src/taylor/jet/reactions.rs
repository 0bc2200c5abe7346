//! Series of reactions: a contact ceases to press at a root of one, and a friction slips where one reaches its limit.

use super::friction::Limits;
use super::{Jet, Shape};
use crate::linalg::lane::{Lane, WIDTH, splat};
use crate::linalg::number::Number;
use crate::model::Model;
use crate::program::arm_form::{ArmForm, ContactRow, ORDERS};
use crate::taylor::products::move_start;

/// The series of the reactions of all loop equations.
#[derive(Clone, Debug)]
pub(super) struct Reactions<N, const L: usize> {
    /// Lanes of one order.
    lanes: usize,
    /// By orders.
    series: Vec<Lane<N, L>>,
    /// True if a contact is closed, or a friction sticks.
    wanted: bool,
}

impl<N: Number, const L: usize> Reactions<N, L> {
    /// Storage.
    pub fn new(model: &Model, form: &ArmForm) -> Self {
        let lanes = lanes(model, form, L);
        Self { lanes, series: vec![splat(N::ZERO); ORDERS * lanes], wanted: false }
    }

    /// Detects whether any contact is closed: the reactions of the others are zero.
    pub fn detect_closed(&mut self, form: &ArmForm, coefficients: &[N]) {
        let is_closed = |contact: &ContactRow| coefficients[contact.open as usize] == N::ZERO;
        self.wanted = self.lanes > 0 && form.contacts.iter().any(is_closed);
    }

    /// True if reactions are kept.
    #[inline(always)]
    pub fn are_kept(&self) -> bool {
        self.wanted
    }

    /// Keeps those of order k.
    #[inline(always)]
    pub fn keep(&mut self, k: usize, found: &[Lane<N, L>]) {
        for (place, found) in self.series.iter_mut().skip(k * self.lanes).zip(found) {
            *place = *found;
        }
    }
}

/// Lanes of one order: none unless events are searched for by reactions.
fn lanes(model: &Model, form: &ArmForm, width: usize) -> usize {
    let has_friction = form.contacts.iter().any(|contact| contact.friction.is_some());
    if has_friction || model.program().instants.has_gaps_only() { form.rows.len().div_ceil(width) } else { 0 }
}

impl Jet {
    /// Numbers in a polynomial of the highest order, with reactions and series of friction behind it.
    pub fn room(model: &Model, form: &ArmForm) -> usize {
        let lanes = Shape::new(form, WIDTH).all() + lanes(model, form, WIDTH);
        ORDERS * (lanes * WIDTH + Limits::<f64, WIDTH>::kept(form))
    }

    /// Where the series of friction begin in a polynomial.
    pub(super) fn friction_in(&self) -> usize {
        let [first, count] = self.reactions_in();
        first + ORDERS * count
    }

    /// Where reactions begin in a polynomial, and how many numbers are those of one order.
    fn reactions_in(&self) -> [usize; 2] {
        [ORDERS * self.shape.places(), self.reactions_kept.lanes * WIDTH]
    }

    /// Writes the polynomial of all unknowns, by orders, and behind it those of reactions, which have two orders less.
    pub fn write_polynomial(&self, order: usize, polynomial: &mut [f64]) {
        let unknowns = self.values[..(order + 1) * self.shape.all()].as_flattened();
        polynomial[..unknowns.len()].copy_from_slice(unknowns);
        if !self.limits.is_empty() {
            let first = self.friction_in();
            self.limits.write(order - 2, &mut polynomial[first..]);
        }
        if !self.reactions_kept.wanted {
            return;
        }
        let [first, count] = self.reactions_in();
        let reactions = &self.reactions_kept.series.as_flattened()[..(order - 1) * count];
        polynomial[first..first + reactions.len()].copy_from_slice(reactions);
    }

    /// The reaction of a contact along a polynomial, by its loop equation of the program; false if it is not kept.
    pub fn reaction(&self, polynomial: &[f64], order: usize, constraint: u32, coefficients: &mut [f64]) -> bool {
        let [first, count] = self.reactions_in();
        if !self.reactions_kept.wanted {
            return false;
        }
        // In a flight contacts have no row.
        let is_of = |row: &usize| self.form.rows.get(*row).is_some_and(|row| row.constraint == constraint);
        let Some(row) = self.form.contacts.iter().map(|contact| contact.row as usize).find(is_of) else { return false };
        coefficients.fill(0.0);
        let orders = polynomial[first..].chunks_exact(count).take(order - 1);
        for (coefficient, reactions) in coefficients.iter_mut().zip(orders) {
            *coefficient = reactions[row] * self.form.unit_of_mass;
        }
        true
    }

    /// Rewrites a polynomial about a time so long after its start.
    pub fn move_start(&self, polynomial: &mut [f64], order: usize, dt: f64) {
        let (places, [first, count]) = (self.shape.places(), self.reactions_in());
        move_start(&mut polynomial[..(order + 1) * places], places, dt);
        if count > 0 {
            move_start(&mut polynomial[first..][..(order - 1) * count], count, dt);
        }
        if !self.limits.is_empty() {
            for series in polynomial[self.friction_in()..].as_chunks_mut::<ORDERS>().0 {
                move_start(&mut series[..order - 1], 1, dt);
            }
        }
    }
}
