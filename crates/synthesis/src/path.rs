//! Four-bars whose coupler point follows a path.
//!
//! Unknown are both dyads and the angle of the coupler at each point: no loop can fail to close on the way, and each angle is eliminated in its own
//! block. Two dyads that coincide meet every path, so bars that vanish beside others are refused. What that finds are candidates only: the
//! distance of the points from the curve, loops closed, decides.
//!
//! Source of the equations: A. P. Morgan, C. W. Wampler, *Solving a planar four-bar design problem using continuation*, J. Mech. Des. 112, 1990; of the
//! search: starts from an atlas.

use std::f64::consts::TAU;

use crate::atlas::{self, Start};
use crate::corridor::Corridor;
use crate::defects::Verdict;
use crate::dyad::Dyad;
use crate::least::{EndCriteria, TermResiduals, Terms, Unknowns, minimise};
use crate::linkage::Linkage;
use crate::poses::{Pose, extent, way};
use crate::random::RandomNumbers;
use crate::valley::descend;
use crate::{Point, dot, polar, sextic};

/// What a point of the coupler shall follow.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CouplerPath {
    /// The points, in order \[m\].
    pub points: Vec<Point>,
    /// Is it a closed curve, whose last point is beside the first?
    pub closed: bool,
    /// How far the first bar has turned at each point from the first one on, if that is given \[rad\].
    pub crank: Option<Vec<f64>>,
    /// The pivots in the ground, if they are given \[m\].
    pub pivots: Option<[Point; 2]>,
}

impl CouplerPath {
    /// How far the curve of a linkage leaves the path at most: between the inputs of its ends, or in a full turn if the path is closed.
    ///
    /// Between two points the path may be as round as the arcs through neighbouring points are, up to 2 % of its size.
    pub fn departure(&self, linkage: &Linkage, verdict: &Verdict) -> f64 {
        let at = |input: f64| linkage.pose(input, verdict.side).map(|pose| pose.at);
        Corridor::of(&self.points, self.closed).departure(&verdict.inputs, at)
    }
}

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathEffort {
    /// So many starts at most.
    pub starts: usize,
    /// Of what is tried beside the atlas.
    pub seed: u64,
}

impl Default for PathEffort {
    fn default() -> PathEffort {
        PathEffort { starts: 960, seed: 1 }
    }
}

/// A four-bar that follows a path.
#[derive(Clone, Debug)]
pub struct PathFollower {
    /// The coupler, its frame at the point that draws, on its dyads.
    pub linkage: Linkage,
    /// The coupler where it is nearest to each point of the path, or where the crank has the given turn.
    pub poses: Vec<Pose>,
    /// The largest distance of a point of the path from where it should be \[m\].
    pub largest: f64,
    /// The root mean square of these distances, in each direction; what the search within limits minimises counts the curve between the points, too \[m\].
    pub rms: f64,
}

/// A bar shorter than this share of the longest is none: two coincident dyads meet every path.
const SHORTEST: f64 = 3e-3;
/// A bar longer than this is none, in sizes of the path.
const LONGEST: f64 = 1e3;
/// A residual is zero below so many rounding errors of the points: pieces of curves of four-bars that are far apart differ by 1e-13 of their size.
const ZERO: f64 = 64.0 * f64::EPSILON;

struct Bars {
    pins: [Point; 2],
    pivots: [Point; 2],
    lengths: [f64; 2],
}

fn bars(shared: &[f64]) -> Bars {
    let point = |first: usize| Point::new(shared[first], shared[first + 1]);
    Bars { pins: [point(0), point(2)], pivots: [point(4), point(6)], lengths: [shared[8], shared[9]] }
}

fn all_bars(shared: &[f64]) -> [f64; 4] {
    let dyads = bars(shared);
    let ground = (dyads.pivots[1] - dyads.pivots[0]).norm();
    let body = (dyads.pins[1] - dyads.pins[0]).norm();
    [ground, dyads.lengths[0].abs(), body, dyads.lengths[1].abs()]
}

fn longest(shared: &[f64]) -> f64 {
    all_bars(shared).into_iter().fold(0.0, f64::max)
}

