//! An open chain of frames, whose full matrices are simple. (Chains that branch are in `tree`.)
//!
//! Of two frames let k be the one nearer to the ground. The masses between their arms are A_kl = a_k m_l, where a_k is the link of k (conjugated) and m_l what
//! l carries; A_lk is the conjugate. So sums over l are found while one walks along the chain, and cost its length, not the square of it.

use super::ROUNDING_OF_SUMS;
use super::columns::Entry;
use super::lane::{Lane, WIDTH, minus, plus, splat};
use super::number::Number;
use super::tree::Limb;

/// A complex number.
pub(super) type Complex<N = f64> = [N; 2];

/// The masses of a chain of frames, numbered from the ground.
#[derive(Clone, Debug)]
pub(crate) struct Chain<N = f64, const L: usize = WIDTH> {
    /// Are the masses products of links and loads?
    holds: bool,
    frames: usize,
    /// A_kl of all k and l that differ.
    entries: Vec<Entry>,
    /// a, real and imaginary parts.
    links: [Vec<Lane<N, L>>; 2],
    /// m
    loads: [Vec<Lane<N, L>>; 2],
}

impl<N: Number, const L: usize> Chain<N, L> {
    /// From the entries between so many frames; none if some of them do not feel each other.
    pub fn new(frames: usize, entries: &[Entry]) -> Option<Self> {
        let between = |entry: &&Entry| entry.0 < frames && entry.1 < frames;
        let entries: Vec<Entry> = entries.iter().filter(between).copied().collect();
        let zeros = || vec![splat(N::ZERO); frames.div_ceil(L)];
        let full = entries.len() == frames * (frames - 1) && entries.iter().all(|entry| entry.0 != entry.1);
        full.then(|| Self { holds: false, frames, entries, links: [zeros(), zeros()], loads: [zeros(), zeros()] })
    }

    /// For so many frames whose links and loads are given.
    pub fn of_limbs(frames: usize) -> Self {
        let zeros = || vec![splat(N::ZERO); frames.div_ceil(L)];
        Self { holds: true, frames, entries: Vec::new(), links: [zeros(), zeros()], loads: [zeros(), zeros()] }
    }

    /// Takes links and loads over.
    pub fn renew(&mut self, limbs: &[Limb<N>]) {
        for (k, limb) in limbs.iter().enumerate() {
            put(&mut self.loads, k, limb.carried);
            if let Some(before) = limb.parent {
                put(&mut self.links, before, conjugate(limb.begin));
            }
        }
    }

    /// Is it one, with the present coefficients?
    pub fn holds(&self) -> bool {
        self.holds
    }

    /// Number of links and loads.
    pub fn count(&self) -> usize {
        2 * self.frames
    }

    /// Takes the coefficients over. The links are what the last frame does to the others, if what it carries is one; the loads follow from what they do to
    /// the first.
    pub fn fill(&mut self, c: &[N]) {
        let value = |mass: [u32; 2]| mass.map(|part| c[part as usize]);
        let last = self.frames - 1;
        let ends = self.entries.iter().find(|entry| (entry.0, entry.1) == (0, last));
        let whole = ends.map_or([N::ZERO; 2], |entry| value(entry.2));
        for &(row, column, mass) in &self.entries {
            if column == last {
                put(&mut self.links, row, value(mass));
            }
            if row == 0 {
                put(&mut self.loads, column, quotient(value(mass), whole));
            }
        }
        self.holds = self.entries.iter().all(|&(row, column, mass)| {
            let found = if row < column {
                product(part(&self.links, row), part(&self.loads, column))
            } else {
                conjugate(product(part(&self.links, column), part(&self.loads, row)))
            };
            distance(found, value(mass)) <= ROUNDING_OF_SUMS * distance(found, [N::ZERO; 2])
        });
    }

    /// Its frames as limbs, with these inertias; each has the equation of its number.
    pub fn limbs(&self, inertia: &[Lane<N, L>]) -> Vec<Limb<N>> {
        let limb = |(k, &inertia): (usize, &N)| Limb {
            place: k,
            derivative: k,
            parent: k.checked_sub(1),
            equation: Some(k),
            begin: conjugate(k.checked_sub(1).map_or([N::ZERO; 2], |before| part(&self.links, before))),
            carried: part(&self.loads, k),
            inertia,
        };
        inertia.as_flattened().iter().take(self.frames).enumerate().map(limb).collect()
    }

