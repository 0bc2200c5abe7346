//! Four-bars whose coupler point follows a path as well as it can within limits: lengths, positions of pivots, transmission angle, full rotation of the crank.
//!
//! The dimensions are the lengths themselves, so that limits of lengths are bounds of the search. Starts are those four-bars of the atlas that are like the path and have nearly the
//! size, what was found without limits, and places beside the best.

use std::f64::consts::{PI, TAU};

use crate::atlas::{self, Start};
use crate::bounded::{Goal, Inequalities, SPARE, Search, Slopes, Trial};
use crate::chain::{Chain, DIMENSIONS, Node, Places};
use crate::corridor::Corridor;
use crate::dyad::Dyad;
use crate::limits::LinkageLimits;
use crate::linkage::Linkage;
use crate::path::{CouplerPath, PathEffort, PathFollower, Scaled, scaled};
use crate::poses::{Pose, way};
use crate::random::RandomNumbers;
use crate::{Point, cross, polar};

/// What the dimensions are.
const GROUND: usize = 2;
const CRANK: usize = 4;
const COUPLER: usize = 5;
const SECOND: usize = 6;
const PHASE: usize = 9;
const COUNT: usize = 10;
const BARS: [usize; 4] = [GROUND, CRANK, COUPLER, SECOND];
/// What the nodes are.
const SECOND_PIN: usize = 3;
const TRACER: usize = 4;

fn chain([side, _]: Sides) -> Chain {
    let nodes = vec![
        Node::Ground { at: 0 },
        Node::Beside { from: 0, at: GROUND },
        Node::Crank { pivot: 0, length: CRANK },
        Node::Dyad { from: 2, to: 1, lengths: [COUPLER, SECOND], side },
        Node::Attached { from: 2, to: SECOND_PIN, at: 7 },
    ];
    Chain { nodes, dimensions: COUNT }
}

/// Without a limit bars are at least this share of the path's size, and at most so many times as long.
const LEAST: f64 = 1e-2;
const LARGEST: f64 = 200.0;
/// Without a limit transmission angles are above this \[rad\]: a linkage in its dead point follows nothing.
const DEAD: f64 = 0.02;

/// An error is none below this, in sizes of the task: where linkages do without one they are a family, and the one with the best transmission angle is looked for.
pub(crate) const EXACT: f64 = 1e-9;

/// Starts that are tried with a few steps; those that go on; those that are settled.
const STEPS: [usize; 2] = [12, 40];
const SECOND_ROUND: usize = 72;
const SETTLED: usize = 16;
/// Of the best so many are varied, each in so many ways, so often.
const VARIED: usize = 6;
const VARIANTS: usize = 10;
const VARIATIONS: usize = 2;
/// How often the way to the tightest bound is halved.
const HALVINGS: usize = 9;

/// What is to be done by what kind of linkage, within what.
pub(crate) struct Plan<'p> {
    pub chain: fn(Sides) -> Chain,
    pub goal: Goal<'p>,
    pub low: Slopes,
    pub high: Slopes,
    pub inequalities: Inequalities,
    /// Dimensions that are lengths of bars.
    pub lengths: &'static [usize],
    /// Is the order of the crank's angles to be that of the points? Then whether the path is closed.
    pub order: Option<bool>,
}

