//! Steep laws along the polynomial of a step.

use super::course::{Course, DEEP, PLACES, ROUGH_PLACES, Suspect, varies};
use super::switch::first_fall;
use crate::math::{self, horner};
use crate::program::Steep;
use crate::program::arm_form::ORDERS;

/// A step ends so far inside the layer of a saturating law: what begins there sees the layer, and is not cut again.
const INSIDE: f64 = 0.5;

/// An exponential whose argument changes by less cannot be steep.
const GENTLE_ARGUMENT: f64 = 1.0;
/// The last terms of an argument are no larger where it is known well enough to say where its law is steep.
const UNKNOWN: f64 = 0.1;
/// The same of an argument that may nearly vanish, as a share of what it may be.
const UNKNOWN_SHARE: f64 = 1e-4;

/// The arguments of steep laws as polynomials of time since the start of a step.
#[derive(Clone, Debug)]
pub(crate) struct Layers {
    /// How each is steep, and the number of its series.
    laws: Vec<(Steep, u32)>,
    polynomials: Vec<f64>,
    /// Coefficients of each.
    length: usize,
    samples: [f64; PLACES.len()],
}

impl Layers {
    /// Storage for laws: how each is steep, and the number of the series that is its argument.
    pub fn new(laws: Vec<(Steep, u32)>) -> Self {
        Self { polynomials: vec![0.0; laws.len() * ORDERS], laws, length: 0, samples: [0.0; PLACES.len()] }
    }

    /// Are there no such laws?
    pub fn is_empty(&self) -> bool {
        self.laws.is_empty()
    }

    /// Takes the arguments over, from series that are known up to an order.
    pub fn take(&mut self, order: usize, series: impl Fn(u32, &mut [f64])) {
        self.length = order + 1;
        for (place, (_, number)) in self.polynomials.chunks_exact_mut(ORDERS).zip(&self.laws) {
            series(*number, &mut place[..=order]);
        }
    }

    /// Is no law steep within a step of length h, as far as the arguments tell? `layer` as for [`Self::first_cut`].
    pub fn are_gentle(&mut self, h: f64, layer: f64) -> bool {
        self.first_cut(h, layer) == f64::INFINITY && self.suspect((0, 0.0), h).is_none()
    }

    /// The same polynomials back in time.
    pub fn reverse(&mut self) {
        let odd = self.polynomials.chunks_exact_mut(ORDERS).flat_map(|argument| argument.iter_mut().skip(1).step_by(2));
        odd.for_each(|coefficient| *coefficient = -*coefficient);
    }

    fn polynomial(&self, law: usize) -> &[f64] {
        &self.polynomials[law * ORDERS..][..self.length]
    }

    /// Are the arguments known all along a step of length h by their terms up to an order?
    pub fn are_known<'a>(&self, order: usize, h: f64, series: impl Fn(u32) -> &'a [f64]) -> bool {
        self.laws.iter().all(|(kind, number)| known(*kind, &series(*number)[..=order], h) == f64::INFINITY)
    }

    /// Where a step of length h must end: the first saturated law comes into its layer of that half width, or an argument is not known any further.
    /// Infinity if it need not.
    pub fn first_cut(&self, h: f64, layer: f64) -> f64 {
        let mut first = f64::INFINITY;
        for (law, (kind, _)) in self.laws.iter().enumerate() {
            let argument = self.polynomial(law);
            let distance = argument[0].abs() - layer + INSIDE;
            let cut = match kind {
                Steep::Saturating if distance > INSIDE && majorant(argument, h) > distance => {
                    math::minimum(entry(argument, h, layer - INSIDE), known(*kind, argument, h))
                }
                Steep::Growing if majorant(argument, h) > GENTLE_ARGUMENT => known(*kind, argument, h),
                Steep::Vanishing if may_vanish(argument, h) => known(*kind, argument, h),
                _ => f64::INFINITY,
            };
            first = math::minimum(first, cut);
        }
        first
    }

    /// The first place that may be steep within a step of length h, of the laws from this one on: of this one only places after another one.
    pub fn suspect(&mut self, (from, after): (usize, f64), h: f64) -> Option<Suspect> {
        (from..self.laws.len()).find_map(|law| {
            let (kind, _) = self.laws[law];
            let argument = &self.polynomials[law * ORDERS..][..self.length];
            if !may_hide(kind, argument, h) {
                return None;
            }
            let samples = &mut self.samples;
            for (sample, place) in samples.iter_mut().zip(PLACES) {
                *sample = horner(argument, place * h);
            }
            let after = if law == from { after } else { 0.0 };
            kind.suspect(law, &mut Polynomial { argument, h, samples }, f64::INFINITY, after)
        })
    }

    /// Where the effect of a suspect begins that is so many times what may be overlooked, in a step of length h.
    pub fn begin(&mut self, suspect: &Suspect, h: f64, excess: f64) -> f64 {
        let argument = &self.polynomials[suspect.law * ORDERS..][..self.length];
        let course = &mut Polynomial { argument, h, samples: &self.samples };
        h * self.laws[suspect.law].0.begin(suspect, course, 0.0, excess)
    }
}

