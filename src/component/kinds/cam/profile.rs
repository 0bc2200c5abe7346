//! A cam in numbers: its profile, and what designers ask of it.

use std::f64::consts::TAU;

use cotree_fmu::math::largest_between;

use super::geometry::CamGeometry;
use super::mounting::{FollowerGuide, Misfit, Mounting, place, value};
use crate::expr::{Arena, Expr, Symbol, indicators};
use crate::model::{BodyId, Mechanism, Part};

/// A cam for given parameters.
#[derive(Clone, Debug)]
pub struct Profile {
    /// The joint.
    pub name: String,
    /// The cam; `None` is the ground.
    pub body: Option<BodyId>,
    pub follower: Option<BodyId>,
    /// Radius of the roller \[m\]; 0 is an edge, none a flat face.
    pub roller: Option<f64>,
    /// Does the follower turn? Else it slides.
    pub turning: bool,
    /// Radius of the base circle \[m\].
    pub base: f64,
    /// Where the cam turns, in its axes from its mass centre.
    pub hub: [f64; 2],
    arena: Arena,
    roots: [Expr; 13],
    /// All that the roots are made of.
    order: Vec<Expr>,
    /// Parameters, then the radius of the base circle.
    values: Vec<f64>,
    /// Where the law switches (`if`, `min`, the ends of a rise), by their angles: the last number before each, and the first behind it.
    pub switches: Vec<[f64; 2]>,
    /// Where a turn is looked at before extremes are refined, in order from 0.
    angles: Vec<f64>,
}

/// A cam at one of its angles \[SI\].
#[derive(Clone, Copy, Debug)]
pub struct CamSample {
    pub angle: f64,
    /// The law and its derivatives by the angle.
    pub law: [f64; 4],
    /// Where it touches the follower, in the cam's axes from its mass centre.
    pub contact: [f64; 2],
    /// The follower's point there.
    pub point: [f64; 2],
    /// From the direction in which the follower rises to the common normal.
    pub pressure: f64,
    /// Of the profile, positive where it is convex.
    pub curvature: f64,
    /// Of the pitch curve.
    pub pitch: f64,
    /// Above zero where the profile is not undercut.
    pub excess: f64,
    /// From the follower's point along its face.
    pub reach: f64,
}

/// A rise or a return, with the peaks of its first three derivatives in shares of h/beta, h/beta^2 and h/beta^3.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Phase {
    /// From which angle \[rad\].
    pub from: f64,
    /// To which angle \[rad\].
    pub to: f64,
    /// How far the follower rises, SI; negative for a return.
    pub rise: f64,
    /// Peak coefficients of velocity, acceleration and jerk.
    pub peaks: [f64; 3],
}

/// At so many angles a turn is looked at before extremes are refined, and each part of it between two switches at no fewer than these.
const STEPS: usize = 720;
const PIECE: usize = 24;
/// Halvings of a step: down to rounding errors.
const HALVINGS: usize = 60;
/// A base circle that is too small is tried larger by this factor, up to so many times as large.
const LARGER: f64 = 1.1;
const LARGEST: f64 = 1e3;
/// Switches no further apart are one [rad].
pub(super) const SAME: f64 = 1e-12;
/// A common normal at less than this cosine to the follower's direction does not move it.
const PUSHES: f64 = 1e-6;

impl Profile {
    /// The cam of a part for these parameters.
    pub fn of(part: &Part, mechanism: &Mechanism, parameters: &[f64]) -> Result<Profile, Misfit> {
        let mounting = Mounting::of(part, mechanism)?;
        let mut arena = Arena::default();
        let base = arena.symbol(Symbol::Parameter(parameters.len()));
        let CamGeometry { law, contact, .. } = CamGeometry::of(&mut arena, mechanism, part, &mounting, base);
        let ([x, y], [u, v]) = (contact.at, contact.point);
        let of_contact = [contact.pressure, contact.curvature, contact.pitch, contact.excess];
        let mut roots = [Expr::ZERO; 13];
        let all = law.into_iter().chain([x, y, u, v]).chain(of_contact).chain([contact.reach]);
        roots.iter_mut().zip(all).for_each(|(root, expr)| *root = expr);
        let sizes = [part.formula("base"), part.formula("roller")].map(|formula| value(&mut arena, formula));
        let [hub_x, hub_y] = place(&mut arena, mechanism, mounting.shaft[1]);
        let sizes = [sizes[0], sizes[1], hub_x, hub_y];
        let known = |symbol: Symbol| if let Symbol::Parameter(index) = symbol { parameters[index] } else { 0.0 };
        let numbers = arena.evaluate(&sizes, &known);
        let switches = switches(&mut arena, &law, parameters);
        Ok(Profile {
            name: part.name.clone(),
            body: part.between[0].body(),
            follower: part.between[1].body(),
            roller: part.value("face").is_none().then_some(numbers[1]),
            turning: matches!(mounting.guide, FollowerGuide::Pivot(_)),
            base: numbers[0],
            hub: [numbers[2], numbers[3]],
            order: arena.reachable(roots),
            arena,
            roots,
            values: parameters.iter().copied().chain([numbers[0]]).collect(),
            angles: angles(&switches),
            switches,
        })
    }

