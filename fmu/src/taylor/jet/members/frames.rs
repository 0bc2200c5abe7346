//! The orders of a mechanism of few frames and nothing else: every angle an unknown of its own, no displacements, no signals in the loops.
//!
//! Let h be the second derivatives of the arms without the new accelerations, and m the moments on them without the new forces. The accelerations and the forces of
//! an order both follow linearly from m and h; this response of the pose is found once a step. Then an order is its products of series and one full matrix, instead
//! of equations that wait for each other.

use super::{Arm, Members};
use crate::linalg::many::{Elementary, Number};
use crate::program::arm_form::ORDERS;

/// With more frames the full matrix costs more than the equations one after the other.
const MOST_FRAMES: usize = 4;
/// Frames and loop equations.
const MOST_EQUATIONS: usize = 8;
/// The sums of one frame of larger numbers fill the registers \[bytes\].
const SHORT: usize = 32;

/// What an order leaves of each frame: m and both components of h.
type Left<N, const F: usize> = [[N; 3]; F];

/// The acceleration and both components of the force of each frame, as sums over what is left.
type Response<N, const F: usize> = [[Left<N, F>; 3]; F];

/// Both components of something for each equation and frame.
type Pairs<N, const F: usize> = [[[N; 2]; F]; MOST_EQUATIONS];

impl<N: Elementary> Members<N> {
    /// The number of frames, if there is nothing else and few of them; otherwise none.
    pub(super) fn few_frames(&self) -> usize {
        let frames = self.turns.len();
        let few = frames <= MOST_FRAMES && frames + self.form.rows.len() <= MOST_EQUATIONS;
        if N::FULL && few && self.form.has_only_frames() { frames } else { 0 }
    }

    /// Room for the response.
    pub(super) fn room(frames: usize) -> Vec<N> {
        vec![N::ZERO; 9 * frames * frames]
    }

    /// Finds how the pose of few frames responds.
    #[inline(always)]
    pub(super) fn respond(&mut self) {
        if !N::FULL || self.frames == 0 {
            return;
        }
        let size = self.vector.len().min(MOST_EQUATIONS);
        let inverse = self.inverse(size);
        match self.frames {
            1 => self.respond_frames::<1>(&inverse[..size]),
            2 => self.respond_frames::<2>(&inverse[..size]),
            3 => self.respond_frames::<3>(&inverse[..size]),
            _ => self.respond_frames::<MOST_FRAMES>(&inverse[..size]),
        }
    }

    /// An order of few frames.
    #[inline(always)]
    pub(super) fn advance_few(&mut self, k: usize) {
        match self.frames {
            1 => self.advance_frames::<1>(k),
            2 => self.advance_frames::<2>(k),
            3 => self.advance_frames::<3>(k),
            _ => self.advance_frames::<MOST_FRAMES>(k),
        }
    }

    #[inline(always)]
    fn respond_frames<const F: usize>(&mut self, inverse: &[[N; MOST_EQUATIONS]]) {
        let size = inverse.len();
        let (masses, [forces, residuals]) = (self.masses::<F>(), self.effects::<F>(size));
        let Some(response) = room_mut::<N, F>(&mut self.response) else { return };
        for from in 0..F {
            for part in 0..3 {
                let mut solution = [N::ZERO; MOST_EQUATIONS];
                if part == 0 {
                    solution = inverse[from];
                } else {
                    for (column, residuals) in inverse.iter().zip(&residuals) {
                        let residual = residuals[from][part - 1];
                        solution.iter_mut().zip(column).take(size).for_each(|(sum, value)| *sum += *value * residual);
                    }
                }
                for to in 0..F {
                    let [re, im] = masses[to][from];
                    let mut force = [[N::ZERO; 2], [re, im], [-im, re]][part];
                    for (forces, value) in forces[..size].iter().zip(&solution) {
                        force[0] += forces[to][0] * *value;
                        force[1] += forces[to][1] * *value;
                    }
                    let row = &mut response[to];
                    [row[0][from][part], row[1][from][part], row[2][from][part]] = [solution[to], force[0], force[1]];
                }
            }
        }
    }

    /// Minus the columns of the inverse of the matrix of the equations.
    #[inline(always)]
    fn inverse(&mut self, size: usize) -> [[N; MOST_EQUATIONS]; MOST_EQUATIONS] {
        let mut inverse = [[N::ZERO; MOST_EQUATIONS]; MOST_EQUATIONS];
        for (equation, column) in inverse[..size].iter_mut().enumerate() {
            self.vector.fill(N::ZERO);
            self.vector[equation] = N::all(-1.0);
            self.factors.solve_by_rows(&self.vector, &mut column[..size]);
        }
        inverse
    }

    /// The masses between every two frames.
    #[inline(always)]
    fn masses<const F: usize>(&self) -> [[[N; 2]; F]; F] {
        let mut masses = [[[N::ZERO; 2]; F]; F];
        for entry in &self.form.coupling {
            masses[entry.on as usize][entry.from as usize] = entry.mass.map(|place| self.coefficients[place as usize]);
        }
        masses
    }

