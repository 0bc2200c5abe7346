//! Chains of bars one end of which is much heavier or much lighter than the rest.
//!
//! What the masses leave of a bar's inertia is a small difference of large numbers, so the reference is found with numbers of twice the precision: by Taylor
//! series of the bars' unit vectors, from the equations that the tree of bars has in absolute angles, with one factorisation a step.

use cotree::scene::Scene;

use super::four_bar::bar;
use super::reference::Reference;
use super::twofold::Twofold;
use super::{Case, Random};

const GRAVITY: f64 = 9.81;
/// Orders of the series, what the last one may contribute to a step, and how much of the step that it permits is taken.
const ORDER: usize = 30;
const NEGLIGIBLE: f64 = 1e-26;
const SAFETY: f64 = 0.8;
/// What rounding errors may do without a warning.
const ROUNDING: f64 = 1e-11;
/// A run lasts no longer than this, nor than so many radians of what oscillates fastest: a light bar that heavy ones hang from.
const LONGEST: f64 = 0.5;
const RADIANS: f64 = 40.0;

/// Bars that hang from each other.
struct Chain {
    lengths: Vec<f64>,
    masses: Vec<f64>,
    angles: Vec<f64>,
    rates: Vec<f64>,
}

/// A chain of 2 to 50 bars, one end of which is 1e-8 to 1e8 times as heavy as the others.
pub fn unlike_end(seed: u64) -> Case {
    let mut random = Random(7100 + seed);
    let count = (2.0 * 26.0_f64.powf(random.unit())) as usize;
    let ratio = 10.0_f64.powf(random.between(-8.0, 8.0));
    let mut draw = |low, high| (0..count).map(|_| random.between(low, high)).collect::<Vec<f64>>();
    let (lengths, mut masses) = (draw(0.2, 0.6), draw(0.5, 2.0));
    let (angles, rates) = (draw(-1.5, 1.5), draw(-1.0, 1.0));
    let end = if random.unit() < 0.75 { count - 1 } else { 0 };
    masses[end] *= ratio;
    let chain = Chain { lengths, masses, angles, rates };
    let stop = f64::min(LONGEST, RADIANS / chain.fastest());
    let names = (0..count).flat_map(|k| [format!("b{k}.angle"), format!("b{k}.omega")]).collect();
    let times = vec![0.3 * stop, stop];
    let reference = Reference { names, values: chain.motion(&times), times };
    let name = format!("unlike_{seed}_{count}_bars_{ratio:.0e}_at_{end}");
    Case::new("chain with unlike masses", chain.scene(&name), stop, vec![]).against(reference).within(100.0, ROUNDING)
}

impl Chain {
    fn scene(&self, name: &str) -> Scene {
        let mut scene = Scene::new(name).gravity([0.0, -GRAVITY]);
        for (k, (mass, length)) in self.masses.iter().zip(&self.lengths).enumerate() {
            let before = if k == 0 { "ground".to_string() } else { format!("b{}.b", k - 1) };
            scene = scene
                .body(&format!("b{k}"), bar(*mass, *length))
                .revolute(&format!("j{k}"), &before, &format!("b{k}.a"))
                .initial(&format!("b{k}.angle"), self.angles[k])
                .initial(&format!("b{k}.omega"), self.rates[k]);
        }
        scene
    }

    /// About how fast a bar oscillates that the others pull straight [rad/s].
    fn fastest(&self) -> f64 {
        let mut weight = 0.0;
        let bars = self.masses.iter().zip(&self.lengths).rev();
        let squares = bars.map(|(mass, length)| {
            weight += GRAVITY * mass;
            weight / (mass * length)
        });
        squares.fold(0.0, f64::max).sqrt()
    }

    /// Angles and rates at these times.
    fn motion(&self, times: &[f64]) -> Vec<Vec<f64>> {
        let twofold = |values: &[f64]| values.iter().copied().map(Twofold::from).collect::<Vec<_>>();
        follow(twofold(&self.angles), twofold(&self.rates), times, NEGLIGIBLE, |angles, rates| {
            self.series(angles, rates)
        })
    }

