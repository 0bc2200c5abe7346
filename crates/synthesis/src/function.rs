//! Function generation: linkages whose output follows their input.
//!
//! Seen from the input bar, the output bar takes poses: its pivot at `exp(-i phi)`, turned by `psi - phi` (ground of length one). The ground is one of the
//! dyads of these poses, the couplers are the others. Three pairs with both zero angles are Freudenstein's linear equation.
//!
//! Source: F. Freudenstein, *Approximate synthesis of four-bar linkages*, Trans. ASME 77, 1955; inversion: A. S. Hall, *Kinematics and Linkage Design*, 1961.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use crate::dyad::{Dyad, DyadCondition, Family, dyads};
use crate::least::{EndCriteria, TermResiduals, Terms, Unknowns, minimise};
use crate::linkage::{Linkage, Side};
use crate::poses::{Pose, way};
use crate::{Point, dot, polar};

/// A turn of the input \[rad\] and what the output has then: a turn \[rad\], or a way \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Turn of the input.
    pub input: f64,
    /// Turn or way of the output.
    pub output: f64,
}

/// Angles of the bars where the turns are zero, as far as they are given \[rad\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Zero {
    /// Of the input bar.
    pub input: Option<f64>,
    /// Of the output bar.
    pub output: Option<f64>,
}

/// A four-bar or a slider-crank that follows pairs. The pivot of the input is at the origin, the ground lies along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupler {
    /// The body between both pins, its frame at the first pin and along the second, on its dyads.
    pub linkage: Linkage,
    /// The angle of the input bar where its turn is zero \[rad\].
    pub input_zero: f64,
    /// The angle of the output bar \[rad\] or the place of the slider \[m\] where the output is zero.
    pub output_zero: f64,
}

impl Coupler {
    pub(crate) fn four_bar([ground, first, body, second]: [f64; 4], input_zero: f64, output_zero: f64) -> Coupler {
        let zero = Point::new(0.0, 0.0);
        let pivot = Point::new(ground, 0.0);
        let first = Dyad::Bar { moving: zero, ground: zero, length: first };
        let second = Dyad::Bar { moving: Point::new(body, 0.0), ground: pivot, length: second };
        Coupler { linkage: Linkage { first, second }, input_zero, output_zero }
    }

    /// The slider moves along x, `offset` above the pivot.
    pub(crate) fn slider_crank([crank, rod, offset]: [f64; 3], input_zero: f64, output_zero: f64) -> Coupler {
        let zero = Point::new(0.0, 0.0);
        let first = Dyad::Bar { moving: zero, ground: zero, length: crank };
        let sign = if offset < 0.0 { -1.0 } else { 1.0 };
        let second = Dyad::Slider { moving: Point::new(rod, 0.0), normal: Point::new(0.0, sign), offset: offset.abs() };
        Coupler { linkage: Linkage { first, second }, input_zero, output_zero }
    }

    /// Where the pin of the output is, for an output.
    pub(crate) fn output_pin(&self, output: f64) -> Point {
        match self.linkage.second {
            Dyad::Bar { ground, length, .. } => ground + polar(length, self.output_zero + output),
            Dyad::Slider { normal, offset, .. } => Point::new(self.output_zero + output, offset * normal.im),
            Dyad::Slot { ground, .. } => ground,
        }
    }

    /// The body as far as it can be placed at a pair: its first pin is, the second is looked at.
    pub fn pose(&self, pair: &Pair) -> Pose {
        let pin = self.linkage.pin(self.input_zero + pair.input);
        Pose { at: pin, angle: (self.output_pin(pair.output) - pin).arg() }
    }

    /// The output at an input, on the side on which another pair is; none where the loop does not close.
    pub fn output(&self, input: f64, side: Side) -> Option<f64> {
        let pose = self.linkage.pose(self.input_zero + input, side)?;
        Some(match self.linkage.second {
            Dyad::Bar { moving, ground, .. } => (pose.carry(moving) - ground).arg() - self.output_zero,
            Dyad::Slider { moving, .. } => pose.carry(moving).re - self.output_zero,
            Dyad::Slot { .. } => pose.angle,
        })
    }

