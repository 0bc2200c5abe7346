//! Limits of a linkage in addition to its task, and by how much it violates them.

use crate::defects::Verdict;
use crate::dyad::Dyad;
use crate::linkage::Linkage;
use crate::{Point, cross};

/// Where a point may be.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// From the lower left to the upper right corner \[m\].
    Box(Point, Point),
    /// Corners one after the other; the last one is beside the first \[m\].
    Polygon(Vec<Point>),
}

impl Region {
    /// How far a point is outside \[m\]; zero inside.
    pub fn outside(&self, point: Point) -> f64 {
        match self {
            Region::Box(low, high) => {
                let beyond = |value: f64, low: f64, high: f64| (low - value).max(value - high).max(0.0);
                beyond(point.re, low.re, high.re).hypot(beyond(point.im, low.im, high.im))
            }
            Region::Polygon(corners) => {
                let sides = || corners.iter().zip(corners.iter().cycle().skip(1));
                let crosses = |(a, b): &(&Point, &Point)| {
                    (a.im > point.im) != (b.im > point.im) && (cross(*b - *a, point - *a) > 0.0) == (b.im > a.im)
                };
                if sides().filter(crosses).count() % 2 == 1 {
                    return 0.0;
                }
                let distance = |(a, b): (&Point, &Point)| {
                    let along = b - a;
                    let share = ((point - a) * along.conj()).re / along.norm_sqr().max(f64::MIN_POSITIVE);
                    (point - a - along * share.clamp(0.0, 1.0)).norm()
                };
                sides().map(distance).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// How far a point is outside, below zero inside, and the direction in which that grows fastest.
    pub(crate) fn signed(&self, point: Point) -> (f64, Point) {
        let corners = self.corners();
        let sides = || corners.iter().zip(corners.iter().cycle().skip(1));
        let nearest = |(a, b): (&Point, &Point)| {
            let along = b - a;
            let share = ((point - a) * along.conj()).re / along.norm_sqr().max(f64::MIN_POSITIVE);
            let (foot, across) = (a + along * share.clamp(0.0, 1.0), along * Point::new(0.0, -1.0));
            (point - foot, across)
        };
        let all = sides().map(nearest);
        let Some((way, across)) = all.min_by(|a, b| a.0.norm().total_cmp(&b.0.norm())) else {
            return (0.0, Point::new(0.0, 0.0));
        };
        let sign = if self.outside(point) > 0.0 { 1.0 } else { -1.0 };
        let size = way.norm();
        // On the side itself the direction is across it, away from the inside: corners of a box go around it to the left.
        let along = if size > 1e-9 { way * (sign / size) } else { across / across.norm().max(f64::MIN_POSITIVE) };
        (sign * size, along)
    }

    /// Its corners, those of a box that is open to a side far away.
    fn corners(&self) -> Vec<Point> {
        const FAR: f64 = 1e6;
        match self {
            Region::Box(low, high) => {
                let [left, right, bottom, top] = [low.re, high.re, low.im, high.im].map(|bound| bound.clamp(-FAR, FAR));
                vec![Point::new(left, bottom), Point::new(right, bottom), Point::new(right, top), Point::new(left, top)]
            }
            Region::Polygon(corners) => {
                let area: f64 = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| cross(*a, *b)).sum();
                if area < 0.0 { corners.iter().rev().copied().collect() } else { corners.clone() }
            }
        }
    }

    /// The same region seen with another origin and another unit of length.
    pub(crate) fn scaled(&self, middle: Point, size: f64) -> Region {
        let place = |point: &Point| (point - middle) / size;
        match self {
            Region::Box(low, high) => Region::Box(place(low), place(high)),
            Region::Polygon(corners) => Region::Polygon(corners.iter().map(place).collect()),
        }
    }

    /// The box around it.
    pub fn bounds(&self) -> [Point; 2] {
        match self {
            Region::Box(low, high) => [*low, *high],
            Region::Polygon(corners) => {
                let edge = |pick: fn(f64, f64) -> f64, of: fn(&Point) -> f64, start: f64| {
                    corners.iter().map(of).fold(start, pick)
                };
                let part = |pick: fn(f64, f64) -> f64, start: f64| {
                    Point::new(edge(pick, |corner| corner.re, start), edge(pick, |corner| corner.im, start))
                };
                [part(f64::min, f64::INFINITY), part(f64::max, f64::NEG_INFINITY)]
            }
        }
    }
}

/// What is asked of a linkage; nothing by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinkageLimits {
    /// Where pins in the ground may be.
    pub ground: Option<Region>,
    /// Where pins in the body may be, in its frame.
    pub moving: Option<Region>,
    /// Shortest bar, and largest distance of two points of a link \[m\].
    pub length: Option<[f64; 2]>,
    /// Is the body's origin one of these points, as the one that draws a path?
    pub tracer: bool,
    /// The smallest transmission angle \[rad\].
    pub transmission: Option<f64>,
    /// Must the input turn fully?
    pub crank: bool,
}

/// One of the limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LinkageLimit {
    /// [`LinkageLimits::ground`]
    Ground,
    /// [`LinkageLimits::moving`]
    Moving,
    /// [`LinkageLimits::length`]
    Length,
    /// [`LinkageLimits::crank`]
    Crank,
    /// [`LinkageLimits::transmission`]
    Transmission,
}

