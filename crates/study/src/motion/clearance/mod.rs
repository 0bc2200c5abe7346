//! How close outlines come to each other in a turn or stroke, and where they overlap.
//!
//! The distance of two outlines changes no faster than their points move against each other, so between two samples it cannot fall below a bound. Intervals
//! whose bound is below the least distance so far are halved until that is known to a share of the outlines' size; then each minimum that can be the least
//! is found by golden section, and each end of an overlap by bisection. Between samples the bodies are on polynomials through both neighbours; what is
//! found there is compared with the motion that is run to that input, and found anew on that motion where the two differ.

mod distance;
mod track;

use std::cell::OnceCell;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

use cotree::component::outline_at;
use cotree::model::{BodyId, Mechanism};
use cotree::scene::constant::evaluate;
use serde::Serialize;

use self::distance::{Nearest, OutlineRegion, Point, difference, nearest, norm};
use self::track::{BodyTrack, Pose, speed};
use super::drive::{self, DrivenMechanism, InputTable, POSE};
use super::figures::{MotionColumn, Subject};
use super::{DrivenJoint, MotionError};

/// What is closer than this share of the outlines' size touches, and does not overlap.
const TOUCHING: f64 = 1e-12;
/// Poses that differ by less than this share of the size are the same.
const SAME: f64 = 1e-10;
/// Minima that differ by more than this share of the size are told from each other by the bound alone.
const RESOLVED: f64 = 1e-4;
/// Distances of one pair that are computed to that end, at most: outlines that keep their distance would need any number.
const MOST: usize = 20_000;
/// Steps of a search between two places.
const STEPS: usize = 80;
/// The bound of a step is this much above the speeds in the samples around it.
const MARGIN: f64 = 1.1;

/// How close two outlines come.
#[derive(Clone, Debug, Serialize)]
pub struct PairClearance {
    /// Two bodies, or a body and `ground`.
    pub pair: [String; 2],
    /// Their least distance \[m\]; 0 if they overlap.
    pub least: f64,
    /// Where that is; of an overlap its beginning.
    pub at: InputTime,
    /// The nearest points there, in the frame of the ground \[m\].
    pub points: [Point; 2],
    /// The inputs from which to which they overlap, in the order of the motion; those of a turn may go on beyond its end.
    pub overlaps: Vec<[f64; 2]>,
}

/// A configuration of the motion.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct InputTime {
    pub input: f64,
    /// The time since the input was at the begin of the range, or at 0 of the turn \[s\]; none for static forces.
    pub time: Option<f64>,
}

/// All pairs that are of interest.
#[derive(Clone, Debug, Default)]
pub struct Clearances {
    pub pairs: Vec<PairClearance>,
    /// The distance of each over the input; 0 where they overlap.
    pub columns: Vec<MotionColumn>,
    /// The least distance that is permitted \[m\].
    pub permitted: Option<f64>,
}

/// The clearances of a motion that has been sampled.
///
/// # Errors
/// An outline that its parameters make no outline.
pub(super) fn of(subject: &Subject, table: &InputTable) -> Result<Clearances, MotionError> {
    let mechanism = subject.mechanism;
    let mut found = Clearances::default();
    let pairs = mechanism.clearance_pairs();
    if pairs.is_empty() {
        return Ok(found);
    }
    let parameters = mechanism.parameter_values();
    let least = mechanism.clearance.as_ref().and_then(|clearance| clearance.least.as_ref());
    found.permitted = least.map(|least| evaluate(least, &parameters));
    let exact = ExactMotion { subject, found: OnceCell::new() };
    for pair in pairs {
        let bodies =
            [moving(mechanism, pair[0], subject.drive, table)?, moving(mechanism, pair[1], subject.drive, table)?];
        let [Some(first), Some(second)] = bodies else { continue };
        let search = PairSearch::new([first, second], table, &exact);
        let (clearance, distances) = search.clearance();
        found.columns.push(MotionColumn {
            name: format!("clearance {} {}", clearance.pair[0], clearance.pair[1]),
            unit: "m".to_owned(),
            values: distances.into_iter().step_by(subject.drive.fineness.max(1)).collect(),
        });
        found.pairs.push(clearance);
    }
    Ok(found)
}