    /// The same cam on another base circle.
    pub fn on_base(&self, base: f64) -> Profile {
        let mut other = self.clone();
        other.base = base;
        other.values.pop();
        other.values.push(base);
        other
    }

    pub fn sample(&self, angle: f64) -> CamSample {
        let known = |symbol: Symbol| match symbol {
            Symbol::Argument => angle,
            Symbol::Parameter(index) => self.values[index],
            Symbol::Time
            | Symbol::Discrete(_)
            | Symbol::Input(..)
            | Symbol::Follower(..)
            | Symbol::Coordinate(..)
            | Symbol::State(..)
            | Symbol::Reaction(_)
            | Symbol::Missing(..) => 0.0,
        };
        let found = self.arena.evaluate_in(&self.order, &self.roots, &known);
        CamSample {
            angle,
            law: [found[0], found[1], found[2], found[3]],
            contact: [found[4], found[5]],
            point: [found[6], found[7]],
            pressure: found[8],
            curvature: found[9],
            pitch: found[10],
            excess: found[11],
            reach: found[12],
        }
    }

    /// So many samples of a turn; the last is a step before the first.
    pub fn samples(&self, count: usize) -> Vec<CamSample> {
        (0..count).map(|step| self.sample(TAU * step as f64 / count as f64)).collect()
    }

    /// A turn with samples in each piece of the law.
    pub fn turn(&self) -> impl Iterator<Item = CamSample> {
        self.angles.iter().map(|&angle| self.sample(angle))
    }

    /// The sample with the smallest value of a quantity.
    pub fn least(&self, of: impl Fn(&CamSample) -> f64) -> CamSample {
        let samples: Vec<CamSample> = self.turn().collect();
        let finite = (0..samples.len()).filter(|&index| of(&samples[index]).is_finite());
        let best = finite.min_by(|&a, &b| of(&samples[a]).total_cmp(&of(&samples[b])));
        let Some(best) = best else { return self.sample(0.0) };
        let before =
            best.checked_sub(1).map_or_else(|| self.angles[samples.len() - 1] - TAU, |index| self.angles[index]);
        let behind = self.angles.get(best + 1).copied().unwrap_or(TAU);
        let refined = self.narrowed([before, behind], &of);
        if of(&refined) < of(&samples[best]) { refined } else { samples[best] }
    }

    /// Where the follower cannot touch the cam, or the cam cannot push it.
    pub fn missed(&self) -> Option<CamSample> {
        let touches =
            |sample: &CamSample| sample.contact.iter().all(|x| x.is_finite()) && sample.pressure.cos() > PUSHES;
        self.turn().find(|sample| !touches(sample))
    }

    /// The smallest value between two angles.
    fn narrowed(&self, range: [f64; 2], of: &impl Fn(&CamSample) -> f64) -> CamSample {
        let at = |angle: f64| self.sample(angle.rem_euclid(TAU));
        at(largest_between(range, HALVINGS, |angle| -of(&at(angle))).0)
    }

