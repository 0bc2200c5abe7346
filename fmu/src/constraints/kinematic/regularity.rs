//! How regular the loop equations of a driven mechanism are at a pose, block by block: what tells apart the solutions of a block.
//!
//! The other solution of a dyad is as far away as the angle between its bars; in general the distance is about that of the Jacobian to a
//! singular one, 1 / |J^-1| with rows and columns of unit size (Eckart, Young 1936). Its determinant has another sign there.

use crate::constraints::loops::Loops;
use crate::model::Model;

/// One block at one pose.
#[derive(Clone, Debug, Default)]
struct Regularity {
    /// Reciprocal pivots of the LU factors.
    reciprocals: Vec<f64>,
    /// Has an odd number of rows been exchanged?
    odd: bool,
    /// Distance to singularity, 1 at most.
    distance: f64,
}

/// All blocks at two poses: where a step starts, and where it ends.
#[derive(Clone, Debug)]
pub(super) struct Monitor {
    start: Vec<Regularity>,
    end: Vec<Regularity>,
    /// For the estimate of a norm.
    vectors: [Vec<f64>; 3],
}

impl Monitor {
    pub fn new(loops: &Loops) -> Self {
        let of = |block: usize| Regularity { reciprocals: vec![0.0; loops.size(block)], ..Regularity::default() };
        let blocks: Vec<Regularity> = (0..loops.blocks()).map(of).collect();
        let largest = (0..loops.blocks()).map(|block| loops.size(block)).max().unwrap_or_default();
        Self { start: blocks.clone(), end: blocks, vectors: std::array::from_fn(|_| vec![0.0; largest]) }
    }

    /// The loop equations have been factored where a step starts.
    pub fn record_start(&mut self, model: &Model, loops: &Loops) {
        record(&mut self.start, &mut self.vectors, model, loops);
    }

    /// The loop equations have been factored where it ends.
    pub fn record_end(&mut self, model: &Model, loops: &Loops) {
        record(&mut self.end, &mut self.vectors, model, loops);
    }

    /// The ratio of a block's determinants, at the end to that at the start.
    pub fn ratio(&self, block: usize) -> f64 {
        let (start, end) = (&self.start[block], &self.end[block]);
        let sign = if start.odd == end.odd { 1.0 } else { -1.0 };
        start.reciprocals.iter().zip(&end.reciprocals).fold(sign, |ratio, (start, end)| ratio * (start / end))
    }

    /// The smaller of a block's distances to singularity.
    pub fn distance(&self, block: usize) -> f64 {
        f64::min(self.start[block].distance, self.end[block].distance)
    }

    /// The block that is least regular at the start.
    pub fn weakest(&self) -> Option<usize> {
        (0..self.start.len()).min_by(|&a, &b| self.start[a].distance.total_cmp(&self.start[b].distance))
    }

    /// How regular a block is at the start.
    pub fn start_distance(&self, block: usize) -> f64 {
        self.start[block].distance
    }
}

fn record(blocks: &mut [Regularity], vectors: &mut [Vec<f64>; 3], model: &Model, loops: &Loops) {
    for (block, regularity) in blocks.iter_mut().enumerate() {
        let places = regularity.reciprocals.iter_mut();
        places.zip(loops.reciprocal_pivots(block)).for_each(|(place, reciprocal)| *place = reciprocal);
        regularity.odd = loops.is_odd(block);
        let size = regularity.reciprocals.len();
        let vectors = vectors.each_mut().map(|vector| &mut vector[..size]);
        regularity.distance = 1.0
            / inverse_norm(vectors, |vector, transposed| {
                loops.solve_scaled(model, block, vector, transposed);
            });
    }
}

/// A lower bound of |A^-1| in the 1-norm, mostly the norm itself (Hager 1984; Higham 1988, algorithm 2.4). `solve` replaces b by A^-1 b, or by A^-T b.
fn inverse_norm([x, y, signs]: [&mut [f64]; 3], mut solve: impl FnMut(&mut [f64], bool)) -> f64 {
    /// It has seldom needed more (Higham 1988).
    const STEPS: usize = 5;
    let size = x.len() as f64;
    let norm = |y: &[f64]| y.iter().map(|y| y.abs()).sum::<f64>();
    x.fill(1.0 / size);
    let mut estimate = 0.0;
    for _ in 0..STEPS {
        y.copy_from_slice(x);
        solve(y, false);
        let found = norm(y);
        // Written so that NaN ends it too.
        let grows = found > estimate;
        if !grows {
            break;
        }
        estimate = found;
        signs.iter_mut().zip(y.iter()).for_each(|(sign, y)| *sign = if *y < 0.0 { -1.0 } else { 1.0 });
        solve(signs, true);
        let steepest = (0..x.len()).max_by(|&a, &b| signs[a].abs().total_cmp(&signs[b].abs())).unwrap_or_default();
        let slope: f64 = signs.iter().zip(x.iter()).map(|(z, x)| z * x).sum();
        if signs[steepest].abs() <= slope {
            break;
        }
        x.fill(0.0);
        x[steepest] = 1.0;
    }
    // Against a start that hides the largest column.
    let share = f64::max(size - 1.0, 1.0);
    for (place, x) in x.iter_mut().enumerate() {
        let value = 1.0 + place as f64 / share;
        *x = if place % 2 == 0 { value } else { -value };
    }
    solve(x, false);
    f64::max(estimate, 2.0 * norm(x) / (3.0 * size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_bars_the_distance_is_about_the_sine_between_them() {
        for angle in [1.5, 0.3, 1e-3, 1e-7, -1e-5] {
            let (sine, cosine) = (f64::sin(angle), f64::cos(angle));
            // Columns (1, 0) and (cosine, sine).
            let solve = |b: &mut [f64], transposed: bool| {
                let [first, second] = [b[0], b[1]];
                match transposed {
                    false => b.copy_from_slice(&[first - cosine * second / sine, second / sine]),
                    true => b.copy_from_slice(&[first, (second - cosine * first) / sine]),
                }
            };
            let mut vectors = [[0.0; 2]; 3];
            let [x, y, z] = &mut vectors;
            let distance = 1.0 / inverse_norm([x, y, z], solve);
            assert!((0.4..=1.01).contains(&(distance / sine.abs())), "{angle}: {distance}");
        }
    }
}
