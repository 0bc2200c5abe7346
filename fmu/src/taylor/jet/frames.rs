//! The orders of a mechanism of frames only: every angle an unknown of its own, no displacements but those of states, no signals in the loops. What
//! [`super::orders`] does for all, with everything between two stores in registers.

use super::friction::Known;
use super::{Coefficient, Jet, Loads, ORDERS, Scatter, Series, vectors};
use crate::linalg::columns::Columns;
use crate::linalg::lane::{Lane, WIDTH, add, minus, multiply, plus, splat, subtract, times};
use crate::linalg::matrix::Solve;
use crate::linalg::number::{Elementary, Number};
use crate::taylor::tape::Scalars;

/// One order of x and y of F lanes.
pub(super) type Pair<N, const L: usize, const F: usize> = [[Lane<N, L>; F]; 2];

/// For each order k: 1 / ((k + 1) (k + 2)) and 1 / (k + 1).
const RECIPROCALS: [[f64; 2]; ORDERS] = {
    let mut table = [[0.0; 2]; ORDERS];
    let mut k = 0;
    while k < ORDERS {
        table[k] = [1.0 / ((k + 1) * (k + 2)) as f64, 1.0 / (k + 1) as f64];
        k += 1;
    }
    table
};

/// Where the new coefficients go.
struct Frames<'a, N, const L: usize, const F: usize, const S: usize> {
    x: &'a mut [Series<N, L>; F],
    y: &'a mut [Series<N, L>; F],
    omega: &'a mut [Series<N, L>; F],
    force: [&'a mut [Series<N, L>; F]; 2],
    values: &'a mut [[Lane<N, L>; S]; ORDERS],
}

/// What stays as it is along a step, with E lanes of equations.
pub(super) struct Fixed<'a, N, const L: usize, const E: usize> {
    pub coupling: &'a Columns<N, L>,
    pub rows: &'a Columns<N, L>,
    pub reactions: &'a Columns<N, L>,
    /// Rows of the inverse.
    pub inverse: &'a [[Lane<N, L>; E]],
    /// Numbers of accelerations and reactions.
    pub equations: [usize; 2],
}

impl Jet {
    /// Finds how the pose responds, if there are no more than a lane of frames: what is saved in orders of more is lost here.
    #[inline(always)]
    pub(super) fn respond_any(&mut self) {
        match self.frames {
            [1, 1, 1] => self.respond_frames::<1, 1, 1>(),
            [1, 1, 2] => self.respond_frames::<1, 1, 2>(),
            [1, 1, 3] => self.respond_frames::<1, 1, 3>(),
            [1, 2, 2] => self.respond_frames::<1, 2, 2>(),
            [1, 2, 3] => self.respond_frames::<1, 2, 3>(),
            _ => {}
        }
    }
}

#[expect(private_bounds, reason = "there are two kinds of numbers")]
impl<N: Coefficient, const L: usize> Jet<N, L> {
    /// Finds how the pose of F lanes of frames responds, beside S - F lanes of states.
    #[inline(always)]
    pub(super) fn respond_frames<const F: usize, const S: usize, const E: usize>(&mut self) {
        let Some(inverse) = self.matrix.rows() else { return };
        let Self { rows, reactions, .. } = self;
        let coupling = self.coupling.entries();
        let equations = [self.form.frames.len(), self.form.rows.len()];
        let fixed = Fixed::<N, L, E> { coupling, rows, reactions, inverse, equations };
        self.response.find::<F, S, E>(&fixed, first_order(&self.x), first_order(&self.y));
    }

