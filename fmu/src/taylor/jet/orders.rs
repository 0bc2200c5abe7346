//! One order after the other.

use super::{Coefficient, Jet, Loads, ORDERS, Scatter, Series, at, back, flat, frames, series, vectors};
use crate::linalg::lane::{Lane, add, by_width, minus, multiply, plus, splat, subtract, times};
use crate::linalg::matrix::Solve;
use crate::linalg::number::Elementary;
use crate::program::arm_form::Factor;
use crate::taylor::tape::Scalars;

impl Jet {
    /// Orders k of accelerations from the first to the last, orders k + 2 of positions; all lower ones are known.
    pub fn advance(&mut self, first: usize, last: usize) {
        if self.found.orders == 0 {
            self.advance_alone(first, last);
        } else if first == 0 || last + 2 > self.found.orders {
            // A batch finds the unknowns only: what else further orders need follows from the beginning.
            self.found.orders = 0;
            self.advance_alone(first.min(1), last);
        }
    }

    by_width! {
        fn advance_alone(&mut self: Jet, first: usize, last: usize) = advance_all
    }

    #[inline(always)]
    fn advance_all(&mut self, first: usize, last: usize) {
        self.at_start = last == 0;
        self.scalars.signals(last + 2);
        let done = match self.frames {
            [1, 1, 1] => self.advance_frames::<1, 1, 1>(first, last),
            [1, 1, 2] => self.advance_frames::<1, 1, 2>(first, last),
            [1, 1, 3] => self.advance_frames::<1, 1, 3>(first, last),
            [1, 2, 2] => self.advance_frames::<1, 2, 2>(first, last),
            [1, 2, 3] => self.advance_frames::<1, 2, 3>(first, last),
            [2, 2, 2] => self.advance_frames::<2, 2, 2>(first, last),
            [2, 2, 3] => self.advance_frames::<2, 2, 3>(first, last),
            [2, 2, 4] => self.advance_frames::<2, 2, 4>(first, last),
            [3, 3, 3] => self.advance_frames::<3, 3, 3>(first, last),
            _ => None,
        };
        if done.is_none() {
            for k in first..last + 1 {
                self.advance_general(k);
            }
        }
    }

    /// Are the orders found by [`Jet::advance_frames`]?
    pub(super) fn has_kernel(&self) -> bool {
        matches!(self.frames, [1, 1, 1..=3] | [1, 2, 2..=3] | [2, 2, 2..=4] | [3, 3, 3])
    }
}

#[expect(private_bounds, reason = "there are two kinds of numbers")]
impl<N: Coefficient, const L: usize> Jet<N, L> {
    /// One order, of any mechanism.
    #[inline(always)]
    pub(super) fn advance_general(&mut self, k: usize) {
        self.scalars.rates(k, vectors(&self.x, &self.y, &self.values, self.shape.all()));
        self.predict(k);
        self.foresee_curves(k);
        if !self.limits.is_empty() {
            self.applied.iter_mut().for_each(|lanes| lanes.fill(splat(N::ZERO)));
        }
        self.loads.apply(k, &self.scalars, &self.coefficients, &mut self.applied);
        self.residual_of_balance(k);
        self.solve();
        if !self.limits.is_empty() {
            self.solve_limits(k);
        }
        self.keep_reactions(k);
        self.correct(k);
        self.follow(k + 2);
    }

    /// Scalar series of positions.
    #[inline(always)]
    pub(super) fn follow(&mut self, k: usize) {
        self.scalars.positions(k, vectors(&self.x, &self.y, &self.values, self.shape.all()));
    }

    /// Second derivatives of the arms without the new accelerations, and moments without the new forces.
    #[inline(always)]
    fn predict(&mut self, k: usize) {
        let frames = self.shape.lanes[0];
        let scale = ((k + 1) * (k + 2)) as f64;
        for lane in 0..frames {
            let of = |lanes| all(lanes, lane);
            let (arm, force) = ([of(&self.x), of(&self.y)], [of(&self.force[0]), of(&self.force[1])]);
            [self.second[0][lane], self.second[1][lane], self.residual_lanes[lane]] =
                frames::convolve(k, arm, of(&self.omega), force);
        }
        for index in 0..self.special.len() {
            let frame = self.special[index];
            let alpha = self.signal(self.form.frames[frame].signal, k + 2).times(scale);
            self.accelerate(frame, alpha);
        }
        self.second[0][frames..].fill(splat(N::ZERO));
        self.second[1][frames..].fill(splat(N::ZERO));
        if self.shape.counts[1] > 0 {
            self.place_frames(k + 2, scale);
            for lane in 0..self.shape.lanes[1] {
                self.convolve_product(k, lane);
            }
            self.lengthen(k, scale, false);
        }
        if self.shape.counts[2] > 0 {
            self.shift(k, scale, false);
        }
    }

