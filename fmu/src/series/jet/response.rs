//! How a pose of frames only responds to what an order leaves unbalanced, found once a step.
//!
//! Let h be the second derivatives of the arms without the new accelerations. Then x, the accelerations and reactions of an order, follows from
//! K x = -(moments + S h) with K = \[M J^T; J 0\], where S h are the moments of the forces A h and what h leaves of the loop equations. The forces on
//! the arms are A h + (A D + R) x with the derivatives D of the arms by their angles and the reactions' directions R. With K^-1 S and A D + R at hand,
//! x need not wait for A h, nor the forces for the arms.

use super::frames::Fixed;
use crate::series::lane::{Lane, WIDTH, ZERO, add, minus, multiply, plus, splat, subtract};

/// For one lane of frames and N of all equations.
#[derive(Clone, Debug, Default)]
pub(super) struct Response {
    /// K^-1 S: for both components of h of each frame, N lanes.
    free: Vec<Lane>,
    /// A D + R: for each of x, both components of the forces.
    forced: Vec<[Lane; 2]>,
}

impl Response {
    /// Storage.
    pub fn new(frames: usize, rows: usize, lanes: usize) -> Self {
        Self { free: vec![ZERO; 2 * frames * lanes], forced: vec![[ZERO; 2]; frames + rows] }
    }

    /// At the pose x + i y.
    #[inline(always)]
    pub fn find<const N: usize>(&mut self, fixed: &Fixed, x: Lane, y: Lane) {
        let [frames, _] = fixed.equations;
        let rows = fixed.inverse.rows::<N>();
        let (balanced, closed) = rows.split_at_checked(WIDTH).unwrap_or_default();
        let free = self.free.as_chunks_mut::<N>().0.as_chunks_mut::<2>().0;
        free.fill([[ZERO; N]; 2]);
        self.forced.fill([ZERO; 2]);
        for (column, re, im) in fixed.coupling.pieces(0) {
            let moments = [subtract(multiply(x, im), multiply(y, re)), plus(multiply(x, re), y, im)];
            let (Some(free), Some(forced)) = (free.get_mut(column), self.forced.get_mut(column)) else { continue };
            gather(free, balanced, moments);
            let [dx, dy] = [-y[column % WIDTH], x[column % WIDTH]].map(splat);
            *forced = [minus(multiply(re, dx), im, dy), plus(multiply(re, dy), im, dx)];
        }
        for (row, re, im) in fixed.reactions.pieces(0) {
            if let Some(forced) = self.forced.get_mut(frames + row) {
                *forced = [re, im];
            }
        }
        for (lane, closed) in closed.chunks(WIDTH).enumerate() {
            for (column, re, im) in fixed.rows.pieces(lane) {
                if let Some(free) = free.get_mut(column) {
                    gather(free, closed, [re, im]);
                }
            }
        }
    }

    /// Accelerations and reactions that make up for these moments and h.
    #[inline(always)]
    pub fn solve<const N: usize>(&self, fixed: &Fixed, moments: Lane, [x, y]: [Lane; 2]) -> [Lane; N] {
        // Three sums, which do not wait for each other.
        let mut sums = [[ZERO; N]; 3];
        let free = self.free.as_chunks::<N>().0.as_chunks::<2>().0;
        for (i, (row, [by_x, by_y])) in fixed.inverse.rows::<N>().iter().zip(free).enumerate().take(WIDTH) {
            let [moment, x, y] = [moments[i], x[i], y[i]].map(splat);
            for n in 0..N {
                sums[0][n] = minus(sums[0][n], row[n], moment);
                sums[1][n] = minus(sums[1][n], by_x[n], x);
                sums[2][n] = minus(sums[2][n], by_y[n], y);
            }
        }
        std::array::from_fn(|n| add(add(sums[1][n], sums[2][n]), sums[0][n]))
    }

    /// The forces on the arms with these accelerations and reactions.
    #[inline(always)]
    pub fn force<const N: usize>(
        &self,
        fixed: &Fixed,
        [x, y]: [Lane; 2],
        solution: &[Lane; N],
        loads: [Lane; 2],
    ) -> [Lane; 2] {
        let mut sum = fixed.coupling.complex(0, &x, &y, loads);
        let (accelerations, reactions) = solution.as_flattened().split_at(WIDTH);
        let (turning, held) = self.forced.split_at_checked(fixed.equations[0]).unwrap_or_default();
        for (forced, values) in [(turning, accelerations), (held, reactions)] {
            for ([x, y], value) in forced.iter().zip(values) {
                sum = [plus(sum[0], *x, splat(*value)), plus(sum[1], *y, splat(*value))];
            }
        }
        sum
    }
}

/// Adds rows times a value each.
#[inline(always)]
fn gather<const N: usize>(sums: &mut [[Lane; N]; 2], rows: &[[Lane; N]], values: [Lane; 2]) {
    for (sum, values) in sums.iter_mut().zip(values) {
        for (row, value) in rows.iter().zip(values) {
            for (sum, entry) in sum.iter_mut().zip(row) {
                *sum = plus(*sum, *entry, splat(value));
            }
        }
    }
}