fn is_nothing(shared: &[f64], least: f64) -> bool {
    let longest = longest(shared);
    let shortest = all_bars(shared).into_iter().fold(f64::INFINITY, f64::min);
    longest.is_nan() || shortest < least * longest || longest > LONGEST
}

/// The residual of a bar at a place and an angle of the body, and its derivatives by pin, pivot, length, angle, place.
struct BarTerm {
    value: f64,
    by_pin: Point,
    along: Point,
    by_angle: f64,
}

fn bar(place: Point, turn: Point, pin: Point, pivot: Point, length: f64) -> BarTerm {
    let arm = turn * pin;
    let way = place + arm - pivot;
    let size = way.norm();
    let along = way / size.max(f64::MIN_POSITIVE);
    BarTerm {
        value: size - length,
        by_pin: along * turn.conj(),
        along,
        by_angle: dot(along, Point::new(-arm.im, arm.re)),
    }
}

/// Residuals of both bars at the points; the angle of the body is a point's own.
struct Dyads<'p> {
    points: &'p [Point],
    held: bool,
}

fn by_bar<const G: usize>(slopes: &mut [f64; G], which: usize, term: &BarTerm, held: bool) {
    let (pin, pivot) = (2 * which, 4 + 2 * which);
    (slopes[pin], slopes[pin + 1]) = (term.by_pin.re, term.by_pin.im);
    if !held {
        (slopes[pivot], slopes[pivot + 1]) = (-term.along.re, -term.along.im);
    }
    slopes[8 + which] = -1.0;
}

impl Terms<10, 1, 2> for Dyads<'_> {
    fn count(&self) -> usize {
        self.points.len()
    }

    fn at(&self, term: usize, shared: &[f64; 10], local: &[f64; 1]) -> TermResiduals<10, 1, 2> {
        let (bars, turn) = (bars(shared), polar(1.0, local[0]));
        let mut found = TermResiduals::zero();
        for which in 0..2 {
            let one = bar(self.points[term], turn, bars.pins[which], bars.pivots[which], bars.lengths[which]);
            found.value[which] = one.value;
            by_bar(&mut found.by_shared[which], which, &one, self.held);
            found.by_local[which] = [one.by_angle];
        }
        found
    }
}

/// Distances of the points from places where both loops close: place and angle are a point's own; loops count much more than distances.
struct Distances<'p> {
    points: &'p [Point],
    held: bool,
    weight: f64,
}

impl Terms<10, 3, 4> for Distances<'_> {
    fn count(&self) -> usize {
        self.points.len()
    }

    fn at(&self, term: usize, shared: &[f64; 10], local: &[f64; 3]) -> TermResiduals<10, 3, 4> {
        let (bars, place, turn) = (bars(shared), Point::new(local[0], local[1]), polar(1.0, local[2]));
        let mut found = TermResiduals::zero();
        let way = place - self.points[term];
        (found.value[0], found.value[1]) = (way.re, way.im);
        (found.by_local[0], found.by_local[1]) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        for which in 0..2 {
            let one = bar(place, turn, bars.pins[which], bars.pivots[which], bars.lengths[which]);
            found.value[2 + which] = self.weight * one.value;
            by_bar(&mut found.by_shared[2 + which], which, &one, self.held);
            found.by_shared[2 + which].iter_mut().for_each(|slope| *slope *= self.weight);
            found.by_local[2 + which] = [one.along.re, one.along.im, one.by_angle].map(|slope| slope * self.weight);
        }
        found
    }
}

/// The same with the turns of the first bar given: its angle at the first point is one more unknown. Places are the points' own, or the points.
struct Timed<'p> {
    points: &'p [Point],
    turns: &'p [f64],
    held: bool,
    weight: f64,
}

