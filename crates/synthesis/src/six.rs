//! Six-bars for paths, functions and poses: a four-bar with one more dyad. All dimensions are optimised together within limits.
//!
//! Starts are four-bars whose coupler curve is near a path, with a dyad at the point that draws, and linkages at random. In all of them the crank turns in the ground and belongs to a
//! loop of four bars, so that each place follows from it by dyads. The Stephenson II chain with such an input is not among them: its loop of five bars needs the solution of a triad.
//!
//! Source of the kinds: R. L. Norton, *Design of Machinery*, 2012, chapter 2.

use std::f64::consts::TAU;

use crate::bounded::{Goal, Inequalities, SPARE};
use crate::chain::{Chain, DIMENSIONS, Node, Places};
use crate::corridor::{Corridor, ends, reach};
use crate::function::Pair;
use crate::limits::{LinkageLimits, Region};
use crate::path::{CouplerPath, PathFollower, Scaled, scaled};
use crate::poses::{Pose, way};
use crate::random::RandomNumbers;
use crate::within::{Candidate, Plan, Sides, cosine, four_bars, is_in_order, searched};
use crate::{Point, polar};

/// Where the dyad is added to the four-bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SixKind {
    /// Between coupler and second bar.
    WattOne,
    /// Between second bar and ground.
    WattTwo,
    /// Between crank and second bar.
    StephensonOne,
    /// Between coupler and ground.
    StephensonThree,
}

/// All kinds.
pub const KINDS: [SixKind; 4] = [SixKind::StephensonThree, SixKind::WattOne, SixKind::WattTwo, SixKind::StephensonOne];

impl SixKind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            SixKind::WattOne => "Watt I",
            SixKind::WattTwo => "Watt II",
            SixKind::StephensonOne => "Stephenson I",
            SixKind::StephensonThree => "Stephenson III",
        }
    }

    /// Does the dyad end at a pivot in the ground? Then a bar there can be an output.
    fn has_pivot(self) -> bool {
        matches!(self, SixKind::WattTwo | SixKind::StephensonThree)
    }

    fn chain(self, [first, second]: [f64; 2]) -> Chain {
        let on = |from: usize, to: usize, at: usize| Node::Attached { from, to, at };
        let (d, f) = match self {
            SixKind::WattOne => (on(2, 3, D), on(1, 3, F)),
            SixKind::WattTwo => (on(1, 3, D), Node::Beside { from: 0, at: F }),
            SixKind::StephensonOne => (on(0, 2, D), on(1, 3, F)),
            SixKind::StephensonThree => (on(2, 3, D), Node::Beside { from: 0, at: F }),
        };
        let nodes = vec![
            Node::Ground { at: 0 },
            Node::Beside { from: 0, at: GROUND },
            Node::Crank { pivot: 0, length: CRANK },
            Node::Dyad { from: 2, to: 1, lengths: [COUPLER, SECOND], side: first },
            d,
            f,
            Node::Dyad { from: 4, to: 5, lengths: [LINK, OUTPUT], side: second },
            on(4, 6, TRACER),
        ];
        Chain { nodes, dimensions: COUNT }
    }
}

/// What the dimensions are.
const GROUND: usize = 2;
const CRANK: usize = 4;
const COUPLER: usize = 5;
const SECOND: usize = 6;
const D: usize = 7;
const F: usize = 9;
const LINK: usize = 11;
const OUTPUT: usize = 12;
const TRACER: usize = 13;
const PHASE: usize = 15;
const ZERO: usize = 16;
const COUNT: usize = 17;
const BARS: [usize; 6] = [GROUND, CRANK, COUPLER, SECOND, LINK, OUTPUT];

/// So often bars are drawn at random for a crank that turns fully.
const TRIES: usize = 1000;
/// Starts of each kind that are made at random, and beside each four-bar.
const ANYWHERE: usize = 480;
const BESIDE: usize = 24;

