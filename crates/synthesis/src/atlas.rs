//! An atlas of coupler curves of four-bars of every class, searched for curves that resemble a given path.
//!
//! Closed curves are compared by the sizes of their harmonics, pieces of curves by themselves, both whatever their place, size, turn, mirror image and sense.
//! The four-bars come from a fixed seed, when they are first needed.
//!
//! Source of the idea: J. A. Hrones, G. L. Nelson, *Analysis of the Four-Bar Linkage*, 1951; of the harmonics: I. Ullah, S. Kota, *Optimal synthesis of
//! mechanisms for path generation using Fourier descriptors and global search methods*, J. Mech. Des. 119, 1997.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use crate::dyad::Dyad;
use crate::least::Unknowns;
use crate::linkage::{Linkage, Side};
use crate::poses::way;
use crate::random::RandomNumbers;
use crate::{Point, polar};

/// What a search begins from: pins in the body, pivots, lengths of the bars; the angle of the body at each point.
pub(crate) type Start = Unknowns<10, 1>;

/// A four-bar whose first pivot is at the origin, its ground along x; the point is seen from the first pin, along the body.
#[derive(Clone, Copy, Debug)]
struct AtlasBars {
    lengths: [f64; 4],
    point: Point,
    side: Side,
}

/// How many four-bars there are, and how many pieces each one's curve gives.
const CLOSED: usize = 12_000;
const OPEN: usize = 6_000;
const PIECES: usize = 8;
/// Kinds of four-bars.
const KINDS: usize = 3;
/// Steps along a curve, places on a closed one and on a piece, harmonics.
const STEPS: usize = 160;
const PLACES: usize = 64;
const PIECE: usize = 24;
const HARMONICS: usize = 10;

/// A bar that misses a limit by this share may be made to hold it.
const NEARLY: f64 = 0.4;

impl AtlasBars {
    fn random(random: &mut RandomNumbers) -> AtlasBars {
        loop {
            let lengths: [f64; 4] = std::array::from_fn(|_| random.between(0.1, 1.0));
            let longest = lengths.iter().copied().fold(0.0, f64::max);
            if 2.0 * longest >= 0.98 * lengths.iter().sum::<f64>() {
                continue;
            }
            let radius = 1.5 * random.between(0.0, 1.0).sqrt();
            let point = (polar(radius, random.between(0.0, TAU)) + 0.5) * lengths[2];
            let side = if random.integer().is_multiple_of(2) { 1.0 } else { -1.0 };
            return AtlasBars { lengths, point, side };
        }
    }

    /// No bar turns; the coupler turns; another one turns.
    fn kind(&self) -> usize {
        let [least, most] = [f64::min, f64::max].map(|of| self.lengths.into_iter().fold(self.lengths[0], of));
        match 2.0 * (least + most) < self.lengths.iter().sum() {
            false => 0,
            true if self.lengths[2] == least => 1,
            true => 2,
        }
    }

    /// Are all bars between two lengths, or nearly, where the curve is made so many times as large?
    fn is_within(&self, times: f64, room: Option<[f64; 2]>) -> bool {
        room.is_none_or(|[low, high]| {
            self.lengths.iter().all(|length| (low * (1.0 - NEARLY)..=high * (1.0 + NEARLY)).contains(&(length * times)))
        })
    }

    /// The body's frame is at the point that draws.
    fn linkage(&self) -> Linkage {
        let [ground, first, body, second] = self.lengths;
        let (zero, pivot) = (Point::new(0.0, 0.0), Point::new(ground, 0.0));
        Linkage {
            first: Dyad::Bar { moving: -self.point, ground: zero, length: first },
            second: Dyad::Bar { moving: Point::new(body, 0.0) - self.point, ground: pivot, length: second },
        }
    }

