//! Loop equations with a function f of the unknowns, such as a cam's law: s - f(theta) = 0.
//!
//! At every order f is its own series without the newest coefficients of the unknowns, and their multiple by the slope of f where the step begins: so an entry of the
//! matrix is that slope, and the right-hand side is the rest. A reaction l loads theta by f' l, a product of series.

use std::f64::consts::TAU;

use super::{Coefficient, Jet};
use crate::linalg::lane::splat;
use crate::linalg::number::Elementary;
use crate::model::Model;
use crate::program::GapMeasure;
use crate::program::arm_form::{ArmForm, Cause, ORDERS, Push, Slot};
use crate::taylor::products::convolution;
use crate::taylor::tape::Numbers;

/// How a loop equation changes with an unknown, where that is no constant.
#[derive(Clone, Debug)]
pub(super) struct CurveSlope<N> {
    pub(super) row: usize,
    /// The place of the unknown.
    pub(super) place: usize,
    slope: Slot,
    factor: u32,
    /// The reaction, by orders.
    reaction: Numbers<N>,
}

/// All of a form.
pub(super) fn curves<N: Elementary>(form: &ArmForm, place: impl Fn(u32) -> usize) -> Vec<CurveSlope<N>> {
    let curve = |&Push { unknown, value, factor }: &Push| match value {
        Cause::Reaction { row, slope } => {
            Some(CurveSlope { row: row as usize, place: place(unknown), slope, factor, reaction: [N::ZERO; ORDERS] })
        }
        Cause::One | Cause::Series(_) => None,
    };
    form.pushes.iter().filter_map(curve).collect()
}

/// Loop equations that whole turns leave closed, also where the function is one of time because a driver moves its angle.
pub(super) fn direction_rows(model: &Model, form: &ArmForm) -> Vec<usize> {
    let measure = |row: usize| model.program().constraints[form.rows[row].constraint as usize].measure;
    (0..form.rows.len()).filter(|&row| measure(row) == GapMeasure::Direction).collect()
}

#[expect(private_bounds, reason = "there are two kinds of numbers")]
impl<N: Coefficient, const L: usize> Jet<N, L> {
    /// Takes whole turns off the gaps of loop equations that these leave closed.
    #[inline(always)]
    pub(super) fn take_off_turns(&mut self) {
        let gaps = self.gaps.as_flattened_mut();
        for &row in &self.direction_rows {
            gaps[row] -= N::all(TAU * (gaps[row].value() / TAU).round());
        }
    }

    /// The functions at one of the first two orders, of which all is known.
    #[inline(always)]
    pub(super) fn follow_curves(&mut self, order: usize) {
        if !self.curves.is_empty() {
            self.follow(order);
        }
    }

    /// The functions at order k + 2 without the newest coefficients of the unknowns.
    #[inline(always)]
    pub(super) fn foresee_curves(&mut self, k: usize) {
        if self.curves.is_empty() {
            return;
        }
        let (all, scale) = (self.shape.all(), ((k + 1) * (k + 2)) as f64);
        self.values[(k + 2) * all..][..all].fill(splat(N::ZERO));
        self.place_frames(k + 2, scale);
        self.follow(k + 2);
    }

    /// Entries of the matrix.
    #[inline(always)]
    pub(super) fn slope_curves(&mut self) {
        for (slope, curve) in self.terms.curve_slopes.iter_mut().zip(&self.curves) {
            *slope = self.coefficients[curve.factor as usize] * self.scalars.get(curve.slope, 0);
        }
    }

    /// Adds what reactions of lower orders do to the residuals of the unknowns.
    #[inline(always)]
    pub(super) fn press_curves(&mut self, k: usize) {
        let residual = self.residual_lanes.as_flattened_mut();
        for curve in &mut self.curves {
            curve.reaction[k] = N::ZERO;
            let Some(slope) = self.scalars.series(curve.slope).first_chunk() else { continue };
            residual[curve.place] += self.coefficients[curve.factor as usize] * convolution(slope, &curve.reaction, k);
        }
    }

    /// Keeps the reactions just found.
    #[inline(always)]
    pub(super) fn keep_reactions(&mut self, k: usize) {
        if self.reactions_kept.are_kept() {
            self.reactions_kept.keep(k, &self.solution[self.shape.all()..]);
        }
        let reactions = &self.solution.as_flattened()[self.shape.places()..];
        for curve in &mut self.curves {
            curve.reaction[k] = reactions[curve.row];
        }
    }
}
