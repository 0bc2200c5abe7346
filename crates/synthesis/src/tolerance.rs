//! Effect of deviations of lengths and pivots on the task of a four-bar: to first order by exact derivatives, and by samples.
//!
//! The input is where it is without deviations. Of a path only what is across it counts: along it the point is earlier or later.

use crate::chain::{Chain, Node, Places};
use crate::dyad::Dyad;
use crate::linkage::Linkage;
use crate::poses::{Pose, way};
use crate::random::RandomNumbers;
use crate::{Point, dot};

/// What an error is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// How far the body's origin is beside its path \[m\].
    Across,
    /// How far the body's origin is from its place \[m\].
    Place,
    /// How far the second bar is from its angle \[rad\].
    Output,
}

/// What a dimension of a four-bar does.
#[derive(Clone, Debug, PartialEq)]
pub struct Contribution {
    /// The dimension.
    pub name: String,
    /// By how much it deviates at most, SI.
    pub tolerance: f64,
    /// The error that it alone makes at most at the points of the task, in first order \[m or rad\].
    pub error: f64,
}

/// What all deviations together do.
#[derive(Clone, Debug, PartialEq)]
pub struct Tolerances {
    /// Dimension by dimension.
    pub contributions: Vec<Contribution>,
    /// All deviations at their ends, at the worst point of the task, in first order \[m or rad\].
    pub worst: f64,
    /// Three standard deviations where each tolerance is three of its own, in first order \[m or rad\].
    pub three_sigma: f64,
    /// 99.73 % of samples have no larger error at any point of the task \[m or rad\].
    pub sampled: f64,
    /// How many samples could not take all positions.
    pub jammed: usize,
}

const NAMES: [&str; 9] = [
    "first pivot x",
    "first pivot y",
    "second pivot x",
    "second pivot y",
    "first",
    "coupler",
    "second",
    "point along",
    "point across",
];
const PIVOTS: usize = 4;
const PIN: usize = 3;
const POINT: usize = 4;
const SAMPLES: usize = 2000;
/// The share of a normal distribution within three standard deviations.
const WITHIN: f64 = 0.9973;

fn chain(side: f64) -> Chain {
    let nodes = vec![
        Node::Ground { at: 0 },
        Node::Ground { at: 2 },
        Node::Crank { pivot: 0, length: 4 },
        Node::Dyad { from: 2, to: 1, lengths: [5, 6], side },
        Node::Attached { from: 2, to: PIN, at: 7 },
    ];
    Chain { nodes, dimensions: NAMES.len() }
}

/// A four-bar with the numbers of its dimensions.
struct Dimensioned {
    chain: Chain,
    x: [f64; NAMES.len()],
    inputs: Vec<f64>,
    measured: Measured,
}

impl Dimensioned {
    fn new(linkage: &Linkage, poses: &[Pose], measured: Measured) -> Option<Dimensioned> {
        let (Dyad::Bar { moving: a, ground: a0, length: r }, Dyad::Bar { moving: b, ground: b0, length: s }) =
            (linkage.first, linkage.second)
        else {
            return None;
        };
        let body = b - a;
        let tracer = -a * (body / body.norm()).conj();
        let first = poses.first()?;
        let across = crate::cross(b0 - first.carry(a), first.turn() * body);
        let chain = chain(if across < 0.0 { -1.0 } else { 1.0 });
        let x = [a0.re, a0.im, b0.re, b0.im, r, body.norm(), s, tracer.re, tracer.im];
        let inputs = poses.iter().map(|pose| linkage.input(pose)).collect();
        Some(Dimensioned { chain, x, inputs, measured })
    }

    /// The errors at a position by all dimensions: one or two parts.
    fn slopes(&self, places: &Places) -> Vec<[f64; NAMES.len()]> {
        let point = &places.all[POINT];
        let by = |of: &dyn Fn(usize) -> f64| std::array::from_fn(of);
        match self.measured {
            Measured::Place => vec![by(&|i| point.by[i].re), by(&|i| point.by[i].im)],
            Measured::Across => {
                let along = point.by_input / point.by_input.norm().max(f64::MIN_POSITIVE);
                vec![by(&|i| crate::cross(along, point.by[i]))]
            }
            Measured::Output => {
                let arm = places.all[PIN].at - places.all[1].at;
                let moved = |i: usize| places.all[PIN].by[i] - places.all[1].by[i];
                vec![by(&|i| crate::cross(arm, moved(i)) / arm.norm_sqr())]
            }
        }
    }

    /// The largest error of other dimensions at all positions; none if a position is not reached.
    fn error(&self, x: &[f64; NAMES.len()], places: &mut [Places; 2]) -> Option<f64> {
        let mut most: f64 = 0.0;
        for input in &self.inputs {
            let [here, there] = places;
            self.chain.place(&self.x, *input, false, here);
            self.chain.place(x, *input, false, there);
            if self.chain.cosine(x, PIN, there).value.abs() > 1.0 {
                return None;
            }
            let moved = there.all[POINT].at - here.all[POINT].at;
            let arm = |places: &Places| (places.all[PIN].at - places.all[1].at).arg();
            let error = match self.measured {
                Measured::Place => moved.norm(),
                Measured::Output => way(arm(here), arm(there)).abs(),
                Measured::Across => {
                    let across = here.all[POINT].by_input * Point::new(0.0, 1.0);
                    dot(across, moved).abs() / across.norm().max(f64::MIN_POSITIVE)
                }
            };
            most = most.max(error);
        }
        Some(most)
    }
}