/// A body or the ground with its outline.
struct Outlined {
    name: String,
    /// In its own frame.
    regions: Vec<OutlineRegion>,
    /// None of the ground.
    track: Option<BodyTrack>,
    /// How far its corners are from its origin, at most.
    radius: f64,
}

/// A body that moves, or the ground; none if the scene lacks something of its motion.
fn moving(
    mechanism: &Mechanism,
    body: Option<BodyId>,
    drive: &DrivenJoint,
    table: &InputTable,
) -> Result<Option<Outlined>, MotionError> {
    let (name, outlines) = match body {
        Some(body) => {
            let body = &mechanism.bodies[body.0];
            (body.name.clone(), body.outline.as_slice())
        }
        None => ("ground".to_owned(), &mechanism.ground_outlines[..]),
    };
    let parameters = mechanism.parameter_values();
    let regions = outlines.iter().map(|outline| match outline_at(outline, &parameters) {
        Ok((corners, offset)) => Ok(OutlineRegion { corners, offset }),
        Err(flaw) => Err(MotionError::Request(format!("with these parameters the outline of `{name}` {flaw}"))),
    });
    let regions: Vec<OutlineRegion> = regions.collect::<Result<_, _>>()?;
    let step = table.input(1) - table.input(0);
    let track = match body {
        Some(_) => match BodyTrack::of(table, &name, step, drive.rate()) {
            None => return Ok(None),
            track => track,
        },
        None => None,
    };
    let radius = regions.iter().flat_map(|region| &region.corners).map(|corner| norm(*corner)).fold(0.0, f64::max);
    Ok(Some(Outlined { name, regions, track, radius }))
}

impl Outlined {
    /// Its outline in the frame of the ground.
    fn posed(&self, [x, y, angle]: Pose) -> Vec<OutlineRegion> {
        let (sine, cosine) = angle.sin_cos();
        let place = |[u, v]: &Point| [x + cosine * u - sine * v, y + sine * u + cosine * v];
        let posed =
            |region: &OutlineRegion| OutlineRegion { corners: region.corners.iter().map(place).collect(), ..*region };
        self.regions.iter().map(posed).collect()
    }

    fn pose(&self, place: f64) -> Pose {
        self.track.as_ref().map_or([0.0; 3], |track| track.pose(place))
    }

    /// The largest distance of two of its points, at most.
    fn size(&self) -> f64 {
        let offset = self.regions.iter().map(|region| region.offset).fold(0.0, f64::max);
        2.0 * (self.radius + offset)
    }
}

/// The motion that is run to an input, which is as accurate as runs are.
struct ExactMotion<'a> {
    subject: &'a Subject<'a>,
    found: OnceCell<Option<(DrivenMechanism, f64)>>,
}

impl ExactMotion<'_> {
    /// The poses of two bodies at an input; none if the run does not get there.
    fn poses(&self, bodies: &[Outlined; 2], input: f64, periodic: bool) -> Option<[Pose; 2]> {
        let Subject { moved, drive, .. } = *self.subject;
        let (driven, begin) = self
            .found
            .get_or_init(|| {
                let way = drive::way(moved, drive).ok()?;
                Some((DrivenMechanism::of_motion(&way.driven, drive).ok()?, way.begin))
            })
            .as_ref()?;
        let way = drive.direction() * (input - begin);
        let way = if periodic { way.rem_euclid(TAU) } else { way.max(0.0) };
        let columns = driven.run(way.max(f64::MIN_POSITIVE), 1.0).ok()?;
        let pose = |body: &Outlined| -> Option<Pose> {
            if body.track.is_none() {
                return Some([0.0; 3]);
            }
            let [x, y, angle] = POSE.map(|quantity| columns.get(&quantity.of(&body.name))?.last().copied());
            Some([x?, y?, angle?])
        };
        Some([pose(&bodies[0])?, pose(&bodies[1])?])
    }
}

