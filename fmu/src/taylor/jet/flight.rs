//! Motion while no contact is closed and nothing sticks: the series need none of their loop equations, which would only be carried along.

use super::Jet;
use crate::model::Model;
use crate::program::arm_form::{ArmForm, Cause, NormalForce, Solved};

/// The row of a contact whose loop equation is left out.
const NO_ROW: u32 = u32::MAX;

impl ArmForm {
    /// The form without the loop equations of contacts, and the rows that remain. None if there are no contacts, if loop equations repeat others, or if anything but a normal force follows from the reactions of contacts.
    fn without_contacts(&self) -> Option<(Self, Vec<usize>)> {
        if self.contacts.is_empty() || self.repeating() > 0 {
            return None;
        }
        let is_contact = |row: usize| self.contacts.iter().any(|contact| contact.row as usize == row);
        let kept: Vec<usize> = (0..self.rows.len()).filter(|row| !is_contact(*row)).collect();
        let place = |row: u32| kept.iter().position(|kept| *kept == row as usize).map(|place| place as u32);
        let mut form = self.clone();
        form.rows = kept.iter().map(|&row| self.rows[row].clone()).collect();
        form.contacts.iter_mut().for_each(|contact| contact.row = NO_ROW);
        for push in &mut form.pushes {
            if let Cause::Reaction { row, .. } = &mut push.value {
                *row = place(*row)?;
            }
        }
        let pairs = form.auxiliary.iter_mut().map(|auxiliary| &mut auxiliary.row);
        for row in pairs.chain(form.rods.iter_mut().map(|rod| &mut rod.row)) {
            let first = place(*row)?;
            (place(*row + 1) == Some(first + 1)).then_some(())?;
            *row = first;
        }
        let frictions = form.contacts.iter_mut().filter_map(|contact| contact.friction.as_mut());
        for force in frictions.flat_map(|friction| &mut friction.normal) {
            let sums = match force {
                NormalForce::Signed(_, one) => std::slice::from_mut(one),
                NormalForce::Magnitude(components) => &mut components[..],
            };
            for sum in sums {
                // What does not hold does not react.
                sum.terms.retain(|(solved, _)| !matches!(solved, Solved::Row(row) if place(*row).is_none()));
                for (solved, _) in &mut sum.terms {
                    if let Solved::Row(row) = solved {
                        *row = place(*row)?;
                    }
                }
            }
        }
        Some((form, kept))
    }
}

impl Jet {
    /// The series of a flight, on the heap: its polynomials lie in the same places. None where it would be the same, or where a part depends on the reactions of contacts.
    pub fn of_flight(&self, model: &Model) -> Option<Box<Self>> {
        let (form, kept) = self.form.without_contacts()?;
        let mut jet = Self::boxed_of(model, &form);
        jet.reactions_kept = self.reactions_kept.clone();
        jet.groups = kept.iter().map(|&row| self.groups[row]).collect();
        jet.left_out = vec![0.0; self.groups()];
        for (row, (scale, group)) in self.row_scales.iter().zip(&self.groups).enumerate() {
            if !kept.contains(&row) {
                // An equation that does not hold is its reaction = 0.
                jet.left_out[*group] += scale * scale;
            }
        }
        Some(jet)
    }

    /// True for the series of a flight.
    pub fn is_of_flight(&self) -> bool {
        !self.left_out.is_empty()
    }

    /// True while no contact is closed and nothing sticks.
    pub fn flies(&self, registers: &[f64]) -> bool {
        let results = &self.form.coefficients.results;
        self.form.contacts.iter().all(|contact| registers[results[contact.open as usize] as usize] != 0.0)
    }
}