impl Terms<11, 3, 5> for Timed<'_> {
    fn count(&self) -> usize {
        self.points.len()
    }

    fn at(&self, term: usize, shared: &[f64; 11], local: &[f64; 3]) -> TermResiduals<11, 3, 5> {
        let (bars, place, turn) = (bars(shared), Point::new(local[0], local[1]), polar(1.0, local[2]));
        let mut found = TermResiduals::zero();
        let way = place - self.points[term];
        (found.value[0], found.value[1]) = (way.re, way.im);
        (found.by_local[0], found.by_local[1]) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let crank = polar(1.0, shared[10] + self.turns[term]);
        let arm = turn * bars.pins[0];
        let open = place + arm - bars.pivots[0] - crank * bars.lengths[0];
        let across = Point::new(-arm.im, arm.re);
        let turned = Point::new(crank.im, -crank.re) * bars.lengths[0];
        let pivot = if self.held { 0.0 } else { -1.0 };
        let rows = [
            (open.re, [turn.re, -turn.im], [pivot, 0.0], crank.re, turned.re, [1.0, 0.0, across.re]),
            (open.im, [turn.im, turn.re], [0.0, pivot], crank.im, turned.im, [0.0, 1.0, across.im]),
        ];
        for (row, (value, by_pin, by_pivot, along, by_phase, by_local)) in rows.into_iter().enumerate() {
            let slopes = &mut found.by_shared[2 + row];
            (slopes[0], slopes[1], slopes[4], slopes[5]) = (by_pin[0], by_pin[1], by_pivot[0], by_pivot[1]);
            (slopes[8], slopes[10]) = (-along, by_phase);
            slopes.iter_mut().for_each(|slope| *slope *= self.weight);
            found.value[2 + row] = self.weight * value;
            found.by_local[2 + row] = by_local.map(|slope| slope * self.weight);
        }
        let one = bar(place, turn, bars.pins[1], bars.pivots[1], bars.lengths[1]);
        found.value[4] = self.weight * one.value;
        by_bar(&mut found.by_shared[4], 1, &one, self.held);
        found.by_shared[4].iter_mut().for_each(|slope| *slope *= self.weight);
        found.by_local[4] = [one.along.re, one.along.im, one.by_angle].map(|slope| slope * self.weight);
        found
    }
}

/// A path of size one around the origin.
pub(crate) struct Scaled {
    pub points: Vec<Point>,
    pub pivots: Option<[Point; 2]>,
    pub middle: Point,
    pub size: f64,
}

pub(crate) fn scaled(path: &CouplerPath) -> Scaled {
    let (middle, size) = extent(path.points.iter().copied());
    let place = |point: &Point| (point - middle) / size;
    Scaled {
        points: path.points.iter().map(place).collect(),
        pivots: path.pivots.map(|pivot| pivot.map(|at| place(&at))),
        middle,
        size,
    }
}

/// Points that determine a four-bar up to its cognates: nine determine finitely many, more none but by chance.
const DETERMINED: usize = 10;
/// Candidates whose distances are looked at.
const CANDIDATES: usize = 24;
/// Starts that are tried together. The best of them go on to the second and the third round, each with more steps: the minima of short pieces of curves lie in
/// long valleys (more steps for a few of the starts find twice as many known four-bars in the same time as few steps for all).
const ROUND: usize = 96;
const ROUNDS: [(usize, usize); 3] = [(ROUND, 18), (12, 60), (3, 1500)];
/// Steps along the floors of the valleys in which the last ones lie.
const VALLEY: usize = 3000;
/// Points that a four-bar meets so well, in sizes of the path, are without noise. So many times as many starts are then tried, beside so many of the best.
const EXACT: f64 = 1e-6;
/// A four-bar with a longer bar is a giant, in sizes of the path.
const GIANT: f64 = 30.0;
const MORE: usize = 3;
const BEST: usize = 12;

/// The four-bars that follow a path best, best first, each a local minimum of the distances; cognates are not among them.
pub fn followers(path: &CouplerPath, effort: &PathEffort) -> Vec<PathFollower> {
    if path.points.len() < 3 {
        return Vec::new();
    }
    let scaled = scaled(path);
    let candidates = candidates(&scaled, path, effort);
    let mut found: Vec<PathFollower> = match &path.crank {
        Some(turns) => candidates.iter().filter_map(|candidate| timed(&scaled, turns, candidate)).collect(),
        None => candidates.iter().filter_map(|candidate| nearest(&scaled, candidate)).collect(),
    };
    if found.is_empty() && path.crank.is_none() {
        // Both dyads of all candidates have run into each other, to soak up the noise: from the curves themselves the distances do not lead there.
        let mut starts = PathStarts::new(&scaled, path, effort);
        found = starts.next().unwrap_or_default().iter().filter_map(|start| nearest(&scaled, start)).collect();
    }
    found.sort_by(|a, b| a.rms.total_cmp(&b.rms));
    let mut apart: Vec<PathFollower> = Vec::new();
    for one in found {
        if !apart.iter().any(|other| is_same(other, &one)) {
            apart.push(one);
        }
    }
    apart
}