    /// What a bar moves further out: the first moment of itself and of all that hangs from its end.
    fn loads(&self) -> Vec<Twofold> {
        let mut hanging = Twofold::default();
        let bars = self.masses.iter().zip(&self.lengths).rev();
        let mut loads: Vec<Twofold> = bars
            .map(|(&mass, &length)| {
                let load = (hanging + Twofold::from(mass) * 0.5.into()) * length.into();
                hanging = hanging + mass.into();
                load
            })
            .collect();
        loads.reverse();
        loads
    }

    /// M_kk of the absolute angles.
    fn inertias(&self) -> Vec<Twofold> {
        let mut hanging = Twofold::default();
        let bars = self.masses.iter().zip(&self.lengths).rev();
        let mut inertias: Vec<Twofold> = bars
            .map(|(&mass, &length)| {
                // The inertia is the number that the scene says.
                let (half, own) = (length / 2.0, mass * length * length / 12.0);
                let arms = Twofold::from(mass) * half.into() * half.into() + hanging * length.into() * length.into();
                hanging = hanging + mass.into();
                arms + own.into()
            })
            .collect();
        inertias.reverse();
        inertias
    }

    /// The series of the rates. Bars k and l move each other through A_kl e_l'', where A_kl is the length of the inner one times the load of the outer
    /// one, so sums over all others are found while one walks along the chain.
    fn series(&self, angles: &[Twofold], rates: &[Twofold]) -> Vec<Vec<Twofold>> {
        let count = angles.len();
        let (loads, inertias) = (self.loads(), self.inertias());
        let mut arms: Vec<Vec<[Twofold; 2]>> = angles.iter().map(|angle| vec![angle.cosine_and_sine()]).collect();
        let mut omega: Vec<Vec<Twofold>> = rates.iter().map(|rate| vec![*rate]).collect();
        let mut forces: Vec<Vec<[Twofold; 2]>> = vec![Vec::new(); count];
        let factors = self.factors(&arms, &loads, &inertias);
        for k in 0..count {
            let next = turned(&arms[k], &omega[k]);
            arms[k].push(next);
        }
        for order in 0..ORDER {
            // e'' without the new accelerations.
            omega.iter_mut().for_each(|omega| omega.push(Twofold::default()));
            let scale = Twofold::from(((order + 1) * (order + 2)) as f64);
            let known: Vec<[Twofold; 2]> =
                (0..count).map(|k| turned(&arms[k], &omega[k]).map(|part| scale * part)).collect();
            self.couple(&known, &loads, order, &mut forces);
            let lack: Vec<Twofold> = (0..count).map(|k| -moment(&arms[k], &forces[k])).collect();
            let alpha = solve(&factors, lack);
            let second: Vec<[Twofold; 2]> = (0..count)
                .map(|k| [known[k][0] - alpha[k] * arms[k][0][1], known[k][1] + alpha[k] * arms[k][0][0]])
                .collect();
            forces.iter_mut().for_each(|force| _ = force.pop());
            self.couple(&second, &loads, order, &mut forces);
            for k in 0..count {
                omega[k][order + 1] = alpha[k] / (order as f64 + 1.0).into();
                arms[k].push(second[k].map(|part| part / scale));
            }
        }
        omega
    }

    /// Adds an order of the forces on the bars' arms.
    fn couple(&self, second: &[[Twofold; 2]], loads: &[Twofold], order: usize, forces: &mut [Vec<[Twofold; 2]>]) {
        let count = second.len();
        let weight = |k: usize| if order == 0 { loads[k] * GRAVITY.into() } else { Twofold::default() };
        let mut sums = vec![[Twofold::default(); 2]; count];
        let mut inner = [Twofold::default(); 2];
        for k in 0..count {
            for axis in 0..2 {
                sums[k][axis] = loads[k] * inner[axis];
                inner[axis] = inner[axis] + second[k][axis] * self.lengths[k].into();
            }
            sums[k][1] = sums[k][1] + weight(k);
        }
        let mut outer = [Twofold::default(); 2];
        for k in (0..count).rev() {
            for axis in 0..2 {
                sums[k][axis] = sums[k][axis] + outer[axis] * self.lengths[k].into();
                outer[axis] = outer[axis] + second[k][axis] * loads[k];
            }
        }
        forces.iter_mut().zip(sums).for_each(|(force, sum)| force.push(sum));
    }