impl Plan<'_> {
    pub fn search(&self, sides: Sides) -> Search<'_> {
        let (chain, inequalities) = ((self.chain)(sides), self.inequalities.clone());
        Search { chain, goal: self.goal, low: self.low, high: self.high, inequalities }
    }

    /// With no two points of a link farther apart than this.
    fn smaller(&self, size: f64) -> Plan<'_> {
        let (mut high, mut inequalities) = (self.high, self.inequalities.clone());
        self.lengths.iter().for_each(|&i| high[i] = high[i].min(size).max(self.low[i]));
        inequalities.distances.iter_mut().for_each(|(_, [low, high])| *high = high.min(size).max(*low));
        Plan { high, inequalities, ..*self }
    }

    /// With transmission angles that are at least so large \[rad\].
    fn transmitting(&self, least: f64) -> Plan<'_> {
        let cosine = self.inequalities.cosine.min(least.cos());
        Plan { inequalities: Inequalities { cosine, ..self.inequalities.clone() }, ..*self }
    }

    /// The less the better: what is missed, inequalities that are violated, an order that is not that of the points.
    fn merit(&self, candidate: &Candidate) -> f64 {
        let wrong = self.order.is_some_and(|closed| !is_in_order(&candidate.trial.inputs, closed));
        let order = if wrong { DISORDER } else { 0.0 };
        let cost = (candidate.trial.sum / candidate.trial.inputs.len().max(1) as f64).sqrt()
            + candidate.trial.violation
            + order;
        if cost.is_nan() { f64::INFINITY } else { cost }
    }

    /// The largest distance of two points of one link.
    fn size(&self, candidate: &Candidate) -> f64 {
        let (x, mut places) = (&candidate.trial.x, Places::new());
        let input = candidate.trial.inputs.first().copied().unwrap_or(0.0);
        (self.chain)(candidate.sides).place(x, input, false, &mut places);
        let distances =
            self.inequalities.distances.iter().map(|([a, b], _)| (places.all[*b].at - places.all[*a].at).norm());
        self.lengths.iter().map(|&i| x[i].abs()).chain(distances).fold(0.0, f64::max)
    }
}

/// Dimensions of a path's four-bar and their bounds, in the size of the path.
fn path_plan<'p>(
    scaled: &'p Scaled,
    corridor: &'p Corridor,
    path: &'p CouplerPath,
    limits: &LinkageLimits,
) -> Plan<'p> {
    let [least, longest] = limits.length.map_or([0.0, f64::INFINITY], |range| range.map(|range| range / scaled.size));
    let region = limits.ground.as_ref().map(|ground| ground.scaled(scaled.middle, scaled.size));
    let regions = region.iter().flat_map(|zone| [(0, zone.clone()), (1, zone.clone())]).collect();
    let [mut low, mut high] = [[f64::NEG_INFINITY; DIMENSIONS], [f64::INFINITY; DIMENSIONS]];
    let longest = longest.min(LARGEST).max(least);
    for length in BARS {
        (low[length], high[length]) = (least.max(LEAST.min(longest)), longest);
    }
    if let Some([a, b]) = scaled.pivots {
        for (dimension, value) in [a.re, a.im, (b - a).norm(), (b - a).arg()].into_iter().enumerate() {
            (low[dimension], high[dimension]) = (value, value);
        }
    }
    let turns = path.crank.as_ref().map(|turns| (&turns[..], PHASE));
    let goal = Goal::Path { tracer: TRACER, points: &scaled.points, corridor, turns };
    let turn = limits.crank || path.closed;
    let distances = [2, SECOND_PIN].map(|pin| ([pin, TRACER], [0.0, longest])).to_vec();
    let inequalities = Inequalities { cosine: cosine(limits), turn, regions, distances };
    let order = turns.is_none().then_some(path.closed);
    Plan { chain, goal, low, high, inequalities, lengths: &BARS, order }
}

/// The largest cosine of a transmission angle.
pub(crate) fn cosine(limits: &LinkageLimits) -> f64 {
    limits.transmission.unwrap_or(0.0).max(DEAD).cos()
}

/// The sides of the pins of both dyads; four-bars have one.
pub(crate) type Sides = [f64; 2];

/// A trial with the sides of its pins.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub trial: Trial,
    pub sides: Sides,
}

impl Candidate {
    pub fn new(x: Slopes, inputs: Vec<f64>, sides: Sides, plan: &Plan<'_>) -> Candidate {
        let mut candidate = Candidate { trial: Trial { x, inputs, sum: 0.0, violation: 0.0 }, sides };
        candidate.bound(plan);
        candidate
    }

