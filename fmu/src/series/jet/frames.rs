//! The orders of a mechanism of frames only: every angle an unknown of its own, no displacements, no signals in the loops. What
//! [`super::orders`] does for all, with everything between two stores in registers.

use super::{Jet, ORDERS, at, vectors};
use crate::series::columns::Columns;
use crate::series::inverse::Inverse;
use crate::series::lane::{Lane, WIDTH, ZERO, add, minus, multiply, plus, splat, subtract};
use crate::series::matrix::Matrix;

/// Series of F lanes.
type Series<const F: usize> = [[Lane; ORDERS]; F];

/// One order of x and y of F lanes.
type Pair<const F: usize> = [[Lane; F]; 2];

/// Where the new coefficients go.
struct Frames<'a, const F: usize> {
    x: &'a mut Series<F>,
    y: &'a mut Series<F>,
    omega: &'a mut Series<F>,
    force: [&'a mut Series<F>; 2],
}

/// What stays as it is along a step.
pub(super) struct Fixed<'a> {
    pub coupling: &'a Columns,
    pub rows: &'a Columns,
    pub reactions: &'a Columns,
    pub inverse: &'a Inverse,
    /// Numbers of accelerations and reactions.
    pub equations: [usize; 2],
}

impl Jet {
    /// Are there only frames?
    pub(super) fn has_only_frames(&self) -> bool {
        self.shape.counts[1..] == [0, 0]
            && self.special.is_empty()
            && self.unknowns.len() == self.shape.counts[0]
            && self.form.rows.iter().all(|row| row.signals.is_empty())
    }

    /// Finds how the pose responds, if there are no more than a lane of frames: what is saved in orders of more is lost here.
    #[inline(always)]
    pub(super) fn respond_any(&mut self) {
        match self.frames {
            [1, 1] => self.respond_frames::<1>(),
            [1, 2] => self.respond_frames::<2>(),
            _ => {}
        }
    }

    #[inline(always)]
    fn respond_frames<const N: usize>(&mut self) {
        let Matrix::Whole(inverse) = &self.matrix else { return };
        let Self { rows, reactions, .. } = self;
        let coupling = self.coupling.entries();
        let equations = [self.unknowns.len(), self.form.rows.len()];
        let fixed = Fixed { coupling, rows, reactions, inverse, equations };
        self.response.find::<N>(&fixed, self.x[at(0, 0)], self.y[at(0, 0)]);
    }

    /// Order k with F lanes of frames and N - F of loops; none if the storage has another shape.
    #[inline(always)]
    pub(super) fn advance_frames<const F: usize, const N: usize>(&mut self, k: usize) -> Option<()> {
        if k + 2 >= ORDERS {
            return None;
        }
        if !self.scalars.is_steady() {
            self.scalars.rates(k, vectors(&self.x, &self.y, &self.values, F));
        }
        let steady = k > 1 && self.constant_loads == self.loads.len();
        if !steady {
            self.apply_loads(k);
        }
        let applied: Pair<F> = [*self.applied[0].first_chunk()?, *self.applied[1].first_chunk()?];
        let [force_x, force_y] = &mut self.force;
        let mut frames = Frames::<F> {
            x: series(&mut self.x)?,
            y: series(&mut self.y)?,
            omega: series(&mut self.omega)?,
            force: [series(force_x)?, series(force_y)?],
        };
        let Matrix::Whole(inverse) = &self.matrix else { return None };
        let Self { rows, reactions, .. } = self;
        let coupling = self.coupling.entries();
        let fixed =
            Fixed { coupling, rows, reactions, inverse, equations: [self.unknowns.len(), self.form.rows.len()] };
        let (mut second, mut moment) = frames.convolve(k);
        let free = match F {
            // What the loads do; the response knows the rest.
            1 => applied,
            _ => fixed.coupling.couple(&second, applied),
        };
        if F > 1 || !steady {
            for (f, moment) in moment.iter_mut().enumerate() {
                let turning = subtract(multiply(frames.x[f][0], free[1][f]), multiply(frames.y[f][0], free[0][f]));
                *moment = add(*moment, turning);
            }
        }
        for push in &self.pushes[if k == 0 { 0 } else { self.constant_pushes }..] {
            let value = push.value.map_or(1.0, |slot| self.scalars.get(slot, k));
            let place = moment.as_flattened_mut().get_mut(push.place)?;
            *place -= self.coefficients[push.factors[0] as usize] * value;
        }
        let values = self.values.get_mut((k + 2) * F..)?.first_chunk_mut()?;
        let force: Pair<F> = if F == 1 {
            let h = [second[0][0], second[1][0]];
            let solution: [Lane; N] = self.response.solve(&fixed, moment[0], h);
            let force = self.response.force(&fixed, h, &solution, [applied[0][0], applied[1][0]]);
            frames.turn(k, solution.first_chunk()?, &mut second, values);
            force.map(|force| [force; F])
        } else {
            let solution: [Lane; N] = fixed.solve::<F, N>(&moment, &second);
            frames.turn(k, solution.first_chunk()?, &mut second, values);
            let applied = match fixed.equations[1] {
                0 => applied,
                _ => fixed.reactions.react(solution[F..].as_flattened(), applied),
            };
            fixed.coupling.couple(&second, applied)
        };
        for (series, force) in frames.force.iter_mut().zip(force) {
            for (series, force) in series.iter_mut().zip(force) {
                series[k] = force;
            }
        }
        if !self.scalars.is_still() {
            self.scalars.positions(k + 2, vectors(&self.x, &self.y, &self.values, F));
        }
        Some(())
    }
}