/// A place of the input in steps, and what is there.
#[derive(Clone, Copy, Debug)]
struct Looked {
    place: f64,
    gap: f64,
    overlaps: bool,
}

/// Two places, and a bound of the distance between them.
#[derive(Clone, Copy, Debug)]
struct Interval {
    bound: f64,
    ends: [Looked; 2],
    /// How fast the distance can change.
    speed: f64,
}

impl Interval {
    fn new(ends: [Looked; 2], speed: f64) -> Interval {
        let [a, b] = ends;
        Interval { bound: 0.5 * (a.gap + b.gap - speed * (b.place - a.place)), ends, speed }
    }
}

impl PartialEq for Interval {
    fn eq(&self, other: &Interval) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Interval {}

impl PartialOrd for Interval {
    fn partial_cmp(&self, other: &Interval) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The lowest bound is the greatest.
impl Ord for Interval {
    fn cmp(&self, other: &Interval) -> Ordering {
        other.bound.total_cmp(&self.bound)
    }
}

/// Two outlines along a motion.
struct PairSearch<'a> {
    bodies: [Outlined; 2],
    exact: &'a ExactMotion<'a>,
    /// The input at the first sample, and the step.
    grid: [f64; 2],
    /// Steps of the motion.
    steps: usize,
    periodic: bool,
    size: f64,
}

impl PairSearch<'_> {
    fn new<'a>(bodies: [Outlined; 2], table: &InputTable, exact: &'a ExactMotion<'a>) -> PairSearch<'a> {
        let grid = [table.input(0), table.input(1) - table.input(0)];
        let steps = if table.periodic { table.count() } else { table.count().saturating_sub(1) };
        let size = bodies[0].size().max(bodies[1].size());
        PairSearch { bodies, exact, grid, steps, periodic: table.periodic, size }
    }

    /// The clearance, and the distance in each sample.
    fn clearance(&self) -> (PairClearance, Vec<f64>) {
        let samples: Vec<Looked> = (0..=self.steps).map(|index| self.look(index as f64)).collect();
        let count = if self.periodic { self.steps } else { self.steps + 1 };
        let distances = samples[..count].iter().map(|looked| if looked.overlaps { 0.0 } else { looked.gap.max(0.0) });
        let distances = distances.collect();
        let mut looked = self.resolve(&samples);
        let least = self.refine(&mut looked);
        let overlaps = self.overlaps(&looked);
        let place = overlaps.first().map_or(least.place, |[from, _]| *from);
        let at = self.nearest_at(place);
        let least = if overlaps.is_empty() { at.gap.max(0.0) } else { 0.0 };
        let overlaps = overlaps.into_iter().map(|ends| ends.map(|place| self.input(place))).collect();
        let pair = self.bodies.each_ref().map(|body| body.name.clone());
        (PairClearance { pair, least, at: self.input_time(place), points: at.points, overlaps }, distances)
    }

    fn input_time(&self, place: f64) -> InputTime {
        let drive = self.exact.subject.drive;
        let input = if self.periodic { self.input(place).rem_euclid(TAU) } else { self.input(place) };
        let begin = if self.periodic { 0.0 } else { self.grid[0] };
        InputTime { input, time: (drive.speed != 0.0).then(|| (input - begin) / drive.rate()) }
    }

    fn input(&self, place: f64) -> f64 {
        self.grid[0] + self.grid[1] * place
    }