    /// Adds an angular acceleration to the second derivative of a frame's arm.
    #[inline(always)]
    fn accelerate(&mut self, frame: usize, alpha: N) {
        let (c, s) = (self.x.as_flattened()[flat::<L>(frame, 0)], self.y.as_flattened()[flat::<L>(frame, 0)]);
        self.second[0].as_flattened_mut()[frame] -= alpha * s;
        self.second[1].as_flattened_mut()[frame] += alpha * c;
    }

    /// Coefficients of the frames' arms from their second derivatives.
    #[inline(always)]
    pub(super) fn place_frames(&mut self, order: usize, scale: f64) {
        let inverse = 1.0 / scale;
        for lane in 0..self.shape.lanes[0] {
            self.x[at(lane, order)] = times(inverse, self.second[0][lane]);
            self.y[at(lane, order)] = times(inverse, self.second[1][lane]);
        }
    }

    /// sum of sigma_j e_(k+2-j) without its ends.
    #[inline(always)]
    fn convolve_product(&mut self, k: usize, lane: usize) {
        let sigma = &series(&self.sigma, lane, k + 1)[1..];
        for axis in 0..2 {
            self.inner[axis][lane] = convolve(sigma, &series(&self.unit[axis], lane, k + 1)[1..]);
        }
    }

    /// Products at order k + 2, with or without the displacements just found.
    #[inline(always)]
    fn lengthen(&mut self, k: usize, scale: f64, found: bool) {
        let (all, order) = (self.shape.all(), k + 2);
        let (first, products) = (self.shape.lanes[0], self.shape.lanes[1]);
        for index in 0..self.shape.counts[1] {
            let product = self.form.products[index];
            self.sigma.as_flattened_mut()[flat::<L>(index, order)] = match product.factor {
                Factor::Unknown if found => self.values.as_flattened()[(order * all + first) * L + index],
                Factor::Unknown => N::ZERO,
                Factor::Signal(slot) => self.scalars.get(slot, order),
            };
            let frame = flat::<L>(product.frame as usize, order);
            self.unit[0].as_flattened_mut()[flat::<L>(index, order)] = self.x.as_flattened()[frame];
            self.unit[1].as_flattened_mut()[flat::<L>(index, order)] = self.y.as_flattened()[frame];
        }
        for lane in 0..products {
            let sigma = [self.sigma[at(lane, 0)], self.sigma[at(lane, order)]];
            for axis in 0..2 {
                let unit = [self.unit[axis][at(lane, 0)], self.unit[axis][at(lane, order)]];
                let b = plus(plus(self.inner[axis][lane], sigma[1], unit[0]), sigma[0], unit[1]);
                self.second[axis][first + lane] = times(scale, b);
                let arms = if axis == 0 { &mut self.x } else { &mut self.y };
                arms[at(first + lane, order)] = b;
            }
        }
    }

    /// World arms at order k + 2, with or without the displacements just found.
    #[inline(always)]
    fn shift(&mut self, k: usize, scale: f64, found: bool) {
        let (all, order) = (self.shape.all(), k + 2);
        let first = (self.shape.lanes[0] + self.shape.lanes[1]) * L;
        for index in 0..self.shape.counts[2] {
            let sigma = match self.form.world[index] {
                Factor::Unknown if found => self.values.as_flattened()[order * all * L + first + index],
                Factor::Unknown => N::ZERO,
                Factor::Signal(slot) => self.scalars.get(slot, order),
            };
            self.x.as_flattened_mut()[flat::<L>(first + index, order)] = sigma;
            self.second[0].as_flattened_mut()[first + index] = sigma.times(scale);
        }
    }

