//! Steep laws along the dense output of a Runge-Kutta step.

use super::course::{Course, EDGE_HALVINGS, PLACES, ROUGH_PLACES, varies};
use super::half_width;
use super::sliding::pushed;
use crate::machine::Machine;
use crate::math;
use crate::model::{Model, State};
use crate::program::Steep;

/// Switches closer than this, in steps, are one: no root is found better.
pub(crate) const ONE_SWITCH: f64 = 1e-9;

/// A step ends before a switch by this share of its length: a stage behind it would count with its whole weight.
const MARGIN: f64 = 1e-6;
/// What follows a switch begins with a step of this share of what is left of the one that ended there.
const RESTART: f64 = 0.01;

/// Degree of the dense output of a Runge-Kutta step (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 1993, section II.6).
const DENSE_DEGREE: usize = 7;
/// Both sides of a switch are looked at so many shortest steps from it, or ten times further than it is found.
const SWITCH_SPACINGS: f64 = 16.0;
/// A switch is judged that lies no more than this share of what its function varies by in the step after it.
const SWITCH_AHEAD: f64 = 0.1;
/// The rate of a switching function counts from this share of the change in the step on.
const MOVES: f64 = 1e-3;

/// Follows the arguments of the laws along a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Monitor {
    laws: usize,
    /// By places, then by laws.
    samples: Vec<f64>,
    /// Where switching functions change sign, and which.
    crossings: Vec<(f64, usize)>,
    motion: Vec<f64>,
    /// The motion a little later.
    moved: Vec<f64>,
    accelerations: Vec<f64>,
    /// Accelerations on the other side of a switch.
    behind: Vec<f64>,
    /// Those as far on as that side is from this one.
    beyond: Vec<f64>,
}

/// A step whose motion is known all along it.
pub(crate) struct Span<'a, F> {
    pub model: &'a Model,
    pub machine: &'a mut Machine,
    pub origin: &'a State,
    pub time: f64,
    pub h: f64,
    /// The shortest step.
    pub shortest: f64,
    /// That of the run.
    pub tolerance: f64,
    /// Writes (q, v), so many steps after the start.
    pub motion: F,
    /// Evaluations of the motion and of the laws so far.
    pub places: u64,
}

/// What is against a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Objection {
    /// It has not seen a law.
    Overlooked(Overlooked),
    /// On both sides of a switch the motion is pushed to the other one; the coordinate that is pushed most.
    SlidingMode(usize),
}

/// A law that a step has not seen, in steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Overlooked {
    /// Where its effect begins.
    pub begin: f64,
    /// Where it is steepest.
    pub place: f64,
}

/// About how much work it is to look at the laws at one place.
fn work_of_a_place(model: &Model) -> usize {
    let laws = &model.program().tapes.laws;
    laws.tape.instructions().len() + laws.kinds.len() + 2 * model.coordinates() * DENSE_DEGREE
}

/// About how much work it is to look at the laws along a step on which nothing happens.
pub(crate) fn work_of_laws(model: &Model) -> usize {
    match model.program().tapes.laws.kinds.len() {
        0 => 0,
        _ => PLACES.len() * work_of_a_place(model),
    }
}

impl<F: FnMut(f64, &mut [f64])> Span<'_, F> {
    /// About how much work the evaluations have been, in instructions of tapes: of a motion they are polynomials, of each law some comparisons.
    pub fn work(&self) -> u64 {
        self.places * work_of_a_place(self.model) as u64
    }

    fn load(&mut self, place: f64, motion: &mut [f64]) {
        (self.motion)(place, motion);
        self.set(place, motion);
    }

    /// Brings a motion at the time of a place into the registers.
    fn set(&mut self, place: f64, motion: &[f64]) {
        self.places += 1;
        self.machine.load_signals(self.model, self.origin, self.time + place * self.h);
        self.machine.load_motion(self.model, motion);
    }

    /// Switches closer than this, in steps, are one, or at an end.
    fn finest(&self) -> f64 {
        f64::max(ONE_SWITCH, self.shortest / self.h)
    }

    /// Brings the arguments at a place into the registers.
    fn evaluate(&mut self, place: f64, motion: &mut [f64]) {
        self.load(place, motion);
        self.machine.run(&self.model.program().tapes.laws.tape);
    }

    /// An argument of a motion at the time of a place.
    fn argument(&mut self, law: usize, place: f64, motion: &[f64]) -> f64 {
        let tape = &self.model.program().tapes.laws.tape;
        self.set(place, motion);
        self.machine.run(tape);
        self.machine.result(tape, law)
    }
}

