//! One order after the other.

use super::{ByArm, Slide, Turn};
use crate::linalg::number::Elementary;
use crate::program::arm_form::Factor;
use crate::program::arm_form::ORDERS;

impl<N: Elementary> ByArm<N> {
    /// Orders k of accelerations from the first to the last, orders k + 2 of positions; all lower ones are known.
    #[inline(always)]
    pub(super) fn advance_all(&mut self, first: usize, last: usize) {
        let lawful = !self.laws.are_none();
        for k in first..(last + 1).min(ORDERS - 2) {
            if lawful {
                self.laws.rates(&self.coefficients, k, &self.arms);
            }
            self.predict(k);
            self.load_arms(k);
            self.balance(k);
            self.factors.solve_by_rows(&self.vector, &mut self.solution);
            self.correct(k);
            if lawful {
                self.laws.positions(&self.coefficients, k + 2, &self.arms);
            }
        }
    }

    /// Second derivatives of the arms without the new accelerations, and moments without the new forces.
    #[inline(always)]
    fn predict(&mut self, k: usize) {
        let scale = ((k + 1) * (k + 2)) as f64;
        for frame in 0..self.turns.len() {
            self.convolve_frame(frame, k);
            if let Some(slot) = self.turns[frame].signal {
                self.accelerate(frame, self.laws.get(slot, k + 2).times(scale));
            }
        }
        if self.slides.is_empty() {
            return;
        }
        self.place_frames(k + 2, scale);
        for index in 0..self.slides.len() {
            if let Slide { arm, frame: Some(frame), .. } = self.slides[index] {
                self.arms[arm].inner = self.convolve_product(arm, frame, k);
            }
        }
        self.lengthen(k, scale, false);
    }

    /// Order k of (omega x b)' without its newest term, and of b x G without its newest force.
    #[inline(always)]
    fn convolve_frame(&mut self, frame: usize, k: usize) {
        let arm = &mut self.arms[frame];
        let omega = arm.rate[0];
        let (mut x, mut y) = (omega * arm.y[k + 1], omega * arm.x[k + 1]);
        let (mut left, mut right) = (N::ZERO, N::ZERO);
        let (bx, by, rates) = (&arm.x[1..k + 1], &arm.y[1..k + 1], &arm.rate[1..k + 1]);
        let forces = arm.force[0][..k].iter().zip(&arm.force[1][..k]);
        for (((cosine, sine), rate), (fx, fy)) in bx.iter().rev().zip(by.iter().rev()).zip(rates).zip(forces) {
            x += *rate * *sine;
            y += *rate * *cosine;
            left += *cosine * *fy;
            right += *sine * *fx;
        }
        let scale = (k + 1) as f64;
        arm.second = [x.times(-scale), y.times(scale)];
        arm.residual = left - right;
    }

    /// Adds an angular acceleration to the second derivative of a frame's arm.
    #[inline(always)]
    fn accelerate(&mut self, frame: usize, alpha: N) {
        let arm = &mut self.arms[frame];
        arm.second[0] -= alpha * arm.y[0];
        arm.second[1] += alpha * arm.x[0];
    }

    /// Coefficients of the frames' arms from their second derivatives.
    #[inline(always)]
    fn place_frames(&mut self, order: usize, scale: f64) {
        let share = N::all(1.0 / scale);
        for arm in &mut self.arms[..self.turns.len()] {
            arm.x[order] = arm.second[0] * share;
            arm.y[order] = arm.second[1] * share;
        }
    }

    /// sum of sigma_j e_(k+2-j) without its ends.
    #[inline(always)]
    fn convolve_product(&self, arm: usize, frame: usize, k: usize) -> [N; 2] {
        let (arm, frame) = (&self.arms[arm], &self.arms[frame]);
        let (length, ex, ey) = (&arm.rate[1..k + 2], &frame.x[1..k + 2], &frame.y[1..k + 2]);
        let (mut x, mut y, mut j) = (N::ZERO, N::ZERO, 0);
        while j < k + 1 {
            x += length[j] * ex[k - j];
            y += length[j] * ey[k - j];
            j += 1;
        }
        [x, y]
    }

    /// Products and world arms at order k + 2, with or without the displacements just found.
    #[inline(always)]
    fn lengthen(&mut self, k: usize, scale: f64, found: bool) {
        for index in 0..self.slides.len() {
            let Slide { arm, factor, frame } = self.slides[index];
            let is_known = found || factor != Factor::Unknown;
            let length = if is_known { self.length(arm, factor, k + 2) } else { N::ZERO };
            let ends = frame.map(|frame| {
                let (start, frame) = (self.arms[arm].rate[0], &self.arms[frame]);
                [length * frame.x[0] + start * frame.x[k + 2], length * frame.y[0] + start * frame.y[k + 2]]
            });
            let arm = &mut self.arms[arm];
            arm.rate[k + 2] = length;
            let [x, y] = ends.map_or([length, N::ZERO], |[x, y]| [arm.inner[0] + x, arm.inner[1] + y]);
            (arm.x[k + 2], arm.y[k + 2]) = (x, y);
            arm.second = [x.times(scale), y.times(scale)];
        }
    }

