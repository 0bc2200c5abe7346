//! A run whose series are found together with those of others, several at a time.
//!
//! Only the usual is done there: steps of natural length, far from singular poses, that are accepted. For everything else the run takes the step by itself, from the
//! same state. Both ways follow from its own state alone, so its neighbours do not matter.

use super::passage::is_foreseen;
use super::propose::{GROW, goal, is_long, natural, share};
use super::{Taylor, order_for};
use crate::context::{Context, Settings};
use crate::events::{Choices, half_width};
use crate::integrator::control::{STRETCH, shortest};
use crate::integrator::memory::Memory;
use crate::linalg::many::{Many, Number};
use crate::model::Model;
use crate::motion::Run;
use crate::motion::last_step::LONGEST;
use crate::program::Engine;
use crate::program::arm_form::Slot;
use crate::taylor::{Begun, Members};

/// A step of one run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Proposed {
    pub h: f64,
    pub end: f64,
    /// Does it end at the limit?
    cut: bool,
    goal: f64,
}

impl Taylor {
    /// May the next step of this run be found together with those of others?
    pub fn joins(&self, run: &Run, memory: &Memory, settings: &Settings) -> bool {
        let (last, limit) = (&run.last, settings.limit());
        let regular = !is_foreseen(run, last.natural) && run.following().is_none() && !run.in_zone(limit);
        let series = memory.taylor.series == Some(false) && memory.taylor.branches == Choices::default();
        let usual = !memory.choice.is_other() && !last.undefined;
        let known = last.natural > 0.0 && last.natural <= limit - last.end_time;
        settings.engine == Engine::Taylor && self.jet.joins() && regular && series && usual && known
    }

    /// Takes note of how close loop equations are to depending on each other where the series begins.
    pub fn join(&mut self, reciprocal_pivots: impl FnOnce(&mut [f64])) {
        reciprocal_pivots(&mut self.guard.next);
        self.guard.roll();
        self.forget();
    }

    /// The next step, of this length if nothing else limits it; none if the run must take it alone.
    pub fn propose_with(
        &mut self,
        context: &Context,
        run: &Run,
        (motions, member): (&Motions, usize),
        length: f64,
    ) -> Option<Proposed> {
        let (time, settings) = (run.last.end_time, context.settings);
        let natural = length.min(GROW * run.last.natural).min(LONGEST).min(settings.max_step);
        // Written so that NaN is too short.
        let long = natural >= shortest(time);
        if !long || is_foreseen(run, natural) {
            return None;
        }
        self.layers.take(motions.order() - 2, |slot, place| motions.scalar(member, slot, place));
        let limit = settings.limit();
        let cut = STRETCH * natural >= limit - time;
        let end = if cut { limit } else { time + natural };
        let gentle = self.layers.are_gentle(end - time, half_width(settings.tolerance));
        gentle.then(|| Proposed { h: end - time, end, cut, goal: goal(context, run) })
    }

    /// Accepts the step, unless the run must take it alone.
    pub fn conclude_with(
        &mut self,
        context: &mut Context,
        (run, memory): (&mut Run, &mut Memory),
        step: &Proposed,
        motions: &Motions,
        member: usize,
    ) -> bool {
        self.memory = memory.taylor;
        motions.reciprocal_pivots(member, &mut self.guard.next);
        let good = motions.openness(member) <= step.goal && motions.defect(member) <= step.goal;
        let passed = run.singular.ahead > 0.0 && self.guard.turned(step.h).is_some();
        let near = self.guard.arrives() || self.guard.ends_near() || self.guard.began_near() || passed;
        if !good || near || !motions.is_regular(member) {
            return false;
        }
        motions.end(member, &mut self.next);
        self.tight = false;
        context.statistics.evaluations += 1;
        self.accept(context, run, step.end, step.cut);
        memory.taylor = self.memory;
        true
    }
}

/// As many members as are served at once, at most: eight were no faster, but for mechanisms of many loops.
pub const MOST_LANES: usize = 4;

/// Something of each member.
pub(crate) type Each<T> = [T; MOST_LANES];

/// The series of several motions.
#[derive(Clone, Debug)]
pub(crate) struct Motions {
    series: Members<Many>,
    tolerance: f64,
    order: usize,
    /// (q, v) where the steps begin, and where they end.
    start: Vec<Many>,
    end: Vec<Many>,
    begun: Begun<Many>,
    finite: Each<bool>,
    defect: Each<f64>,
}