    /// The closed curve of the point, and the angle of the body along it without a jump.
    fn curve(&self) -> (Vec<Point>, Vec<f64>) {
        let linkage = self.linkage();
        let [ground, first, body, second] = self.lengths;
        // From where to where the first bar goes: as far as body and second bar reach.
        let limit = |between: f64| {
            ((ground * ground + first * first - between * between) / (2.0 * ground * first)).clamp(-1.0, 1.0).acos()
        };
        let (near, far) = ((body - second).abs(), body + second);
        let low = (near > (ground - first).abs()).then(|| limit(near));
        let high = (far < ground + first).then(|| limit(far));
        let [from, to] = match (low, high) {
            (None, None) => [0.0, 0.0],
            (Some(low), None) => [low, TAU - low],
            (None, Some(high)) => [-high, high],
            (Some(low), Some(high)) => [low, high],
        };
        let (mut points, mut angles) = (Vec::with_capacity(STEPS + 1), Vec::<f64>::with_capacity(STEPS + 1));
        for step in 0..STEPS {
            let part = TAU * (step as f64 + 0.5) / STEPS as f64;
            let (input, side) = if from == to {
                (part, self.side)
            } else {
                let side = if part < PI { self.side } else { -self.side };
                (0.5 * (from + to) - 0.5 * (to - from) * part.cos(), side)
            };
            let Some(pose) = linkage.pose(input, side) else { continue };
            points.push(pose.at);
            angles.push(angles.last().map_or(pose.angle, |last| last + way(*last, pose.angle)));
        }
        if let (Some(&point), Some(&angle), Some(&last)) = (points.first(), angles.first(), angles.last()) {
            points.push(point);
            angles.push(last + way(last, angle));
        }
        (points, angles)
    }

    /// A start from a similar curve: `k (w - from) + to` is near the path; mirrored first if it is so.
    fn start(&self, mirrored: bool, k: Point, from: Point, to: Point, angles: Vec<f64>) -> Start {
        let image = |point: Point| if mirrored { point.conj() } else { point };
        let size = k.norm();
        let body = [-self.point, Point::new(self.lengths[2], 0.0) - self.point].map(|pin| image(pin) * size);
        let pivots = [0.0, self.lengths[0]].map(|x| (image(Point::new(x, 0.0)) - image(from)) * k + to);
        let [a, b, c, d] = [body[0], body[1], pivots[0], pivots[1]];
        let bars = [self.lengths[1] * size, self.lengths[3] * size];
        let shared = [a.re, a.im, b.re, b.im, c.re, c.im, d.re, d.im, bars[0], bars[1]];
        let sign = if mirrored { -1.0 } else { 1.0 };
        Unknowns { shared, local: angles.into_iter().map(|angle| [sign * angle + k.arg()]).collect() }
    }
}

/// The lengths along points, from zero on.
fn along(points: &[Point]) -> Vec<f64> {
    let mut sum = 0.0;
    let steps = points.windows(2).map(|pair| (pair[1] - pair[0]).norm());
    std::iter::once(0.0)
        .chain(steps.map(|step| {
            sum += step;
            sum
        }))
        .collect()
}

/// Where a value is between ascending ones: the index before it and the share of the step.
fn between(values: &[f64], value: f64) -> (usize, f64) {
    let last = values.len().saturating_sub(2);
    let before = values.partition_point(|other| *other <= value).saturating_sub(1).min(last);
    let step = values[before + 1] - values[before];
    (before, if step > 0.0 { (value - values[before]) / step } else { 0.0 })
}

fn linear<T>(values: &[T], (before, share): (usize, f64)) -> T
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>,
{
    values[before] + (values[before + 1] - values[before]) * share
}

/// Places at lengths along points, on cubic pieces through them; the points are closed if the first is the last one.
fn smooth(points: &[Point], lengths: &[f64], at: impl Iterator<Item = f64>) -> Vec<Point> {
    let count = points.len();
    let closed = count > 3 && points[0] == points[count - 1];
    let slope = |i: usize| {
        let (before, after) = match i {
            0 if closed => (count - 2, 1),
            i if i + 1 == count && closed => (count - 2, 1),
            i => (i.saturating_sub(1), (i + 1).min(count - 1)),
        };
        let step = |a: usize, b: usize| {
            let length = if b == 1 && a + 1 == count { lengths[1] } else { (lengths[b] - lengths[a]).abs() };
            (points[b] - points[a], length.max(f64::MIN_POSITIVE))
        };
        if before == i || after == i {
            let (way, length) = step(before, after);
            return way / length;
        }
        let start = if i == 0 { count - 1 } else { i };
        let ((back, h), (forth, k)) = (step(before, start), step(if start + 1 == count { 0 } else { start }, after));
        (back / h * k + forth / k * h) / (h + k)
    };
    at.map(|length| {
        let (before, t) = between(lengths, length);
        let h = lengths[before + 1] - lengths[before];
        let (p, q) = (points[before], points[before + 1]);
        let (u, v) = (slope(before) * h, slope(before + 1) * h);
        let (t2, t3) = (t * t, t * t * t);
        p * (2.0 * t3 - 3.0 * t2 + 1.0) + u * (t3 - 2.0 * t2 + t) + q * (3.0 * t2 - 2.0 * t3) + v * (t3 - t2)
    })
    .collect()
}