    fn nearest_in(&self, poses: [Pose; 2]) -> Nearest {
        let [first, second] = [0, 1].map(|side| self.bodies[side].posed(poses[side]));
        let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (a, b)));
        let all = pairs.map(|(a, b)| nearest(a, b, TOUCHING * self.size));
        let closer = |a: Nearest, b: Nearest| if (b.overlaps, -b.gap) > (a.overlaps, -a.gap) { b } else { a };
        let none = Nearest { gap: f64::INFINITY, overlaps: false, points: [[f64::NAN; 2]; 2] };
        all.fold(none, closer)
    }

    fn sampled_poses(&self, place: f64) -> [Pose; 2] {
        self.bodies.each_ref().map(|body| body.pose(place))
    }

    /// What is at a place, on the polynomials through samples.
    fn look(&self, place: f64) -> Looked {
        let Nearest { gap, overlaps, .. } = self.nearest_in(self.sampled_poses(place));
        Looked { place, gap, overlaps }
    }

    /// The same on the motion that is run there, if that arrives.
    fn look_exactly(&self, place: f64) -> Looked {
        let Nearest { gap, overlaps, .. } = self.nearest_at(place);
        Looked { place, gap, overlaps }
    }

    fn exact_poses(&self, place: f64) -> Option<[Pose; 2]> {
        self.exact.poses(&self.bodies, self.input(place), self.periodic)
    }

    fn nearest_at(&self, place: f64) -> Nearest {
        self.nearest_in(self.exact_poses(place).unwrap_or_else(|| self.sampled_poses(place)))
    }

    /// Do the polynomials agree with the motion that is run there?
    fn is_exact(&self, place: f64) -> bool {
        let Some(exact) = self.exact_poses(place) else { return true };
        let sampled = self.sampled_poses(place);
        self.bodies.iter().zip(exact.iter().zip(&sampled)).all(|(body, (a, b))| {
            let turned = (a[2] - b[2]) / TAU;
            let turned = TAU * (turned - turned.round());
            norm(difference([a[0], a[1]], [b[0], b[1]])) + turned.abs() * body.radius <= SAME * self.size
        })
    }

    /// A bound of the change of the distance in a step.
    fn speed(&self, step: usize) -> f64 {
        let last = self.steps;
        let around = [step.saturating_sub(1), step, (step + 1).min(last), (step + 2).min(last)];
        let tracks = self.bodies.each_ref().map(|body| body.track.as_ref());
        let radii = self.bodies.each_ref().map(|body| body.radius);
        let sampled = |index: usize| if self.periodic { index % self.steps } else { index };
        MARGIN * around.into_iter().map(|index| speed(tracks, radii, sampled(index))).fold(0.0, f64::max)
    }

    /// Halves the intervals in which there may be a smaller distance, or an overlap that no sample sees. All places in their order.
    fn resolve(&self, samples: &[Looked]) -> Vec<Looked> {
        let mut best = samples.iter().map(|looked| looked.level()).fold(f64::INFINITY, f64::min);
        let pairs = samples.windows(2).enumerate();
        let is_open = |ends: &[Looked]| ends.iter().all(|end| !end.overlaps);
        let mut open: BinaryHeap<Interval> = pairs
            .filter(|(_, pair)| is_open(pair))
            .map(|(step, pair)| Interval::new([pair[0], pair[1]], self.speed(step)))
            .collect();
        let mut looked = samples.to_vec();
        while let Some(Interval { bound, ends, speed }) = open.pop() {
            let is_resolved = bound >= best - RESOLVED * self.size;
            // What touches all the time is looked at no closer.
            if is_resolved || looked.len() >= samples.len() + MOST {
                break;
            }
            let middle = self.look(0.5 * (ends[0].place + ends[1].place));
            looked.push(middle);
            best = best.min(middle.level());
            let halves = [[ends[0], middle], [middle, ends[1]]];
            open.extend(halves.into_iter().filter(|half| is_open(half)).map(|half| Interval::new(half, speed)));
        }
        looked.sort_by(|a, b| a.place.total_cmp(&b.place));
        looked
    }

    /// Finds the minima that can be the least, and those that may be an overlap; what is found joins the places. The least of them.
    fn refine(&self, looked: &mut Vec<Looked>) -> Looked {
        let least = |all: &[Looked]| all.iter().copied().min_by(|a, b| a.level().total_cmp(&b.level()));
        let mut best = least(looked).unwrap_or_else(|| self.look(0.0));
        let last = looked.len().saturating_sub(1);
        let mut minima: Vec<(f64, [f64; 2])> = Vec::new();
        for (index, at) in looked.iter().enumerate().filter(|(_, at)| !at.overlaps) {
            let [before, after] = [index.saturating_sub(1), (index + 1).min(last)].map(|index| looked[index]);
            if at.gap <= before.gap && at.gap <= after.gap && !before.overlaps && !after.overlaps {
                let step = (at.place.floor() as usize).min(self.steps.saturating_sub(1));
                let bound = at.gap - 0.5 * self.speed(step) * (after.place - at.place).max(at.place - before.place);
                minima.push((bound, [before.place, after.place]));
            }
        }
        minima.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut found = Vec::new();
        for (bound, ends) in minima {
            if bound > best.level() {
                break;
            }
            let mut lowest = golden(ends, |place| self.look(place));
            if !self.is_exact(lowest.place) {
                lowest = golden(ends, |place| self.look_exactly(place));
            }
            found.push(lowest);
            if lowest.level() < best.level() {
                best = lowest;
            }
        }
        looked.extend(found);
        looked.sort_by(|a, b| a.place.total_cmp(&b.place));
        best
    }

    /// The places from which to which the outlines overlap.
    fn overlaps(&self, looked: &[Looked]) -> Vec<[f64; 2]> {
        let mut ranges: Vec<[f64; 2]> = Vec::new();
        let mut from = looked.first().filter(|first| first.overlaps).map(|first| first.place);
        for pair in looked.windows(2) {
            if pair[0].overlaps == pair[1].overlaps {
                continue;
            }
            let end = self.end([pair[0], pair[1]]);
            match from.take() {
                Some(from) => ranges.push([from, end]),
                None => from = Some(end),
            }
        }
        ranges.extend(from.zip(looked.last()).map(|(from, last)| [from, last.place]));
        // The overlap at the end of a turn goes on at its start.
        let steps = self.steps as f64;
        if let (true, [[begin, to], .., [from, end]]) = (self.periodic, &ranges[..])
            && *begin == 0.0
            && *end == steps
        {
            let joined = [*from, steps + *to];
            ranges.pop();
            ranges[0] = joined;
            ranges.rotate_left(1);
        }
        ranges
    }

    /// Where an overlap begins or ends between two places.
    fn end(&self, pair: [Looked; 2]) -> f64 {
        let end = bisected(pair, |place| self.look(place));
        if self.is_exact(end) { end } else { bisected(pair, |place| self.look_exactly(place)) }
    }
}