    /// The residuals of the equations without the new accelerations and reactions.
    #[inline(always)]
    fn residual_of_balance(&mut self, k: usize) {
        let (all, [frames, products, _]) = (self.shape.all(), self.shape.lanes);
        for axis in 0..2 {
            self.forces[axis].copy_from_slice(&self.applied[axis]);
        }
        // Moments of frames are without the newest forces.
        self.couple(k, frames);
        let [x, y] = [&self.second[0], &self.second[1]].map(|lanes| lanes.as_flattened());
        for lane in 0..self.gaps.len() {
            self.gaps[lane] = self.rows.dot(lane, x, y);
        }
        for lane in 0..frames {
            let (x, y) = (self.x[at(lane, 0)], self.y[at(lane, 0)]);
            let turning = subtract(multiply(x, self.forces[1][lane]), multiply(y, self.forces[0][lane]));
            self.residual_lanes[lane] = add(self.residual_lanes[lane], turning);
        }
        for lane in 0..products {
            self.residual_lanes[frames + lane] = self.pull(k, lane);
        }
        for lane in frames + products..all {
            self.residual_lanes[lane] = self.force[0][back(lane, k)];
        }
        self.scatter_moments(k);
        self.press_curves(k);
        let residual = self.residual_lanes.as_flattened_mut();
        for push in self.pushes.at(k) {
            residual[push.place] -= push.value(k, &self.scalars, &self.coefficients);
        }
        for (place, unknown) in self.residual.iter_mut().zip(&self.unknowns) {
            *place = -residual[*unknown];
        }
        let scale = ((k + 1) * (k + 2)) as f64;
        self.row_residual.copy_from_slice(self.gaps.as_flattened());
        for &(row, slot, factor) in &self.row_signals {
            self.row_residual[row] += self.coefficients[factor as usize] * self.scalars.get(slot, k + 2).times(scale);
        }
        self.close_rows();
    }

    /// The right-hand sides of the loop equations, from the residuals of the rows.
    #[inline(always)]
    pub(super) fn close_rows(&mut self) {
        if self.terms.pairs.is_empty() {
            // Every row has an equation, in this order.
            let of_rows = &mut self.residual[self.unknowns.len()..];
            return of_rows.iter_mut().zip(&self.row_residual).for_each(|(place, gap)| *place = -*gap);
        }
        for (equation, gap) in self.equations.iter().zip(&self.row_residual) {
            if let Some(equation) = equation {
                self.residual[*equation] = -*gap;
            }
        }
        self.terms.pairs.reduce(self.residual_lanes.as_flattened(), &self.row_residual, &mut self.residual);
    }

    /// Order k of b x G.
    #[inline(always)]
    fn moment(&self, k: usize, lane: usize) -> Lane<N, L> {
        let left = dot(series(&self.x, lane, k), from_back(&self.force[1], lane, k));
        let right = dot(series(&self.y, lane, k), from_back(&self.force[0], lane, k));
        subtract(left, right)
    }

    /// Order k of e . G for products.
    #[inline(always)]
    fn pull(&self, k: usize, lane: usize) -> Lane<N, L> {
        let arm = self.shape.lanes[0] + lane;
        let left = dot(series(&self.unit[0], lane, k), from_back(&self.force[0], arm, k));
        let right = dot(series(&self.unit[1], lane, k), from_back(&self.force[1], arm, k));
        add(left, right)
    }

    /// Moments that belong to the unknown of another place: those of products and of frames that share an angle.
    #[inline(always)]
    fn scatter_moments(&mut self, k: usize) {
        let scale = ((k + 1) * (k + 2)) as f64;
        for &frame in &self.special {
            let Some(place) = self.turned_by[frame] else { continue };
            let alpha = self.signal(self.form.frames[frame].signal, k + 2).times(scale);
            let moment = self.residual_lanes.as_flattened()[frame];
            let residual = self.residual_lanes.as_flattened_mut();
            residual[place] +=
                self.inertia.as_flattened()[frame] * alpha + if place == frame { N::ZERO } else { moment };
        }
        let frames = self.shape.lanes[0];
        for lane in 0..self.shape.lanes[1] {
            let moment = self.moment(k, frames + lane);
            let first = lane * L;
            let count = self.shape.counts[1].saturating_sub(first).min(L);
            for (product, moment) in self.form.products[first..first + count].iter().zip(moment) {
                if let Some(place) = self.turned_by[product.frame as usize] {
                    self.residual_lanes.as_flattened_mut()[place] += moment;
                }
            }
        }
    }

    /// Accelerations and reactions from the residuals of the equations.
    #[inline(always)]
    pub(super) fn solve(&mut self) {
        self.matrix.solve(&self.residual, self.solution.as_flattened_mut());
        if !self.terms.pairs.is_empty() {
            let first = self.shape.places();
            self.terms.pairs.complete(first, &self.unknowns, self.solution.as_flattened_mut());
        }
    }