fn mean(points: &[Point]) -> Point {
    points.iter().sum::<Point>() / points.len().max(1) as f64
}

/// Sizes of the harmonics, those of the stronger sense first.
fn harmonics(points: &[Point; PLACES]) -> [f32; 2 * HARMONICS] {
    static TURNS: OnceLock<[Point; PLACES]> = OnceLock::new();
    let turns = TURNS.get_or_init(|| std::array::from_fn(|i| polar(1.0, -TAU * i as f64 / PLACES as f64)));
    let size = |harmonic: usize| {
        let part = |(i, point): (usize, &Point)| point * turns[i * harmonic % PLACES];
        points.iter().enumerate().map(part).sum::<Point>().norm()
    };
    let mut all: [f64; 2 * HARMONICS] = std::array::from_fn(|i| {
        let order = i % HARMONICS + 1;
        size(if i < HARMONICS { order } else { PLACES - order })
    });
    if all[HARMONICS] > all[0] {
        all.rotate_left(HARMONICS);
    }
    let whole = all.iter().map(|one| one * one).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    all.map(|one| (one / whole) as f32)
}

/// Even places along a closed curve, with the angles there.
fn places(points: &[Point], angles: &[f64]) -> ([Point; PLACES], [f64; PLACES]) {
    let lengths = along(points);
    let whole = lengths.last().copied().unwrap_or(0.0);
    let at: [(usize, f64); PLACES] = std::array::from_fn(|i| between(&lengths, whole * i as f64 / PLACES as f64));
    (at.map(|place| linear(points, place)), at.map(|place| linear(angles, place)))
}

/// A part of a curve: whose, and from where on, how long, as shares of the whole.
#[derive(Clone, Copy)]
struct CurvePiece {
    bars: AtlasBars,
    from: f64,
    length: f64,
}

/// Places on a piece, evenly, with the angles there.
fn piece(points: &[Point], angles: &[f64], lengths: &[f64], part: &CurvePiece) -> ([Point; PIECE], [f64; PIECE]) {
    let whole = lengths.last().copied().unwrap_or(0.0);
    let turned = angles.last().copied().unwrap_or(0.0) - angles.first().copied().unwrap_or(0.0);
    let at: [(f64, (usize, f64)); PIECE] = std::array::from_fn(|i| {
        let share = part.from + part.length * i as f64 / (PIECE - 1) as f64;
        let over = if share >= 1.0 { 1.0 } else { 0.0 };
        (over, between(lengths, (share - over) * whole))
    });
    (at.map(|(_, place)| linear(points, place)), at.map(|(over, place)| linear(angles, place) + over * turned))
}

/// Both atlases.
struct ClosedAtlas {
    bars: Vec<AtlasBars>,
    harmonics: Vec<[f32; 2 * HARMONICS]>,
    sizes: Vec<f64>,
}

struct OpenAtlas {
    pieces: Vec<CurvePiece>,
    shapes: Vec<[[f32; 2]; PIECE]>,
    sizes: Vec<f64>,
}

fn closed() -> &'static ClosedAtlas {
    static ATLAS: OnceLock<ClosedAtlas> = OnceLock::new();
    ATLAS.get_or_init(|| {
        let mut random = RandomNumbers::new(7);
        let mut atlas = ClosedAtlas { bars: Vec::new(), harmonics: Vec::new(), sizes: Vec::new() };
        while atlas.bars.len() < CLOSED {
            let bars = AtlasBars::random(&mut random);
            let (points, angles) = bars.curve();
            if points.len() == STEPS + 1 {
                let even = places(&points, &angles).0;
                atlas.harmonics.push(harmonics(&even));
                atlas.sizes.push(spread(&even));
                atlas.bars.push(bars);
            }
        }
        atlas
    })
}

/// The root of the sum of squares of the distances from the middle.
fn spread(points: &[Point]) -> f64 {
    let middle = mean(points);
    points.iter().map(|point| (point - middle).norm_sqr()).sum::<f64>().sqrt()
}

/// Moved to the middle, of size one.
fn shape(points: &[Point; PIECE]) -> ([Point; PIECE], Point, f64) {
    let middle = mean(points);
    let moved = points.map(|point| point - middle);
    let size = moved.iter().map(Point::norm_sqr).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    (moved.map(|point| point / size), middle, size)
}