    /// L D L^T of the mass matrix, from the free end: L below the diagonal, D on it.
    fn factors(&self, arms: &[Vec<[Twofold; 2]>], loads: &[Twofold], inertias: &[Twofold]) -> Vec<Vec<Twofold>> {
        let count = arms.len();
        let entry = |k: usize, l: usize| {
            let ([ck, sk], [cl, sl]) = (arms[k][0], arms[l][0]);
            loads[k.max(l)] * self.lengths[k.min(l)].into() * (ck * cl + sk * sl)
        };
        let mut matrix: Vec<Vec<Twofold>> =
            (0..count).map(|k| (0..count).map(|l| if k == l { inertias[k] } else { entry(k, l) }).collect()).collect();
        for pivot in (0..count).rev() {
            for row in (0..pivot).rev() {
                let factor = matrix[pivot][row] / matrix[pivot][pivot];
                for column in 0..=row {
                    matrix[row][column] = matrix[row][column] - factor * matrix[pivot][column];
                }
            }
            for row in 0..pivot {
                matrix[pivot][row] = matrix[pivot][row] / matrix[pivot][pivot];
            }
        }
        matrix
    }
}

fn solve(factors: &[Vec<Twofold>], mut x: Vec<Twofold>) -> Vec<Twofold> {
    let count = x.len();
    for pivot in (0..count).rev() {
        for row in 0..pivot {
            x[row] = x[row] - factors[pivot][row] * x[pivot];
        }
    }
    for row in 0..count {
        x[row] = x[row] / factors[row][row];
    }
    for pivot in 0..count {
        for row in 0..pivot {
            x[pivot] = x[pivot] - factors[pivot][row] * x[row];
        }
    }
    x
}

/// The next coefficient of a unit vector: e' = i omega e.
fn turned(arm: &[[Twofold; 2]], omega: &[Twofold]) -> [Twofold; 2] {
    let mut sum = [Twofold::default(); 2];
    for ([c, s], rate) in arm.iter().rev().zip(omega) {
        sum = [sum[0] - *rate * *s, sum[1] + *rate * *c];
    }
    sum.map(|part| part / (arm.len() as f64).into())
}

/// The last order of e x F.
fn moment(arm: &[[Twofold; 2]], force: &[[Twofold; 2]]) -> Twofold {
    let terms = arm.iter().zip(force.iter().rev());
    terms.fold(Twofold::default(), |sum, ([c, s], [x, y])| sum + (*c * *y - *s * *x))
}

/// Follows a motion by the series of its rates: angles and rates at these times. A step is as long as the last orders are negligible.
pub(super) fn follow(
    mut angles: Vec<Twofold>,
    mut rates: Vec<Twofold>,
    times: &[f64],
    negligible: f64,
    series: impl Fn(&[Twofold], &[Twofold]) -> Vec<Vec<Twofold>>,
) -> Vec<Vec<f64>> {
    let mut now = 0.0;
    let mut found = Vec::new();
    for &time in times {
        while now < time {
            let series = series(&angles, &rates);
            let h = f64::min(reach(&series, negligible), time - now);
            for (k, omega) in series.iter().enumerate() {
                let (mut angle, mut rate) = (Twofold::default(), Twofold::default());
                for (order, coefficient) in omega.iter().enumerate().rev() {
                    angle = angle * h.into() + *coefficient / (order as f64 + 1.0).into();
                    rate = rate * h.into() + *coefficient;
                }
                (angles[k], rates[k]) = (angles[k] + angle * h.into(), rate);
            }
            now += h;
        }
        found.push(angles.iter().zip(&rates).flat_map(|(angle, rate)| [angle.high, rate.high]).collect());
    }
    found
}

fn reach(series: &[Vec<Twofold>], negligible: f64) -> f64 {
    let last = series.first().map_or(1, |omega| omega.len() - 1);
    let largest = |order: usize| series.iter().fold(1e-300, |most: f64, omega| most.max(omega[order].high.abs()));
    let bound = |order: usize| (negligible * largest(0).max(1.0) / largest(order)).powf(1.0 / order as f64);
    SAFETY * bound(last).min(bound(last - 1))
}