impl LinkageLimit {
    /// Is it missed by a length? Else by an angle, or as a whole.
    pub fn is_length(self) -> bool {
        matches!(self, LinkageLimit::Ground | LinkageLimit::Moving | LinkageLimit::Length)
    }

    /// Its name in the file of a task.
    pub fn name(self) -> &'static str {
        match self {
            LinkageLimit::Ground => "ground",
            LinkageLimit::Moving => "moving",
            LinkageLimit::Length => "length",
            LinkageLimit::Crank => "crank",
            LinkageLimit::Transmission => "transmission",
        }
    }
}

/// A limit holds up to this share of its value.
const HELD: f64 = 1e-9;

impl LinkageLimits {
    /// The first limit that a linkage misses, and by how much: \[m\], or \[rad\] for the transmission angle.
    pub fn missed(&self, linkage: &Linkage, verdict: &Verdict) -> Option<(LinkageLimit, f64)> {
        self.misses(linkage, verdict).first().copied()
    }

    /// All limits that a linkage misses, and by how much.
    pub fn misses(&self, linkage: &Linkage, verdict: &Verdict) -> Vec<(LinkageLimit, f64)> {
        let dyads = [linkage.first, linkage.second];
        let pins = |of: fn(&Dyad) -> Option<Point>, region: &Option<Region>| {
            let outside = |region: &Region| {
                let all = dyads.iter().filter_map(of).map(|pin| region.outside(pin));
                all.fold(0.0, f64::max)
            };
            region.as_ref().map_or(0.0, outside)
        };
        let ground = pins(ground_pin, &self.ground);
        let moving = pins(moving_pin, &self.moving);
        let wrong = |length: f64| {
            self.length.map_or(0.0, |[low, high]| (low * (1.0 - HELD) - length).max(length - high * (1.0 + HELD)))
        };
        let bars = linkage.lengths().into_iter().flatten().map(wrong).fold(0.0, f64::max);
        let too_large = |[_, high]: [f64; 2]| linkage.size(self.tracer) - high * (1.0 + HELD);
        let length = bars.max(self.length.map_or(0.0, too_large));
        let crank = if self.crank && !verdict.full_turn { f64::INFINITY } else { 0.0 };
        let transmission = self.transmission.map_or(0.0, |least| least * (1.0 - HELD) - verdict.transmission);
        let all = [
            (LinkageLimit::Ground, ground),
            (LinkageLimit::Moving, moving),
            (LinkageLimit::Length, length),
            (LinkageLimit::Crank, crank),
            (LinkageLimit::Transmission, transmission),
        ];
        all.into_iter().filter(|(_, miss)| *miss > 0.0).collect()
    }

    /// The limits that a linkage has just reached.
    pub fn active(&self, linkage: &Linkage, verdict: &Verdict) -> Vec<LinkageLimit> {
        let lengths = || linkage.lengths().into_iter().flatten();
        let size = linkage.size(self.tracer);
        let near = |value: f64, bound: f64| (value - bound).abs() <= ACTIVE * bound.abs();
        let at_length = |[low, high]: [f64; 2]| near(size, high) || lengths().any(|length| near(length, low));
        let at_side = |region: &Option<Region>, of: fn(&Dyad) -> Option<Point>| {
            let pins = || [linkage.first, linkage.second].iter().filter_map(of).collect::<Vec<_>>();
            region
                .as_ref()
                .is_some_and(|region| pins().into_iter().any(|pin| region.signed(pin).0.abs() <= ACTIVE * size))
        };
        let transmission = |least: f64| verdict.transmission - least <= ACTIVE;
        let all = [
            (LinkageLimit::Ground, at_side(&self.ground, ground_pin)),
            (LinkageLimit::Moving, at_side(&self.moving, moving_pin)),
            (LinkageLimit::Length, self.length.is_some_and(at_length)),
            (LinkageLimit::Transmission, self.transmission.is_some_and(transmission)),
        ];
        all.into_iter().filter_map(|(limit, is_active)| is_active.then_some(limit)).collect()
    }
}

/// A limit is reached where this share of it is left, or of a transmission angle so much \[rad\].
const ACTIVE: f64 = 1e-5;

fn ground_pin(dyad: &Dyad) -> Option<Point> {
    match *dyad {
        Dyad::Bar { ground, .. } | Dyad::Slot { ground, .. } => Some(ground),
        Dyad::Slider { .. } => None,
    }
}

fn moving_pin(dyad: &Dyad) -> Option<Point> {
    match *dyad {
        Dyad::Bar { moving, .. } | Dyad::Slider { moving, .. } => Some(moving),
        Dyad::Slot { .. } => None,
    }
}