/// Are two four-bars the same, also with their dyads exchanged?
fn is_same(a: &PathFollower, b: &PathFollower) -> bool {
    let lengths = |follower: &PathFollower| follower.linkage.lengths().map(|length| length.unwrap_or(0.0));
    let pivots = |linkage: &Linkage| {
        [linkage.first, linkage.second].map(|dyad| match dyad {
            Dyad::Bar { ground, .. } => ground,
            Dyad::Slider { .. } | Dyad::Slot { .. } => Point::new(0.0, 0.0),
        })
    };
    let (first, [g, r, k, s]) = (lengths(a), lengths(b));
    let (here, [p, q]) = (pivots(&a.linkage), pivots(&b.linkage));
    let size = first.iter().sum::<f64>();
    let near = |other: [f64; 4], places: [Point; 2]| {
        (0..4).all(|i| (first[i] - other[i]).abs() < 1e-6 * size)
            && (0..2).all(|i| (here[i] - places[i]).norm() < 1e-6 * size)
    };
    near([g, r, k, s], [p, q]) || near([g, s, k, r], [q, p])
}

/// The best of what was found, without what is there already; none with nearly coincident dyads, which soak noise up.
struct Pool {
    most: usize,
    shortest: f64,
    starts: Vec<(f64, Start)>,
}

impl Pool {
    fn new(most: usize, shortest: f64) -> Pool {
        Pool { most, shortest, starts: Vec::new() }
    }

    fn take(&mut self, round: &[(f64, Start)]) {
        for (sum, start) in round {
            let full = self.starts.len() >= self.most;
            if full && self.starts.last().is_some_and(|(worst, _)| worst <= sum) {
                break;
            }
            if !is_nothing(&start.shared, self.shortest) && !self.starts.iter().any(|(_, other)| is_near(other, start))
            {
                let place = self.starts.partition_point(|(other, _)| other < sum);
                self.starts.insert(place, (*sum, start.clone()));
                self.starts.truncate(self.most);
            }
        }
    }
}

/// In candidates for paths with noise, bars are longer than this share of the longest.
const NOISY: f64 = 0.03;

/// Dyads that meet the path nearly. Where a path has more points than a four-bar can meet by chance, one that meets it is enough.
fn candidates(scaled: &Scaled, path: &CouplerPath, effort: &PathEffort) -> Vec<Start> {
    let held = scaled.pivots.is_some();
    let count = scaled.points.len();
    let enough = if held { count > 5 } else { count >= DETERMINED };
    let mut search = Search::new(scaled, enough, held);
    if enough && !held {
        if let Some(found) = search.round(sextic::starts(&scaled.points)) {
            return vec![found];
        }
        // Noise bends the equation more than any four-bar.
        if !search.is_exact() {
            search = Search::new(scaled, enough, held);
        }
    }
    let mut starts = PathStarts::new(scaled, path, effort);
    while let Some(round) = starts.next() {
        if let Some(found) = search.round(round) {
            return vec![found];
        }
    }
    for number in 0..if search.is_exact() { MORE * effort.starts / ROUND } else { 0 } {
        let best = &search.late.starts[..search.late.starts.len().min(BEST)];
        let random = &mut starts.random;
        let round = match number % 2 {
            0 => (0..ROUND).map(|_| atlas::variant(&best[random.below(best.len())].1, random)).collect(),
            _ => starts.further(ROUND),
        };
        if let Some(found) = search.round(round) {
            return vec![found];
        }
    }
    search.late.starts.into_iter().chain(search.early.starts).map(|(_, start)| start).collect()
}

