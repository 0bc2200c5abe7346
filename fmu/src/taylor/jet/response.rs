//! How a pose of frames only responds to what an order leaves unbalanced, found once a step.
//!
//! Let h be the second derivatives of the arms without the new accelerations. Then x, the accelerations and reactions of an order, follows from
//! K x = -(moments + S h) with K = \[M J^T; J 0\], where S h are the moments of the forces A h and what h leaves of the loop equations. The forces on
//! the arms are A h + (A D + R) x with the derivatives D of the arms by their angles and the reactions' directions R. With K^-1 S and A D + R at hand,
//! x need not wait for A h, nor the forces for the arms.

use super::frames::{Fixed, Pair};
use crate::linalg::lane::{Lane, WIDTH, add, minus, multiply, plus, splat, subtract};
use crate::linalg::number::Number;

/// For F lanes of frames, no more than four frames in all, and E of all equations.
#[derive(Clone, Debug, Default)]
pub(super) struct Response<N, const L: usize> {
    /// K^-1 S: for both components of h of each frame, E lanes.
    free: Vec<Lane<N, L>>,
    /// A D + R: for each of x, both components of the forces, F lanes each.
    forced: Vec<Lane<N, L>>,
    /// A: for each frame, both parts of the masses that its arm accelerates, F lanes each.
    masses: Vec<Lane<N, L>>,
}

impl<N: Number, const L: usize> Response<N, L> {
    /// Storage for so many frames and rows, in lanes of frames and of all equations.
    pub fn new([frames, rows]: [usize; 2], [lanes, all]: [usize; 2]) -> Self {
        let zeros = |count: usize| vec![splat(N::ZERO); count];
        Self {
            free: zeros(2 * frames * all),
            forced: zeros(2 * (frames + rows) * lanes),
            masses: zeros(2 * frames * lanes),
        }
    }

    /// At the pose x + i y, with S lanes of unknowns.
    #[inline(always)]
    pub fn find<const F: usize, const S: usize, const E: usize>(
        &mut self,
        fixed: &Fixed<N, L, E>,
        x: [Lane<N, L>; F],
        y: [Lane<N, L>; F],
    ) {
        let zero = splat(N::ZERO);
        let [frames, loops] = fixed.equations;
        let (balanced, closed) = fixed.inverse.split_at_checked(S * L).unwrap_or_default();
        let balanced = &balanced[..frames.min(balanced.len())];
        let free = self.free.as_chunks_mut::<E>().0.as_chunks_mut::<2>().0;
        let forced = self.forced.as_chunks_mut::<F>().0.as_chunks_mut::<2>().0;
        let masses = self.masses.as_chunks_mut::<F>().0.as_chunks_mut::<2>().0;
        free.fill([[zero; E]; 2]);
        forced.fill([[zero; F]; 2]);
        masses.fill([[zero; F]; 2]);
        for f in 0..F {
            let (columns, parts_re, parts_im) = fixed.coupling.lane(f);
            let balanced = &balanced[(f * L).min(balanced.len())..];
            for i in 0..columns.len() {
                let (column, re, im) = (columns[i], parts_re[i], parts_im[i]);
                let moments = [subtract(multiply(x[f], im), multiply(y[f], re)), plus(multiply(x[f], re), y[f], im)];
                if column < frames.min(free.len()).min(masses.len()).min(forced.len()) {
                    gather(&mut free[column], balanced, moments);
                    let arm = [&x, &y].map(|lanes| lanes.as_flattened()[column % (F * L)]);
                    let (dx, dy) = (splat(-arm[1]), splat(arm[0]));
                    (masses[column][0][f], masses[column][1][f]) = (re, im);
                    forced[column][0][f] = minus(multiply(re, dx), im, dy);
                    forced[column][1][f] = plus(multiply(re, dy), im, dx);
                }
            }
            let (columns, parts_re, parts_im) = fixed.reactions.lane(f);
            for i in 0..columns.len() {
                if let Some(forced) = forced.get_mut(frames + columns[i]) {
                    (forced[0][f], forced[1][f]) = (parts_re[i], parts_im[i]);
                }
            }
        }
        let (mut lane, mut first) = (0, 0);
        while first < loops.min(closed.len()) {
            let rows = &closed[first..loops.min(closed.len()).min(first + L)];
            let (columns, parts_re, parts_im) = fixed.rows.lane(lane);
            for i in 0..columns.len() {
                if columns[i] < free.len() {
                    gather(&mut free[columns[i]], rows, [parts_re[i], parts_im[i]]);
                }
            }
            (lane, first) = (lane + 1, first + L);
        }
    }