    /// From a start of the atlas, its first or its second bar for the crank, lengths within their limits.
    fn of(start: &Start, exchanged: bool, path: &CouplerPath, points: &[Point], plan: &Plan<'_>) -> Candidate {
        let s = &start.shared;
        let point = |first: usize| Point::new(s[first], s[first + 1]);
        let [a, b] = if exchanged { [2, 0] } else { [0, 2] }.map(point);
        let [a0, b0] = if exchanged { [6, 4] } else { [4, 6] }.map(point);
        let along = (b - a) / (b - a).norm().max(f64::MIN_POSITIVE);
        let tracer = -a * along.conj();
        let lengths = if exchanged { [s[9], s[8]] } else { [s[8], s[9]] }.map(f64::abs);
        let ground = b0 - a0;
        let mut x = [0.0; DIMENSIONS];
        x[..4].copy_from_slice(&[a0.re, a0.im, ground.norm(), ground.arg()]);
        x[4..9].copy_from_slice(&[lengths[0], (b - a).norm(), lengths[1], tracer.re, tracer.im]);
        let mut side = 0.0;
        let mut inputs: Vec<f64> = Vec::with_capacity(start.local.len());
        for (place, local) in points.iter().zip(&start.local) {
            let turn = polar(1.0, local[0]);
            let angle = (place + turn * a - a0).arg();
            inputs.push(inputs.last().map_or(angle, |last| last + way(*last, angle)));
            side += cross(b0 - (place + turn * a), turn * (b - a)).signum();
        }
        if let Some(turns) = &path.crank {
            let phase: Point = inputs.iter().zip(turns).map(|(input, turn)| polar(1.0, input - turn)).sum();
            x[PHASE] = phase.arg();
        }
        Candidate::new(x, inputs, [if side < 0.0 { -1.0 } else { 1.0 }, 1.0], plan)
    }

    fn bound(&mut self, plan: &Plan<'_>) {
        for i in 0..DIMENSIONS {
            self.trial.x[i] = self.trial.x[i].clamp(plan.low[i], plan.high[i]);
        }
    }

    fn variant(&self, random: &mut RandomNumbers, plan: &Plan<'_>) -> Candidate {
        let mut other = self.clone();
        let size = 0.05 * 6f64.powf(random.between(0.0, 1.0));
        for (index, value) in other.trial.x.iter_mut().enumerate() {
            let scale = if plan.lengths.contains(&index) { value.abs() } else { value.abs().max(0.3) };
            *value += size * scale * random.normal().re;
        }
        other.bound(plan);
        other
    }
}

/// What a wrong order counts, in sizes of the path.
const DISORDER: f64 = 1.0;
/// Points of a path are looked at for their order only so many at once: noise may exchange neighbours.
const APART: usize = 8;

/// Do the angles of the crank go one way, and once around where the path is closed?
pub(crate) fn is_in_order(inputs: &[f64], closed: bool) -> bool {
    let thin: Vec<f64> = inputs.iter().step_by(inputs.len().div_ceil(APART)).copied().collect();
    if !closed {
        let all = |sign: f64| thin.windows(2).all(|pair| sign * (pair[1] - pair[0]) > 0.0);
        let ends = inputs.first().zip(inputs.last());
        return (all(1.0) || all(-1.0)) && ends.is_some_and(|(a, b)| (a - b).abs() < TAU);
    }
    let steps = || thin.iter().zip(thin.iter().cycle().skip(1)).map(|(a, b)| (b - a).rem_euclid(TAU));
    let forth: f64 = steps().sum();
    let back: f64 = steps().map(|step| TAU - step).sum();
    (forth - TAU).abs() < 1.0 || (back - TAU).abs() < 1.0
}

/// What is wanted of the linkages that keep the limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// The smallest error.
    Accuracy,
    /// The smallest linkage with errors of at most so much \[m or rad\].
    Size(f64),
    /// The largest transmission angle with errors of at most so much \[m or rad\].
    Transmission(f64),
}