fn open() -> &'static OpenAtlas {
    static ATLAS: OnceLock<OpenAtlas> = OnceLock::new();
    ATLAS.get_or_init(|| {
        let mut random = RandomNumbers::new(3);
        let mut atlas = OpenAtlas { pieces: Vec::new(), shapes: Vec::new(), sizes: Vec::new() };
        while atlas.pieces.len() < OPEN * PIECES {
            // As many of each kind: at random two thirds have no bar that turns, and one of twelve is a double rocker.
            let kind = atlas.pieces.len() / PIECES % KINDS;
            let bars = AtlasBars::random(&mut random);
            if bars.kind() != kind {
                continue;
            }
            let (points, angles) = bars.curve();
            if points.len() != STEPS + 1 {
                continue;
            }
            let lengths = along(&points);
            for _ in 0..PIECES {
                let part = CurvePiece { bars, from: random.between(0.0, 1.0), length: random.between(0.1, 0.95) };
                let (shape, _, size) = shape(&piece(&points, &angles, &lengths, &part).0);
                atlas.sizes.push(size);
                atlas.shapes.push(shape.map(|point| [point.re as f32, point.im as f32]));
                atlas.pieces.push(part);
            }
        }
        atlas
    })
}

/// Numbers of the least of some, in order.
fn least(values: &[f32], count: usize, some: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).filter(|index| some(*index)).collect();
    let count = count.min(order.len());
    if count < order.len() {
        order.select_nth_unstable_by(count, |&a, &b| values[a].total_cmp(&values[b]));
    }
    order.truncate(count);
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    order
}