impl Looked {
    /// The distance; zero in an overlap, whose depth is not known.
    fn level(&self) -> f64 {
        if self.overlaps { 0.0 } else { self.gap }
    }
}

/// The least distance between two places, or an overlap (golden section).
fn golden([mut low, mut high]: [f64; 2], look: impl Fn(f64) -> Looked) -> Looked {
    let inner = |low: f64, high: f64, share: f64| low + share * (high - low);
    const SHARE: f64 = 0.618_033_988_749_895;
    let mut pair = [1.0 - SHARE, SHARE].map(|share| look(inner(low, high, share)));
    let ends = [look(low), look(high)];
    let mut best = ends.into_iter().chain(pair).reduce(lower).unwrap_or(pair[0]);
    for _ in 0..STEPS {
        if best.overlaps || high - low <= f64::EPSILON * high.abs() {
            break;
        }
        if pair[0].gap > pair[1].gap {
            low = pair[0].place;
            pair = [pair[1], look(inner(low, high, SHARE))];
        } else {
            high = pair[1].place;
            pair = [look(inner(low, high, 1.0 - SHARE)), pair[0]];
        }
        best = pair.into_iter().fold(best, lower);
    }
    best
}

fn lower(a: Looked, b: Looked) -> Looked {
    if b.level() < a.level() { b } else { a }
}

/// Where an overlap begins or ends between two places of which one is in it.
fn bisected([from, to]: [Looked; 2], look: impl Fn(f64) -> Looked) -> f64 {
    let (mut low, mut high) = (from.place, to.place);
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if look(middle).overlaps == from.overlaps { low = middle } else { high = middle }
    }
    if from.overlaps { low } else { high }
}