    /// By how much the output misses a pair \[rad or m\]; none where the loop does not close.
    pub fn error(&self, pair: &Pair, side: Side) -> Option<f64> {
        let output = self.output(pair.input, side)?;
        let angular = matches!(self.linkage.second, Dyad::Bar { .. });
        Some(if angular { way(pair.output, output) } else { output - pair.output })
    }

    /// The larger of the errors at all pairs, and their root mean square.
    pub fn errors(&self, pairs: &[Pair], side: Side) -> Option<[f64; 2]> {
        let errors: Vec<f64> = pairs.iter().map(|pair| self.error(pair, side)).collect::<Option<_>>()?;
        let square = errors.iter().map(|error| error * error).sum::<f64>() / errors.len().max(1) as f64;
        Some([errors.iter().fold(0.0, |most: f64, error| most.max(error.abs())), square.sqrt()])
    }

    /// Made larger, so that the ground has this length; a slider-crank stays as it is.
    #[must_use]
    pub fn with_ground(self, ground: f64) -> Coupler {
        match self.linkage.lengths() {
            [Some(base), Some(first), Some(body), Some(second)] => {
                let lengths = [base, first, body, second].map(|length| length * ground / base);
                Coupler::four_bar(lengths, self.input_zero, self.output_zero)
            }
            _ => self,
        }
    }
}

/// A bar is there if it is longer than this share of the ground.
const NO_BAR: f64 = 1e-7;

/// The zero angles as lines on which the pins are.
fn conditions(zero: Zero) -> Vec<DyadCondition> {
    let across = |angle: f64| polar(1.0, angle) * Point::new(0.0, 1.0);
    let ground = zero.input.map(|angle| DyadCondition::Ground { direction: across(angle), value: 0.0 });
    let moving = zero.output.map(|angle| DyadCondition::Moving { direction: across(angle), value: 0.0 });
    ground.into_iter().chain(moving).collect()
}

/// All four-bars with a ground of length one whose output turns as the pairs say; pairs and zero angles that are given are five together.
///
/// A given zero angle is met up to half a turn: the bar then lies the other way.
///
/// # Errors
/// The pairs do not determine single linkages.
pub fn couplers(pairs: &[Pair], zero: Zero) -> Result<Vec<Coupler>, Family> {
    let seen = |pair: &Pair| Pose { at: polar(1.0, -pair.input), angle: pair.output - pair.input };
    let poses: Vec<Pose> = pairs.iter().map(seen).collect();
    let four_bar = |dyad: Dyad| {
        let Dyad::Bar { moving, ground, length } = dyad else { return None };
        let (first, second) = (ground.norm(), moving.norm());
        let there = first.min(second).min(length) > NO_BAR;
        there.then(|| Coupler::four_bar([1.0, first, length, second], ground.arg(), moving.arg()))
    };
    Ok(dyads(&poses, &conditions(zero))?.into_iter().filter_map(four_bar).collect())
}

/// All slider-cranks whose slider moves as the pairs say \[m\]; pairs and a zero angle of the input that is given are five together.
///
/// # Errors
/// The pairs do not determine single linkages.
pub fn slider_cranks(pairs: &[Pair], input_zero: Option<f64>) -> Result<Vec<Coupler>, Family> {
    let seen = |pair: &Pair| Pose { at: polar(1.0, -pair.input) * pair.output, angle: -pair.input };
    let poses: Vec<Pose> = pairs.iter().map(seen).collect();
    let zero = Zero { input: input_zero, output: None };
    let slider_crank = |dyad: Dyad| {
        let Dyad::Bar { moving, ground, length } = dyad else { return None };
        let there = ground.norm() > NO_BAR * length;
        there.then(|| Coupler::slider_crank([ground.norm(), length, moving.im], ground.arg(), moving.re))
    };
    Ok(dyads(&poses, &conditions(zero))?.into_iter().filter_map(slider_crank).collect())
}

