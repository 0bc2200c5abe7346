//! The start of a step: pose, matrix, and the motion put back on the loops.

use super::{ByArm, Slide, Turn};
use crate::linalg::inverse::LEFT;
use crate::linalg::number::Elementary;
use crate::program::arm_form::{Factor, Place};

impl<N: Elementary> ByArm<N> {
    /// Everything but the first order of accelerations. Is there a series that needs no pivots?
    #[inline(always)]
    pub(super) fn begin_any(&mut self, order: usize, motion: &[N]) -> bool {
        self.laws.begin(&self.coefficients, order);
        let (positions, rates) = motion.split_at(self.form.coordinates.len());
        self.load(0, positions);
        self.turn();
        let regular = self.factor();
        let amplification = self.amplification();
        self.load(1, rates);
        self.close(0);
        self.turn_rates();
        self.close(1);
        self.weigh();
        for k in 0..2 {
            self.laws.positions(&self.coefficients, k, &self.arms);
        }
        // Not a number is not alike.
        regular && N::all(1.0 / LEFT).exceeds(amplification)
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

    /// One Newton step of positions or rates onto the loops, in the metric of the masses.
    #[inline(always)]
    fn close(&mut self, order: usize) {
        if self.gaps.is_empty() {
            return;
        }
        self.gap(order);
        let unknowns = self.unknowns.len();
        self.vector[..unknowns].fill(N::ZERO);
        for (place, gap) in self.vector[unknowns..].iter_mut().zip(&self.gaps) {
            *place = -*gap;
        }
        self.factors.solve_by_rows(&self.vector, &mut self.solution);
        for (change, &arm) in self.solution.iter().zip(&self.unknowns) {
            self.arms[arm].value[order] += *change;
        }
        if order == 0 { self.turn() } else { self.turn_rates() }
    }

    /// What counts of each unknown: the reciprocal of its rate, or of the least that counts relative to itself.
    #[inline(always)]
    fn weigh(&mut self) {
        for (&arm, least) in self.unknowns.iter().zip(&self.least_rates) {
            let arm = &mut self.arms[arm];
            arm.weight = N::all(*least).larger(arm.value[1]).reciprocal();
        }
    }

    /// Factors the matrix of the pose; has it factors?
    #[inline(always)]
    fn factor(&mut self) -> bool {
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