    /// Adds the forces between frames of different lanes: a_k times the sum of m_l (x + i y)_l over those further out, and the conjugate of m_k times that
    /// of the conjugates of a_l over those further in.
    #[inline(always)]
    pub fn add_forces(&self, x: &[Lane<N, L>], y: &[Lane<N, L>], fx: &mut [Lane<N, L>], fy: &mut [Lane<N, L>]) {
        let ([ax, ay], [mx, my]) = (&self.links, &self.loads);
        let count = ax.len().min(ay.len()).min(mx.len()).min(my.len());
        let count = count.min(x.len()).min(y.len()).min(fx.len()).min(fy.len());
        let (mut inner_x, mut inner_y) = (splat(N::ZERO), splat(N::ZERO));
        for k in 0..count {
            let [sx, sy] = [sum(inner_x), sum(inner_y)];
            fx[k] = plus(plus(fx[k], mx[k], sx), my[k], sy);
            fy[k] = minus(plus(fy[k], mx[k], sy), my[k], sx);
            inner_x = plus(plus(inner_x, ax[k], x[k]), ay[k], y[k]);
            inner_y = minus(plus(inner_y, ax[k], y[k]), ay[k], x[k]);
        }
        let (mut outer_x, mut outer_y) = (splat(N::ZERO), splat(N::ZERO));
        for k in (0..count).rev() {
            let [sx, sy] = [sum(outer_x), sum(outer_y)];
            fx[k] = minus(plus(fx[k], ax[k], sx), ay[k], sy);
            fy[k] = plus(plus(fy[k], ax[k], sy), ay[k], sx);
            outer_x = minus(plus(outer_x, mx[k], x[k]), my[k], y[k]);
            outer_y = plus(plus(outer_y, mx[k], y[k]), my[k], x[k]);
        }
    }
}

/// The sum of all places, the halves apart, in every place.
#[inline(always)]
fn sum<N: Number, const L: usize>(lane: Lane<N, L>) -> Lane<N, L> {
    let half = |part: &[N]| part[1..].iter().fold(part[0], |sum, value| sum + *value);
    let (first, second) = lane.split_at(L.div_ceil(2));
    splat(if second.is_empty() { half(first) } else { half(first) + half(second) })
}

fn put<N: Number, const L: usize>(lanes: &mut [Vec<Lane<N, L>>; 2], place: usize, value: Complex<N>) {
    for (lanes, part) in lanes.iter_mut().zip(value) {
        lanes.as_flattened_mut()[place] = part;
    }
}

fn part<N: Number, const L: usize>(lanes: &[Vec<Lane<N, L>>; 2], place: usize) -> Complex<N> {
    [lanes[0].as_flattened()[place], lanes[1].as_flattened()[place]]
}

pub(super) fn conjugate<N: Number>([re, im]: Complex<N>) -> Complex<N> {
    [re, -im]
}

pub(super) fn product<N: Number>([a, b]: Complex<N>, [c, d]: Complex<N>) -> Complex<N> {
    [a * c - b * d, a * d + b * c]
}

fn quotient<N: Number>(a: Complex<N>, [c, d]: Complex<N>) -> Complex<N> {
    let [re, im] = product(a, [c, -d]);
    let size = c * c + d * d;
    [re.over(size), im.over(size)]
}