    /// The forces on the arms that go with each acceleration and reaction, and what both components of h leave of each equation.
    #[inline(always)]
    fn effects<const F: usize>(&self, size: usize) -> [Pairs<N, F>; 2] {
        let [mut forces, mut residuals] = [[[[N::ZERO; 2]; F]; MOST_EQUATIONS]; 2];
        for entry in &self.form.coupling {
            let (on, from) = (entry.on as usize, entry.from as usize);
            let [re, im] = entry.mass.map(|place| self.coefficients[place as usize]);
            let pose = |frame: usize| (self.arms[frame].x[0], self.arms[frame].y[0]);
            let (x, y) = pose(from);
            forces[from][on] = [-(re * y) - im * x, re * x - im * y];
            let (x, y) = pose(on);
            residuals[on][from] = [x * im - y * re, x * re + y * im];
        }
        for (equation, row) in (F..size).zip(&self.form.rows) {
            for (arm, p) in &row.arms {
                let p = p.map(|place| self.coefficients[place as usize]);
                (forces[equation][*arm as usize], residuals[equation][*arm as usize]) = (p, p);
            }
        }
        [forces, residuals]
    }

    #[inline(always)]
    fn advance_frames<const F: usize>(&mut self, k: usize) {
        let acts = self.loads.act(k);
        let (Some(arms), Some(response)) = (self.arms.first_chunk_mut::<F>(), room_mut::<N, F>(&mut self.response))
        else {
            return;
        };
        let mut left = convolve(arms, k);
        if acts {
            for (left, arm) in left.iter_mut().zip(&*arms) {
                left[0] += arm.x[0] * arm.applied[1] - arm.y[0] * arm.applied[0];
            }
        }
        for push in self.pushes.at(k) {
            let value = push.value.map_or(N::all(1.0), |slot| self.laws.get(slot, k));
            left[push.place][0] -= self.coefficients[push.factors[0] as usize] * value;
        }
        accept(arms, k, &left, &find(response, &left), acts);
    }
}

#[inline(always)]
fn room_mut<N, const F: usize>(response: &mut [N]) -> Option<&mut Response<N, F>> {
    response.as_chunks_mut().0.as_chunks_mut().0.as_chunks_mut().0.first_chunk_mut()
}

/// What is left of order k: from orders 0 to k + 1 of the arms, 0 to k of the rates, and 0 to k - 1 of the forces.
#[inline(always)]
fn convolve<N: Number, const F: usize>(arms: &[Arm<N>; F], k: usize) -> Left<N, F> {
    // Said again for the compiler, which then needs no test in the loop.
    let k = k.min(ORDERS - 2);
    let mut sums = [[N::ZERO; 4]; F];
    if size_of::<N>() > SHORT {
        for (sums, arm) in sums.iter_mut().zip(arms) {
            *sums = (0..k).fold(*sums, |sums, j| term(sums, arm, k, j));
        }
    } else {
        for j in 0..k {
            for (sums, arm) in sums.iter_mut().zip(arms) {
                *sums = term(*sums, arm, k, j);
            }
        }
    }
    let scale = (k + 1) as f64;
    let mut left = [[N::ZERO; 3]; F];
    for ((left, [x, y, over, under]), arm) in left.iter_mut().zip(sums).zip(arms) {
        let (x, y) = (x + arm.x[k + 1] * arm.rate[0], y + arm.y[k + 1] * arm.rate[0]);
        *left = [over - under, y.times(-scale), x.times(scale)];
    }
    left
}

/// One term of x omega, y omega, x force_y and y force_x.
#[inline(always)]
fn term<N: Number>(sums: [N; 4], arm: &Arm<N>, k: usize, j: usize) -> [N; 4] {
    let (x, y, rate) = (arm.x[k - j], arm.y[k - j], arm.rate[j + 1]);
    [sums[0] + x * rate, sums[1] + y * rate, sums[2] + x * arm.force[1][j], sums[3] + y * arm.force[0][j]]
}

/// Accelerations and forces.
#[inline(always)]
fn find<N: Number, const F: usize>(response: &Response<N, F>, left: &Left<N, F>) -> [[N; 3]; F] {
    let mut found = [[N::ZERO; 3]; F];
    for (found, rows) in found.iter_mut().zip(response) {
        for (found, row) in found.iter_mut().zip(rows) {
            for ([moment, x, y], left) in row.iter().zip(left) {
                *found += (*moment * left[0] + *x * left[1]) + *y * left[2];
            }
        }
    }
    found
}

/// Everything at the new order.
#[inline(always)]
fn accept<N: Number, const F: usize>(
    arms: &mut [Arm<N>; F],
    k: usize,
    left: &Left<N, F>,
    found: &[[N; 3]; F],
    acts: bool,
) {
    let k = k.min(ORDERS - 3);
    let scale = ((k + 1) * (k + 2)) as f64;
    let (share, rate_share) = (N::all(1.0 / scale), N::all(1.0 / (k + 1) as f64));
    for ((arm, [_, hx, hy]), [alpha, fx, fy]) in arms.iter_mut().zip(left).zip(found) {
        arm.value[k + 2] = *alpha * share;
        arm.rate[k + 1] = *alpha * rate_share;
        arm.x[k + 2] = (*hx - *alpha * arm.y[0]) * share;
        arm.y[k + 2] = (*hy + *alpha * arm.x[0]) * share;
        let applied = if acts { arm.applied } else { [N::ZERO; 2] };
        (arm.force[0][k], arm.force[1][k]) = (*fx + applied[0], *fy + applied[1]);
    }
}