/// A body with named points, as a scene has it.
#[derive(Clone, Debug, PartialEq)]
pub struct SixBody {
    /// Its name.
    pub name: &'static str,
    /// Its points in its frame \[m\].
    pub points: Vec<(&'static str, Point)>,
    /// Its angle at the start \[rad\].
    pub angle: f64,
}

impl SixBar {
    /// The largest distance of two points of one link, the ground included; the tracer is a point of its link only if it is asked for \[m\].
    pub fn size(&self, tracer: bool) -> f64 {
        let is_counted = |name: &str| tracer || name != "tracer";
        let points = |points: &[(&'static str, Point)]| -> Vec<Point> {
            points.iter().filter(|(name, _)| is_counted(name)).map(|(_, point)| *point).collect()
        };
        let links = self.bodies.iter().map(|body| points(&body.points)).chain([points(&self.ground)]);
        links.map(|link| reach(&link)).fold(0.0, f64::max)
    }
}

/// A six-bar that does its task.
#[derive(Clone, Debug)]
pub struct SixBar {
    /// What it is.
    pub kind: SixKind,
    /// Pivots in the ground.
    pub ground: Vec<(&'static str, Point)>,
    /// Its moving bodies, the crank first.
    pub bodies: Vec<SixBody>,
    /// Which points are one pin: `body.point`.
    pub joints: Vec<[&'static str; 2]>,
    /// Lengths of ground, crank, coupler, second bar, and of both bars of the dyad \[m\].
    pub lengths: [f64; 6],
    /// The angles of the crank at the points of the task \[rad\].
    pub inputs: Vec<f64>,
    /// The angles of the body that takes poses, which is `link`; empty for other tasks \[rad\].
    pub turns: Vec<f64>,
    /// Where the point is, or \[output, 0\] as turns from the first position.
    pub outputs: Vec<Point>,
    /// The largest error \[m or rad\].
    pub largest: f64,
    /// The smallest transmission angles of both loops over the way of the crank \[rad\].
    pub transmission: [f64; 2],
    /// Does the crank turn fully?
    pub full_turn: bool,
}

/// Six-bars for a path, best first, from four-bars that are near it.
pub fn six_bar_followers(path: &CouplerPath, limits: &LinkageLimits, known: &[PathFollower], seed: u64) -> Vec<SixBar> {
    let scaled = scaled(path);
    let turns = path.crank.as_ref().map(|turns| (&turns[..], PHASE));
    let corridor = Corridor::of(&scaled.points, path.closed);
    let goal = Goal::Path { tracer: 7, points: &scaled.points, corridor: &corridor, turns };
    let mut found = Vec::new();
    for kind in KINDS {
        let mut plan = plan(kind, goal, scaled.size, limits.crank || path.closed, limits);
        let [_, most] = lengths(limits, scaled.size);
        plan.inequalities.distances.extend([4, 6].map(|pin| ([pin, 7], [0.0, most])));
        plan.order = turns.is_none().then_some(path.closed);
        plan.inequalities.regions = regions(kind, limits, &scaled);
        let mut random = RandomNumbers::new(seed);
        let mut starts = Vec::new();
        for start in four_bars(known, path, &plan) {
            starts.extend((0..BESIDE).map(|_| with_dyad(kind, &start, &plan, &mut random)));
        }
        for candidate in searched(&plan, starts, seed) {
            let error = |index: usize, places: &Places| {
                let place = places.all[7].at;
                (place * scaled.size + scaled.middle, (place - scaled.points[index]).norm() * scaled.size)
            };
            found.extend(built(
                kind,
                &candidate,
                &plan,
                [scaled.size, scaled.middle.re, scaled.middle.im],
                None,
                error,
            ));
        }
    }
    found.sort_by(|a: &SixBar, b| a.largest.total_cmp(&b.largest));
    found
}

/// How much a radian counts beside the extent of the poses.
const RADIAN: f64 = 1.0;

/// Six-bars whose link between the dyad's pins takes a body through poses, best first, from four-bars one of whose points is near the poses' origins. Errors are distances, or
/// angles times the extent of the poses.
pub fn six_bar_poses(poses: &[Pose], limits: &LinkageLimits, known: &[PathFollower], seed: u64) -> Vec<SixBar> {
    let path = CouplerPath { points: poses.iter().map(|pose| pose.at).collect(), ..CouplerPath::default() };
    let scaled = scaled(&path);
    let angles: Vec<f64> = poses.iter().map(|pose| pose.angle).collect();
    let body = [4, 6];
    let goal = Goal::Poses { tracer: 7, body, zero: ZERO, points: &scaled.points, angles: &angles, weight: RADIAN };
    let mut found = Vec::new();
    for kind in KINDS {
        let mut plan = plan(kind, goal, scaled.size, limits.crank, limits);
        plan.order = Some(false);
        plan.inequalities.regions = regions(kind, limits, &scaled);
        let mut random = RandomNumbers::new(seed);
        let mut starts = Vec::new();
        for start in four_bars(known, &path, &plan) {
            starts.extend((0..BESIDE).map(|_| with_dyad(kind, &start, &plan, &mut random)));
        }
        starts.iter_mut().for_each(|start| turn_frame(start, &angles, &plan));
        for candidate in searched(&plan, starts, seed) {
            let error = |index: usize, places: &Places| {
                let place = places.all[7].at;
                let turn = (places.all[6].at - places.all[4].at).arg() + candidate.trial.x[ZERO];
                let miss = (place - scaled.points[index]).norm().max(RADIAN * way(angles[index], turn).abs());
                (place * scaled.size + scaled.middle, miss * scaled.size)
            };
            let frame = Some(candidate.trial.x[ZERO]);
            found.extend(built(
                kind,
                &candidate,
                &plan,
                [scaled.size, scaled.middle.re, scaled.middle.im],
                frame,
                error,
            ));
        }
    }
    found.sort_by(|a: &SixBar, b| a.largest.total_cmp(&b.largest));
    found
}

/// Where the pivots of a path's or of poses' six-bar may be.
fn regions(kind: SixKind, limits: &LinkageLimits, scaled: &Scaled) -> Vec<(usize, Region)> {
    let region = limits.ground.as_ref().map(|ground| ground.scaled(scaled.middle, scaled.size));
    let pivots: &[usize] = if kind.has_pivot() { &[0, 1, 5] } else { &[0, 1] };
    region.iter().flat_map(|zone| pivots.iter().map(|&pin| (pin, zone.clone()))).collect()
}

/// The frame of the body turned so that its angles are nearest to those of the poses.
fn turn_frame(candidate: &mut Candidate, angles: &[f64], plan: &Plan<'_>) {
    let (chain, mut places) = ((plan.chain)(candidate.sides), Places::new());
    let mut mean = Point::new(0.0, 0.0);
    for (angle, input) in angles.iter().zip(&candidate.trial.inputs) {
        chain.place(&candidate.trial.x, *input, false, &mut places);
        mean += polar(1.0, angle - (places.all[6].at - places.all[4].at).arg());
    }
    candidate.trial.x[ZERO] = mean.arg();
}

/// Six-bars whose output bar follows pairs, for this length of the ground, best first.
pub fn six_bar_functions(pairs: &[Pair], ground: f64, limits: &LinkageLimits, seed: u64) -> Vec<SixBar> {
    let goal = Goal::Function { pivot: 5, pin: 6, pairs, zeros: [PHASE, ZERO] };
    let mut found = Vec::new();
    for kind in KINDS.into_iter().filter(|kind| kind.has_pivot()) {
        let mut plan = plan(kind, goal, ground, limits.crank, limits);
        for (dimension, value) in [0.0, 0.0, 1.0, 0.0].into_iter().enumerate() {
            (plan.low[dimension], plan.high[dimension]) = (value, value);
        }
        let mut random = RandomNumbers::new(seed);
        let starts = (0..ANYWHERE).map(|_| anywhere(kind, &plan, pairs, &mut random)).collect();
        for candidate in searched(&plan, starts, seed) {
            let error = |index: usize, places: &Places| {
                let output = (places.all[6].at - places.all[5].at).arg() - candidate.trial.x[ZERO];
                (Point::new(output, 0.0), way(pairs[index].output, output).abs())
            };
            found.extend(built(kind, &candidate, &plan, [ground, 0.0, 0.0], None, error));
        }
    }
    found.sort_by(|a: &SixBar, b| a.largest.total_cmp(&b.largest));
    found
}

/// Without limits bars are between these shares of the size.
const LENGTHS: [f64; 2] = [0.02, 6.0];

/// The shortest bar and the largest distance of two points of a link, in sizes of the task.
fn lengths(limits: &LinkageLimits, size: f64) -> [f64; 2] {
    let [least, most] = limits.length.map_or(LENGTHS, |range| range.map(|range| range / size));
    [least.max(LENGTHS[0].min(0.5 * most)), most]
}

fn plan<'p>(kind: SixKind, goal: Goal<'p>, size: f64, turn: bool, limits: &LinkageLimits) -> Plan<'p> {
    let [least, most] = lengths(limits, size);
    let [mut low, mut high] = [[f64::NEG_INFINITY; DIMENSIONS], [f64::INFINITY; DIMENSIONS]];
    BARS.iter().for_each(|&bar| (low[bar], high[bar]) = (least, most));
    // Sides of bodies with three pins are bars too.
    let mut distances = vec![([4, 2], [least, most]), ([4, 3], [least, most]), ([5, 1], [least, most])];
    match kind {
        SixKind::WattOne => distances.push(([5, 3], [least, most])),
        SixKind::WattTwo => {
            distances =
                vec![([4, 1], [least, most]), ([4, 3], [least, most]), ([5, 1], [least, most]), ([5, 0], [least, most])]
        }
        SixKind::StephensonOne => {
            distances =
                vec![([4, 0], [least, most]), ([4, 2], [least, most]), ([5, 1], [least, most]), ([5, 3], [least, most])]
        }
        SixKind::StephensonThree => distances.push(([5, 0], [least, most])),
    }
    let chain: fn(Sides) -> Chain = match kind {
        SixKind::WattOne => |sides| SixKind::WattOne.chain(sides),
        SixKind::WattTwo => |sides| SixKind::WattTwo.chain(sides),
        SixKind::StephensonOne => |sides| SixKind::StephensonOne.chain(sides),
        SixKind::StephensonThree => |sides| SixKind::StephensonThree.chain(sides),
    };
    let cosine = cosine(limits) - COARSE;
    let inequalities = Inequalities { cosine, turn, regions: Vec::new(), distances };
    Plan { chain, goal, low, high, inequalities, lengths: &BARS, order: None }
}

/// The four-bar with a dyad at the point that draws; where neither pin can be there, a dyad anywhere.
fn with_dyad(kind: SixKind, start: &Candidate, plan: &Plan<'_>, random: &mut RandomNumbers) -> Candidate {
    let mut x = [0.0; DIMENSIONS];
    x[..7].copy_from_slice(&start.trial.x[..7]);
    x[PHASE] = start.trial.x[9];
    let is_drawn = matches!(kind, SixKind::StephensonThree | SixKind::WattOne);
    (x[D], x[D + 1]) = if is_drawn { (start.trial.x[7], start.trial.x[8]) } else { free(x[COUPLER], random) };
    let sides = [start.sides[0], if random.integer().is_multiple_of(2) { 1.0 } else { -1.0 }];
    place_dyad(kind, x, start.trial.inputs.clone(), sides, plan, random)
}

fn free(size: f64, random: &mut RandomNumbers) -> (f64, f64) {
    let at = random.normal() * size;
    (at.re, at.im)
}

/// The second pin of the dyad anywhere, its bars so long that they meet at the first angle of the crank.
fn place_dyad(
    kind: SixKind,
    mut x: [f64; DIMENSIONS],
    inputs: Vec<f64>,
    sides: Sides,
    plan: &Plan<'_>,
    random: &mut RandomNumbers,
) -> Candidate {
    let size = x[GROUND].max(x[COUPLER]);
    (x[F], x[F + 1]) = if kind.has_pivot() {
        (size * random.between(0.3, 2.0), random.between(0.0, TAU))
    } else {
        free(x[SECOND].max(0.3 * size), random)
    };
    let chain = (plan.chain)(sides);
    let mut places = Places::new();
    let (mut near, mut far): (f64, f64) = (f64::INFINITY, 0.0);
    let step = inputs.len().div_ceil(8).max(1);
    for input in inputs.iter().step_by(step) {
        (x[LINK], x[OUTPUT]) = (1.0, 1.0);
        chain.place(&x, *input, false, &mut places);
        let distance = (places.all[5].at - places.all[4].at).norm();
        (near, far) = (near.min(distance), far.max(distance));
    }
    // |a - b| < near, far < a + b
    let sum = far * random.between(1.1, 2.5);
    let difference = near.min(sum) * random.between(-0.9, 0.9);
    (x[LINK], x[OUTPUT]) = (0.5 * (sum + difference), 0.5 * (sum - difference));
    let share = 0.02 * size;
    (x[TRACER], x[TRACER + 1]) = (share * random.normal().re, share * random.normal().re);
    Candidate::new(x, inputs, sides, plan)
}

fn anywhere(kind: SixKind, plan: &Plan<'_>, pairs: &[Pair], random: &mut RandomNumbers) -> Candidate {
    let mut x = [0.0; DIMENSIONS];
    x[GROUND] = 1.0;
    let within = |bar: usize, random: &mut RandomNumbers| {
        let [low, high] = [plan.low[bar].max(0.1), plan.high[bar].min(3.0)];
        low * (high.max(low) / low).powf(random.between(0.0, 1.0))
    };
    // Where the crank is to turn fully it is the shortest bar, and the others close in all of its turn; limits of lengths may permit no such bars.
    for _ in 0..TRIES {
        for bar in [CRANK, COUPLER, SECOND] {
            x[bar] = within(bar, random);
        }
        let (a, b, c) = (x[CRANK], x[COUPLER], x[SECOND]);
        if !plan.inequalities.turn || ((b - c).abs() < (1.0 - a).abs() && 1.0 + a < b + c) {
            break;
        }
    }
    (x[D], x[D + 1]) = free(x[COUPLER], random);
    x[PHASE] = random.between(0.0, TAU);
    let inputs: Vec<f64> = pairs.iter().map(|pair| x[PHASE] + pair.input).collect();
    let side = |random: &mut RandomNumbers| if random.integer().is_multiple_of(2) { 1.0 } else { -1.0 };
    let sides = [side(random), side(random)];
    let mut candidate = place_dyad(kind, x, inputs, sides, plan, random);
    // The angle of the output that is nearest to all pairs.
    let (chain, mut places) = ((plan.chain)(sides), Places::new());
    let mut mean = Point::new(0.0, 0.0);
    for (pair, input) in pairs.iter().zip(&candidate.trial.inputs) {
        chain.place(&candidate.trial.x, *input, false, &mut places);
        mean += polar(1.0, (places.all[6].at - places.all[5].at).arg() - pair.output);
    }
    candidate.trial.x[ZERO] = mean.arg();
    candidate
}

/// Places of a turn at which a six-bar is looked at.
const LOOKED_AT: usize = 720;

/// A six-bar in its size, if it keeps its limits all the way.
fn built(
    kind: SixKind,
    candidate: &Candidate,
    plan: &Plan<'_>,
    [size, x, y]: [f64; 3],
    frame: Option<f64>,
    error: impl Fn(usize, &Places) -> (Point, f64),
) -> Option<SixBar> {
    let in_order = plan.order.is_none_or(|closed| is_in_order(&candidate.trial.inputs, closed));
    if candidate.trial.violation > 0.5 * SPARE || !in_order {
        return None;
    }
    let (chain, dimensions) = ((plan.chain)(candidate.sides), &candidate.trial.x);
    let mut places = Places::new();
    let inputs = || candidate.trial.inputs.iter().copied();
    let (low, high) = ends(&candidate.trial.inputs);
    let span = if plan.inequalities.turn { TAU } else { high - low };
    let mut most = [0.0f64; 2];
    for place in 0..=LOOKED_AT {
        let input = low + span * place as f64 / LOOKED_AT as f64;
        chain.place(dimensions, input, false, &mut places);
        for (most, pin) in most.iter_mut().zip([3, 6]) {
            *most = most.max(chain.cosine(dimensions, pin, &places).value.abs());
        }
    }
    if most.iter().any(|cosine| *cosine > plan.inequalities.cosine + COARSE) {
        return None;
    }
    let (mut outputs, mut turns, mut largest) = (Vec::new(), Vec::new(), 0.0f64);
    for (index, input) in inputs().enumerate() {
        chain.place(dimensions, input, false, &mut places);
        let (output, error) = error(index, &places);
        outputs.push(output);
        turns.extend(frame.map(|zero| (places.all[6].at - places.all[4].at).arg() + zero));
        largest = largest.max(error);
    }
    if let Goal::Path { tracer, corridor, .. } = plan.goal {
        let at = |input: f64| {
            chain.place(dimensions, input, false, &mut places);
            Some(places.all[tracer].at)
        };
        largest = largest.max(size * corridor.departure(&candidate.trial.inputs, at));
    }
    chain.place(dimensions, inputs().next()?, false, &mut places);
    let real = |node: usize| places.all[node].at * size + Point::new(x, y);
    let ([a0, b0], [a, b, d, f, e]) = ([real(0), real(1)], [2, 3, 4, 5, 6].map(real));
    let (ground, bodies, joints) = assembly(kind, [a0, b0, a, b, d, f, e], real(7), frame);
    let lengths = BARS.map(|bar| dimensions[bar] * size);
    let transmission = most.map(|cosine| cosine.min(1.0).acos());
    let (full_turn, inputs) = (plan.inequalities.turn, candidate.trial.inputs.clone());
    Some(SixBar { kind, ground, bodies, joints, lengths, inputs, turns, outputs, largest, transmission, full_turn })
}

/// Between the places of the search the cosine of a transmission angle may be so much larger: the search keeps it from the limit.
const COARSE: f64 = 2e-3;

type Assembly = (Vec<(&'static str, Point)>, Vec<SixBody>, Vec<[&'static str; 2]>);

/// Bodies and joints, from the places of all pins at the start. A body that takes poses has the frame of the task, with its origin at the tracer.
fn assembly(kind: SixKind, [a0, b0, a, b, d, f, e]: [Point; 7], tracer: Point, frame: Option<f64>) -> Assembly {
    let body = |name: &'static str, from: Point, to: Point, points: &[(&'static str, Point)]| {
        let along = (to - from) / (to - from).norm();
        let points = points.iter().map(|(name, place)| (*name, (place - from) * along.conj())).collect();
        SixBody { name, points, angle: along.arg() }
    };
    let mut crank = vec![("pivot", a0), ("pin", a)];
    let mut coupler = vec![("first", a), ("second", b)];
    let mut second = vec![("pivot", b0), ("pin", b)];
    let mut ground = vec![("first", a0), ("second", b0)];
    let mut joints = vec![
        ["ground.first", "crank.pivot"],
        ["crank.pin", "coupler.first"],
        ["coupler.second", "second.pin"],
        ["ground.second", "second.pivot"],
    ];
    match kind {
        SixKind::WattOne | SixKind::StephensonThree => {
            coupler.push(("link", d));
            joints.push(["coupler.link", "link.first"]);
        }
        SixKind::WattTwo => {
            second.push(("link", d));
            joints.push(["second.link", "link.first"]);
        }
        SixKind::StephensonOne => {
            crank.push(("link", d));
            joints.push(["crank.link", "link.first"]);
        }
    }
    joints.push(["link.second", "output.pin"]);
    if kind.has_pivot() {
        ground.push(("output", f));
        joints.push(["ground.output", "output.pivot"]);
    } else {
        second.push(("output", f));
        joints.push(["second.output", "output.pivot"]);
    }
    let points = [("first", d), ("second", e), ("tracer", tracer)];
    let link = match frame {
        None => body("link", d, e, &points),
        Some(zero) => {
            let angle = (e - d).arg() + zero;
            let seen = |(name, place): (&'static str, Point)| (name, (place - tracer) * polar(1.0, -angle));
            SixBody { name: "link", points: points.map(seen).to_vec(), angle }
        }
    };
    let bodies = vec![
        body("crank", a0, a, &crank),
        body("coupler", a, b, &coupler),
        body("second", b0, b, &second),
        link,
        body("output", f, e, &[("pivot", f), ("pin", e)]),
    ];
    (ground, bodies, joints)
}
