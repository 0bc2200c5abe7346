//! How a pose of frames only responds to what an order leaves unbalanced, found once a step.
//!
//! Let h be the second derivatives of the arms without the new accelerations. Then x, the accelerations and reactions of an order, follows from
//! K x = -(moments + S h) with K = \[M J^T; J 0\], where S h are the moments of the forces A h and what h leaves of the loop equations. The forces on
//! the arms are A h + (A D + R) x with the derivatives D of the arms by their angles and the reactions' directions R. With K^-1 S and A D + R at hand,
//! x need not wait for A h, nor the forces for the arms.

use super::frames::Fixed;
use crate::linalg::lane::{Lane, WIDTH, ZERO, add, minus, multiply, plus, splat, subtract};

/// For one lane of frames and N of all equations.
#[derive(Clone, Debug, Default)]
pub(super) struct Response {
    /// K^-1 S: for both components of h of each frame, N lanes.
    free: Vec<Lane>,
    /// A D + R: for each of x, both components of the forces.
    forced: Vec<[Lane; 2]>,
    /// A: for each frame, the masses that its arm accelerates.
    masses: Vec<[Lane; 2]>,
}

impl Response {
    /// Storage.
    pub fn new(frames: usize, rows: usize, lanes: usize) -> Self {
        Self {
            free: vec![ZERO; 2 * frames * lanes],
            forced: vec![[ZERO; 2]; frames + rows],
            masses: vec![[ZERO; 2]; frames],
        }
    }

    /// At the pose x + i y, with S lanes of unknowns.
    #[inline(always)]
    pub fn find<const S: usize, const N: usize>(&mut self, fixed: &Fixed, x: Lane, y: Lane) {
        let [frames, loops] = fixed.equations;
        let (balanced, closed) = fixed.inverse.rows::<N>().split_at_checked(S * WIDTH).unwrap_or_default();
        let balanced = &balanced[..frames.min(balanced.len())];
        let free = self.free.as_chunks_mut::<N>().0.as_chunks_mut::<2>().0;
        free.fill([[ZERO; N]; 2]);
        self.forced.fill([ZERO; 2]);
        self.masses.fill([ZERO; 2]);
        let (columns, parts_re, parts_im) = fixed.coupling.lane(0);
        for i in 0..columns.len() {
            let (column, re, im) = (columns[i], parts_re[i], parts_im[i]);
            let moments = [subtract(multiply(x, im), multiply(y, re)), plus(multiply(x, re), y, im)];
            if column < frames.min(free.len()).min(self.masses.len()).min(self.forced.len()) {
                gather(&mut free[column], balanced, moments);
                let (dx, dy) = (splat(-y[column % WIDTH]), splat(x[column % WIDTH]));
                self.masses[column] = [re, im];
                self.forced[column] = [minus(multiply(re, dx), im, dy), plus(multiply(re, dy), im, dx)];
            }
        }
        let (columns, parts_re, parts_im) = fixed.reactions.lane(0);
        for i in 0..columns.len() {
            if let Some(forced) = self.forced.get_mut(frames + columns[i]) {
                *forced = [parts_re[i], parts_im[i]];
            }
        }
        let (mut lane, mut first) = (0, 0);
        while first < loops.min(closed.len()) {
            let rows = &closed[first..loops.min(closed.len()).min(first + WIDTH)];
            let (columns, parts_re, parts_im) = fixed.rows.lane(lane);
            for i in 0..columns.len() {
                if columns[i] < free.len() {
                    gather(&mut free[columns[i]], rows, [parts_re[i], parts_im[i]]);
                }
            }
            (lane, first) = (lane + 1, first + WIDTH);
        }
    }