    /// Orders from the first to the last with F lanes of frames, S - F of states and E - S of loops; none if the storage has another shape. States are not beside more frames than
    /// the response serves.
    #[inline(always)]
    pub(super) fn advance_frames<const F: usize, const S: usize, const E: usize>(
        &mut self,
        first: usize,
        last: usize,
    ) -> Option<()> {
        if last + 2 >= ORDERS {
            return None;
        }
        let inverse = self.matrix.rows()?;
        let Self { rows, reactions, .. } = self;
        let coupling = self.coupling.entries();
        let equations = [self.form.frames.len(), self.form.rows.len()];
        let fixed = Fixed::<N, L, E> { coupling, rows, reactions, inverse, equations };
        let view = self.response.view::<F, E>(&fixed);
        let [force_x, force_y] = &mut self.force;
        let mut frames = Frames::<N, L, F, S> {
            x: all_orders(&mut self.x)?,
            y: all_orders(&mut self.y)?,
            omega: all_orders(&mut self.omega)?,
            force: [all_orders(force_x)?, all_orders(force_y)?],
            values: self.values.as_chunks_mut().0.first_chunk_mut()?,
        };
        // Of one lane the response knows all but what the loads do.
        let responds = F * L <= WIDTH;
        let has_limits = !self.limits.is_empty();
        let is_watched = has_limits || self.reactions_kept.are_kept();
        for k in first..last + 1 {
            if !self.scalars.is_steady() {
                self.scalars.rates(k, frames.vectors());
            }
            self.loads.apply(k, &self.scalars, &self.coefficients, &mut self.applied);
            let mut applied: Pair<N, L, F> = [*self.applied[0].first_chunk()?, *self.applied[1].first_chunk()?];
            let (second, mut moment) = frames.convolve(k);
            let turned = if responds { applied } else { fixed.coupling.couple(&second, applied) };
            if !responds || self.loads.act(k) {
                for f in 0..F {
                    let (x, y) = (frames.x[f][0], frames.y[f][0]);
                    let turning = subtract(multiply(x, turned[1][f]), multiply(y, turned[0][f]));
                    moment[f] = add(moment[f], turning);
                }
            }
            for push in self.pushes.at(k) {
                *moment.as_flattened_mut().get_mut(push.place)? -= push.value(k, &self.scalars, &self.coefficients);
            }
            let mut solution: [Lane<N, L>; E] = if responds {
                let balanced = view.solve(moment.first_chunk()?, &second);
                // A state has a mass of its own, which nothing but its law moves.
                let of_states = inverse.get(F * L..).unwrap_or_default();
                less(balanced, of_states, moment[F..].as_flattened(), self.form.world.len())
            } else {
                fixed.solve::<F>(moment.first_chunk()?, &second)
            };
            if is_watched {
                if has_limits {
                    let known = frames.known(&self.scalars, &self.coefficients, &second);
                    let [x, y] = &mut applied;
                    self.limits.solve(k, known, &mut solution, [x, y]);
                    self.solution.copy_from_slice(&solution);
                }
                if self.reactions_kept.are_kept() {
                    self.reactions_kept.keep(k, &solution[S..]);
                }
            }
            if responds {
                let force = view.force(&second, solution[..F].as_flattened(), solution[S..].as_flattened(), applied);
                frames.turn(k, solution.first_chunk()?, second);
                frames.shift(k, &solution[F..S]);
                frames.push(k, force);
            } else {
                let second = frames.turn(k, solution.first_chunk()?, second);
                let reacting = match fixed.equations[1] {
                    0 => applied,
                    _ => fixed.reactions.react(solution[F..].as_flattened(), applied),
                };
                frames.push(k, fixed.coupling.couple(&second, reacting));
            }
            if !self.scalars.is_still() {
                self.scalars.positions(k + 2, frames.vectors());
            }
        }
        Some(())
    }
}

impl Loads {
    /// Do they change anything at this order?
    #[inline(always)]
    pub(super) fn act(&self, k: usize) -> bool {
        k <= 1 || self.constant < self.entries.len()
    }

    /// Those that count at this order: constant ones have one order only.
    #[inline(always)]
    pub(super) fn at(&self, k: usize) -> &[Scatter] {
        if k == 0 { &self.entries } else { self.entries.get(self.constant..).unwrap_or_default() }
    }
}

#[inline(always)]
fn all_orders<N, const L: usize, const F: usize>(lanes: &mut [Lane<N, L>]) -> Option<&mut [Series<N, L>; F]> {
    lanes.as_chunks_mut().0.first_chunk_mut()
}

