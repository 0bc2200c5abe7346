//! Masses between arms: the forces that go with second derivatives of arms.
//!
//! In an open chain the matrix A of the masses is full, but simple: of two frames the force on the arm of the one nearer to the ground, k, is
//! A_kl b_l'' with A_kl = a_k m_l, where a_k is its own link (conjugated) and m_l what the other, l, carries; and A_lk is the conjugate of A_kl. The sums over l
//! are then found while one walks along the chain, and cost its length, not the square of it.

use super::columns::Columns;
use super::lane::{Lane, WIDTH, ZERO, minus, plus, splat};

/// With fewer lanes of frames sums along a chain gain nothing.
const LONG: usize = 4;
/// Products of links and loads are the masses up to rounding errors, relative to their size.
const ROUNDING: f64 = 1e-14;

/// A complex number.
type Complex = [f64; 2];

/// An entry of A: row, column, coefficients.
type Entry = (usize, usize, [u32; 2]);

/// The matrix A.
#[derive(Clone, Debug)]
pub(super) struct Coupling {
    all: Columns,
    chain: Option<Chain>,
}

/// Frames in the order of an open chain, as far as lanes tell: within a lane any order is fine.
#[derive(Clone, Debug)]
struct Chain {
    /// Are the masses products of links and loads?
    holds: bool,
    /// Entries between different lanes of frames.
    between: Vec<Entry>,
    /// The last frame.
    last: usize,
    /// All other entries.
    rest: Columns,
    /// a, real and imaginary parts.
    links: [Vec<Lane>; 2],
    /// m
    loads: [Vec<Lane>; 2],
}

impl Coupling {
    /// For entries (row, column, coefficients) of so many lanes, and so many frames, which come first.
    pub fn new(lanes: usize, frames: usize, entries: &[Entry]) -> Self {
        Self { all: Columns::new(lanes, entries), chain: Chain::new(lanes, frames, entries) }
    }

    /// Takes the coefficients over.
    pub fn fill(&mut self, coefficients: &[f64]) {
        self.all.fill(coefficients);
        if let Some(chain) = &mut self.chain {
            chain.fill(coefficients);
        }
    }

    /// Entry by entry.
    pub fn entries(&self) -> &Columns {
        &self.all
    }

    /// forces + A (x + i y), all lanes.
    #[inline(always)]
    pub fn add_forces(&self, x: &[Lane], y: &[Lane], forces: &mut [Vec<Lane>; 2]) {
        let chain = self.chain.as_ref().filter(|chain| chain.holds);
        let entries = chain.map_or(&self.all, |chain| &chain.rest);
        let [fx, fy] = forces;
        for (lane, (fx, fy)) in fx.iter_mut().zip(fy.iter_mut()).enumerate() {
            [*fx, *fy] = entries.complex(lane, x.as_flattened(), y.as_flattened(), [*fx, *fy]);
        }
        if let Some(chain) = chain {
            chain.add_forces(x, y, fx, fy);
        }
    }
}

impl Chain {
    /// None if there are too few frames, or some of them do not feel each other.
    fn new(lanes: usize, frames: usize, entries: &[Entry]) -> Option<Self> {
        let lanes_of_frames = frames.div_ceil(WIDTH);
        if lanes_of_frames < LONG {
            return None;
        }
        let is_between = |row: usize, column: usize| row < frames && column < frames && row / WIDTH != column / WIDTH;
        let (between, rest): (Vec<Entry>, Vec<Entry>) = entries.iter().partition(|entry| is_between(entry.0, entry.1));
        let full = (0..frames).map(|row| (0..frames).filter(|&column| is_between(row, column)).count()).sum::<usize>();
        let zeros = || [vec![ZERO; lanes_of_frames], vec![ZERO; lanes_of_frames]];
        (between.len() == full).then(|| Self {
            holds: false,
            between,
            last: frames - 1,
            rest: Columns::new(lanes, &rest),
            links: zeros(),
            loads: zeros(),
        })
    }

    /// The links are what the last frame does to the others, if what it carries is one; the loads follow from what they do to the first.
    fn fill(&mut self, c: &[f64]) {
        self.rest.fill(c);
        let value = |mass: [u32; 2]| mass.map(|part| c[part as usize]);
        let ends = self.between.iter().find(|&&(row, column, _)| (row, column) == (0, self.last));
        let whole = ends.map_or([0.0; 2], |entry| value(entry.2));
        for &(row, column, mass) in &self.between {
            if column == self.last {
                put(&mut self.links, row, value(mass));
            }
            if row == 0 {
                put(&mut self.loads, column, quotient(value(mass), whole));
            }
        }
        self.holds = self.between.iter().all(|&(row, column, mass)| {
            let found = if row < column {
                product(part(&self.links, row), part(&self.loads, column))
            } else {
                conjugate(product(part(&self.links, column), part(&self.loads, row)))
            };
            distance(found, value(mass)) <= ROUNDING * distance(found, [0.0; 2])
        });
    }