/// Freudenstein's numbers `K1 = d/a`, `K2 = d/c`, `K3` and the lengths of ground (one), input, coupler and output bar for three pairs of angles. A negative
/// length: the bar lies the other way. None if there is no such linkage.
pub fn freudenstein(pairs: &[Pair; 3]) -> Option<([f64; 3], [f64; 4])> {
    let matrix = Matrix3::from_fn(|i, j| [pairs[i].output.cos(), -pairs[i].input.cos(), 1.0][j]);
    let right = Vector3::from_fn(|i, _| (pairs[i].input - pairs[i].output).cos());
    let k = matrix.lu().solve(&right)?;
    let (first, second) = (1.0 / k[0], 1.0 / k[1]);
    let square = first * first + second * second + 1.0 - 2.0 * first * second * k[2];
    (square > 0.0).then(|| ([k[0], k[1], k[2]], [1.0, first, square.sqrt(), second]))
}

/// Errors of outputs: lengths (or crank, rod, offset) and both zeros shared.
struct OutputErrors<'p> {
    pairs: &'p [Pair],
    side: Side,
    is_slider: bool,
    fixed: Zero,
}

/// The error of an output where the loop does not close: far above what is wanted.
const OPEN: f64 = 10.0;

impl OutputErrors<'_> {
    fn built(&self, shared: &[f64; 5]) -> Coupler {
        let [a, b, c, input_zero, output_zero] = *shared;
        if self.is_slider {
            Coupler::slider_crank([a, b, c], input_zero, output_zero)
        } else {
            Coupler::four_bar([1.0, a, b, c], input_zero, output_zero)
        }
    }
}

impl Terms<5, 0, 1> for OutputErrors<'_> {
    fn count(&self) -> usize {
        self.pairs.len()
    }

    fn at(&self, term: usize, shared: &[f64; 5], _: &[f64; 0]) -> TermResiduals<5, 0, 1> {
        let (built, pair) = (self.built(shared), &self.pairs[term]);
        let mut found = TermResiduals::zero();
        let bars = shared.iter().take(if self.is_slider { 2 } else { 3 }).all(|length| *length > 0.0);
        let Some(error) = built.error(pair, self.side).filter(|_| bars) else {
            found.value = [OPEN];
            return found;
        };
        // |body| - length = 0 gives the slopes.
        let output = pair.output + error;
        let (from, to) = (built.linkage.pin(built.input_zero + pair.input), built.output_pin(output));
        let body = to - from;
        let turned = Point::new(0.0, 1.0);
        let crank = polar(1.0, built.input_zero + pair.input);
        let (by_output, by_third) = if self.is_slider {
            (Point::new(1.0, 0.0), dot(body, turned))
        } else {
            let arm = polar(1.0, built.output_zero + output);
            (turned * arm * shared[2], dot(body, arm))
        };
        let below = -dot(body, by_output);
        let slope = [-dot(body, crank), -body.norm(), by_third, -dot(body, turned * crank * shared[0])];
        let mut slopes = [slope[0] / below, slope[1] / below, slope[2] / below, slope[3] / below, -1.0];
        if self.fixed.input.is_some() {
            slopes[3] = 0.0;
        }
        if self.fixed.output.is_some() {
            slopes[4] = 0.0;
        }
        TermResiduals { value: [error], by_shared: [slopes], by_local: [[]] }
    }
}

/// Numbers of evenly spread pairs, nearer at the ends (Chebyshev's spacing).
fn spread(pairs: &[Pair], count: usize) -> Vec<Pair> {
    let place = |i: usize| {
        let cosine = (std::f64::consts::PI * (2 * i + 1) as f64 / (2 * count) as f64).cos();
        ((0.5 - 0.5 * cosine) * (pairs.len() - 1) as f64).round() as usize
    };
    (0..count).map(|i| pairs[place(i).min(pairs.len() - 1)]).collect()
}