/// The first order of F lanes.
#[inline(always)]
fn first_order<N: Number, const L: usize, const F: usize>(lanes: &[Lane<N, L>]) -> [Lane<N, L>; F] {
    let mut first = [splat(N::ZERO); F];
    for (place, series) in first.iter_mut().zip(lanes.as_chunks::<ORDERS>().0) {
        *place = series[0];
    }
    first
}

/// Second derivatives of the arms of a lane of frames, and moments of the forces on them, without the accelerations and forces of order k: from orders 1 to
/// k + 1 of the arms, 0 to k of the rates, and 0 to k - 1 of the forces. The last two are stored the other way round.
#[inline(always)]
pub(super) fn convolve<N: Number, const L: usize>(
    k: usize,
    [x, y]: [&Series<N, L>; 2],
    omega: &Series<N, L>,
    [force_x, force_y]: [&Series<N, L>; 2],
) -> [Lane<N, L>; 3] {
    // Said again for the compiler, which then needs no test in the loop.
    let k = k.min(ORDERS - 2);
    let first = ORDERS - 1 - k;
    // Sums of cosines, of sines, and of both parts of the moment. What the order before has found comes last, so that the others do not wait for it.
    let zero = splat(N::ZERO);
    let mut sums = [zero, zero, zero, zero];
    if k > 1 {
        let count = k - 1;
        let (x, y) = (&x[2..2 + count], &y[2..2 + count]);
        let omega = &omega[first + 1..first + 1 + count];
        let (force_x, force_y) = (&force_x[first + 2..first + 2 + count], &force_y[first + 2..first + 2 + count]);
        // One term at a time: with two the compiler tears the lanes apart.
        let mut j = 0;
        while j < count {
            sums = terms(sums, [x[j], y[j]], omega[j], [force_x[j], force_y[j]]);
            j += 1;
        }
    }
    if k > 0 {
        sums = terms(sums, [x[1], y[1]], omega[first], [force_x[first + 1], force_y[first + 1]]);
    }
    let [cosine, sine, over, under] = sums;
    let (cosine, sine) = (plus(cosine, x[k + 1], omega[ORDERS - 1]), plus(sine, y[k + 1], omega[ORDERS - 1]));
    let up = (k + 1) as f64;
    [times(-up, sine), times(up, cosine), subtract(over, under)]
}

/// One term of x omega, y omega, x force_y and y force_x.
#[inline(always)]
fn terms<N: Number, const L: usize>(
    sums: [Lane<N, L>; 4],
    [x, y]: [Lane<N, L>; 2],
    omega: Lane<N, L>,
    [force_x, force_y]: [Lane<N, L>; 2],
) -> [Lane<N, L>; 4] {
    [plus(sums[0], x, omega), plus(sums[1], y, omega), plus(sums[2], x, force_y), plus(sums[3], y, force_x)]
}

