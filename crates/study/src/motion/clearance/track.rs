//! Where a body is at any input: between the samples of a turn or stroke by the polynomials that have the positions, rates and accelerations of both neighbours.

use std::f64::consts::TAU;

use cotree::model::Quantity;

use super::super::drive::{InputTable, POSE};
use super::distance::{Point, difference, norm};

/// Where a body is: its position, and its angle.
pub type Pose = [f64; 3];

const RATES: [Quantity; 3] = [Quantity::Vx, Quantity::Vy, Quantity::Omega];
const ACCELERATIONS: [Quantity; 3] = [Quantity::Ax, Quantity::Ay, Quantity::Alpha];

/// The samples of a body's motion.
pub struct BodyTrack {
    /// For each sample position, rate and acceleration by the steps of the input, of x, y and the angle.
    samples: Vec<[[f64; 3]; 3]>,
}

impl BodyTrack {
    /// The body with this name; none if the scene lacks something of its motion. `step` is that of the input, `rate` the input's.
    pub fn of(table: &InputTable, body: &str, step: f64, rate: f64) -> Option<BodyTrack> {
        let column = |quantity: Quantity| table.get(&quantity.of(body)).map(|samples| samples.values().to_vec());
        let columns: Option<Vec<[Vec<f64>; 3]>> = (0..3)
            .map(|axis| Some([column(POSE[axis])?, column(RATES[axis])?, column(ACCELERATIONS[axis])?]))
            .collect();
        let columns = columns?;
        let scale = [1.0, step / rate, (step / rate).powi(2)];
        let at = |index: usize, axis: usize| std::array::from_fn(|order| scale[order] * columns[axis][order][index]);
        let mut samples: Vec<[[f64; 3]; 3]> =
            (0..table.count()).map(|index| std::array::from_fn(|axis| at(index, axis))).collect();
        if table.periodic {
            samples.extend(samples.first().copied());
        }
        Some(BodyTrack { samples })
    }

    /// Where the body is at a place in steps.
    pub fn pose(&self, place: f64) -> Pose {
        let first = (place.floor().max(0.0) as usize).min(self.samples.len().saturating_sub(2));
        let Some([from, to]) = self.samples.get(first..first + 2) else {
            return self.samples[first].map(|axis| axis[0]);
        };
        std::array::from_fn(|axis| {
            let (from, mut to) = (from[axis], to[axis]);
            if axis == 2 {
                // A table of a turn has angles within turns of their own.
                let predicted = from[0] + 0.5 * (from[1] + to[1]);
                to[0] += TAU * ((predicted - to[0]) / TAU).round();
            }
            hermite(from, to, place - first as f64)
        })
    }

    /// Velocities by the steps of the input.
    fn rates(&self, index: usize) -> [f64; 3] {
        self.samples[index].map(|axis| axis[1])
    }

    fn centre(&self, index: usize) -> Point {
        [self.samples[index][0][0], self.samples[index][1][0]]
    }
}

/// The polynomial of order five with a position, rate and acceleration at 0 and at 1.
fn hermite(from: [f64; 3], to: [f64; 3], s: f64) -> f64 {
    let (r, cube) = (1.0 - s, s * s * s);
    // Differences to the start keep the digits of a position that is far from the origin.
    let step = to[0] - from[0];
    let middle = step * (10.0 - 15.0 * s + 6.0 * s * s)
        - from[1] * (6.0 - 8.0 * s + 3.0 * s * s)
        - to[1] * (4.0 - 7.0 * s + 3.0 * s * s)
        + 0.5 * to[2] * r * r;
    from[0] + s * from[1] + 0.5 * from[2] * s * s * r * r * r + cube * middle
}

/// A speed that no point of one outline exceeds against the other, by the steps of the input, in the steps around a sample. Seen from either of the two: the smaller.
pub fn speed(tracks: [Option<&BodyTrack>; 2], radii: [f64; 2], index: usize) -> f64 {
    let rates = tracks.map(|track| track.map_or([0.0; 3], |track| track.rates(index)));
    let centres = tracks.map(|track| track.map_or([0.0; 2], |track| track.centre(index)));
    let seen_from = |from: usize| {
        let other = 1 - from;
        let [x, y] = difference(centres[other], centres[from]);
        let turn = rates[from][2];
        let relative = [rates[other][0] - rates[from][0] + turn * y, rates[other][1] - rates[from][1] - turn * x];
        norm(relative) + (rates[other][2] - turn).abs() * radii[other]
    };
    seen_from(0).min(seen_from(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_order_five_is_itself() {
        let of = |x: f64| [3.0 - x + x * x - 2.0 * x.powi(3) + x.powi(4) - 0.5 * x.powi(5), 0.0, 0.0];
        let value = |x: f64| {
            let rate = -1.0 + 2.0 * x - 6.0 * x * x + 4.0 * x.powi(3) - 2.5 * x.powi(4);
            [of(x)[0], rate, 2.0 - 12.0 * x + 12.0 * x * x - 10.0 * x.powi(3)]
        };
        for s in [0.0, 0.2, 0.5, 0.9, 1.0] {
            assert!((hermite(value(0.0), value(1.0), s) - of(s)[0]).abs() < 1e-14, "{s}");
        }
    }
}