/// What deviations of lengths (bars, the point of the coupler) and of the places of pivots do, at the poses of a task; none if it is no four-bar.
pub fn tolerances(
    linkage: &Linkage,
    poses: &[Pose],
    measured: Measured,
    length: f64,
    pivot: f64,
) -> Option<Tolerances> {
    let nominal = Dimensioned::new(linkage, poses, measured)?;
    let each: [f64; NAMES.len()] = std::array::from_fn(|i| if i < PIVOTS { pivot } else { length });
    let mut first = FirstOrder::new(NAMES.map(str::to_owned).to_vec(), each.to_vec());
    let mut places = Places::new();
    for input in &nominal.inputs {
        nominal.chain.place(&nominal.x, *input, true, &mut places);
        let slopes: Vec<Vec<f64>> = nominal.slopes(&places).iter().map(|row| row.to_vec()).collect();
        first.add(&slopes);
    }
    Some(first.sampled(samples(&nominal, &each), SAMPLES))
}

/// Errors in first order, gathered position by position.
#[derive(Clone, Debug)]
pub struct FirstOrder {
    names: Vec<String>,
    each: Vec<f64>,
    alone: Vec<f64>,
    worst: f64,
    worst_position: usize,
    three_sigma: f64,
    positions: usize,
}

impl FirstOrder {
    /// Of dimensions that deviate by so much at most.
    pub fn new(names: Vec<String>, each: Vec<f64>) -> FirstOrder {
        let alone = vec![0.0; each.len()];
        FirstOrder { names, each, alone, worst: 0.0, worst_position: 0, three_sigma: 0.0, positions: 0 }
    }

    /// One more position: how the error, or its two parts at right angles, changes with each dimension.
    pub fn add(&mut self, slopes: &[Vec<f64>]) {
        let size = |of: &dyn Fn(&Vec<f64>) -> f64| slopes.iter().map(|row| of(row).powi(2)).sum::<f64>().sqrt();
        for (i, alone) in self.alone.iter_mut().enumerate() {
            *alone = alone.max(size(&|row| row[i] * self.each[i]));
        }
        let sum = |of: &dyn Fn(usize) -> f64| (0..self.each.len()).map(|i| (of(i) * self.each[i]).abs()).sum::<f64>();
        // In a plane the worst direction is tried: the sum of the deviations' shares along it.
        let worst = match slopes {
            [x, y] => (0..90)
                .map(|k| crate::polar(1.0, f64::from(k) * std::f64::consts::PI / 90.0))
                .map(|along| sum(&|i| along.re * x[i] + along.im * y[i]))
                .fold(0.0, f64::max),
            _ => size(&|row| sum(&|i| row[i])),
        };
        if worst > self.worst {
            (self.worst, self.worst_position) = (worst, self.positions);
        }
        let square =
            |row: &Vec<f64>| row.iter().zip(&self.each).map(|(slope, each)| (slope * each).powi(2)).sum::<f64>();
        self.three_sigma = self.three_sigma.max(slopes.iter().map(square).sum::<f64>().sqrt());
        self.positions += 1;
    }

    /// The number of the position at which the worst case is largest.
    pub fn worst_position(&self) -> usize {
        self.worst_position
    }

    /// With the largest errors of samples, of which there were so many, those included that could not take all positions.
    pub fn sampled(self, mut errors: Vec<f64>, all: usize) -> Tolerances {
        errors.sort_by(f64::total_cmp);
        let jammed = all - errors.len();
        let index = (WITHIN * errors.len() as f64) as usize;
        let sampled = errors.get(index.min(errors.len().saturating_sub(1))).copied().unwrap_or(f64::INFINITY);
        let contributions = self.names.into_iter().zip(self.each).zip(self.alone);
        let contributions = contributions.map(|((name, tolerance), error)| Contribution { name, tolerance, error });
        Tolerances {
            contributions: contributions.filter(|contribution| contribution.tolerance > 0.0).collect(),
            worst: self.worst,
            three_sigma: self.three_sigma,
            sampled,
            jammed,
        }
    }
}

/// The largest error of each sample that takes all positions.
fn samples(dimensioned: &Dimensioned, each: &[f64; NAMES.len()]) -> Vec<f64> {
    let (mut random, mut places) = (RandomNumbers::new(1), [Places::new(), Places::new()]);
    let mut errors: Vec<f64> = Vec::with_capacity(SAMPLES);
    for _ in 0..SAMPLES {
        let x = std::array::from_fn(|i| dimensioned.x[i] + each[i] / 3.0 * random.normal().re);
        errors.extend(dimensioned.error(&x, &mut places));
    }
    errors
}