impl Monitor {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let (laws, n) = (model.program().tapes.laws.kinds.len(), model.coordinates());
        let (samples, crossings) = (vec![0.0; laws * PLACES.len()], Vec::with_capacity(laws * (PLACES.len() + 1)));
        let [motion, moved] = [vec![0.0; 2 * n], vec![0.0; 2 * n]];
        let [accelerations, behind, beyond] = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        Self { laws, samples, crossings, motion, moved, accelerations, behind, beyond }
    }

    /// Are there no laws that may be steep?
    pub fn is_empty(&self) -> bool {
        self.laws == 0
    }

    /// What is against the step: the first law that it has not seen, or a switch that the motion does not leave. `share` of a law may be overlooked; `excess` says by
    /// how much the accelerations that the equations demand at a place are not those of the step, in units of what may be overlooked.
    ///
    /// The estimates of a `filtering` method take off what stiff springs, and friction at rest, do; `excess` is told whether to do so. A contact may be as
    /// stiff, and a force may set free what rests: its steps end where a law switches, and begin there with a short one.
    pub fn objection<F: FnMut(f64, &mut [f64])>(
        &mut self,
        span: &mut Span<F>,
        share: f64,
        filtering: bool,
        mut excess: impl FnMut(bool, f64, &[f64]) -> f64,
    ) -> Option<Objection> {
        self.sample(span, |index| ROUGH_PLACES.contains(&index));
        if !self.may_be_steep(span.model) {
            return None;
        }
        self.sample(span, |index| !ROUGH_PLACES.contains(&index));
        self.find_crossings(span);
        let mut unfiltered = |place: f64, accelerations: &[f64]| excess(false, place, accelerations);
        let window = self.between_switches(span, &mut unfiltered);
        let switch = filtering.then(|| self.first_switch(span, &mut unfiltered)).flatten();
        let first = window.into_iter().chain(switch).min_by(|a, b| a.begin.total_cmp(&b.begin));
        let overlooked = first.or_else(|| {
            self.beside_its_ends(span, share, &mut |place, accelerations| excess(filtering, place, accelerations))
        });
        overlooked.map(Objection::Overlooked).or_else(|| self.sliding_mode(span).map(Objection::SlidingMode))
    }

    /// The coordinate that is pushed most at a switch to which both sides push the motion back (Filippov, Differential equations with discontinuous right-hand
    /// sides, 1988, section 4: a solution would stay there, and steps are endless).
    fn sliding_mode<F: FnMut(f64, &mut [f64])>(&mut self, span: &mut Span<F>) -> Option<usize> {
        self.add_switches_ahead(span.model);
        for index in 0..self.crossings.len() {
            let (at, law) = self.crossings[index];
            let aside = f64::max(10.0 * ONE_SWITCH, SWITCH_SPACINGS * span.shortest / span.h);
            let (ahead, place) = (at == 1.0, if at < 1.0 { at - aside } else { at });
            if place < MOVES {
                // Shortly before the step: the one before has looked ahead.
                continue;
            }
            let before = ahead.then(|| self.rate_at(span, law, [MOVES, -MOVES]).1);
            let (mut value, mut towards) = self.rate_at(span, law, [place, -MOVES]);
            // What lies ahead may change by as much as in the step.
            let change = before.map_or(0.0, |before| (towards - before).abs());
            if ahead {
                // A law that is steep, but does not jump, has the same value on both sides of the switch only.
                self.advance((1.0 - MOVES) * (value / towards).abs() * span.h);
                (value, towards) = self.rate(span, law, [place, -MOVES]);
            }
            // Across the switch, as far as it is ahead.
            let across = f64::max(2.0 * (value / towards).abs(), aside) * span.h;
            self.advance(across);
            std::mem::swap(&mut self.accelerations, &mut self.behind);
            // Away from the switch, for a switching function may jump there, as that of a periodic law does; but not beyond the end of the step.
            let (other, back) =
                self.rate(span, law, [place, if ahead { -MOVES } else { f64::min(MOVES, 1.0 - place) }]);
            let crosses = (value >= 0.0) != (other >= 0.0) && (value >= 0.0) == (towards < 0.0);
            let least = math::maximum(MOVES * self.range(law), change);
            // Written so that NaN is no push.
            if crosses && towards * back < 0.0 && towards.abs() > least && back.abs() > least {
                self.sample_beyond(span, place, across);
                let sides = [&self.behind[..], &self.accelerations, &self.beyond];
                let rates = &self.motion[self.behind.len()..];
                if let Some(pushed) = pushed(span.model, span.tolerance, rates, sides) {
                    return Some(pushed);
                }
            }
        }
        None
    }

    /// The accelerations where the motion would be as long behind the switch again, if what is before it went on.
    fn sample_beyond<F: FnMut(f64, &mut [f64])>(&mut self, span: &mut Span<F>, place: f64, dt: f64) {
        std::mem::swap(&mut self.accelerations, &mut self.behind);
        self.advance(dt);
        std::mem::swap(&mut self.accelerations, &mut self.behind);
        span.set(place, &self.motion);
        span.machine.evaluate(&span.model.program().tapes.acceleration, &mut self.beyond);
    }

    /// Adds the switches shortly before which the step ends to those within it.
    fn add_switches_ahead(&mut self, model: &Model) {
        for (law, kind) in model.program().tapes.laws.kinds.iter().enumerate() {
            let end = self.samples[(PLACES.len() - 1) * self.laws + law];
            if *kind == Steep::Switching && end.abs() < SWITCH_AHEAD * self.range(law) {
                self.crossings.push((1.0, law));
            }
        }
    }

    /// By how much an argument varies in the step.
    fn range(&self, law: usize) -> f64 {
        let samples = || (0..PLACES.len()).map(|place| self.samples[place * self.laws + law]);
        samples().fold(f64::MIN, f64::max) - samples().fold(f64::MAX, f64::min)
    }

    /// [`Self::rate`] of the motion that the step has at a place.
    fn rate_at<F: FnMut(f64, &mut [f64])>(
        &mut self,
        span: &mut Span<F>,
        law: usize,
        [place, aside]: [f64; 2],
    ) -> (f64, f64) {
        (span.motion)(place, &mut self.motion);
        self.rate(span, law, [place, aside])
    }

    /// A switching function where the motion is at a place, and how fast it changes by the accelerations demanded there, which are kept, times the length of the step: by the
    /// difference to its value a little aside.
    fn rate<F: FnMut(f64, &mut [f64])>(
        &mut self,
        span: &mut Span<F>,
        law: usize,
        [place, aside]: [f64; 2],
    ) -> (f64, f64) {
        span.set(place, &self.motion);
        span.machine.evaluate(&span.model.program().tapes.acceleration, &mut self.accelerations);
        self.go_on(aside * span.h);
        let here = span.argument(law, place, &self.motion);
        (here, (span.argument(law, place + aside, &self.moved) - here) / aside)
    }

    /// Goes on from the motion that is kept.
    fn advance(&mut self, dt: f64) {
        self.go_on(dt);
        std::mem::swap(&mut self.motion, &mut self.moved);
    }

    /// Where the motion is so much later, with the accelerations that are kept.
    fn go_on(&mut self, dt: f64) {
        let n = self.accelerations.len();
        for index in 0..n {
            self.moved[index] = self.motion[index] + dt * self.motion[n + index];
            self.moved[n + index] = self.motion[n + index] + dt * self.accelerations[index];
        }
    }

    /// The first switch within the step before or behind which the step is not what the equations demand.
    fn first_switch<F: FnMut(f64, &mut [f64])>(
        &mut self,
        span: &mut Span<F>,
        excess: &mut impl FnMut(f64, &[f64]) -> f64,
    ) -> Option<Overlooked> {
        for index in 0..self.crossings.len() {
            let (at, _) = self.crossings[index];
            let found = Overlooked { begin: (1.0 - MARGIN) * at, place: at + RESTART * (1.0 - at) };
            let within = (span.finest()..1.0 - span.finest()).contains(&at);
            // All stages may lie behind the switch: what the law does before it lasts a share of the step.
            let mut before = |place: f64, accelerations: &[f64]| at * excess(place, accelerations);
            if within && !(self.is_seen(span, 0.5 * at, &mut before) && self.is_seen(span, found.place, excess)) {
                return Some(found);
            }
        }
        None
    }

    /// Is the step at a place what the equations demand?
    fn is_seen<F: FnMut(f64, &mut [f64])>(
        &mut self,
        span: &mut Span<F>,
        place: f64,
        excess: &mut impl FnMut(f64, &[f64]) -> f64,
    ) -> bool {
        excess_at(span, place, (&mut self.motion, &mut self.accelerations), excess) <= 1.0
    }

    /// The same of each law by itself: where its argument comes to a layer, or goes through one, that it is outside of at the ends.
    fn beside_its_ends<F: FnMut(f64, &mut [f64])>(
        &mut self,
        span: &mut Span<F>,
        share: f64,
        excess: &mut impl FnMut(f64, &[f64]) -> f64,
    ) -> Option<Overlooked> {
        let layer = half_width(share);
        let Self { laws, samples, motion, accelerations, .. } = self;
        let model = span.model;
        for (law, kind) in model.program().tapes.laws.kinds.iter().enumerate() {
            let course = &mut Sampled { span: &mut *span, law, laws: *laws, samples, motion };
            let mut after = 0.0;
            while let Some(suspect) = kind.suspect(law, course, layer, after) {
                let excess =
                    suspect.excess(|place| excess_at(course.span, place, (course.motion, accelerations), excess));
                if excess > 1.0 {
                    let begin = kind.begin(&suspect, course, layer, excess);
                    return Some(Overlooked { begin, place: suspect.place });
                }
                after = suspect.place;
            }
        }
        None
    }

    /// What holds only between two switches within the step, of one function or of two: the step's ends do not tell of it.
    fn between_switches<F: FnMut(f64, &mut [f64])>(
        &mut self,
        span: &mut Span<F>,
        excess: &mut impl FnMut(f64, &[f64]) -> f64,
    ) -> Option<Overlooked> {
        for index in 0..self.crossings.len() {
            let (place, law) = self.crossings[index];
            let next = self.crossings.get(index + 1).map(|(next, _)| *next).filter(|next| next - place > span.finest());
            let window = self.window(span, place, law);
            // What it holds may end with zero at the switch that it ends with.
            let within = window.map(|found| Overlooked { place: 0.5 * (found.begin + place), ..found });
            let middle = next.map(|next| Overlooked { begin: place, place: 0.5 * (place + next) });
            for found in window.into_iter().chain(within).chain(middle) {
                if !self.is_seen(span, found.place, excess) {
                    return Some(found);
                }
            }
        }
        None
    }

    /// Where switching functions change sign within the step, in order.
    fn find_crossings<F: FnMut(f64, &mut [f64])>(&mut self, span: &mut Span<F>) {
        self.crossings.clear();
        for (law, kind) in span.model.program().tapes.laws.kinds.iter().enumerate() {
            for index in (1..PLACES.len()).filter(|_| *kind == Steep::Switching) {
                let [before, behind] = [index - 1, index].map(|index| self.samples[index * self.laws + law] >= 0.0);
                if before != behind {
                    let place = self.bisect(span, law, [PLACES[index - 1], PLACES[index]], before);
                    self.crossings.push((place, law));
                }
            }
        }
        self.crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    }

    /// Where a switching function changes sign between two places; `positive`: is it so at the first one?
    fn bisect<F: FnMut(f64, &mut [f64])>(
        &mut self,
        span: &mut Span<F>,
        law: usize,
        [mut before, mut behind]: [f64; 2],
        positive: bool,
    ) -> f64 {
        for _ in 0..EDGE_HALVINGS {
            let middle = 0.5 * (before + behind);
            span.evaluate(middle, &mut self.motion);
            let same = (span.machine.result(&span.model.program().tapes.laws.tape, law) >= 0.0) == positive;
            *(if same { &mut before } else { &mut behind }) = middle;
        }
        before
    }

    /// Another function that changes sign about a place where one does, and back, between two samples: as the flanks of a peak do.
    fn window<F: FnMut(f64, &mut [f64])>(&mut self, span: &mut Span<F>, at: f64, law: usize) -> Option<Overlooked> {
        let behind = PLACES.iter().position(|place| *place > at).unwrap_or(PLACES.len() - 1).max(1);
        let kinds = &span.model.program().tapes.laws.kinds;
        let others = (0..self.laws).filter(|other| *other != law && kinds[*other] == Steep::Switching);
        span.evaluate(at, &mut self.motion);
        let other = others.into_iter().find(|other| {
            let here = span.machine.result(&span.model.program().tapes.laws.tape, *other) >= 0.0;
            [behind - 1, behind].iter().all(|index| (self.samples[index * self.laws + other] >= 0.0) != here)
        })?;
        let positive = self.samples[(behind - 1) * self.laws + other] >= 0.0;
        let begin = self.bisect(span, other, [PLACES[behind - 1], at], positive);
        Some(Overlooked { begin, place: at })
    }

    /// Is there any law that may be steep within the step without an effect on its ends, as far as a few samples tell?
    fn may_be_steep(&self, model: &Model) -> bool {
        model.program().tapes.laws.kinds.iter().enumerate().any(|(law, kind)| {
            *kind != Steep::Vanishing || varies(ROUGH_PLACES.iter().map(|index| self.samples[index * self.laws + law]))
        })
    }

    fn sample<F: FnMut(f64, &mut [f64])>(&mut self, span: &mut Span<F>, wanted: impl Fn(usize) -> bool) {
        let tape = &span.model.program().tapes.laws.tape;
        let places = self.samples.chunks_exact_mut(self.laws.max(1)).zip(PLACES).enumerate();
        for (_, (samples, place)) in places.filter(|(index, _)| wanted(*index)) {
            span.evaluate(place, &mut self.motion);
            samples.iter_mut().zip(tape.results(span.machine.registers())).for_each(|(sample, value)| *sample = value);
        }
    }
}

/// By how much the equations demand something else at a place than the step says, in units of what may be overlooked; infinity where they demand no numbers.
fn excess_at<F: FnMut(f64, &mut [f64])>(
    span: &mut Span<F>,
    place: f64,
    (motion, accelerations): (&mut [f64], &mut [f64]),
    excess: &mut impl FnMut(f64, &[f64]) -> f64,
) -> f64 {
    span.load(place, motion);
    span.machine.evaluate(&span.model.program().tapes.acceleration, accelerations);
    let finite = accelerations.iter().all(|acceleration| acceleration.is_finite());
    if finite { excess(place, accelerations) } else { f64::INFINITY }
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