    /// The smallest base circle without undercut, if this one has some and there is a larger one without that the follower can touch.
    pub fn least_base(&self) -> Option<f64> {
        let is_cut = |base: f64| self.on_base(base).is_undercut();
        if !is_cut(self.base) {
            return None;
        }
        let mut high = self.base;
        while is_cut(high) {
            high *= LARGER;
            if high > LARGEST * self.base || self.on_base(high).missed().is_some() {
                return None;
            }
        }
        let mut low = high / LARGER;
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            *(if is_cut(middle) { &mut low } else { &mut high }) = middle;
        }
        Some(high)
    }

    fn is_undercut(&self) -> bool {
        let cut = |sample: &CamSample| sample.excess <= 0.0;
        self.turn().any(|sample| cut(&sample)) || cut(&self.least(|sample| sample.excess))
    }

    /// The shortest way between two switches of the law, if it has some.
    pub fn shortest_piece(&self) -> Option<f64> {
        let ways = self.switches.windows(2).map(|pair| pair[1][0] - pair[0][1]);
        ways.filter(|way| *way > SAME).min_by(f64::total_cmp)
    }

    /// The rises and returns of a turn, each between angles at which the follower stands still.
    pub fn phases(&self) -> Vec<Phase> {
        let samples: Vec<CamSample> = self.turn().collect();
        let largest = [1, 2, 3].map(|order| samples.iter().map(|sample| sample.law[order].abs()).fold(0.0, f64::max));
        let directions: Vec<i32> = samples.iter().map(|sample| direction(sample, largest)).collect();
        let ends = (0..samples.len()).filter_map(|index| {
            let next = (index + 1) % samples.len();
            let span = [self.angles[index], if next == 0 { TAU } else { self.angles[next] }];
            (directions[index] != directions[next]).then(|| self.change(span, directions[index], largest))
        });
        let ends: Vec<f64> = ends.collect();
        let spans = (0..ends.len()).map(|end| {
            let next = if end + 1 < ends.len() { ends[end + 1] } else { ends[0] + TAU };
            [ends[end], next]
        });
        spans.filter(|[from, to]| to - from > 1e-6).filter_map(|span| self.phase(span)).collect()
    }

    /// Where the follower's direction changes, by bisection.
    fn change(&self, span: [f64; 2], before: i32, largest: [f64; 3]) -> f64 {
        let same = |angle: f64| direction(&self.sample(angle.rem_euclid(TAU)), largest) == before;
        let [low, high] = halved(span, same);
        if before == 0 { low } else { high }
    }

    fn phase(&self, [from, to]: [f64; 2]) -> Option<Phase> {
        // Rounding errors of the phase before, such as sin(pi), hide the slow beginning of the next.
        let (beta, inset) = (to - from, 1e-7 * (to - from));
        let law = |angle: f64| self.sample(angle.rem_euclid(TAU)).law;
        let rise = law(to - inset)[0] - law(from + inset)[0];
        if rise.abs() < 1e-12 * self.base {
            return None;
        }
        let peak = |order: usize| {
            let of = |sample: &CamSample| -sample.law[order].abs();
            let steps = 400;
            let angle = |step: usize| from + inset + (beta - 2.0 * inset) * step as f64 / steps as f64;
            // On to the ends themselves.
            let end = |end: f64, inset: f64| 2.0 * law(end + inset)[order] - law(end + 2.0 * inset)[order];
            let size = |step: usize| match step {
                0 => end(from, inset),
                step if step == steps => end(to, -inset),
                step => law(angle(step))[order],
            };
            let sizes: Vec<f64> = (0..=steps).map(|step| size(step).abs()).collect();
            let best = (0..=steps).max_by(|&a, &b| sizes[a].total_cmp(&sizes[b])).unwrap_or(0);
            let around = [angle(best.saturating_sub(1)), angle((best + 1).min(steps))];
            let size = sizes[best].max(-of(&self.narrowed(around, &of)));
            size * beta.powi(order as i32) / rise.abs()
        };
        // One that begins where the turn ends begins with the next.
        let turn = if from > TAU * (1.0 - 1e-12) { TAU } else { 0.0 };
        Some(Phase { from: from - turn, to: to - turn, rise, peaks: [peak(1), peak(2), peak(3)] })
    }
}

/// The two ends of where a condition that holds at the first end no longer does.
fn halved([mut low, mut high]: [f64; 2], holds: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if holds(middle) { &mut low } else { &mut high }) = middle;
    }
    [low, high]
}

/// Where the event indicators of a law change their signs, by halving.
fn switches(arena: &mut Arena, law: &[Expr], parameters: &[f64]) -> Vec<[f64; 2]> {
    let indicators = indicators(arena, law);
    let order = arena.reachable(indicators.iter().copied());
    let above = |roots: &[Expr], angle: f64| -> Vec<bool> {
        let known = |symbol: Symbol| if let Symbol::Parameter(index) = symbol { parameters[index] } else { angle };
        arena.evaluate_in(&order, roots, &known).into_iter().map(|value| value > 0.0).collect()
    };
    let mut found = Vec::new();
    let mut before = (0.0, above(&indicators, 0.0));
    for step in 1..=STEPS {
        let angle = TAU * step as f64 / STEPS as f64;
        let now = above(&indicators, angle);
        for index in (0..indicators.len()).filter(|&index| now[index] != before.1[index]) {
            let same = |angle: f64| above(&indicators[index..=index], angle)[0] == before.1[index];
            found.push(halved([before.0, angle], same));
        }
        before = (angle, now);
    }
    found.sort_by(|a, b| a[0].total_cmp(&b[0]));
    found.dedup();
    found
}

/// A regular grid of the turn, both sides of all switches, and a grid of each short piece between two of them.
fn angles(switches: &[[f64; 2]]) -> Vec<f64> {
    let step = TAU / STEPS as f64;
    let mut angles: Vec<f64> = (0..STEPS).map(|index| step * index as f64).collect();
    angles.extend(switches.iter().flatten());
    let pieces = switches.windows(2).map(|pair| [pair[0][1], pair[1][0]]);
    for [from, to] in pieces.filter(|[from, to]| to - from < step * PIECE as f64) {
        angles.extend((1..PIECE).map(|part| from + (to - from) * part as f64 / PIECE as f64));
    }
    angles.retain(|angle| (0.0..TAU).contains(angle));
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    angles
}

/// 1 while the follower rises, -1 while it returns, 0 while it stands still with all derivatives.
fn direction(sample: &CamSample, largest: [f64; 3]) -> i32 {
    let still = (1..4).all(|order| sample.law[order].abs() <= 1e-12 * largest[order - 1]);
    // Where a rise begins, the first derivatives may be too small for a number.
    match sample.law[1..].iter().find(|derivative| **derivative != 0.0) {
        Some(derivative) if !still => derivative.signum() as i32,
        _ => 0,
    }
}