    /// a_k times the sum of m_l b_l'' over those further out, and the conjugate of m_k times that of the conjugates of a_l over those further in.
    #[inline(always)]
    fn add_forces(&self, x: &[Lane], y: &[Lane], fx: &mut [Lane], fy: &mut [Lane]) {
        let ([ax, ay], [mx, my]) = (&self.links, &self.loads);
        let count = ax.len().min(ay.len()).min(mx.len()).min(my.len());
        let count = count.min(x.len()).min(y.len()).min(fx.len()).min(fy.len());
        let (mut inner_x, mut inner_y) = (ZERO, ZERO);
        for k in 0..count {
            let [sx, sy] = [inner_x, inner_y].map(sum);
            fx[k] = plus(plus(fx[k], mx[k], sx), my[k], sy);
            fy[k] = minus(plus(fy[k], mx[k], sy), my[k], sx);
            inner_x = plus(plus(inner_x, ax[k], x[k]), ay[k], y[k]);
            inner_y = minus(plus(inner_y, ax[k], y[k]), ay[k], x[k]);
        }
        let (mut outer_x, mut outer_y) = (ZERO, ZERO);
        for k in (0..count).rev() {
            let [sx, sy] = [outer_x, outer_y].map(sum);
            fx[k] = minus(plus(fx[k], ax[k], sx), ay[k], sy);
            fy[k] = plus(plus(fy[k], ax[k], sy), ay[k], sx);
            outer_x = minus(plus(outer_x, mx[k], x[k]), my[k], y[k]);
            outer_y = plus(plus(outer_y, mx[k], y[k]), my[k], x[k]);
        }
    }
}

/// The sum of the four, in every place.
#[inline(always)]
fn sum([a, b, c, d]: Lane) -> Lane {
    splat((a + b) + (c + d))
}

fn put(lanes: &mut [Vec<Lane>; 2], place: usize, value: Complex) {
    for (lanes, part) in lanes.iter_mut().zip(value) {
        lanes.as_flattened_mut()[place] = part;
    }
}

fn part(lanes: &[Vec<Lane>; 2], place: usize) -> Complex {
    [lanes[0].as_flattened()[place], lanes[1].as_flattened()[place]]
}

fn conjugate([re, im]: Complex) -> Complex {
    [re, -im]
}

fn product([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

fn quotient(a: Complex, [c, d]: Complex) -> Complex {
    let [re, im] = product(a, [c, -d]);
    let size = c * c + d * d;
    [re / size, im / size]
}

fn distance([a, b]: Complex, [c, d]: Complex) -> f64 {
    (a - c).hypot(b - d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::lane::subtract;

    /// Entries of a chain of links a, carrying m: A_kl = a_k m_l for k < l; 1 on the diagonal.
    fn chain(frames: usize, spoil: Option<usize>) -> (Vec<Entry>, Vec<f64>) {
        let link = |k: usize| [0.3 + 0.1 * k as f64, 0.2 - 0.03 * k as f64];
        let load = |k: usize| [5.0 - 0.2 * k as f64, 0.4 + 0.01 * k as f64];
        let (mut entries, mut coefficients) = (Vec::new(), Vec::new());
        for row in 0..frames {
            for column in 0..frames {
                let mut mass = match row.cmp(&column) {
                    std::cmp::Ordering::Less => product(link(row), load(column)),
                    std::cmp::Ordering::Equal => [1.0, 0.0],
                    std::cmp::Ordering::Greater => conjugate(product(link(column), load(row))),
                };
                mass[0] += if spoil == Some(entries.len()) { 1e-9 } else { 0.0 };
                entries.push((row, column, [coefficients.len() as u32, coefficients.len() as u32 + 1]));
                coefficients.extend(mass);
            }
        }
        (entries, coefficients)
    }

    fn motion(lanes: usize) -> [Vec<Lane>; 2] {
        let lane =
            |seed: f64| (0..lanes).map(|k| std::array::from_fn(|i| (seed * (k * WIDTH + i) as f64).sin())).collect();
        [lane(0.7), lane(1.3)]
    }

    #[test]
    fn sums_along_a_chain_are_those_over_all_entries() {
        for frames in [13, 16, 30] {
            let (entries, coefficients) = chain(frames, None);
            let lanes = frames.div_ceil(WIDTH) + 1;
            let mut coupling = Coupling::new(lanes, frames, &entries);
            coupling.fill(&coefficients);
            assert!(coupling.chain.as_ref().is_some_and(|chain| chain.holds), "{frames}");
            let [x, y] = motion(lanes);
            let mut forces = [vec![splat(0.5); lanes], vec![splat(-0.5); lanes]];
            coupling.add_forces(&x, &y, &mut forces);
            for lane in 0..lanes {
                let loads = [splat(0.5), splat(-0.5)];
                let expected = coupling.all.complex(lane, x.as_flattened(), y.as_flattened(), loads);
                for (found, expected) in [forces[0][lane], forces[1][lane]].iter().zip(expected) {
                    let error = subtract(*found, expected);
                    assert!(error.iter().all(|error| error.abs() < 1e-12), "{frames} {lane} {found:?} {expected:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_chain_is_summed_entry_by_entry() {
        let (entries, coefficients) = chain(16, Some(7));
        let mut coupling = Coupling::new(4, 16, &entries);
        coupling.fill(&coefficients);
        assert!(coupling.chain.as_ref().is_some_and(|chain| !chain.holds));
        assert!(Coupling::new(4, 16, &entries[..200]).chain.is_none());
        assert!(Coupling::new(3, 12, &chain(12, None).0).chain.is_none());
    }
}
