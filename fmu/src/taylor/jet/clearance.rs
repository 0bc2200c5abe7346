//! How far from a pose the nearest one can be in which loop equations depend on each other.
//!
//! With the rows J of a pose let P be changes of the unknowns that open one loop equation each: J P = 1. If a combination l of the rows of another pose vanishes,
//! l J' = 0, then l = l (J - J') P, so that the matrix |J - J'| |P| has an eigenvalue of one or more. It has none if for some positive w each entry of |J - J'| |P| w is smaller
//! than that of w (Collatz and Wielandt: Horn and Johnson, Matrix Analysis, 2013, 8.1.29). Rows change by no more than their arms turn and stretch. A step is compared
//! with the pose at its end, or each half of it with the pose at its own side.

use super::Jet;
use super::terms::Change;
use crate::linalg::lane::{Lane, ZERO, plus, splat};
use crate::linalg::matrix::Matrix;
use crate::program::arm_form::Factor;

/// So many w are tried, each what the matrix makes of the one before: loops that hang on others open by more.
const TRIALS: usize = 4;
/// Of the w before this share stays, so that none of its entries vanishes.
const KEPT: f64 = 0.01;

/// Storage for the changes of a step.
#[derive(Clone, Debug)]
pub struct Changes {
    /// |P| where the step begins and at its end, by loop equations and places; whether they are known.
    openings: [Vec<Lane>; 2],
    known: [bool; 2],
    /// Do arms turn and stretch with unknowns only?
    unsignalled: bool,
    /// How far each unknown moves, by places.
    moved: Vec<Lane>,
    /// How long derivatives of arms are at the pose that others are compared with, and by how much they change, by their places.
    lengths: Vec<f64>,
    derivatives: Vec<f64>,
    /// Changes of the rows' entries.
    entries: Vec<Change>,
    /// How far each unknown moves if all loop equations open by w, whatever their signs, by places.
    opening: Vec<Lane>,
    /// w, and what the matrix makes of it, by equations.
    weights: Vec<f64>,
    rows: Vec<f64>,
}

/// Of a step.
#[derive(Clone, Copy)]
enum Part {
    Whole,
    First,
    Second,
}

impl Changes {
    /// The end of the step has become the start of the next one.
    pub fn roll(&mut self) {
        self.openings.swap(0, 1);
        self.known = [self.known[1], false];
    }

    /// Nothing is known of the pose at the end of the step.
    pub fn forget_end(&mut self) {
        self.known[1] = false;
    }
}

impl Jet {
    /// Storage for [`Jet::stays_clear`].
    pub fn changes(&self) -> Changes {
        let (all, places, rows) = (self.shape.all(), self.shape.places(), self.equations.iter().flatten().count());
        let opening = if matches!(self.matrix, Matrix::Whole(_)) { rows * all } else { 0 };
        Changes {
            openings: [vec![ZERO; opening], vec![ZERO; opening]],
            known: [false; 2],
            unsignalled: !self.has_signals(),
            moved: vec![ZERO; all],
            lengths: vec![1.0; 2 * places],
            derivatives: vec![0.0; 2 * places],
            entries: Vec::with_capacity(self.terms.slopes()),
            opening: vec![ZERO; all],
            weights: vec![0.0; rows],
            rows: vec![0.0; rows],
        }
    }

    /// Takes note of the pose that has just been begun, as the end of the step.
    pub fn note_openings(&self, changes: &mut Changes) {
        changes.known[1] = false;
        let Matrix::Whole(inverse) = &self.matrix else { return };
        let (first, all) = (self.unknowns.len(), self.shape.all());
        let known = changes.openings[1].len() == changes.rows.len() * all
            && changes.unsignalled
            && !inverse.repeats()
            && self.terms.pairs.turn_rigidly(&self.coefficients);
        if known {
            let openings = changes.openings[1].chunks_exact_mut(all.max(1));
            (first..).zip(openings).for_each(|(equation, opening)| inverse.sizes(equation, opening));
            changes.known[1] = true;
        }
    }

