//! Steep laws along the dense output of a Runge-Kutta step.

use super::course::{Course, PLACES};
use super::half_width;
use crate::machine::Machine;
use crate::model::{Model, State};

/// Follows the arguments of the laws along a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Monitor {
    laws: usize,
    /// By places, then by laws.
    samples: Vec<f64>,
    motion: Vec<f64>,
    accelerations: Vec<f64>,
}

/// A step whose motion is known all along it.
pub(crate) struct Span<'a, F> {
    pub model: &'a Model,
    pub machine: &'a mut Machine,
    pub origin: &'a State,
    pub time: f64,
    pub h: f64,
    /// Writes (q, v), so many steps after the start.
    pub motion: F,
}

/// A law that a step has not seen, in steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Overlooked {
    /// Where its effect begins.
    pub begin: f64,
    /// Where it is steepest.
    pub place: f64,
}

impl<F: FnMut(f64, &mut [f64])> Span<'_, F> {
    fn load(&mut self, place: f64, motion: &mut [f64]) {
        (self.motion)(place, motion);
        self.machine.load_signals(self.model, self.origin, self.time + place * self.h);
        self.machine.load_motion(self.model, motion);
    }

    /// Brings the arguments at a place into the registers.
    fn evaluate(&mut self, place: f64, motion: &mut [f64]) {
        self.load(place, motion);
        self.machine.run(&self.model.program().tapes.laws.tape);
    }
}

impl Monitor {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let (laws, n) = (model.program().tapes.laws.kinds.len(), model.coordinates());
        let samples = vec![0.0; laws * PLACES.len()];
        Self { laws, samples, motion: vec![0.0; 2 * n], accelerations: vec![0.0; n] }
    }

    /// Are there no laws that may be steep?
    pub fn is_empty(&self) -> bool {
        self.laws == 0
    }

    /// The first law that the step has not seen. `share` of a law may be overlooked; `excess` says by how much the accelerations that the equations
    /// demand at a place are not those of the step, in units of what may be overlooked.
    pub fn overlooked<F: FnMut(f64, &mut [f64])>(
        &mut self,
        span: &mut Span<F>,
        share: f64,
        mut excess: impl FnMut(f64, &[f64]) -> f64,
    ) -> Option<Overlooked> {
        self.sample(span);
        let layer = half_width(share);
        let Self { laws, samples, motion, accelerations } = self;
        let program = span.model.program();
        for (law, kind) in program.tapes.laws.kinds.iter().enumerate() {
            let course = &mut Sampled { span: &mut *span, law, laws: *laws, samples, motion };
            let mut after = 0.0;
            while let Some(suspect) = kind.suspect(law, course, layer, after) {
                course.span.load(suspect.place, course.motion);
                course.span.machine.evaluate(&program.tapes.acceleration, accelerations);
                let finite = accelerations.iter().all(|acceleration| acceleration.is_finite());
                let excess = if finite { excess(suspect.place, accelerations) } else { f64::INFINITY };
                if excess > 1.0 {
                    let begin = kind.begin(&suspect, course, layer, excess);
                    return Some(Overlooked { begin, place: suspect.place });
                }
                after = suspect.place;
            }
        }
        None
    }

    fn sample<F: FnMut(f64, &mut [f64])>(&mut self, span: &mut Span<F>) {
        let tape = &span.model.program().tapes.laws.tape;
        for (samples, place) in self.samples.chunks_exact_mut(self.laws.max(1)).zip(PLACES) {
            span.evaluate(place, &mut self.motion);
            samples.iter_mut().zip(tape.results(span.machine.registers())).for_each(|(sample, value)| *sample = value);
        }
    }
}

/// One argument along a step.
struct Sampled<'a, 'b, F> {
    span: &'a mut Span<'b, F>,
    law: usize,
    laws: usize,
    samples: &'a [f64],
    motion: &'a mut [f64],
}

impl<F: FnMut(f64, &mut [f64])> Course for Sampled<'_, '_, F> {
    fn sample(&self, index: usize) -> f64 {
        self.samples[index * self.laws + self.law]
    }

    fn value(&mut self, place: f64) -> f64 {
        self.span.evaluate(place, self.motion);
        self.span.machine.result(&self.span.model.program().tapes.laws.tape, self.law)
    }
}