/// A four-bar within limits, and what its limits cost.
#[derive(Clone, Debug)]
pub struct Bounded {
    /// The four-bar.
    pub follower: PathFollower,
    /// By how much the root mean square of the distances falls per unit by which the limit of lengths gives way, where a link is at it.
    pub price: f64,
}

/// Candidates that are settled within a plan, the best first.
pub(crate) fn searched(plan: &Plan<'_>, mut all: Vec<Candidate>, seed: u64) -> Vec<Candidate> {
    let approach = |all: &mut Vec<Candidate>, steps: usize, most: usize| {
        all.iter_mut().for_each(|candidate| plan.search(candidate.sides).approach(&mut candidate.trial, steps));
        keep(all, most, plan);
    };
    approach(&mut all, STEPS[0], SECOND_ROUND);
    approach(&mut all, STEPS[1], SETTLED);
    let mut random = RandomNumbers::new(seed);
    for _ in 0..VARIATIONS {
        let best: Vec<Candidate> = all.iter().take(VARIED).cloned().collect();
        let mut varied: Vec<Candidate> = Vec::with_capacity(VARIED * VARIANTS);
        for candidate in &best {
            varied.extend((0..VARIANTS).map(|_| candidate.variant(&mut random, plan)));
        }
        varied.iter_mut().for_each(|candidate| plan.search(candidate.sides).approach(&mut candidate.trial, STEPS[1]));
        all.extend(varied);
        keep(&mut all, SETTLED, plan);
    }
    all.iter_mut().for_each(|candidate| plan.search(candidate.sides).settle(&mut candidate.trial));
    keep(&mut all, SETTLED, plan);
    all
}

/// The best, none like another.
fn keep(all: &mut Vec<Candidate>, most: usize, plan: &Plan<'_>) {
    let mut ranked: Vec<(f64, Candidate)> =
        all.drain(..).map(|candidate| (plan.merit(&candidate), candidate)).collect();
    ranked.retain(|(merit, _)| merit.is_finite());
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, candidate) in ranked {
        if all.len() >= most {
            break;
        }
        let size = plan.size(&candidate);
        let near = |other: &Candidate| {
            let same = |&i: &usize| (candidate.trial.x[i] - other.trial.x[i]).abs() < 1e-3 * candidate.trial.x[i].abs();
            let place = |i: usize| (candidate.trial.x[i] - other.trial.x[i]).abs() < 1e-3 * size;
            candidate.sides == other.sides && plan.lengths.iter().all(same) && place(0) && place(1)
        };
        if !all.iter().any(near) {
            all.push(candidate);
        }
    }
}

/// A candidate with a bound drawn in as far as its error allows: by bisection, each time from the last one that was good enough.
pub(crate) fn drawn_in(
    plan: &Plan<'_>,
    candidate: &Candidate,
    wish: Wish,
    good: impl Fn(&Candidate) -> bool,
) -> Option<Candidate> {
    if !good(candidate) {
        return None;
    }
    let [mut from, mut to] = match wish {
        Wish::Accuracy => return Some(candidate.clone()),
        Wish::Size(_) => [plan.size(candidate), 0.1 * plan.size(candidate)],
        Wish::Transmission(_) => [plan.inequalities.cosine.acos(), 0.5 * PI],
    };
    let mut best = candidate.clone();
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        let tighter = if let Wish::Size(_) = wish { plan.smaller(middle) } else { plan.transmitting(middle) };
        let mut next = best.clone();
        next.bound(&tighter);
        tighter.search(next.sides).settle(&mut next.trial);
        if next.trial.violation <= 0.5 * SPARE && good(&next) {
            (best, from) = (next, middle);
        } else {
            to = middle;
        }
    }
    Some(best)
}