impl Motions {
    /// For a model whose motions can be found together.
    pub fn new(model: &Model, tolerance: f64) -> Option<Self> {
        let motion = vec![Many::ZERO; 2 * model.coordinates()];
        Some(Self {
            series: Members::new(model)?,
            tolerance,
            order: order_for(tolerance),
            start: motion.clone(),
            end: motion,
            begun: Begun { open: Many::ZERO, regular: [false; MOST_LANES], amplification: Many::ZERO },
            finite: [false; MOST_LANES],
            defect: [0.0; MOST_LANES],
        })
    }

    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    pub fn order(&self) -> usize {
        self.order
    }

    /// One member enters: its parameters are in its registers, and it begins at (q, v).
    pub fn enter(&mut self, member: usize, registers: &[f64], motion: &[f64]) {
        self.series.enter(member, registers);
        for (place, value) in self.start.iter_mut().zip(motion) {
            place.0[member] = *value;
        }
    }

    /// A place that nobody takes follows another member, so that it computes with sensible numbers.
    pub fn follow(&mut self, member: usize, other: usize) {
        for place in &mut self.start {
            place.0[member] = place.0[other];
        }
        self.series.follow_member(member, other);
    }

    /// Are there signals of time, which each start of a series needs from the registers?
    pub fn has_signals(&self) -> bool {
        self.series.has_signals()
    }

    /// Takes the signals of one member over from its registers.
    pub fn signal(&mut self, member: usize, model: &Model, registers: &[f64]) {
        self.series.signal(member, model, registers);
    }

    /// Begins all series where the steps begin.
    pub fn begin(&mut self) {
        self.begun = self.series.begin(self.order, &self.start);
        self.finite = self.series.finite();
    }

    /// The rest of the series.
    pub fn expand(&mut self) {
        self.series.advance(1, self.order - 2);
    }

    /// The lengths that the tolerance permits.
    pub fn lengths(&self) -> Each<f64> {
        let reach = |derivative| self.series.reach(self.order, share(self.tolerance), derivative);
        let rates = reach(1);
        let positions = if rates.iter().any(|rate| is_long(self.order, *rate)) { reach(0) } else { rates };
        let mut lengths = [0.0; MOST_LANES];
        for ((length, rate), position) in lengths.iter_mut().zip(rates).zip(positions) {
            *length = natural(self.order, rate, || position);
        }
        lengths
    }

    /// Goes so far after the starts, and begins all series there. The signals there must be known.
    pub fn go(&mut self, h: &Each<f64>) {
        self.series.evaluate(self.order, Many(*h), &mut self.end);
        self.begun = self.series.begin(self.order, &self.end);
        self.finite = self.series.finite();
        self.defect = self.series.defect(self.order, *h);
    }

    /// The next steps begin where these end.
    pub fn roll(&mut self) {
        std::mem::swap(&mut self.start, &mut self.end);
    }

    /// Has a member a series that needs no pivots?
    pub fn is_regular(&self, member: usize) -> bool {
        self.begun.regular[member] && self.finite[member]
    }

    /// The first coefficients of one of its scalar series.
    pub fn scalar(&self, member: usize, slot: Slot, series: &mut [f64]) {
        self.series.scalar(member, slot, series);
    }

    /// How many times rounding errors are multiplied where the series of a member begins.
    pub fn amplification(&self, member: usize) -> f64 {
        self.begun.amplification.0[member]
    }

    /// How far its loops were open where its series begins.
    pub fn openness(&self, member: usize) -> f64 {
        self.begun.open.0[member]
    }

    /// The accelerations at the end of its last step against those with which its series begins there.
    pub fn defect(&self, member: usize) -> f64 {
        self.defect[member]
    }

    /// How close its loop equations are to depending on each other, by joints.
    pub fn reciprocal_pivots(&self, member: usize, reciprocal_pivots: &mut [f64]) {
        self.series.reciprocal_pivots(member, reciprocal_pivots);
    }

    /// (q, v) where its step ends.
    pub fn end(&self, member: usize, motion: &mut [f64]) {
        for (place, value) in motion.iter_mut().zip(&self.end) {
            *place = value.0[member];
        }
    }

    /// The polynomial of its step.
    pub fn polynomial(&self, member: usize, polynomial: &mut [f64]) {
        self.series.polynomial(member, self.order, polynomial);
    }
}