    /// Is there no pose in which loop equations depend on each other on the way along a polynomial, so long, from the pose noted as its start to the one noted as its
    /// end, which has just been begun? False where that is not known.
    pub fn stays_clear(&self, changes: &mut Changes, polynomial: (&[f64], usize), h: f64) -> bool {
        let end = self.values.as_flattened();
        changes.known[1]
            && (self.keeps_apart(changes, (1, end), (polynomial, Part::Whole), h)
                || changes.known[0]
                    && self.keeps_apart(changes, (0, polynomial.0), (polynomial, Part::First), h)
                    && self.keeps_apart(changes, (1, end), (polynomial, Part::Second), h))
    }

    /// Do arms turn or stretch with signals?
    fn has_signals(&self) -> bool {
        let is_signal = |factor: &Factor| matches!(factor, Factor::Signal(_));
        self.form.frames.iter().any(|frame| frame.signal.is_some())
            || self.form.products.iter().any(|product| is_signal(&product.factor))
    }

    /// How far each unknown moves at most along a part of a polynomial, from the start of it or up to its end.
    fn move_unknowns(&self, moved: &mut [Lane], (polynomial, order): (&[f64], usize), part: Part, h: f64) {
        let (all, mut whole, mut half) = (self.shape.all(), 1.0, 1.0);
        moved.fill(ZERO);
        for coefficients in polynomial.as_chunks().0.chunks_exact(all).take(order + 1).skip(1) {
            (whole, half) = (whole * h, half * 0.5 * h);
            let power = match part {
                Part::Whole => whole,
                Part::First => half,
                Part::Second => whole - half,
            };
            for (moved, coefficients) in moved.iter_mut().zip(coefficients) {
                *moved = plus(*moved, splat(power), coefficients.map(f64::abs));
            }
        }
    }

    /// By how much arms and unit vectors change at most on the way to or from a pose, whose unknowns are given.
    fn move_arms(&self, changes: &mut Changes, pose: &[f64]) {
        let Changes { moved, lengths, derivatives, .. } = changes;
        let (moved, places) = (moved.as_flattened(), self.shape.places());
        derivatives.fill(0.0);
        for (change, unknown) in derivatives.iter_mut().zip(&self.turned_by) {
            *change = unknown.map_or(0.0, |unknown| moved[unknown]);
        }
        for (arm, product) in (self.form.frames.len() as u32..).zip(&self.form.products) {
            let (place, turned) = (self.shape.place(arm), derivatives[product.frame as usize]);
            lengths[place] = pose[place].abs();
            derivatives[place] = moved[place] + lengths[place] * turned;
            derivatives[places + place] = turned;
        }
    }

    /// Do loop equations stay independent along a part of a polynomial, compared with the pose at one side of it?
    fn keeps_apart(
        &self,
        changes: &mut Changes,
        (side, pose): (usize, &[f64]),
        (polynomial, part): ((&[f64], usize), Part),
        h: f64,
    ) -> bool {
        self.move_unknowns(&mut changes.moved, polynomial, part, h);
        self.move_arms(changes, pose);
        self.terms.changes(&self.coefficients, [&changes.lengths, &changes.derivatives], &mut changes.entries);
        let equations = self.equations.iter().zip(&self.row_scales).filter(|(equation, _)| equation.is_some());
        changes.weights.iter_mut().zip(equations).for_each(|(weight, (_, scale))| *weight = *scale);
        for _ in 0..TRIALS {
            self.multiply(changes, side);
            let Changes { weights, rows, .. } = &mut *changes;
            let growths = || rows.iter().zip(&*weights).map(|(row, weight)| row / weight);
            // Written so that NaN is not apart.
            if growths().all(|growth| growth < 1.0) {
                return true;
            }
            if growths().all(|growth| growth >= 1.0) {
                return false;
            }
            weights.iter_mut().zip(&*rows).for_each(|(weight, row)| *weight = KEPT * *weight + row);
        }
        false
    }

    /// |J - J'| |P| w
    fn multiply(&self, changes: &mut Changes, side: usize) {
        let Changes { openings, entries, opening, weights, rows, .. } = changes;
        let first = self.unknowns.len();
        opening.fill(ZERO);
        for (weight, sizes) in weights.iter().zip(openings[side].chunks_exact(opening.len().max(1))) {
            for (sum, sizes) in opening.iter_mut().zip(sizes) {
                *sum = plus(*sum, splat(*weight), *sizes);
            }
        }
        rows.fill(0.0);
        for Change { row, column, by } in &*entries {
            rows[row - first] += by * opening.as_flattened()[self.unknowns[*column]];
        }
    }
}