#[inline(always)]
fn series<const F: usize>(lanes: &mut [Lane]) -> Option<&mut Series<F>> {
    lanes.as_chunks_mut().0.first_chunk_mut()
}

/// Second derivatives of the arms of a lane of frames, and moments of the forces on them, without the accelerations and forces of order k: from orders 1 to
/// k + 1 of the arms, 0 to k of the rates, and 0 to k - 1 of the forces.
#[inline(always)]
pub(super) fn convolve([x, y]: [&[Lane]; 2], omega: &[Lane], [force_x, force_y]: [&[Lane]; 2]) -> [Lane; 3] {
    let k = x.len() - 1;
    let (x, y, omega) = (&x[..k + 1], &y[..k + 1], &omega[..k + 1]);
    let (force_x, force_y) = (&force_x[..k], &force_y[..k]);
    // Even and odd terms apart, so that they do not wait for each other: of cosines, of sines, and of both parts of the moment.
    // What the order before has found comes last, so that the others do not wait for it.
    let (mut even, mut odd) = ([ZERO; 4], [ZERO; 4]);
    let mut j = 1;
    while j + 1 < k {
        even = terms(even, [x[j], y[j]], omega[k - j], [force_x[k - 1 - j], force_y[k - 1 - j]]);
        odd = terms(odd, [x[j + 1], y[j + 1]], omega[k - 1 - j], [force_x[k - 2 - j], force_y[k - 2 - j]]);
        j += 2;
    }
    if j < k {
        even = terms(even, [x[j], y[j]], omega[k - j], [force_x[k - 1 - j], force_y[k - 1 - j]]);
    }
    let mut sums = [add(even[0], odd[0]), add(even[1], odd[1]), add(even[2], odd[2]), add(even[3], odd[3])];
    if k > 0 {
        sums = terms(sums, [x[0], y[0]], omega[k], [force_x[k - 1], force_y[k - 1]]);
    }
    let [cosine, sine, over, under] = sums;
    let (cosine, sine) = (plus(cosine, x[k], omega[0]), plus(sine, y[k], omega[0]));
    let up = splat((k + 1) as f64);
    [multiply(sine, multiply(splat(-1.0), up)), multiply(cosine, up), subtract(over, under)]
}

/// One term of x omega, y omega, x force_y and y force_x.
#[inline(always)]
fn terms(sums: [Lane; 4], [x, y]: [Lane; 2], omega: Lane, [force_x, force_y]: [Lane; 2]) -> [Lane; 4] {
    [plus(sums[0], x, omega), plus(sums[1], y, omega), plus(sums[2], x, force_y), plus(sums[3], y, force_x)]
}