/// Starts for a closed path, the most alike first; so many at most, of bars between two lengths if these are given.
pub(crate) fn closed_starts(path: &[Point], count: usize, room: Option<[f64; 2]>) -> Vec<Start> {
    let mut ring = path.to_vec();
    ring.extend(path.first());
    let lengths = along(&ring);
    let whole = lengths.last().copied().unwrap_or(0.0);
    let even = smooth(&ring, &lengths, (0..PLACES).map(|i| whole * i as f64 / PLACES as f64));
    let Ok(even) = <[Point; PLACES]>::try_from(even) else { return Vec::new() };
    let wanted = harmonics(&even);
    let distance = |other: &[f32; 2 * HARMONICS]| wanted.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
    let atlas = closed();
    let distances: Vec<f32> = atlas.harmonics.iter().map(distance).collect();
    let middle = mean(&even);
    let moved = even.map(|point| point - middle);
    let mut found: Vec<(f64, Start)> = Vec::new();
    let size = spread(&moved);
    let fits = |index: usize| atlas.bars[index].is_within(size / atlas.sizes[index], room);
    for index in least(&distances, 2 * count, fits) {
        let bars = &atlas.bars[index];
        let (points, angles) = bars.curve();
        let (curve, angles) = places(&points, &angles);
        found.extend(placed(&moved, middle, &lengths, bars, &curve, &angles));
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().take(count).map(|(_, start)| start).collect()
}

/// The best places of a closed curve on a path, as it is and mirrored, with how far they are from it.
fn placed(
    path: &[Point; PLACES],
    middle: Point,
    lengths: &[f64],
    bars: &AtlasBars,
    curve: &[Point; PLACES],
    angles: &[f64; PLACES],
) -> Vec<(f64, Start)> {
    let centre = mean(curve);
    let size = path.iter().map(Point::norm_sqr).sum::<f64>();
    let whole = lengths.last().copied().unwrap_or(0.0);
    let turned = ((angles[PLACES - 1] - angles[0]) / TAU).round() * TAU;
    let mut all = Vec::new();
    for mirrored in [false, true] {
        let image = curve.map(|point| if mirrored { (point - centre).conj() } else { point - centre });
        let square = image.iter().map(Point::norm_sqr).sum::<f64>();
        let mut best = (0.0, 0, false, Point::new(0.0, 0.0));
        for back in [false, true] {
            for shift in 0..PLACES {
                let index = |i: usize| if back { (2 * PLACES - 1 - i - shift) % PLACES } else { (i + shift) % PLACES };
                let common = (0..PLACES).map(|i| path[i] * image[index(i)].conj()).sum::<Point>();
                if common.norm_sqr() > best.0 {
                    best = (common.norm_sqr(), shift, back, common);
                }
            }
        }
        let (common, shift, back, k) = best;
        let error = 1.0 - common / (size * square).max(f64::MIN_POSITIVE);
        // Angles in the path's order, without a jump, one more at the end.
        let mut ordered: Vec<f64> = Vec::with_capacity(PLACES + 1);
        for i in 0..PLACES {
            let index = if back { (2 * PLACES - 1 - i - shift) % PLACES } else { (i + shift) % PLACES };
            let angle = angles[index];
            ordered.push(ordered.last().map_or(angle, |last| last + way(*last, angle)));
        }
        ordered.push(ordered[0] + if back { -turned } else { turned });
        let at = lengths.iter().take(lengths.len() - 1).map(|length| {
            let place = length / whole * PLACES as f64;
            linear(&ordered, ((place as usize).min(PLACES - 1), place - place.floor()))
        });
        all.push((error, bars.start(mirrored, k / square, centre, middle, at.collect())));
    }
    all
}

/// Starts for an open path, the most alike first; so many at most, of bars between two lengths if these are given.
pub(crate) fn open_starts(path: &[Point], count: usize, room: Option<[f64; 2]>) -> Vec<Start> {
    let lengths = along(path);
    let whole = lengths.last().copied().unwrap_or(0.0);
    let share = |i: usize| whole * i as f64 / (PIECE - 1) as f64;
    let Ok(even) = <[Point; PIECE]>::try_from(smooth(path, &lengths, (0..PIECE).map(share))) else { return Vec::new() };
    let (wanted, middle, size) = shape(&even);
    let wanted: [[f32; 2]; PIECE] = wanted.map(|point| [point.re as f32, point.im as f32]);
    let atlas = open();
    let distances: Vec<f32> = atlas.shapes.iter().map(|other| -likeness(&wanted, other).0).collect();
    let start = |index: usize| {
        let part = &atlas.pieces[index];
        let [back, mirrored] = likeness(&wanted, &atlas.shapes[index]).1;
        let (points, angles) = part.bars.curve();
        let (mut curve, mut angles) = piece(&points, &angles, &along(&points), part);
        if back {
            curve.reverse();
            angles.reverse();
        }
        let (other, from, length) = shape(&curve);
        let image = |point: Point| if mirrored { point.conj() } else { point };
        let (moved, ..) = shape(&even);
        let common = moved.iter().zip(&other).map(|(a, b)| a * image(*b).conj()).sum::<Point>();
        let at = lengths.iter().map(|length| {
            let place = length / whole * (PIECE - 1) as f64;
            let before = (place as usize).min(PIECE - 2);
            linear(&angles, (before, place - before as f64))
        });
        part.bars.start(mirrored, common * size / length, from, middle, at.collect())
    };
    let fits = |index: usize| atlas.pieces[index].bars.is_within(size / atlas.sizes[index], room);
    least(&distances, count, fits).into_iter().map(start).collect()
}

/// How alike two shapes are, at most one, and whether backwards and mirrored.
fn likeness(piece: &[[f32; 2]; PIECE], other: &[[f32; 2]; PIECE]) -> (f32, [bool; 2]) {
    // Sums of a conj(b) and of a b, forwards and backwards.
    let mut sums = [[0.0f32; 2]; 4];
    for i in 0..PIECE {
        let [x, y] = piece[i];
        for (back, [u, v]) in [other[i], other[PIECE - 1 - i]].into_iter().enumerate() {
            let (xu, yv, xv, yu) = (x * u, y * v, x * v, y * u);
            sums[2 * back][0] += xu + yv;
            sums[2 * back][1] += yu - xv;
            sums[2 * back + 1][0] += xu - yv;
            sums[2 * back + 1][1] += yu + xv;
        }
    }
    let sizes = sums.map(|[re, im]| re * re + im * im);
    let best = (0..4).max_by(|&a, &b| sizes[a].total_cmp(&sizes[b])).unwrap_or(0);
    (sizes[best].sqrt(), [best >= 2, best % 2 == 1])
}

/// A start beside another one.
pub(crate) fn variant(start: &Start, random: &mut RandomNumbers) -> Start {
    let mut other = start.clone();
    for value in &mut other.shared {
        *value *= 1.0 + 0.3 * random.normal().re;
    }
    let turn = 0.2 * random.normal().re;
    let slope = 0.2 * random.normal().re;
    let count = other.local.len().max(1) as f64;
    for (index, angle) in other.local.iter_mut().enumerate() {
        angle[0] += turn + slope * (PI * index as f64 / count).cos();
    }
    other
}