    /// Minus the loads on arms.
    #[inline(always)]
    pub(super) fn load_arms(&mut self, k: usize) {
        if !self.loads.act(k) {
            return;
        }
        for arm in &mut self.arms {
            arm.applied = [N::ZERO; 2];
        }
        for load in self.loads.at(k) {
            let [fx, fy] = load.factors.map(|factor| self.coefficients[factor as usize]);
            let value = load.value.map_or(N::all(1.0), |slot| self.laws.get(slot, k));
            let applied = &mut self.arms[load.place].applied;
            applied[0] -= fx * value;
            applied[1] -= fy * value;
        }
    }

    /// Right-hand sides: the residuals of balance and loops without the new accelerations and reactions.
    #[inline(always)]
    fn balance(&mut self, k: usize) {
        for arm in 0..self.arms.len() {
            let force = self.coupling.add(&self.coefficients, &self.arms, arm, self.arms[arm].applied);
            self.push(arm, k, force);
        }
        for arm in &mut self.arms[..self.turns.len()] {
            arm.residual += arm.x[0] * arm.force[1][k] - arm.y[0] * arm.force[0][k];
        }
        for index in 0..self.slides.len() {
            self.balance_slide(self.slides[index], k);
        }
        for frame in 0..self.turns.len() {
            self.share_moment(frame, k);
        }
        for push in self.pushes.at(k) {
            let value = push.value.map_or(N::all(1.0), |slot| self.laws.get(slot, k));
            self.arms[push.place].residual -= self.coefficients[push.factors[0] as usize] * value;
        }
        let (balanced, closed) = self.vector.split_at_mut(self.unknowns.len());
        for (place, arm) in balanced.iter_mut().zip(&self.unknowns) {
            *place = -self.arms[*arm].residual;
        }
        let scale = ((k + 1) * (k + 2)) as f64;
        for (index, (place, row)) in closed.iter_mut().zip(&self.form.rows).enumerate() {
            let mut sum = self.rows.sum(&self.coefficients, &self.arms, index, |arm| arm.second);
            for &(slot, factor) in &row.signals {
                sum += self.coefficients[factor as usize] * self.laws.get(slot, k + 2).times(scale);
            }
            *place = -sum;
        }
    }

    /// A frame whose angle is not its own unknown hands its moment on; the inertia resists what a signal does.
    #[inline(always)]
    fn share_moment(&mut self, frame: usize, k: usize) {
        let Turn { unknown, signal, inertia } = self.turns[frame];
        let Some(unknown) = unknown else { return };
        if unknown != frame {
            let own = self.arms[frame].residual;
            self.arms[unknown].residual += own;
        }
        if let Some(slot) = signal {
            let alpha = self.laws.get(slot, k + 2).times(((k + 1) * (k + 2)) as f64);
            self.arms[unknown].residual += self.coefficients[inertia as usize] * alpha;
        }
    }

    /// Order k of e . G, and of the moment of a product, which belongs to the angle of its frame.
    #[inline(always)]
    fn balance_slide(&mut self, slide: Slide, k: usize) {
        let arm = &self.arms[slide.arm];
        let Some(frame) = slide.frame else {
            self.arms[slide.arm].residual = arm.force[0][k];
            return;
        };
        let (gx, gy) = (&arm.force[0][..k + 1], &arm.force[1][..k + 1]);
        let (ex, ey) = (&self.arms[frame].x[..k + 1], &self.arms[frame].y[..k + 1]);
        let (bx, by) = (&arm.x[..k + 1], &arm.y[..k + 1]);
        let (mut pull, mut moment, mut j) = (N::ZERO, N::ZERO, 0);
        while j < k + 1 {
            pull += ex[j] * gx[k - j] + ey[j] * gy[k - j];
            moment += bx[j] * gy[k - j] - by[j] * gx[k - j];
            j += 1;
        }
        self.arms[slide.arm].residual = pull;
        if let Some(unknown) = self.turns[frame].unknown {
            self.arms[unknown].residual += moment;
        }
    }

    /// Everything at the new order.
    #[inline(always)]
    fn correct(&mut self, k: usize) {
        let scale = ((k + 1) * (k + 2)) as f64;
        let share = N::all(1.0 / scale);
        for (found, &arm) in self.solution.iter().zip(&self.unknowns) {
            let arm = &mut self.arms[arm];
            (arm.value[k + 2], arm.residual) = (*found * share, *found);
        }
        for frame in 0..self.turns.len() {
            let Turn { unknown, signal, .. } = self.turns[frame];
            let own = unknown.map_or(N::ZERO, |unknown| self.arms[unknown].residual);
            let alpha = signal.map_or(own, |slot| own + self.laws.get(slot, k + 2).times(scale));
            self.arms[frame].rate[k + 1] = alpha.times(1.0 / (k + 1) as f64);
            self.accelerate(frame, own);
        }
        self.place_frames(k + 2, scale);
        self.lengthen(k, scale, true);
        let reactions = self.unknowns.len();
        for arm in 0..self.arms.len() {
            let (applied, reactions) = (self.arms[arm].applied, &self.solution[reactions..]);
            let force = self.rows.react(&self.coefficients, reactions, arm, applied);
            let force = self.coupling.add(&self.coefficients, &self.arms, arm, force);
            self.push(arm, k, force);
        }
    }

    /// The force of order k on an arm.
    #[inline(always)]
    fn push(&mut self, arm: usize, k: usize, force: [N; 2]) {
        let places = &mut self.arms[arm].force;
        (places[0][k], places[1][k]) = (force[0], force[1]);
    }
}
