//! Least squares of a linkage's errors within bounds of its dimensions and under inequalities: transmission angles, regions of pivots, distances of joints.
//!
//! Dimensions keep their bounds exactly. Where the crank's angle at a point of a path is free it is that of the nearest point of the curve, and eliminated. Inequalities are
//! residuals where they are violated, shifted until they hold (augmented Lagrangian: R. T. Rockafellar 1973; J. Nocedal, S. J. Wright, *Numerical Optimization*, 2006, chapter 17);
//! the steps are those of Levenberg and Marquardt on the dimensions that are not held at a bound.

use std::f64::consts::{PI, TAU};

use crate::chain::{Chain, Cosine, DIMENSIONS, Node, Places};
use crate::corridor::{Corridor, ends};
use crate::function::Pair;
use crate::least::{factor, solve};
use crate::limits::Region;
use crate::poses::way;
use crate::{Point, cross, dot};

/// Values of all dimensions, or derivatives by them.
pub(crate) type Slopes = [f64; DIMENSIONS];

/// What a linkage is to do.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Goal<'t> {
    /// A point is on a path, and between its points inside the corridor; of a timed one the crank has turned so far at each point, from the angle that is the dimension of this number on.
    Path { tracer: usize, points: &'t [Point], corridor: &'t Corridor, turns: Option<(&'t [f64], usize)> },
    /// A body from one place to another takes poses: a point of it is at places, and the body, whose frame is turned by a dimension, has angles, which count `weight` times.
    Poses { tracer: usize, body: [usize; 2], zero: usize, points: &'t [Point], angles: &'t [f64], weight: f64 },
    /// A bar from its pivot to its pin turns with the crank, both from angles that are dimensions.
    Function { pivot: usize, pin: usize, pairs: &'t [Pair], zeros: [usize; 2] },
    /// A slider moves along x with the crank, from an angle and a place that are dimensions.
    Slider { pin: usize, pairs: &'t [Pair], zeros: [usize; 2] },
}

/// Inequalities.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inequalities {
    /// Largest cosine of a transmission angle.
    pub cosine: f64,
    /// Does the crank turn fully, with the transmission angle kept over the whole turn?
    pub turn: bool,
    /// Where pivots may be.
    pub regions: Vec<(usize, Region)>,
    /// Least and largest distance of joints of one body.
    pub distances: Vec<([usize; 2], [f64; 2])>,
}

/// A search: what is to be done, by what linkage, within what.
pub(crate) struct Search<'t> {
    pub chain: Chain,
    pub goal: Goal<'t>,
    pub low: Slopes,
    pub high: Slopes,
    pub inequalities: Inequalities,
}

/// Where a search is: dimensions, and the angle of the crank at each point.
#[derive(Clone, Debug)]
pub(crate) struct Trial {
    pub x: Slopes,
    pub inputs: Vec<f64>,
    /// The sum of squares of the task's errors.
    pub sum: f64,
    /// The largest violation of an inequality.
    pub violation: f64,
}

/// The normal equations at a place.
struct Normal {
    cost: f64,
    sum: f64,
    square: [Slopes; DIMENSIONS],
    right: Slopes,
    /// How the angles of the crank follow the dimensions.
    by_dimension: Vec<Slopes>,
    /// What each inequality is above zero.
    excess: Vec<f64>,
}

impl Normal {
    fn row(&mut self, value: f64, slopes: &Slopes, count: usize) {
        self.cost += value * value;
        for i in 0..count {
            self.right[i] -= slopes[i] * value;
            for j in 0..=i {
                self.square[i][j] += slopes[i] * slopes[j];
            }
        }
    }
}

/// Inequalities hold with so much to spare: what is left of a violation is below it.
pub(crate) const SPARE: f64 = 1e-8;
/// An angle of the crank moves by no more than this at once on the way to the nearest point.
const STRIDE: f64 = 0.25;
/// Places of a turn at which the transmission angles of the second dyad are looked at, and those of a curve at which its distance from the path is.
const PLACES: usize = 48;

impl Search<'_> {
    /// The crank at the point of the curve that is nearest to a point.
    fn foot(&self, x: &Slopes, tracer: usize, point: Point, input: &mut f64, places: &mut Places) {
        for _ in 0..4 {
            self.chain.place(x, *input, false, places);
            let traced = &places.all[tracer];
            let step = dot(traced.by_input, point - traced.at) / traced.by_input.norm_sqr().max(1e-12);
            *input += step.clamp(-STRIDE, STRIDE);
            if step.abs() < 1e-10 {
                break;
            }
        }
    }

    /// The same for a pose: nearest in place and angle together.
    fn pose_foot(&self, x: &Slopes, index: usize, input: &mut f64, places: &mut Places) {
        for _ in 0..4 {
            self.chain.place(x, *input, false, places);
            let Some(errors) = self.pose_miss(x, index, places) else { return };
            let along = errors.iter().map(|(value, by_input, _)| value * by_input).sum::<f64>();
            let square = errors.iter().map(|(_, by_input, _)| by_input * by_input).sum::<f64>().max(1e-12);
            *input -= (along / square).clamp(-STRIDE, STRIDE);
            if (along / square).abs() < 1e-10 {
                break;
            }
        }
    }

    /// How far the body is from a pose along x and y and in its angle, with the derivatives by the crank and by the dimensions.
    fn pose_miss(&self, x: &Slopes, index: usize, places: &Places) -> Option<[(f64, f64, Slopes); 3]> {
        let Goal::Poses { tracer, body: [from, to], zero, points, angles, weight } = self.goal else { return None };
        let (traced, from, to) = (&places.all[tracer], &places.all[from], &places.all[to]);
        let (miss, arm) = (traced.at - points[index], to.at - from.at);
        let square = arm.norm_sqr().max(f64::MIN_POSITIVE);
        let turn = |p: Point, q: Point| weight * cross(arm, q - p) / square;
        let mut angle: Slopes = std::array::from_fn(|i| turn(from.by[i], to.by[i]));
        angle[zero] += weight;
        Some([
            (miss.re, traced.by_input.re, traced.by.map(|slope| slope.re)),
            (miss.im, traced.by_input.im, traced.by.map(|slope| slope.im)),
            (weight * way(angles[index], arm.arg() + x[zero]), turn(from.by_input, to.by_input), angle),
        ])
    }

    fn normal(&self, trial: &mut Trial, shifts: &[f64], weight: f64) -> Normal {
        let mut normal = Normal {
            cost: 0.0,
            sum: 0.0,
            square: [[0.0; DIMENSIONS]; DIMENSIONS],
            right: [0.0; DIMENSIONS],
            by_dimension: Vec::with_capacity(trial.inputs.len()),
            excess: Vec::with_capacity(shifts.len()),
        };
        let mut places = Places::new();
        let inputs = trial.inputs.len();
        for index in 0..inputs {
            self.errors(trial, index, &mut normal, &mut places);
            let by_dimension = normal.by_dimension[index];
            for pin in self.chain.dyads() {
                let mut cosine = self.chain.cosine(&trial.x, pin, &places);
                (0..self.chain.dimensions).for_each(|i| cosine.by[i] += cosine.by_input * by_dimension[i]);
                self.keep_cosine(&cosine, &mut normal, shifts, weight);
            }
        }
        self.departures(trial, &mut normal, &mut places);
        normal.sum = normal.cost - normal.excess_cost(shifts, weight);
        self.whole_turn(trial, &mut normal, shifts, weight, &mut places);
        self.chain.place(&trial.x, trial.inputs.first().copied().unwrap_or(0.0), true, &mut places);
        for (node, region) in &self.inequalities.regions {
            let joint = &places.all[*node];
            let (outside, along) = region.signed(joint.at);
            let slopes = std::array::from_fn(|i| dot(along, joint.by[i]));
            self.keep(outside, &slopes, &mut normal, shifts, weight);
        }
        for ([a, b], [low, high]) in &self.inequalities.distances {
            let between = places.all[*b].at - places.all[*a].at;
            let size = between.norm().max(f64::MIN_POSITIVE);
            let by = |i: usize| dot(between, places.all[*b].by[i] - places.all[*a].by[i]) / size;
            self.keep(size - high, &std::array::from_fn(by), &mut normal, shifts, weight);
            self.keep(low - size, &std::array::from_fn(|i| -by(i)), &mut normal, shifts, weight);
        }
        trial.sum = normal.sum;
        trial.violation = normal.excess.iter().copied().fold(0.0, f64::max);
        normal
    }

    /// The errors of the task at one point; places are those at the point afterwards.
    fn errors(&self, trial: &mut Trial, index: usize, normal: &mut Normal, places: &mut Places) {
        let (count, x) = (self.chain.dimensions, trial.x);
        let mut by_dimension = [0.0; DIMENSIONS];
        match self.goal {
            Goal::Path { tracer, points, turns, .. } => {
                match turns {
                    Some((turns, phase)) => {
                        trial.inputs[index] = x[phase] + turns[index];
                        by_dimension[phase] = 1.0;
                    }
                    None => self.foot(&x, tracer, points[index], &mut trial.inputs[index], places),
                }
                self.chain.place(&x, trial.inputs[index], true, places);
                let traced = &places.all[tracer];
                let (miss, ahead) = (traced.at - points[index], traced.by_input);
                if turns.is_none() {
                    let square = ahead.norm_sqr().max(1e-12);
                    (0..count).for_each(|i| by_dimension[i] = -dot(ahead, traced.by[i]) / square);
                }
                let moved: [Point; DIMENSIONS] = std::array::from_fn(|i| traced.by[i] + ahead * by_dimension[i]);
                normal.row(miss.re, &moved.map(|change| change.re), count);
                normal.row(miss.im, &moved.map(|change| change.im), count);
            }
            Goal::Poses { .. } => {
                self.pose_foot(&x, index, &mut trial.inputs[index], places);
                self.chain.place(&x, trial.inputs[index], true, places);
                let Some(errors) = self.pose_miss(&x, index, places) else { return };
                let square = errors.iter().map(|(_, ahead, _)| ahead * ahead).sum::<f64>().max(1e-12);
                let along = |i: usize| errors.iter().map(|(_, ahead, by)| ahead * by[i]).sum::<f64>();
                (0..count).for_each(|i| by_dimension[i] = -along(i) / square);
                for (value, ahead, by) in errors {
                    let moved = std::array::from_fn(|i| by[i] + ahead * by_dimension[i]);
                    normal.row(value, &moved, count);
                }
            }
            Goal::Function { pivot, pin, pairs, zeros: [phase, zero] } => {
                trial.inputs[index] = x[phase] + pairs[index].input;
                by_dimension[phase] = 1.0;
                self.chain.place(&x, trial.inputs[index], true, places);
                let (from, to) = (&places.all[pivot], &places.all[pin]);
                let arm = to.at - from.at;
                let square = arm.norm_sqr().max(f64::MIN_POSITIVE);
                let error = way(x[zero] + pairs[index].output, arm.arg());
                let mut slopes: Slopes = std::array::from_fn(|i| {
                    let moved = to.by[i] - from.by[i] + (to.by_input - from.by_input) * by_dimension[i];
                    cross(arm, moved) / square
                });
                slopes[zero] -= 1.0;
                normal.row(error, &slopes, count);
            }
            Goal::Slider { pin, pairs, zeros: [phase, zero] } => {
                trial.inputs[index] = x[phase] + pairs[index].input;
                by_dimension[phase] = 1.0;
                self.chain.place(&x, trial.inputs[index], true, places);
                let pinned = &places.all[pin];
                let mut slopes: Slopes =
                    std::array::from_fn(|i| pinned.by[i].re + pinned.by_input.re * by_dimension[i]);
                slopes[zero] -= 1.0;
                normal.row(pinned.at.re - x[zero] - pairs[index].output, &slopes, count);
            }
        }
        normal.by_dimension.push(by_dimension);
    }

    /// By what the curve of a path leaves the corridor between its ends, or in a full turn: all places together count as much as the points.
    fn departures(&self, trial: &Trial, normal: &mut Normal, places: &mut Places) {
        let Goal::Path { tracer, corridor, .. } = self.goal else { return };
        let (count, inputs) = (self.chain.dimensions, &trial.inputs);
        let by = |end: f64| inputs.iter().position(|input| *input == end).map(|index| normal.by_dimension[index]);
        let (low, high) = ends(inputs);
        let Some((at_low, at_high)) = by(low).zip(by(high)) else { return };
        let weight = (inputs.len() as f64 / PLACES as f64).sqrt();
        for place in 0..PLACES {
            let share = (place as f64 + 0.5) / PLACES as f64;
            let (input, way): (f64, Slopes) = if corridor.is_closed() {
                (TAU * share, [0.0; DIMENSIONS])
            } else {
                (low + (high - low) * share, std::array::from_fn(|i| at_low[i] + (at_high[i] - at_low[i]) * share))
            };
            self.chain.place(&trial.x, input, false, places);
            let Some((excess, along)) = corridor.outside(places.all[tracer].at) else { continue };
            self.chain.place(&trial.x, input, true, places);
            let traced = &places.all[tracer];
            let slope = |i: usize| weight * dot(along, traced.by[i] + traced.by_input * way[i]);
            normal.row(weight * excess, &std::array::from_fn(slope), count);
        }
    }

    /// The transmission angles between the points: at the extremes of the first dyad, at places of a whole turn of the others.
    fn whole_turn(&self, trial: &Trial, normal: &mut Normal, shifts: &[f64], weight: f64, places: &mut Places) {
        let x = &trial.x;
        let (low, high) = ends(&trial.inputs);
        let mut pins = self.chain.dyads();
        let Some(first) = pins.next() else { return };
        let (from, to) = match self.chain.nodes[first] {
            Node::Dyad { from, to, .. } => (from, Some(to)),
            Node::Slide { from, .. } => (from, None),
            Node::Ground { .. } | Node::Beside { .. } | Node::Crank { .. } | Node::Attached { .. } => return,
        };
        if let Node::Crank { pivot, .. } = self.chain.nodes[from] {
            self.chain.place(x, low, false, places);
            let along = to.map_or(0.5 * PI, |to| (places.all[to].at - places.all[pivot].at).arg());
            for extreme in [along, along + PI] {
                let inside = self.inequalities.turn || low + (extreme - low).rem_euclid(TAU) < high;
                if inside {
                    self.chain.place(x, extreme, true, places);
                    let cosine = self.chain.cosine(x, first, places);
                    self.keep_cosine(&cosine, normal, shifts, weight);
                } else {
                    normal.excess.push(-1.0);
                }
            }
        }
        for pin in pins {
            let (from, way) = if self.inequalities.turn { (0.0, TAU) } else { (low, high - low) };
            for place in 0..PLACES {
                self.chain.place(x, from + way * (place as f64 + 0.5) / PLACES as f64, true, places);
                let cosine = self.chain.cosine(x, pin, places);
                self.keep_cosine(&cosine, normal, shifts, weight);
            }
        }
    }

    fn keep_cosine(&self, cosine: &Cosine, normal: &mut Normal, shifts: &[f64], weight: f64) {
        let sign = cosine.value.signum();
        let slopes = cosine.by.map(|slope| slope * sign);
        self.keep(cosine.value.abs() - self.inequalities.cosine, &slopes, normal, shifts, weight);
    }

    /// One inequality: `value` is to be at most zero.
    fn keep(&self, value: f64, slopes: &Slopes, normal: &mut Normal, shifts: &[f64], weight: f64) {
        let excess = value + SPARE;
        let shifted = excess + shifts.get(normal.excess.len()).copied().unwrap_or(0.0);
        normal.excess.push(excess);
        if shifted > 0.0 {
            normal.row(weight * shifted, &slopes.map(|slope| slope * weight), self.chain.dimensions);
        }
    }

    /// So many steps at most to where the cost is least; gives the excess of each inequality.
    fn minimise(&self, trial: &mut Trial, shifts: &[f64], weight: f64, steps: usize) -> Vec<f64> {
        let count = self.chain.dimensions;
        let mut here = self.normal(trial, shifts, weight);
        let (mut damping, mut small) = (1e-3, 0);
        for _ in 0..steps {
            if damping > 1e7 || here.cost.is_nan() || here.cost < 1e-26 {
                break;
            }
            let Some(step) = self.step(&here, &trial.x, damping) else {
                damping *= 4.0;
                continue;
            };
            let mut next = trial.clone();
            (0..count).for_each(|i| next.x[i] = (trial.x[i] + step[i]).clamp(self.low[i], self.high[i]));
            for (input, by) in next.inputs.iter_mut().zip(&here.by_dimension) {
                let ahead: f64 = (0..count).map(|i| by[i] * (next.x[i] - trial.x[i])).sum();
                *input += ahead.clamp(-STRIDE, STRIDE);
            }
            let there = self.normal(&mut next, shifts, weight);
            if there.cost < here.cost {
                small = if here.cost - there.cost < 1e-7 * here.cost { small + 1 } else { 0 };
                (here, *trial) = (there, next);
                damping = (damping * 0.25).max(1e-12);
                if small > 3 {
                    break;
                }
            } else {
                damping *= 3.0;
            }
        }
        here.excess
    }

    /// The step of the dimensions that are free.
    fn step(&self, normal: &Normal, x: &Slopes, damping: f64) -> Option<Slopes> {
        let held = |i: usize| {
            i >= self.chain.dimensions
                || (x[i] <= self.low[i] && normal.right[i] <= 0.0)
                || (x[i] >= self.high[i] && normal.right[i] >= 0.0)
        };
        let held: [bool; DIMENSIONS] = std::array::from_fn(held);
        let mut square = normal.square;
        let mut right = normal.right;
        for i in 0..DIMENSIONS {
            square[i][i] += damping * square[i][i].max(1e-6) + 1e-14;
            if held[i] {
                right[i] = 0.0;
                (0..DIMENSIONS).for_each(|j| (square[i][j], square[j][i]) = (0.0, 0.0));
                square[i][i] = 1.0;
            }
        }
        let step = solve(&factor(square)?, right);
        step.iter().all(|step| step.is_finite()).then_some(step)
    }

    /// A few steps with soft inequalities.
    pub fn approach(&self, trial: &mut Trial, steps: usize) {
        self.minimise(trial, &[], SOFT, steps);
    }

    /// To a minimum at which all inequalities hold, if there is one near.
    pub fn settle(&self, trial: &mut Trial) {
        self.shifts(trial);
    }

    /// The same; gives the shifts that hold the inequalities there.
    fn shifts(&self, trial: &mut Trial) -> Vec<f64> {
        let mut shifts = Vec::new();
        for round in 0..ROUNDS {
            let excess = self.minimise(trial, &shifts, HARD, STEPS);
            if excess.iter().all(|excess| *excess <= 0.5 * SPARE) && round > 0 {
                break;
            }
            shifts.resize(excess.len(), 0.0);
            shifts.iter_mut().zip(&excess).for_each(|(shift, excess)| *shift = (*shift + excess).max(0.0));
        }
        shifts
    }

    /// By how much half the sum of squares falls per unit by which the limits of these lengths and of all distances give way: the sum of their multipliers, zero where none is active.
    pub fn price(&self, trial: &Trial, lengths: &[usize]) -> f64 {
        let mut trial = trial.clone();
        let shifts = self.shifts(&mut trial);
        let normal = self.normal(&mut trial, &shifts, HARD);
        let at_bound = |i: &&usize| trial.x[**i] <= self.low[**i] || trial.x[**i] >= self.high[**i];
        let bars: f64 = lengths.iter().filter(at_bound).map(|&i| normal.right[i].abs()).sum();
        let first = normal.excess.len().saturating_sub(2 * self.inequalities.distances.len());
        let shifted = normal.excess.iter().zip(&shifts).skip(first).map(|(excess, shift)| excess + shift);
        bars + shifted.map(|shifted| HARD * HARD * shifted.max(0.0)).sum::<f64>()
    }
}

impl Normal {
    fn excess_cost(&self, shifts: &[f64], weight: f64) -> f64 {
        let shifted = self.excess.iter().enumerate().map(|(i, excess)| excess + shifts.get(i).copied().unwrap_or(0.0));
        shifted.filter(|distance| *distance > 0.0).map(|distance| (weight * distance).powi(2)).sum()
    }
}

/// How much inequalities count beside the errors of the task, first and at the end.
const SOFT: f64 = 3.0;
const HARD: f64 = 30.0;
/// How often the inequalities are shifted, and steps in between.
const ROUNDS: usize = 10;
const STEPS: usize = 120;