impl<const F: usize> Frames<'_, F> {
    /// Second derivatives of the arms, and moments of the forces, without the accelerations and forces of this order.
    #[inline(always)]
    fn convolve(&self, k: usize) -> (Pair<F>, [Lane; F]) {
        let (mut second, mut moment) = ([[ZERO; F]; 2], [ZERO; F]);
        for f in 0..F {
            let arm = [&self.x[f][1..k + 2], &self.y[f][1..k + 2]];
            let force = [&self.force[0][f][..k], &self.force[1][f][..k]];
            [second[0][f], second[1][f], moment[f]] = convolve(arm, &self.omega[f][..k + 1], force);
        }
        (second, moment)
    }

    /// Takes the accelerations over.
    #[inline(always)]
    fn turn(&mut self, k: usize, alpha: &[Lane; F], second: &mut Pair<F>, values: &mut [Lane; F]) {
        let scale = ((k + 1) * (k + 2)) as f64;
        let (inverse, share) = (splat(1.0 / scale), splat(1.0 / (k + 1) as f64));
        for f in 0..F {
            values[f] = multiply(inverse, alpha[f]);
            self.omega[f][k + 1] = multiply(share, alpha[f]);
            second[0][f] = minus(second[0][f], alpha[f], self.y[f][0]);
            second[1][f] = plus(second[1][f], alpha[f], self.x[f][0]);
            self.x[f][k + 2] = multiply(inverse, second[0][f]);
            self.y[f][k + 2] = multiply(inverse, second[1][f]);
        }
    }
}

impl Fixed<'_> {
    /// Accelerations and reactions that make up for what the equations lack.
    #[inline(always)]
    fn solve<const F: usize, const N: usize>(&self, moment: &[Lane; F], [x, y]: &Pair<F>) -> [Lane; N] {
        let [frames, rows] = self.equations;
        let mut gaps = [ZERO; N];
        for (r, gap) in gaps[F..].iter_mut().enumerate() {
            *gap = self.rows.dot(r, x.as_flattened(), y.as_flattened());
        }
        let (balance, gaps) = (moment.as_flattened(), gaps[F..].as_flattened());
        let (mut even, mut odd) = ([ZERO; N], [ZERO; N]);
        let (balanced, closed) = self.inverse.rows::<N>().split_at_checked(F * WIDTH).unwrap_or_default();
        for (inverse, values) in [(&balanced[..frames], &balance[..frames]), (&closed[..rows], &gaps[..rows])] {
            let (mut pairs, mut two) = (inverse.chunks_exact(2), values.chunks_exact(2));
            for (inverse, values) in (&mut pairs).zip(&mut two) {
                even = less(even, &inverse[0], values[0]);
                odd = less(odd, &inverse[1], values[1]);
            }
            if let ([inverse], [value]) = (pairs.remainder(), two.remainder()) {
                even = less(even, inverse, *value);
            }
        }
        for n in 0..N {
            even[n] = add(even[n], odd[n]);
        }
        even
    }
}

/// sum - row x value
#[inline(always)]
fn less<const N: usize>(mut sum: [Lane; N], row: &[Lane; N], value: f64) -> [Lane; N] {
    for n in 0..N {
        sum[n] = minus(sum[n], row[n], splat(value));
    }
    sum
}

impl Columns {
    /// sum + (re + i im)(x + i y), all lanes.
    #[inline(always)]
    fn couple<const F: usize>(&self, [x, y]: &Pair<F>, sum: Pair<F>) -> Pair<F> {
        let mut result = sum;
        for f in 0..F {
            [result[0][f], result[1][f]] = self.complex(f, x.as_flattened(), y.as_flattened(), [sum[0][f], sum[1][f]]);
        }
        result
    }

    /// sum + (re + i im) x, all lanes.
    #[inline(always)]
    fn react<const F: usize>(&self, x: &[f64], sum: Pair<F>) -> Pair<F> {
        let mut result = sum;
        for f in 0..F {
            [result[0][f], result[1][f]] = self.real(f, x, [sum[0][f], sum[1][f]]);
        }
        result
    }
}