/// The four-bars that follow a path best within limits, best first; `known` ones are starts too.
pub fn bounded_followers(
    path: &CouplerPath,
    limits: &LinkageLimits,
    wish: Wish,
    known: &[PathFollower],
    effort: &PathEffort,
) -> Vec<Bounded> {
    if path.points.len() < 3 {
        return Vec::new();
    }
    let scaled = scaled(path);
    let corridor = Corridor::of(&scaled.points, path.closed);
    let plan = path_plan(&scaled, &corridor, path, limits);
    let settled = searched(&plan, starts(&plan, path, &scaled, known, effort), effort.seed);
    let error = |candidate: &Candidate| {
        follower(&scaled, path, candidate).largest.max(departure(&scaled, &corridor, candidate))
    };
    let is_ordered =
        |candidate: &Candidate| plan.order.is_none_or(|closed| is_in_order(&candidate.trial.inputs, closed));
    let drawn = |candidate: &Candidate| {
        let is_exact = wish == Wish::Accuracy && error(candidate) < EXACT * scaled.size;
        let wish = if is_exact { Wish::Transmission(EXACT * scaled.size) } else { wish };
        let within = match wish {
            Wish::Accuracy => f64::INFINITY,
            Wish::Size(within) | Wish::Transmission(within) => within,
        };
        drawn_in(&plan, candidate, wish, |candidate| is_ordered(candidate) && error(candidate) <= within)
    };
    let drawn: Vec<Candidate> = settled.iter().filter_map(drawn).collect();
    let chosen = if drawn.is_empty() { &settled } else { &drawn };
    chosen.iter().map(|candidate| bounded(&scaled, path, &plan, candidate)).collect()
}

/// How far the curve of a candidate leaves its path \[m\].
fn departure(scaled: &Scaled, corridor: &Corridor, candidate: &Candidate) -> f64 {
    let (chain, mut places) = (chain(candidate.sides), Places::new());
    let at = |input: f64| {
        chain.place(&candidate.trial.x, input, false, &mut places);
        Some(places.all[TRACER].at)
    };
    corridor.departure(&candidate.trial.inputs, at) * scaled.size
}

/// Four-bars for a path that get smaller and smaller, from one that is there on: each is as accurate as it can be.
pub fn smaller_followers(
    path: &CouplerPath,
    limits: &LinkageLimits,
    from: &[PathFollower],
    count: usize,
) -> Vec<Bounded> {
    let scaled = scaled(path);
    let corridor = Corridor::of(&scaled.points, path.closed);
    let whole = path_plan(&scaled, &corridor, path, limits);
    let mut list: Vec<Start> = from.iter().filter_map(|follower| of_follower(follower, &scaled)).collect();
    list.truncate(VARIED);
    let both = list
        .iter()
        .flat_map(|start| [false, true].map(|side| Candidate::of(start, side, path, &scaled.points, &whole)));
    let mut all: Vec<Candidate> = both.collect();
    all.iter_mut().for_each(|candidate| whole.search(candidate.sides).settle(&mut candidate.trial));
    keep(&mut all, VARIED, &whole);
    let Some(begin) = all.first().map(|candidate| whole.size(candidate)) else { return Vec::new() };
    let mut found = Vec::new();
    for step in 1..=count {
        let plan = whole.smaller(begin * SMALLER.powi(step as i32));
        for candidate in &mut all {
            candidate.bound(&plan);
            plan.search(candidate.sides).settle(&mut candidate.trial);
        }
        all.sort_by(|a, b| plan.merit(a).total_cmp(&plan.merit(b)));
        let holds =
            |candidate: &&Candidate| candidate.trial.violation <= 0.5 * SPARE && plan.merit(candidate) < DISORDER;
        let Some(best) = all.iter().find(holds) else { break };
        found.push(bounded(&scaled, path, &plan, best));
    }
    found
}

/// From one linkage to the next the size is this share.
const SMALLER: f64 = 0.8;