/// One argument along a step of length h.
struct Polynomial<'a> {
    argument: &'a [f64],
    h: f64,
    samples: &'a [f64; PLACES.len()],
}

impl Course for Polynomial<'_> {
    fn sample(&self, index: usize) -> f64 {
        self.samples[index]
    }

    fn value(&mut self, place: f64) -> f64 {
        horner(self.argument, place * self.h)
    }
}

/// When an argument falls to the edge.
fn entry(argument: &[f64], h: f64, edge: f64) -> f64 {
    let sign = argument[0].signum();
    let mut above = [0.0; ORDERS];
    above.iter_mut().zip(argument).for_each(|(place, value)| *place = sign * value);
    above[0] -= edge;
    first_fall(&above[..argument.len()], h).unwrap_or(f64::INFINITY)
}

/// May the law be steep within a step of length h without any effect on its ends?
fn may_hide(kind: Steep, argument: &[f64], h: f64) -> bool {
    match kind {
        Steep::Growing => majorant(argument, h) >= GENTLE_ARGUMENT,
        Steep::Vanishing => {
            let few = ROUGH_PLACES.iter().map(|index| horner(argument, PLACES[*index] * h));
            may_vanish(argument, h) && varies(few)
        }
        // No step is so long that it passes a layer whole: see `known`. Switching functions are looked at by themselves.
        Steep::Saturating | Steep::Switching => false,
    }
}

/// May an argument fall so far within h that it counts as nothing? Whatever its terms do.
fn may_vanish(argument: &[f64], h: f64) -> bool {
    majorant(argument, h) > (1.0 - 1.0 / DEEP) * argument[0].abs()
}

/// How far the last terms of an argument are small; infinity if they are at the end of h.
fn known(kind: Steep, argument: &[f64], h: f64) -> f64 {
    let vanishing = kind == Steep::Vanishing;
    let unknown = if vanishing { UNKNOWN_SHARE * (argument[0].abs() + majorant(argument, h)) } else { UNKNOWN };
    let mut known = f64::INFINITY;
    let last = argument.len().saturating_sub(2).max(1);
    for (k, coefficient) in argument.iter().enumerate().skip(last) {
        let within = libm::pow(unknown / coefficient.abs(), 1.0 / k as f64);
        if within < h {
            known = math::minimum(known, within);
        }
    }
    known
}

/// By how much a polynomial changes at most within h.
fn majorant(argument: &[f64], h: f64) -> f64 {
    argument[1..].iter().rev().fold(0.0, |sum, coefficient| (sum + coefficient.abs()) * h)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers(laws: &[(Steep, &[f64])]) -> Layers {
        let mut layers = Layers::new((0..).zip(laws).map(|(number, (kind, _))| (*kind, number)).collect());
        layers.take(laws[0].1.len() - 1, |number, place| place.copy_from_slice(laws[number as usize].1));
        layers
    }

    #[test]
    fn a_step_ends_at_the_first_layer() {
        let laws: &[(Steep, &[f64])] = &[
            (Steep::Saturating, &[100.0, -200.0, 0.0, 0.0, 0.0]),
            (Steep::Saturating, &[-40.0, 0.0, 100.0, 0.0, 0.0]),
        ];
        // At 9.5 and at -9.5.
        assert!((layers(laws).first_cut(1.0, 10.0) - 0.4525).abs() < 1e-12);
        assert!((layers(&laws[1..]).first_cut(1.0, 10.0) - 0.305_f64.sqrt()).abs() < 1e-12);
        assert_eq!(layers(laws).first_cut(0.4, 10.0), f64::INFINITY);
        // What begins in the layer sees it.
        assert_eq!(layers(&[(Steep::Saturating, &[9.9, -200.0])]).first_cut(1.0, 10.0), f64::INFINITY);
    }

    #[test]
    fn all_that_may_be_steep_is_looked_at_one_after_the_other() {
        let bump: &[f64] = &[-5000.0, 20_000.0, -20_000.0];
        let laws = [(Steep::Growing, bump); 6];
        let mut layers = layers(&laws);
        for law in 0..6 {
            let suspect = layers.suspect((law, 0.0), 1.0).expect("a bump");
            assert!(suspect.law == law && (suspect.place - 0.5).abs() < 1e-6);
        }
        // This one has no other bump, and the laws after it come next.
        assert_eq!(layers.suspect((0, 0.5), 1.0).map(|suspect| suspect.law), Some(1));
        assert_eq!(layers.suspect((5, 0.5), 1.0), None);
        // Before the bump there is nothing.
        assert_eq!(layers.suspect((0, 0.0), 0.45), None);
    }
}