/// The best dyads so far.
struct Search<'p> {
    dyads: Dyads<'p>,
    /// Is one that meets the path enough?
    enough: bool,
    /// Residuals are zero below this.
    zero: f64,
    early: Pool,
    late: Pool,
}

impl<'p> Search<'p> {
    fn new(scaled: &'p Scaled, enough: bool, held: bool) -> Search<'p> {
        Search {
            dyads: Dyads { points: &scaled.points, held },
            enough,
            zero: ZERO * (1.0 + scaled.middle.norm() / scaled.size),
            early: Pool::new(CANDIDATES, NOISY),
            late: Pool::new(if enough { CANDIDATES } else { 8 * CANDIDATES }, SHORTEST),
        }
    }

    /// Tries starts together; gives one that meets the path.
    fn round(&mut self, round: Vec<Start>) -> Option<Start> {
        let dyads = &self.dyads;
        let mut round: Vec<(f64, Start)> = round.into_iter().map(|start| (0.0, start)).collect();
        for (number, (kept, steps)) in ROUNDS.into_iter().enumerate() {
            round.truncate(kept);
            round.iter_mut().for_each(|(sum, start)| *sum = minimise(dyads, start, EndCriteria::after(steps)));
            if number + 1 == ROUNDS.len() && self.enough {
                round.iter_mut().for_each(|(sum, start)| *sum = descend(dyads, start, EndCriteria::after(VALLEY)));
            }
            round.retain(|(sum, start)| sum.is_finite() && !is_nothing(&start.shared, SHORTEST));
            round.sort_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, first)) = round.first().filter(|(sum, _)| self.enough && *sum < self.sum(self.zero)) {
                return Some(first.clone());
            }
            if number + 1 < ROUNDS.len() { self.early.take(&round) } else { self.late.take(&round) }
        }
        None
    }

    /// The sum of squares of residuals of this size.
    fn sum(&self, residual: f64) -> f64 {
        residual * residual * self.dyads.points.len() as f64
    }

    /// Is the best so near that the points are without noise? Then there is a four-bar that meets them. Giants come near everything.
    fn is_exact(&self) -> bool {
        let is_near = |(sum, start): &(f64, Start)| *sum < self.sum(EXACT) && longest(&start.shared) < GIANT;
        self.enough && self.late.starts.first().is_some_and(is_near)
    }
}

/// Are pivots and lengths the same?
fn is_near(a: &Start, b: &Start) -> bool {
    let (p, q) = (&a.shared, &b.shared);
    let same = |one: f64, other: f64| (one - other).abs() < 1e-4 * (1.0 + one.abs());
    let near = |i: usize, j: usize| same(p[i], q[j]);
    let body = |shared: &[f64; 10]| (shared[2] - shared[0]).hypot(shared[3] - shared[1]);
    let plain = (4..10).all(|i| near(i, i));
    let exchanged = [(4, 6), (5, 7), (6, 4), (7, 5), (8, 9), (9, 8)];
    same(body(p), body(q)) && (plain || exchanged.into_iter().all(|(i, j)| near(i, j)))
}

/// The atlas gives so many times as many starts as are tried at first.
const FURTHER: usize = 3;
/// With given pivots a start is cheap and the number of solutions finite: so many times more are tried.
const GIVEN: usize = 12;

/// Starts, round by round: of the atlas, then beside them.
struct PathStarts<'p> {
    scaled: &'p Scaled,
    atlas: Vec<Start>,
    /// Those of the atlas that are less alike.
    further: Vec<Start>,
    given: usize,
    left: usize,
    random: RandomNumbers,
}

