//! The start of a step of several motions: their poses, matrices, and the motions put back on the loops.

use super::super::start::CLOSED;
use super::{Members, Slide, Turn};
use crate::linalg::inverse::LEFT;
use crate::linalg::lane::{WIDTH, by_width};
use crate::linalg::many::{Elementary, Many, Number, Which};
use crate::program::arm_form::{Factor, Place};

/// What is known of the start of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Begun<N: Number> {
    /// How far the loops were open, relative to their scales.
    pub open: N,
    /// Which motions have a series that needs no pivots.
    pub regular: N::Which,
    /// How many times the accelerations multiply rounding errors of the masses and forces.
    pub amplification: N,
}

impl Members<Many> {
    /// Begins at (q, v) of several members, as [`super::Jet::begin`] does for one.
    pub(crate) fn begin(&mut self, order: usize, motion: &[Many]) -> Begun<Many> {
        let begun = self.begin_at(order, motion);
        self.advance(0, 0);
        begun
    }

    by_width! {
        fn begin_at(&mut self: Members<Many>, order: usize, motion: &[Many]) -> Begun<Many> = begin_any
    }

    /// As [`super::Jet::reciprocal_pivots`], of one member.
    pub fn reciprocal_pivots(&self, member: usize, values: &mut [f64]) {
        values.fill(0.0);
        for ((row, scale), group) in self.row_scales.iter().enumerate().zip(&self.groups) {
            let own = self.factors.diagonal(self.unknowns.len() + row).0[member].abs();
            values[*group] += scale * scale * own;
        }
    }

    /// Which motions are finite where the step begins?
    pub fn finite(&self) -> [bool; WIDTH] {
        let mut sum = Many::ZERO;
        for &arm in &self.unknowns {
            sum += (self.arms[arm].value[0] + self.arms[arm].value[1]).times(0.0);
        }
        sum.0.map(|sum| sum == 0.0)
    }
}

impl<N: Elementary> Members<N> {
    /// Everything but the first order of accelerations.
    #[inline(always)]
    pub(super) fn begin_any(&mut self, order: usize, motion: &[N]) -> Begun<N> {
        self.laws.begin(&self.coefficients, order);
        let (positions, rates) = motion.split_at(self.form.coordinates.len());
        self.load(0, positions);
        self.turn();
        let regular = self.factor();
        let amplification = self.amplification();
        self.load(1, rates);
        let open = self.close(0);
        self.turn_rates();
        self.close(1);
        self.weigh();
        self.respond();
        for k in 0..2 {
            self.laws.positions(&self.coefficients, k, &self.arms);
        }
        // Not a number is not alike.
        Begun { open, regular: regular.and(N::all(1.0 / LEFT).exceeds(amplification)), amplification }
    }

    /// The unknowns of coordinates.
    #[inline(always)]
    fn load(&mut self, order: usize, motion: &[N]) {
        for &index in &self.chain {
            let value = motion[index];
            match self.form.coordinates[index] {
                Place::Displacement { arm } => self.arms[arm as usize].value[order] = value,
                Place::Angle { arm, parent, reversed } => {
                    let carried = parent.map_or(N::ZERO, |parent| self.arms[parent as usize].value[order]);
                    self.arms[arm as usize].value[order] = if reversed { carried - value } else { carried + value };
                }
            }
        }
    }

    /// One coefficient of a frame's angle.
    #[inline(always)]
    fn angle(&self, turn: Turn, order: usize) -> N {
        let own = turn.unknown.map_or(N::ZERO, |unknown| self.arms[unknown].value[order]);
        turn.signal.map_or(own, |slot| own + self.laws.get(slot, order))
    }

    /// Poses of arms from the unknowns.
    #[inline(always)]
    fn turn(&mut self) {
        for frame in 0..self.turns.len() {
            let [cosine, sine] = self.angle(self.turns[frame], 0).cosine_and_sine();
            let arm = &mut self.arms[frame];
            (arm.x[0], arm.y[0]) = (cosine, sine);
        }
        self.stretch(0);
    }

    /// Rates of arms from the rates of the unknowns.
    #[inline(always)]
    fn turn_rates(&mut self) {
        for frame in 0..self.turns.len() {
            let omega = self.angle(self.turns[frame], 1);
            let arm = &mut self.arms[frame];
            arm.rate[0] = omega;
            (arm.x[1], arm.y[1]) = (-(omega * arm.y[0]), omega * arm.x[0]);
        }
        self.stretch(1);
    }

