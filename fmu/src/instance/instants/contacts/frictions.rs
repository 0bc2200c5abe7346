//! Friction in a step of the series: rates of sliding, limits and reactions are polynomials, so that most steps need not be looked at in many places.
//!
//! A rate that falls to zero is found exactly. Where what sticks, or the sign of a normal force, is not clear of its limit the step is looked through place by place (see [`super::super::events`]).

use super::super::super::Instance;
use super::super::{Instants, Searched};
use super::polynomials::{root, scaled};
use crate::hybrid::contact::{TOUCHING, direction, is_closed};
use crate::hybrid::descent::{self, Descent};
use crate::hybrid::onset::Reach;
use crate::machine::ROUNDING;
use crate::math::horner;
use crate::program::Contacts;
use crate::program::arm_form::ORDERS;
use crate::taylor::TapeAlong;

/// What becomes of a rate of sliding in a step.
enum Sliding {
    GoesOn,
    /// It ends this share of the step after its beginning.
    Ends(f64),
}

impl Instance {
    /// Looks through the last step by polynomials, if there is nothing but friction; none if these do not tell.
    pub(in super::super) fn search_frictions(&mut self, instants: &mut Instants, step: [f64; 2]) -> Option<Searched> {
        let model = self.model.clone();
        let program = &model.program().instants;
        let data = program.contacts.as_ref().filter(|_| program.events.is_empty())?;
        let is_friction = |index: usize| data.all[index].slip.as_ref().is_some_and(|slip| slip.on.is_none());
        if !(0..data.all.len()).all(is_friction) {
            return None;
        }
        let mut rates = instants.contacts.rates_along.take()?;
        let expanded = self.expand_along(&mut rates, step[0]);
        let found = expanded.and_then(|()| {
            self.machine.evaluate(&data.restitutions, &mut instants.contacts.restitutions);
            self.first_friction(instants, data, &mut rates, step)
        });
        instants.contacts.rates_along = Some(rates);
        let first = found?;
        instants.armed.fill(true);
        if let Some((_, event)) = first {
            instants.armed[event] = false;
        } else {
            // A limit may jump there.
            self.evaluate_sides(instants, (step, step), 1.0);
            instants.indicators.iter().all(|indicator| *indicator <= 0.0).then_some(())?;
            instants.known.overlooked = self.find_violated(instants);
        }
        Some(self.searched_by_polynomials(instants, step, first))
    }

    /// The first change; none if polynomials do not tell.
    fn first_friction(
        &mut self,
        instants: &Instants,
        data: &Contacts,
        rates: &mut TapeAlong,
        step: [f64; 2],
    ) -> Option<Option<(f64, usize)>> {
        let mut first: Option<(f64, usize)> = None;
        for index in 0..data.all.len() {
            let direction = direction(data, &self.now.state, index);
            let clear = if is_closed(data, &self.now.state, index) {
                self.sticks(instants, data, index, step)
            } else if direction.abs() == 1.0 {
                match self.sliding(rates, (index, direction), step)? {
                    Sliding::Ends(share) if first.is_none_or(|(before, _)| share < before) => {
                        first = Some((share, index))
                    }
                    Sliding::Ends(_) | Sliding::GoesOn => {}
                }
                true
            } else {
                // Other parts hold it.
                true
            };
            (clear && self.has_signs(data, index, step)).then_some(())?;
        }
        Some(first.map(|(share, index)| (step[0] + share * (step[1] - step[0]), index)))
    }

    /// What becomes of a rate in its direction. Where sliding has just begun the rate begins at zero: over the time since then it does not.
    fn sliding(&self, rates: &mut TapeAlong, (index, direction): (usize, f64), step: [f64; 2]) -> Option<Sliding> {
        let (span, scale, begins) = (step[1] - step[0], self.scale_of(index), !self.now.happened.armed[index]);
        let touching = TOUCHING * scale;
        let mut polynomial = scaled(rates.polynomial(index), span).map(|coefficient| direction * coefficient);
        if begins && polynomial[0].abs() > touching {
            return None;
        }
        let [margin, least] = if begins { [0.0, touching] } else { [ROUNDING * scale, 0.0] };
        polynomial[0] += margin;
        let polynomial = &polynomial[usize::from(begins)..rates.polynomial(index).len()];
        polynomial.first().is_some_and(|begin| *begin > least).then_some(())?;
        let is_linear = rates.is_linear(index);
        let mut rate = |share: f64| {
            let rate = direction * rates.value(index, share * span) + margin;
            if begins { rate / share } else { rate }
        };
        let error = |share: f64| if is_linear { 0.0 } else { (rate(share) - horner(polynomial, share)).abs() };
        match descent::first(polynomial, error) {
            Descent::None => Some(Sliding::GoesOn),
            Descent::Unknown => None,
            Descent::Between(part) => {
                let spacing = Reach::new(step, step[1]).spacing;
                Some(Sliding::Ends(root(polynomial, part, spacing, &mut rate)))
            }
        }
    }

    /// True if what sticks is clearly within its static limit.
    fn sticks(&self, instants: &Instants, data: &Contacts, index: usize, step: [f64; 2]) -> bool {
        let (contact, mut reaction) = (&data.all[index], [0.0; ORDERS]);
        let settings = self.settings();
        let (run, memory) = (&self.now.run, &self.now.memory);
        let series = self.stepper.series(&self.model, run, memory, &settings);
        let Some(series) = series.filter(|_| instants.contacts.has_constant_ratios) else { return false };
        let along = contact.slip.as_ref().and_then(|slip| series.friction(run, slip.level));
        let Some(along) = along.filter(|_| series.reaction(run, contact.constraint, &mut reaction)) else {
            return false;
        };
        let ratio = instants.contacts.restitutions[index];
        [-1.0, 1.0].into_iter().all(|side| {
            let mut margin = reaction.map(|coefficient| side * coefficient);
            margin.iter_mut().zip(along.limit).for_each(|(margin, limit)| *margin += ratio * limit);
            stays_positive(&margin[..along.limit.len()], step)
        })
    }

    /// True if the normal forces clearly keep their signs.
    fn has_signs(&self, data: &Contacts, index: usize, step: [f64; 2]) -> bool {
        let (contact, settings) = (&data.all[index], self.settings());
        let Some(slip) = contact.slip.as_ref().filter(|_| !contact.state.signs.is_empty()) else { return true };
        let (run, memory) = (&self.now.run, &self.now.memory);
        let series = self.stepper.series(&self.model, run, memory, &settings);
        let Some(along) = series.and_then(|series| series.friction(run, slip.level)) else { return false };
        contact.state.signs.iter().zip(along.sums).all(|(&sign, sum)| {
            let sign = self.now.state.discrete()[sign as usize];
            stays_positive(&sum.map(|coefficient| sign * coefficient)[..along.limit.len()], step)
        })
    }
}

/// True if a series stays positive in a step, also with ten times its last terms less.
fn stays_positive(polynomial: &[f64], step: [f64; 2]) -> bool {
    let scaled = scaled(polynomial, step[1] - step[0]);
    let scaled = &scaled[..polynomial.len()];
    let tail: f64 = scaled.iter().rev().take(2).map(|coefficient| coefficient.abs()).sum();
    scaled[0] > 0.0 && descent::first(scaled, |_| tail) == Descent::None
}