impl<'p> PathStarts<'p> {
    fn new(scaled: &'p Scaled, path: &CouplerPath, effort: &PathEffort) -> PathStarts<'p> {
        let first = (effort.starts / 2).min(10 * ROUND);
        let likely = if path.closed { atlas::closed_starts } else { atlas::open_starts };
        let mut atlas = likely(&scaled.points, FURTHER * first, None);
        let further = atlas.split_off(first.min(atlas.len()));
        let left = if scaled.pivots.is_some() { GIVEN * effort.starts } else { effort.starts };
        PathStarts { scaled, atlas, further, given: 0, left, random: RandomNumbers::new(effort.seed) }
    }

    fn next(&mut self) -> Option<Vec<Start>> {
        let count = ROUND.min(self.left);
        self.left -= count;
        let round: Vec<Start> = (0..count).filter_map(|_| self.one()).collect();
        (!round.is_empty()).then_some(round)
    }

    /// So many of those that are less alike, and then beside all.
    fn further(&mut self, count: usize) -> Vec<Start> {
        let mut round: Vec<Start> = self.further.drain(..count.min(self.further.len())).collect();
        round.extend((round.len()..count).filter_map(|_| self.one()));
        round
    }

    fn one(&mut self) -> Option<Start> {
        let index = self.given;
        self.given += 1;
        if let Some(pivots) = self.scaled.pivots.filter(|_| index >= self.atlas.len()) {
            return Some(anywhere(&self.scaled.points, pivots, &mut self.random));
        }
        let mut start = match self.atlas.get(index) {
            Some(start) => start.clone(),
            None => {
                let near = self.random.below(self.atlas.len());
                atlas::variant(self.atlas.get(near)?, &mut self.random)
            }
        };
        if let Some(pivots) = self.scaled.pivots {
            hold(&mut start, pivots, &self.scaled.points);
        }
        Some(start)
    }
}

/// A start with pins of the body and angles at random.
fn anywhere(points: &[Point], pivots: [Point; 2], random: &mut RandomNumbers) -> Start {
    let mut start = Unknowns { shared: [0.0; 10], local: points.iter().map(|_| [random.between(0.0, TAU)]).collect() };
    for pin in 0..2 {
        let at = random.normal() * 2.0;
        (start.shared[2 * pin], start.shared[2 * pin + 1]) = (at.re, at.im);
    }
    hold(&mut start, pivots, points);
    start
}

/// A start with its pivots moved to where they are to be.
fn hold(start: &mut Start, pivots: [Point; 2], points: &[Point]) {
    let dyads = bars(&start.shared);
    let mut lengths = [0.0; 2];
    for which in 0..2 {
        let way = |(point, own_angle): (&Point, &[f64; 1])| {
            (point + polar(1.0, own_angle[0]) * dyads.pins[which] - pivots[which]).norm()
        };
        lengths[which] = points.iter().zip(&start.local).map(way).sum::<f64>() / points.len().max(1) as f64;
    }
    start.shared[4..].copy_from_slice(&[
        pivots[0].re,
        pivots[0].im,
        pivots[1].re,
        pivots[1].im,
        lengths[0],
        lengths[1],
    ]);
}

/// A path is met, in its sizes.
const MET: f64 = 1e-12;
/// Weights of the loops, one after the other: at the last one, loops are open by 1e-8 of the distances.
const WEIGHTS: [f64; 2] = [30.0, 1e4];

fn nearest(scaled: &Scaled, start: &Start) -> Option<PathFollower> {
    let local: Vec<[f64; 3]> =
        scaled.points.iter().zip(&start.local).map(|(point, angle)| [point.re, point.im, angle[0]]).collect();
    // What meets the path is not moved: normal equations would lose it again in the valley that it lies in.
    if let Some(exact) = built(scaled, &start.shared, &local).filter(|follower| follower.largest < MET * scaled.size) {
        return Some(exact);
    }
    let mut at = Unknowns { shared: start.shared, local };
    let held = scaled.pivots.is_some();
    for weight in WEIGHTS {
        minimise(
            &Distances { points: &scaled.points, held, weight },
            &mut at,
            EndCriteria { share: 1e-7, ..EndCriteria::after(80) },
        );
    }
    built(scaled, &at.shared, &at.local)
}

/// With the turns of the first bar; either bar may be the first one.
fn timed(scaled: &Scaled, turns: &[f64], start: &Start) -> Option<PathFollower> {
    let swapped = |start: &Start| {
        let s = start.shared;
        let shared = [s[2], s[3], s[0], s[1], s[6], s[7], s[4], s[5], s[9], s[8]];
        Unknowns { shared, local: start.local.clone() }
    };
    let other = scaled.pivots.is_none().then(|| swapped(start));
    let both = std::iter::once(start.clone()).chain(other);
    both.filter_map(|start| timed_from(scaled, turns, &start)).min_by(|a, b| a.rms.total_cmp(&b.rms))
}

fn timed_from(scaled: &Scaled, turns: &[f64], start: &Start) -> Option<PathFollower> {
    let bars = bars(&start.shared);
    let angle = |(index, local): (usize, &[f64; 1])| {
        let arm = scaled.points[index] + polar(1.0, local[0]) * bars.pins[0] - bars.pivots[0];
        polar(1.0, arm.arg() - turns[index])
    };
    let phase = start.local.iter().enumerate().map(angle).sum::<Point>().arg();
    let mut shared = [0.0; 11];
    shared[..10].copy_from_slice(&start.shared);
    shared[10] = phase;
    let local = scaled.points.iter().zip(&start.local).map(|(point, angle)| [point.re, point.im, angle[0]]).collect();
    let mut at = Unknowns { shared, local };
    for weight in [1.0, 30.0, 1e4] {
        let held = scaled.pivots.is_some();
        let timed = Timed { points: &scaled.points, turns, held, weight };
        minimise(&timed, &mut at, EndCriteria { share: 1e-10, ..EndCriteria::after(150) });
    }
    built(scaled, &at.shared, &at.local)
}

/// The linkage in the size of the path; none if a bar vanishes or a loop is open.
fn built(scaled: &Scaled, shared: &[f64], local: &[[f64; 3]]) -> Option<PathFollower> {
    if is_nothing(shared, SHORTEST) {
        return None;
    }
    let bars = bars(shared);
    let dyad = |which: usize| Dyad::Bar {
        moving: bars.pins[which] * scaled.size,
        ground: bars.pivots[which] * scaled.size + scaled.middle,
        length: bars.lengths[which].abs() * scaled.size,
    };
    let linkage = Linkage { first: dyad(0), second: dyad(1) };
    let pose =
        |local: &[f64; 3]| Pose { at: Point::new(local[0], local[1]) * scaled.size + scaled.middle, angle: local[2] };
    let poses: Vec<Pose> = local.iter().map(|local| pose(&closed(&bars, *local))).collect();
    let open = linkage.first.largest_error(&poses).max(linkage.second.largest_error(&poses));
    let ways =
        || poses.iter().zip(&scaled.points).map(|(pose, point)| (pose.at - scaled.middle - point * scaled.size).norm());
    let largest = ways().fold(0.0, f64::max);
    let square = ways().map(|way_error| way_error * way_error).sum::<f64>() / (2 * poses.len()) as f64;
    let closes = open < CLOSED * scaled.size;
    closes.then(|| PathFollower { linkage, poses: unwound(poses), largest, rms: square.sqrt() })
}

/// Loops are closed up to this share of the size.
const CLOSED: f64 = 1e-10;

/// A place moved by what its loops are open, with the angle of the body as it is (Newton's method); where the bars lie along each other there is none.
fn closed(bars: &Bars, local: [f64; 3]) -> [f64; 3] {
    let (mut place, turn) = (Point::new(local[0], local[1]), polar(1.0, local[2]));
    for _ in 0..3 {
        let [one, other] =
            [0, 1].map(|which| bar(place, turn, bars.pins[which], bars.pivots[which], bars.lengths[which]));
        let across = one.along.re * other.along.im - one.along.im * other.along.re;
        if across.abs() < 1e-6 {
            break;
        }
        let x = (one.value * other.along.im - other.value * one.along.im) / across;
        let y = (other.value * one.along.re - one.value * other.along.re) / across;
        place -= Point::new(x, y);
    }
    [place.re, place.im, local[2]]
}

/// Angles without a jump.
fn unwound(mut poses: Vec<Pose>) -> Vec<Pose> {
    if let Some(first) = poses.first_mut() {
        first.angle = first.angle.rem_euclid(TAU);
    }
    for index in 1..poses.len() {
        let before = poses[index - 1].angle;
        poses[index].angle = before + way(before, poses[index].angle);
    }
    poses
}