fn starts(
    plan: &Plan<'_>,
    path: &CouplerPath,
    scaled: &Scaled,
    known: &[PathFollower],
    effort: &PathEffort,
) -> Vec<Candidate> {
    let likely = if path.closed { atlas::closed_starts } else { atlas::open_starts };
    let count = effort.starts / 4;
    let room = [plan.low[CRANK], plan.high[CRANK]];
    let mut list = likely(&scaled.points, count, Some(room));
    list.extend(likely(&scaled.points, count, None));
    list.extend(known.iter().filter_map(|follower| of_follower(follower, scaled)));
    let both = |start| [false, true].map(|exchanged| Candidate::of(start, exchanged, path, &scaled.points, plan));
    list.iter().flat_map(both).collect()
}

/// Four-bars that are there as starts of a search on the same path.
pub(crate) fn four_bars(known: &[PathFollower], path: &CouplerPath, plan: &Plan<'_>) -> Vec<Candidate> {
    let scaled = scaled(path);
    let start = |follower: &PathFollower| {
        Some(Candidate::of(&of_follower(follower, &scaled)?, false, path, &scaled.points, plan))
    };
    known.iter().take(VARIED).filter_map(start).collect()
}

/// A start from a linkage that is there.
fn of_follower(follower: &PathFollower, scaled: &Scaled) -> Option<Start> {
    let (Dyad::Bar { moving: a, ground: a0, length: r }, Dyad::Bar { moving: b, ground: b0, length: s }) =
        (follower.linkage.first, follower.linkage.second)
    else {
        return None;
    };
    let [a, b] = [a, b].map(|pin| pin / scaled.size);
    let [c, d] = [a0, b0].map(|pivot| (pivot - scaled.middle) / scaled.size);
    let shared = [a.re, a.im, b.re, b.im, c.re, c.im, d.re, d.im, r / scaled.size, s / scaled.size];
    Some(Start { shared, local: follower.poses.iter().map(|pose| [pose.angle]).collect() })
}

fn bounded(scaled: &Scaled, path: &CouplerPath, plan: &Plan<'_>, candidate: &Candidate) -> Bounded {
    let follower = follower(scaled, path, candidate);
    let price = plan.search(candidate.sides).price(&candidate.trial, plan.lengths);
    let count = (2 * scaled.points.len()) as f64;
    let price = if follower.rms > 0.0 { price * scaled.size / (count * follower.rms) } else { 0.0 };
    Bounded { follower, price }
}

/// The linkage in the size of the path, its body's frame at the point that draws, along the coupler.
fn follower(scaled: &Scaled, path: &CouplerPath, candidate: &Candidate) -> PathFollower {
    let (x, chain) = (&candidate.trial.x, chain(candidate.sides));
    let real = |point: Point| point * scaled.size + scaled.middle;
    let tracer = Point::new(x[7], x[8]) * scaled.size;
    let a0 = Point::new(x[0], x[1]);
    let b0 = a0 + polar(x[GROUND], x[GROUND + 1]);
    let bar = |moving: Point, ground: Point, length: f64| Dyad::Bar {
        moving,
        ground: real(ground),
        length: length * scaled.size,
    };
    let first = bar(-tracer, a0, x[CRANK]);
    let second = bar(Point::new(x[COUPLER] * scaled.size, 0.0) - tracer, b0, x[SECOND]);
    let mut places = Places::new();
    let mut poses: Vec<Pose> = Vec::with_capacity(candidate.trial.inputs.len());
    for input in &candidate.trial.inputs {
        chain.place(x, *input, false, &mut places);
        let angle = (places.all[SECOND_PIN].at - places.all[2].at).arg();
        let angle = poses.last().map_or(angle, |last: &Pose| last.angle + way(last.angle, angle));
        poses.push(Pose { at: real(places.all[TRACER].at), angle });
    }
    let distances = poses.iter().zip(&path.points).map(|(pose, point)| (pose.at - point).norm());
    let largest = distances.fold(0.0, f64::max);
    let rms = (candidate.trial.sum / (2 * poses.len()) as f64).sqrt() * scaled.size;
    PathFollower { linkage: Linkage { first, second }, poses, largest, rms }
}