impl<N: Number, const L: usize, const F: usize, const S: usize> Frames<'_, N, L, F, S> {
    /// What scalar series read.
    #[inline(always)]
    fn vectors(&self) -> crate::taylor::tape::Vectors<'_, N, L>
    where
        N: Elementary,
    {
        vectors(self.x.as_flattened(), self.y.as_flattened(), self.values.as_flattened(), S)
    }

    /// What friction limits follow from.
    #[inline(always)]
    fn known<'a>(
        &'a self,
        scalars: &'a Scalars<N, L>,
        coefficients: &'a [N],
        [x, y]: &'a Pair<N, L, F>,
    ) -> Known<'a, N, L>
    where
        N: Elementary,
    {
        Known { scalars, coefficients, arms: [self.x.as_flattened(), self.y.as_flattened()], second: [x, y] }
    }

    /// Second derivatives of the arms, and moments of the forces, without the accelerations and forces of this order.
    #[inline(always)]
    fn convolve(&self, k: usize) -> (Pair<N, L, F>, [Lane<N, L>; S]) {
        let zero = splat(N::ZERO);
        let (mut second, mut moment) = ([[zero; F]; 2], [zero; S]);
        for f in 0..F {
            let force = [&self.force[0][f], &self.force[1][f]];
            [second[0][f], second[1][f], moment[f]] = convolve(k, [&self.x[f], &self.y[f]], &self.omega[f], force);
        }
        (second, moment)
    }

    /// Takes the accelerations over; returns the second derivatives of the arms with them.
    #[inline(always)]
    fn turn(&mut self, k: usize, alpha: &[Lane<N, L>; F], mut second: Pair<N, L, F>) -> Pair<N, L, F> {
        let k = k.min(ORDERS - 3);
        let [inverse, share] = RECIPROCALS[k];
        for f in 0..F {
            self.values[k + 2][f] = times(inverse, alpha[f]);
            self.omega[f][ORDERS - 2 - k] = times(share, alpha[f]);
            second[0][f] = minus(second[0][f], alpha[f], self.y[f][0]);
            second[1][f] = plus(second[1][f], alpha[f], self.x[f][0]);
            self.x[f][k + 2] = times(inverse, second[0][f]);
            self.y[f][k + 2] = times(inverse, second[1][f]);
        }
        second
    }

    /// Takes the accelerations of states over.
    #[inline(always)]
    fn shift(&mut self, k: usize, accelerations: &[Lane<N, L>]) {
        let k = k.min(ORDERS - 3);
        for (value, acceleration) in self.values[k + 2][F..].iter_mut().zip(accelerations) {
            *value = times(RECIPROCALS[k][0], *acceleration);
        }
    }

    /// Keeps the forces.
    #[inline(always)]
    fn push(&mut self, k: usize, [x, y]: Pair<N, L, F>) {
        let place = ORDERS - 1 - k.min(ORDERS - 1);
        for f in 0..F {
            self.force[0][f][place] = x[f];
            self.force[1][f][place] = y[f];
        }
    }
}

impl<N: Number, const L: usize, const E: usize> Fixed<'_, N, L, E> {
    /// Accelerations and reactions that make up for the residuals of the equations.
    #[inline(always)]
    fn solve<const F: usize>(&self, moment: &[Lane<N, L>; F], [x, y]: &Pair<N, L, F>) -> [Lane<N, L>; E] {
        let [frames, rows] = self.equations;
        let zero = [splat(N::ZERO); E];
        let mut gaps = zero;
        for r in F..E {
            gaps[r] = self.rows.dot(r - F, x.as_flattened(), y.as_flattened());
        }
        let (balanced, closed) = self.inverse.split_at_checked(F * L).unwrap_or_default();
        less(less(zero, balanced, moment.as_flattened(), frames), closed, gaps[F..].as_flattened(), rows)
    }
}

/// sum - rows x values
#[inline(always)]
fn less<N: Number, const L: usize, const E: usize>(
    mut sum: [Lane<N, L>; E],
    rows: &[[Lane<N, L>; E]],
    values: &[N],
    count: usize,
) -> [Lane<N, L>; E] {
    let count = count.min(rows.len()).min(values.len());
    let (rows, values) = (&rows[..count], &values[..count]);
    let mut i = 0;
    while i < count {
        for n in 0..E {
            sum[n] = minus(sum[n], rows[i][n], splat(values[i]));
        }
        i += 1;
    }
    sum
}

impl<N: Number, const L: usize> Columns<N, L> {
    /// sum + (re + i im)(x + i y), all lanes.
    #[inline(always)]
    fn couple<const F: usize>(&self, [x, y]: &Pair<N, L, F>, sum: Pair<N, L, F>) -> Pair<N, L, F> {
        let mut result = sum;
        for f in 0..F {
            [result[0][f], result[1][f]] = self.complex(f, x.as_flattened(), y.as_flattened(), [sum[0][f], sum[1][f]]);
        }
        result
    }

    /// sum + (re + i im) x, all lanes.
    #[inline(always)]
    fn react<const F: usize>(&self, x: &[N], sum: Pair<N, L, F>) -> Pair<N, L, F> {
        let mut result = sum;
        for f in 0..F {
            [result[0][f], result[1][f]] = self.real(f, x, [sum[0][f], sum[1][f]]);
        }
        result
    }
}