/// Angles tried for a zero that is not given.
const TRIED: usize = 24;

fn tried(given: Option<f64>) -> Vec<f64> {
    given.map_or_else(|| (0..TRIED).map(|i| TAU * i as f64 / TRIED as f64).collect(), |angle| vec![angle])
}

/// The four-bars whose output turns nearest to the pairs, each a local minimum of the sum of squares of the output's errors; best first.
pub fn nearest_couplers(pairs: &[Pair], zero: Zero) -> Vec<Coupler> {
    if pairs.len() < 3 { Vec::new() } else { nearest(pairs, coupler_starts(pairs, zero), zero, false) }
}

/// Four-bars that meet some of the pairs: three at least.
pub(crate) fn coupler_starts(pairs: &[Pair], zero: Zero) -> Vec<Coupler> {
    let mut starts =
        if pairs.len() >= 5 { couplers(&spread(pairs, 5), Zero::default()).unwrap_or_default() } else { Vec::new() };
    for input in tried(zero.input) {
        let half = Zero { input: Some(input), output: None };
        starts.extend(if pairs.len() >= 4 {
            couplers(&spread(pairs, 4), half).unwrap_or_default()
        } else {
            Vec::new()
        });
        for output in tried(zero.output) {
            let whole = Zero { input: Some(input), output: Some(output) };
            starts.extend(couplers(&spread(pairs, 3), whole).unwrap_or_default());
        }
    }
    starts
}

/// The same for slider-cranks.
pub fn nearest_slider_cranks(pairs: &[Pair], input_zero: Option<f64>) -> Vec<Coupler> {
    if pairs.len() < 4 {
        return Vec::new();
    }
    let fixed = Zero { input: input_zero, output: None };
    nearest(pairs, slider_starts(pairs, input_zero), fixed, true)
}

/// Slider-cranks that meet some of the pairs: four at least.
pub(crate) fn slider_starts(pairs: &[Pair], input_zero: Option<f64>) -> Vec<Coupler> {
    let mut starts =
        if pairs.len() >= 5 { slider_cranks(&spread(pairs, 5), None).unwrap_or_default() } else { Vec::new() };
    for input in tried(input_zero) {
        starts.extend(slider_cranks(&spread(pairs, 4), Some(input)).unwrap_or_default());
    }
    starts
}

fn nearest(pairs: &[Pair], starts: Vec<Coupler>, fixed: Zero, is_slider: bool) -> Vec<Coupler> {
    let mut found: Vec<([f64; 5], Coupler, f64)> = Vec::new();
    for start in starts {
        let side = pairs.first().map_or(1.0, |pair| start.linkage.side(&start.pose(pair)));
        let lengths = start.linkage.lengths();
        let offset = start.output_pin(0.0).im;
        let third = if is_slider { Some(offset) } else { lengths[3] };
        let (Some(a), Some(b), Some(c)) = (lengths[1], lengths[2], third) else { continue };
        let angle = |known: Option<f64>, given: f64| known.unwrap_or(given);
        let shared = [a, b, c, angle(fixed.input, start.input_zero), angle(fixed.output, start.output_zero)];
        let outputs = OutputErrors { pairs, side, is_slider, fixed };
        let mut at = Unknowns { shared, local: vec![[]; pairs.len()] };
        let sum = minimise(&outputs, &mut at, EndCriteria { share: 1e-12, ..EndCriteria::after(200) });
        let near = |other: &[f64; 5]| (0..3).all(|i| (other[i] - at.shared[i]).abs() < 1e-5 * (1.0 + other[i].abs()));
        if sum < OPEN && !found.iter().any(|(other, ..)| near(other)) {
            found.push((at.shared, outputs.built(&at.shared), sum));
        }
    }
    found.sort_by(|a, b| a.2.total_cmp(&b.2));
    found.into_iter().map(|(_, coupler, _)| coupler).collect()
}