    /// One coefficient of products and world arms, of the first two orders.
    #[inline(always)]
    fn stretch(&mut self, order: usize) {
        for index in 0..self.slides.len() {
            let Slide { arm, factor, frame } = self.slides[index];
            let length = self.length(arm, factor, order);
            self.arms[arm].rate[order] = length;
            let start = self.arms[arm].rate[0];
            let Some(frame) = frame else {
                self.arms[arm].x[order] = length;
                continue;
            };
            let (x, y) = (&self.arms[frame].x, &self.arms[frame].y);
            let (x, y) = match order {
                0 => (length * x[0], length * y[0]),
                _ => (length * x[0] + start * x[1], length * y[0] + start * y[1]),
            };
            (self.arms[arm].x[order], self.arms[arm].y[order]) = (x, y);
        }
    }

    /// One coefficient of the length of an arm.
    #[inline(always)]
    pub(super) fn length(&self, arm: usize, factor: Factor, order: usize) -> N {
        match factor {
            Factor::Unknown => self.arms[arm].value[order],
            Factor::Signal(slot) => self.laws.get(slot, order),
        }
    }

    /// One coefficient of the loop equations, of the first two orders.
    #[inline(always)]
    fn gap(&mut self, order: usize) {
        for (row, gap) in self.gaps.iter_mut().enumerate() {
            *gap = self.rows.sum(&self.coefficients, &self.arms, row, |arm| [arm.x[order], arm.y[order]]);
        }
        for (row, arm, factor) in self.terms.linear() {
            self.gaps[row] += self.coefficients[factor as usize] * self.arms[arm].value[order];
        }
        for (gap, row) in self.gaps.iter_mut().zip(&self.form.rows) {
            if order == 0 {
                *gap += self.coefficients[row.constant as usize];
            }
            for &(slot, factor) in &row.signals {
                *gap += self.coefficients[factor as usize] * self.laws.get(slot, order);
            }
        }
    }

    /// One Newton step of positions or rates onto the loops, in the metric of the masses, for those that are open. Returns how far they were.
    #[inline(always)]
    fn close(&mut self, order: usize) -> N {
        if self.gaps.is_empty() {
            return N::ZERO;
        }
        self.gap(order);
        let mut open = N::ZERO;
        for (gap, scale) in self.gaps.iter().zip(&self.row_scales) {
            open = open.larger(gap.over(N::all(*scale)));
        }
        // Not a number is not closed.
        let closed = open.is_below(CLOSED);
        if closed.is_all() {
            return open;
        }
        let unknowns = self.unknowns.len();
        self.vector[..unknowns].fill(N::ZERO);
        for (place, gap) in self.vector[unknowns..].iter_mut().zip(&self.gaps) {
            *place = (-*gap).unless(closed);
        }
        self.factors.solve_by_rows(&self.vector, &mut self.solution);
        for (change, &arm) in self.solution.iter().zip(&self.unknowns) {
            self.arms[arm].value[order] += *change;
        }
        if order == 0 {
            self.turn()
        } else {
            self.turn_rates()
        }
        open
    }

    /// What counts of each unknown: the reciprocal of its rate, or of the least that counts relative to itself.
    #[inline(always)]
    fn weigh(&mut self) {
        for (&arm, least) in self.unknowns.iter().zip(&self.least_rates) {
            let arm = &mut self.arms[arm];
            arm.weight = N::all(*least).larger(arm.value[1]).reciprocal();
        }
    }

    /// Factors the matrices of the poses; says which have factors.
    #[inline(always)]
    fn factor(&mut self) -> N::Which {
        let [dx, dy] = &mut self.derivatives;
        for ((dx, dy), arm) in dx.iter_mut().zip(&mut *dy).zip(&self.arms) {
            (*dx, *dy) = (-arm.y[0], arm.x[0]);
        }
        for &Slide { arm, frame, .. } in &self.slides {
            let place = self.arms.len() + arm;
            (dx[place], dy[place]) = match frame {
                Some(frame) => (self.arms[frame].x[0], self.arms[frame].y[0]),
                None => (N::all(1.0), N::ZERO),
            };
        }
        self.factors.clear();
        let [dx, dy] = &self.derivatives;
        self.terms.assemble_plain(&mut self.factors, &self.coefficients, [dx, dy]);
        self.factors.factor()
    }

    /// The largest share of what the pivot of an unknown is the difference of in that pivot, as [`super::Jet::amplification`].
    #[inline(always)]
    fn amplification(&self) -> N {
        let mut most = N::ZERO;
        for equation in 0..self.unknowns.len() {
            most = most.larger(self.factors.growth(equation));
        }
        most
    }
}