    /// Everything that an order reads, side by side.
    #[inline(always)]
    pub fn view<'a, const N: usize>(&'a self, fixed: &Fixed<'a>) -> View<'a, N> {
        let (turning, constrained) = self.forced.split_at_checked(fixed.equations[0]).unwrap_or_default();
        let rows = fixed.inverse.rows::<N>();
        let free = self.free.as_chunks::<N>().0.as_chunks::<2>().0;
        let count = turning.len().min(rows.len()).min(free.len()).min(self.masses.len()).min(WIDTH);
        View {
            rows: &rows[..count],
            free: &free[..count],
            masses: &self.masses[..count],
            turning: &turning[..count],
            constrained,
        }
    }
}

/// What an order of one lane of frames reads; all but the last have an entry for each frame.
pub(super) struct View<'a, const N: usize> {
    rows: &'a [[Lane; N]],
    free: &'a [[[Lane; N]; 2]],
    masses: &'a [[Lane; 2]],
    turning: &'a [[Lane; 2]],
    constrained: &'a [[Lane; 2]],
}

impl<const N: usize> View<'_, N> {
    /// Accelerations and reactions that make up for these moments and h.
    #[inline(always)]
    pub fn solve(&self, moments: Lane, [x, y]: [Lane; 2]) -> [Lane; N] {
        // Three sums, which do not wait for each other.
        let mut sums = [[ZERO; N]; 3];
        let count = self.rows.len().min(WIDTH);
        let (rows, free) = (&self.rows[..count], &self.free[..count]);
        let mut i = 0;
        while i < count {
            let (moment, x, y) = (splat(moments[i]), splat(x[i]), splat(y[i]));
            for n in 0..N {
                sums[0][n] = minus(sums[0][n], rows[i][n], moment);
                sums[1][n] = minus(sums[1][n], free[i][0][n], x);
                sums[2][n] = minus(sums[2][n], free[i][1][n], y);
            }
            i += 1;
        }
        let mut solution = [ZERO; N];
        for n in 0..N {
            solution[n] = add(add(sums[1][n], sums[2][n]), sums[0][n]);
        }
        solution
    }

    /// The forces on the arms with these accelerations and reactions.
    #[inline(always)]
    pub fn force(&self, [x, y]: [Lane; 2], accelerations: &Lane, reactions: &[f64], loads: [Lane; 2]) -> [Lane; 2] {
        let count = self.masses.len().min(WIDTH);
        let (masses, turning) = (&self.masses[..count], &self.turning[..count]);
        let [mut by_x, mut by_y] = [loads, [ZERO; 2]];
        let mut i = 0;
        while i < count {
            let ([re, im], x, y) = (masses[i], splat(x[i]), splat(y[i]));
            by_x = [plus(by_x[0], re, x), plus(by_x[1], im, x)];
            by_y = [plus(by_y[0], im, y), plus(by_y[1], re, y)];
            i += 1;
        }
        let mut sum = [subtract(by_x[0], by_y[0]), add(by_x[1], by_y[1])];
        i = 0;
        while i < count {
            let value = splat(accelerations[i]);
            sum = [plus(sum[0], turning[i][0], value), plus(sum[1], turning[i][1], value)];
            i += 1;
        }
        let count = self.constrained.len().min(reactions.len());
        let (constrained, reactions) = (&self.constrained[..count], &reactions[..count]);
        i = 0;
        while i < count {
            let value = splat(reactions[i]);
            sum = [plus(sum[0], constrained[i][0], value), plus(sum[1], constrained[i][1], value)];
            i += 1;
        }
        sum
    }
}

/// Adds rows, no more than a lane of them, times a value each.
#[inline(always)]
fn gather<const N: usize>(sums: &mut [[Lane; N]; 2], rows: &[[Lane; N]], [x, y]: [Lane; 2]) {
    let [mut by_x, mut by_y] = *sums;
    let rows = &rows[..rows.len().min(WIDTH)];
    let mut i = 0;
    while i < rows.len() {
        for n in 0..N {
            by_x[n] = plus(by_x[n], rows[i][n], splat(x[i]));
            by_y[n] = plus(by_y[n], rows[i][n], splat(y[i]));
        }
        i += 1;
    }
    *sums = [by_x, by_y];
}
