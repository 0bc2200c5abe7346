//! How far from a pose the nearest one can be in which loop equations depend on each other.
//!
//! With the rows J of a pose let P be changes of the unknowns that open one loop equation each: J P = 1. If a combination l of the rows of another pose vanishes,
//! l J' = 0, then l = l (J - J') P, so that some row of |J - J'| |P| sums up to one or more. Rows change by no more than their arms turn and stretch.

use super::Jet;
use crate::linalg::lane::{Lane, ZERO, add, by_width, multiply, plus, splat};
use crate::linalg::matrix::Matrix;
use crate::math;
use crate::program::arm_form::Factor;

/// Storage for the changes of a step.
#[derive(Clone, Debug)]
pub struct Changes {
    /// How far each unknown moves, by places.
    moved: Vec<Lane>,
    /// How far each unknown moves if all loop equations open by their scales, whatever their signs, by places.
    opening: Vec<Lane>,
    /// By how much derivatives of arms change, by their places.
    derivatives: Vec<f64>,
    rows: Vec<f64>,
}

impl Jet {
    /// Storage for [`Jet::stays_clear`].
    pub fn changes(&self) -> Changes {
        let (all, places) = (self.shape.all(), self.shape.places());
        Changes {
            moved: vec![ZERO; all],
            opening: vec![ZERO; all],
            derivatives: vec![0.0; 2 * places],
            rows: vec![0.0; self.form.rows.len()],
        }
    }

    /// True if there is no pose in which loop equations depend on each other on the way along a polynomial, so long, from the pose that has just been begun. False where
    /// that is not known.
    pub fn stays_clear(&self, changes: &mut Changes, (polynomial, order): (&[f64], usize), h: f64) -> bool {
        if self.is_open() && self.is_of_flight() {
            return true;
        }
        let Matrix::Whole(inverse) = &self.matrix else { return false };
        if inverse.repeats() || !self.terms.pairs.is_empty() || !self.curves.is_empty() || self.has_signals() {
            return false;
        }
        changes.opening.fill(ZERO);
        for (equation, scale) in (self.unknowns.len()..).zip(&self.row_scales) {
            inverse.add_sizes(equation, *scale, &mut changes.opening);
        }
        self.move_unknowns(&mut changes.moved, polynomial, order, h);
        self.move_arms(changes, polynomial);
        self.largest_change(changes) < 1.0
    }

    /// Do arms turn or stretch with signals?
    fn has_signals(&self) -> bool {
        let is_signal = |factor: &Factor| matches!(factor, Factor::Signal(_));
        self.form.frames.iter().any(|frame| frame.signal.is_some())
            || self.form.products.iter().any(|product| is_signal(&product.factor))
    }

    by_width! {
        /// How far each unknown moves along a polynomial, back and forth.
        fn move_unknowns(&self: Jet, moved: &mut [Lane], polynomial: &[f64], order: usize, h: f64) = move_unknowns_any
    }

    #[inline(always)]
    fn move_unknowns_any(&self, moved: &mut [Lane], polynomial: &[f64], order: usize, h: f64) {
        let (all, [step, square]) = (self.shape.all(), [h, h * h].map(splat));
        let coefficients: &[Lane] = polynomial.as_chunks().0;
        let size = |order: usize, place: usize| coefficients[order * all + place].map(f64::abs);
        for place in 0..all {
            // Two sums, each of every other order: neither waits for the other.
            let (mut odd, mut even) = (if order % 2 == 1 { size(order, place) } else { ZERO }, ZERO);
            for half in (1..=order / 2).rev() {
                even = multiply(square, add(even, size(2 * half, place)));
                odd = plus(size(2 * half - 1, place), square, odd);
            }
            moved[place] = plus(even, step, odd);
        }
    }

    /// By how much arms and unit vectors change at most.
    fn move_arms(&self, changes: &mut Changes, start: &[f64]) {
        let (moved, places) = (changes.moved.as_flattened(), self.shape.places());
        changes.derivatives.fill(0.0);
        for (change, unknown) in changes.derivatives.iter_mut().zip(&self.turned_by) {
            *change = unknown.map_or(0.0, |unknown| moved[unknown]);
        }
        for (arm, product) in (self.form.frames.len() as u32..).zip(&self.form.products) {
            let (place, turned) = (self.shape.place(arm), changes.derivatives[product.frame as usize]);
            let longest = start[place].abs() + moved[place];
            changes.derivatives[place] = moved[place] + longest * turned;
            changes.derivatives[places + place] = turned;
        }
    }

    /// The largest sum of a row of |J - J'| |P|, in units of the scales.
    fn largest_change(&self, changes: &mut Changes) -> f64 {
        let (first, opening) = (self.unknowns.len(), changes.opening.as_flattened());
        changes.rows.fill(0.0);
        for (row, column, slope) in self.terms.slopes() {
            let change = slope.size(&self.coefficients) * changes.derivatives[slope.derivative];
            changes.rows[row - first] += change * opening[self.unknowns[column]];
        }
        let relative = changes.rows.iter().zip(&self.row_scales).map(|(sum, scale)| sum / scale);
        relative.fold(0.0, math::maximum)
    }
}