    /// Everything at the new order.
    #[inline(always)]
    fn correct(&mut self, k: usize) {
        let (all, frames) = (self.shape.all(), self.shape.lanes[0]);
        let scale = ((k + 1) * (k + 2)) as f64;
        let (inverse, share) = (1.0 / scale, 1.0 / (k + 1) as f64);
        for lane in 0..all {
            self.values[(k + 2) * all + lane] = times(inverse, self.solution[lane]);
        }
        for lane in 0..frames {
            let alpha = self.solution[lane];
            self.omega[back(lane, k + 1)] = times(share, alpha);
            self.second[0][lane] = minus(self.second[0][lane], alpha, self.y[at(lane, 0)]);
            self.second[1][lane] = plus(self.second[1][lane], alpha, self.x[at(lane, 0)]);
        }
        for index in 0..self.special.len() {
            let frame = self.special[index];
            let rate = self.turned_by[frame].map_or(N::ZERO, |place| self.solution.as_flattened()[place]);
            let signal = self.signal(self.form.frames[frame].signal, k + 2).times(scale);
            self.omega.as_flattened_mut()[flat::<L>(frame, ORDERS - 2 - k)] = (rate + signal).times(share);
            if self.turned_by[frame] != Some(frame) {
                self.accelerate(frame, rate);
            }
        }
        self.place_frames(k + 2, scale);
        if self.shape.counts[1] > 0 {
            self.lengthen(k, scale, true);
        }
        if self.shape.counts[2] > 0 {
            self.shift(k, scale, true);
        }
        let reactions = self.solution[all..].as_flattened();
        for lane in 0..all {
            let applied = [self.applied[0][lane], self.applied[1][lane]];
            [self.forces[0][lane], self.forces[1][lane]] = self.reactions.real(lane, reactions, applied);
        }
        self.couple(k, 0);
    }

    /// Adds the forces of the masses to the others, and keeps the sum from a lane on.
    #[inline(always)]
    fn couple(&mut self, k: usize, first: usize) {
        self.coupling.add_forces(&self.second[0], &self.second[1], &mut self.forces);
        for axis in 0..2 {
            for (lane, force) in self.forces[axis].iter().enumerate().skip(first) {
                self.force[axis][back(lane, k)] = *force;
            }
        }
    }
}

impl Scatter {
    /// Its order k times the first factor.
    #[inline(always)]
    pub(super) fn value<N: Elementary, const L: usize>(
        &self,
        k: usize,
        scalars: &Scalars<N, L>,
        coefficients: &[N],
    ) -> N {
        coefficients[self.factors[0] as usize] * self.unscaled(k, scalars)
    }

    #[inline(always)]
    fn unscaled<N: Elementary, const L: usize>(&self, k: usize, scalars: &Scalars<N, L>) -> N {
        match self.value {
            Some(slot) => scalars.get(slot, k),
            None => N::all(1.0),
        }
    }
}

impl Loads {
    /// Minus the loads on arms.
    #[inline(always)]
    pub(super) fn apply<N: Elementary, const L: usize>(
        &self,
        k: usize,
        scalars: &Scalars<N, L>,
        coefficients: &[N],
        applied: &mut [Vec<Lane<N, L>>; 2],
    ) {
        if !self.act(k) {
            return;
        }
        let [x, y] = applied;
        x.fill(splat(N::ZERO));
        y.fill(splat(N::ZERO));
        let (x, y) = (x.as_flattened_mut(), y.as_flattened_mut());
        for load in self.at(k) {
            let value = load.unscaled(k, scalars);
            let [fx, fy] = load.factors;
            x[load.place] -= coefficients[fx as usize] * value;
            y[load.place] -= coefficients[fy as usize] * value;
        }
    }
}

/// All orders of a lane.
#[inline(always)]
fn all<N, const L: usize>(lanes: &[Lane<N, L>], lane: usize) -> &Series<N, L> {
    &lanes.as_chunks().0[lane]
}

/// Orders k to 0 of a lane whose orders are stored the other way round.
#[inline(always)]
fn from_back<N, const L: usize>(lanes: &[Lane<N, L>], lane: usize, k: usize) -> &[Lane<N, L>] {
    &lanes[back(lane, k)..back(lane, 0) + 1]
}

/// sum a_j b_j
#[inline(always)]
fn dot<N: Elementary, const L: usize>(a: &[Lane<N, L>], b: &[Lane<N, L>]) -> Lane<N, L> {
    let count = a.len().min(b.len());
    let (a, b) = (&a[..count], &b[..count]);
    let (mut sum, mut j) = (splat(N::ZERO), 0);
    while j < count {
        sum = plus(sum, a[j], b[j]);
        j += 1;
    }
    sum
}

/// sum a_j b_(k-j)
#[inline(always)]
fn convolve<N: Elementary, const L: usize>(a: &[Lane<N, L>], b: &[Lane<N, L>]) -> Lane<N, L> {
    let (mut even, mut odd) = (splat(N::ZERO), splat(N::ZERO));
    let (mut left, mut right) = (a.chunks_exact(2), b.rchunks_exact(2));
    for (a, b) in (&mut left).zip(&mut right) {
        even = plus(even, a[0], b[1]);
        odd = plus(odd, a[1], b[0]);
    }
    if let ([a], [b]) = (left.remainder(), right.remainder()) {
        even = plus(even, *a, *b);
    }
    add(even, odd)
}