fn distance<N: Number>([a, b]: Complex<N>, [c, d]: Complex<N>) -> f64 {
    let [x, y] = [(a - c).value(), (b - d).value()];
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::lane::{lanes, subtract};
    use crate::linalg::tree::Recursion;
    use crate::taylor::coupling::Coupling;

    /// Entries of a chain of links a, carrying m: A_kl = a_k m_l for k < l.
    fn chain(count: usize, spoil: Option<usize>) -> (Vec<Entry>, Vec<f64>) {
        let link = |k: usize| [0.3 + 0.01 * k as f64, 0.02 - 0.003 * k as f64];
        let load = |k: usize| [4.0 - 0.1 * k as f64, 0.04 + 0.01 * k as f64];
        let (mut entries, mut coefficients) = (Vec::new(), Vec::new());
        for row in 0..count {
            for column in 0..count {
                let mut mass = match row.cmp(&column) {
                    std::cmp::Ordering::Less => product(link(row), load(column)),
                    std::cmp::Ordering::Equal => continue,
                    std::cmp::Ordering::Greater => conjugate(product(link(column), load(row))),
                };
                mass[0] += if spoil == Some(entries.len()) { 1e-9 } else { 0.0 };
                entries.push((row, column, [coefficients.len() as u32, coefficients.len() as u32 + 1]));
                coefficients.extend(mass);
            }
        }
        (entries, coefficients)
    }

    fn waves(lanes: usize, pace: f64) -> Vec<Lane> {
        (0..lanes).map(|k| std::array::from_fn(|i| (pace * (k * WIDTH + i) as f64).sin())).collect()
    }

    #[test]
    fn sums_along_a_chain_are_those_over_all_entries() {
        for frames in [13, 16, 30] {
            let (entries, coefficients) = chain(frames, None);
            let lanes = frames.div_ceil(WIDTH) + 1;
            let mut coupling: Coupling = Coupling::new(lanes, frames, &entries);
            coupling.fill(&coefficients);
            assert!(coupling.chain().is_some(), "{frames}");
            let (x, y) = (waves(lanes, 0.7), waves(lanes, 1.3));
            let mut forces = [vec![splat(0.5); lanes], vec![splat(-0.5); lanes]];
            coupling.add_forces(&x, &y, &mut forces);
            for (lane, (x_force, y_force)) in forces[0].iter().zip(&forces[1]).enumerate() {
                let loads = [splat(0.5), splat(-0.5)];
                let expected = coupling.entries().complex(lane, x.as_flattened(), y.as_flattened(), loads);
                for (found, expected) in [*x_force, *y_force].into_iter().zip(expected) {
                    let error = subtract(found, expected);
                    assert!(error.iter().all(|error| error.abs() < 1e-11), "{frames} {lane} {found:?} {expected:?}");
                }
            }
        }
    }

    #[test]
    fn the_factors_of_a_chain_solve_its_equations() {
        let count = 14;
        let (entries, coefficients) = chain(count, None);
        let mut chain: Chain = Chain::new(count, &entries).unwrap();
        chain.fill(&coefficients);
        let angles = waves(lanes(count), 0.9);
        let [dx, dy]: [Vec<Lane>; 2] =
            [f64::cos, f64::sin].map(|f| angles.iter().map(|lane| lane.map(|a| f(3.0 * a))).collect());
        let inertia = vec![splat(20.0); lanes(count)];
        let mut recursion = Recursion::new(&chain.limbs(&inertia));
        assert!(recursion.factor([dx.as_flattened(), dy.as_flattened()]));
        let x: Vec<f64> = (0..count).map(|k| 1.0 - 0.3 * k as f64).collect();
        let arm = |k: usize| [dx.as_flattened()[k], dy.as_flattened()[k]];
        let mut right: Vec<f64> = x.iter().map(|x| 20.0 * x).collect();
        for &(row, column, mass) in &entries {
            let force = product(mass.map(|part| coefficients[part as usize]), arm(column));
            right[row] += product(conjugate(arm(row)), force)[0] * x[column];
        }
        let mut found = vec![0.0; count];
        recursion.solve(&right, &mut found);
        assert!(found.iter().zip(&x).all(|(found, x)| (found - x).abs() < 1e-11), "{found:?} {x:?}");
        recursion.renew(&chain.limbs(&vec![splat(f64::NAN); lanes(count)]));
        assert!(!recursion.factor([dx.as_flattened(), dy.as_flattened()]));
    }

    #[test]
    fn what_is_no_chain_is_summed_entry_by_entry() {
        let (entries, coefficients) = chain(16, Some(7));
        let mut coupling: Coupling = Coupling::new(4, 16, &entries);
        coupling.fill(&coefficients);
        assert!(coupling.chain().is_none());
        assert!(<Chain>::new(16, &entries[..200]).is_none());
    }
}