    /// Everything that an order reads, side by side.
    #[inline(always)]
    pub fn view<'a, const F: usize, const E: usize>(&'a self, fixed: &Fixed<'a, N, L, E>) -> View<'a, N, L, F, E> {
        let forced = self.forced.as_chunks::<F>().0.as_chunks::<2>().0;
        let (turning, constrained) = forced.split_at_checked(fixed.equations[0]).unwrap_or_default();
        let free = self.free.as_chunks::<E>().0.as_chunks::<2>().0;
        let masses = self.masses.as_chunks::<F>().0.as_chunks::<2>().0;
        let rows = fixed.inverse;
        let count = turning.len().min(rows.len()).min(free.len()).min(masses.len()).min(F * L).min(WIDTH);
        View {
            rows: &rows[..count],
            free: &free[..count],
            masses: &masses[..count],
            turning: &turning[..count],
            constrained,
        }
    }
}

/// What an order of F lanes of frames reads; all but the last have an entry for each frame.
pub(super) struct View<'a, N, const L: usize, const F: usize, const E: usize> {
    rows: &'a [[Lane<N, L>; E]],
    free: &'a [[[Lane<N, L>; E]; 2]],
    masses: &'a [Pair<N, L, F>],
    turning: &'a [Pair<N, L, F>],
    constrained: &'a [Pair<N, L, F>],
}

impl<N: Number, const L: usize, const F: usize, const E: usize> View<'_, N, L, F, E> {
    /// Accelerations and reactions that make up for these moments and h.
    #[inline(always)]
    pub fn solve(&self, moments: &[Lane<N, L>; F], [x, y]: &Pair<N, L, F>) -> [Lane<N, L>; E] {
        // Three sums, which do not wait for each other.
        let mut sums = [[splat(N::ZERO); E]; 3];
        let [moments, x, y] = [moments, x, y].map(|lanes| lanes.as_flattened());
        let count = self.rows.len().min(F * L).min(WIDTH);
        let (rows, free) = (&self.rows[..count], &self.free[..count]);
        let mut i = 0;
        while i < count {
            let (moment, x, y) = (splat(moments[i]), splat(x[i]), splat(y[i]));
            for n in 0..E {
                sums[0][n] = minus(sums[0][n], rows[i][n], moment);
                sums[1][n] = minus(sums[1][n], free[i][0][n], x);
                sums[2][n] = minus(sums[2][n], free[i][1][n], y);
            }
            i += 1;
        }
        let mut solution = [splat(N::ZERO); E];
        for n in 0..E {
            solution[n] = add(add(sums[1][n], sums[2][n]), sums[0][n]);
        }
        solution
    }

    /// The forces on the arms with these accelerations and reactions.
    #[inline(always)]
    pub fn force(
        &self,
        [x, y]: &Pair<N, L, F>,
        accelerations: &[N],
        reactions: &[N],
        loads: Pair<N, L, F>,
    ) -> Pair<N, L, F> {
        let (x, y) = (x.as_flattened(), y.as_flattened());
        let count = self.masses.len().min(F * L).min(WIDTH);
        let (masses, turning) = (&self.masses[..count], &self.turning[..count]);
        let [mut by_x, mut by_y] = [loads, [[splat(N::ZERO); F]; 2]];
        let mut i = 0;
        while i < count {
            let ([re, im], x, y) = (&masses[i], splat(x[i]), splat(y[i]));
            for f in 0..F {
                (by_x[0][f], by_x[1][f]) = (plus(by_x[0][f], re[f], x), plus(by_x[1][f], im[f], x));
                (by_y[0][f], by_y[1][f]) = (plus(by_y[0][f], im[f], y), plus(by_y[1][f], re[f], y));
            }
            i += 1;
        }
        let mut sum = by_x;
        for f in 0..F {
            (sum[0][f], sum[1][f]) = (subtract(by_x[0][f], by_y[0][f]), add(by_x[1][f], by_y[1][f]));
        }
        sum = react(sum, turning, accelerations);
        react(sum, self.constrained, reactions)
    }
}

/// Adds forces times a value each.
#[inline(always)]
fn react<N: Number, const L: usize, const F: usize>(
    mut sum: Pair<N, L, F>,
    forces: &[Pair<N, L, F>],
    values: &[N],
) -> Pair<N, L, F> {
    let count = forces.len().min(values.len());
    let (forces, values) = (&forces[..count], &values[..count]);
    let mut i = 0;
    while i < count {
        let value = splat(values[i]);
        for f in 0..F {
            sum[0][f] = plus(sum[0][f], forces[i][0][f], value);
            sum[1][f] = plus(sum[1][f], forces[i][1][f], value);
        }
        i += 1;
    }
    sum
}

/// Adds rows, no more than a lane of them, times a value each.
#[inline(always)]
fn gather<N: Number, const L: usize, const E: usize>(
    sums: &mut [[Lane<N, L>; E]; 2],
    rows: &[[Lane<N, L>; E]],
    [x, y]: [Lane<N, L>; 2],
) {
    let [mut by_x, mut by_y] = *sums;
    let rows = &rows[..rows.len().min(L)];
    let mut i = 0;
    while i < rows.len() {
        for n in 0..E {
            by_x[n] = plus(by_x[n], rows[i][n], splat(x[i]));
            by_y[n] = plus(by_y[n], rows[i][n], splat(y[i]));
        }
        i += 1;
    }
    *sums = [by_x, by_y];
}
