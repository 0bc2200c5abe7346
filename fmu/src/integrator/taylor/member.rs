//! A run whose series are found together with those of others, several at a time.
//!
//! Only the usual is done there: steps of natural length, far from singular poses, that are accepted. For everything else the run takes the step by itself, from the
//! same state. Both ways follow from its own state alone, so its neighbours do not matter.

use super::passage::is_foreseen;
use super::propose::{GROW, goal, is_long, natural, share};
use super::{Taylor, order_for};
use crate::context::{Context, Settings};
use crate::events::{Choices, half_width};
use crate::integrator::control::{LONGEST, STRETCH, shortest};
use crate::integrator::run::Run;
use crate::linalg::many::{Many, Number};
use crate::model::Model;
use crate::program::Engine;
use crate::taylor::form::Slot;
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
    pub fn joins(&self, run: &Run, settings: &Settings) -> bool {
        let (last, limit) = (&run.last, settings.limit());
        let regular = !is_foreseen(run, last.natural) && run.following().is_none() && !run.in_zone(limit);
        let series = run.taylor.series == Some(false) && run.taylor.branches == Choices::default();
        let usual = !run.stiffness.is_other() && !last.undefined;
        let known = last.natural > 0.0 && last.natural <= limit - last.end_time;
        settings.engine == Engine::Taylor && self.jet.joins() && regular && series && usual && known
    }

    /// Takes note of how close loop equations are to depending on each other where the series begins.
    pub fn join(&mut self, closeness: impl FnOnce(&mut [f64])) {
        closeness(&mut self.guard.next);
        self.guard.roll();
        self.forget();
    }

    /// The next step, of this length if nothing else limits it; none if the run must take it alone.
    pub fn propose_with(
        &mut self,
        context: &Context,
        run: &Run,
        (motions, member): (&dyn Motions, usize),
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
        run: &mut Run,
        step: &Proposed,
        motions: &dyn Motions,
        member: usize,
    ) -> bool {
        motions.closeness(member, &mut self.guard.next);
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
        true
    }
}

/// As many members as are served at once, at most: eight were no faster, but for mechanisms of many loops.
pub const MOST_LANES: usize = 4;

/// Something of each member.
pub(crate) type Each<T> = [T; MOST_LANES];

/// The series of several motions. Behind a table of functions, so that the code for each width is compiled here, once, and not with every kind of member.
pub(crate) trait Motions: std::fmt::Debug {
    fn tolerance(&self) -> f64;
    fn order(&self) -> usize;

    /// One member enters: its parameters are in its registers, and it begins at (q, v).
    fn enter(&mut self, member: usize, registers: &[f64], motion: &[f64]);

    /// A place that nobody takes follows another member, so that it computes with sensible numbers.
    fn follow(&mut self, member: usize, other: usize);

    /// Are there signals of time, which each start of a series needs from the registers?
    fn has_signals(&self) -> bool;

    /// Takes the signals of one member over from its registers.
    fn signal(&mut self, member: usize, model: &Model, registers: &[f64]);

    /// Begins all series where the steps begin.
    fn begin(&mut self);

    /// The rest of the series.
    fn expand(&mut self);

    /// The lengths that the tolerance permits.
    fn lengths(&self) -> Each<f64>;

    /// Goes so far after the starts, and begins all series there. The signals there must be known.
    fn go(&mut self, h: &Each<f64>);

    /// The next steps begin where these end.
    fn roll(&mut self);

    /// Has a member a series that needs no pivots?
    fn is_regular(&self, member: usize) -> bool;

    /// The first coefficients of one of its scalar series.
    fn scalar(&self, member: usize, slot: Slot, series: &mut [f64]);

    /// How many times rounding errors are multiplied where the series of a member begins.
    fn amplification(&self, member: usize) -> f64;

    /// How far its loops were open where its series begins.
    fn openness(&self, member: usize) -> f64;

    /// The accelerations at the end of its last step against those with which its series begins there.
    fn defect(&self, member: usize) -> f64;

    /// How close its loop equations are to depending on each other, by joints.
    fn closeness(&self, member: usize, closeness: &mut [f64]);

    /// (q, v) where its step ends.
    fn end(&self, member: usize, motion: &mut [f64]);

    /// The polynomial of its step.
    fn polynomial(&self, member: usize, polynomial: &mut [f64]);
}

/// For a model whose motions can be found together.
pub(crate) fn motions(model: &Model, tolerance: f64) -> Option<Box<dyn Motions>> {
    Some(Box::new(Vectors::new(model, tolerance)?))
}

/// Several motions in vectors.
#[derive(Clone, Debug)]
struct Vectors {
    series: Members<Many<MOST_LANES>>,
    tolerance: f64,
    order: usize,
    /// (q, v) where the steps begin, and where they end.
    start: Vec<Many<MOST_LANES>>,
    end: Vec<Many<MOST_LANES>>,
    begun: Begun<Many<MOST_LANES>>,
    finite: Each<bool>,
    defect: Each<f64>,
}

impl Vectors {
    fn new(model: &Model, tolerance: f64) -> Option<Self> {
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
}

impl Motions for Vectors {
    fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn order(&self) -> usize {
        self.order
    }

    fn enter(&mut self, member: usize, registers: &[f64], motion: &[f64]) {
        self.series.enter(member, registers);
        for (place, value) in self.start.iter_mut().zip(motion) {
            place.0[member] = *value;
        }
    }

    fn follow(&mut self, member: usize, other: usize) {
        for place in &mut self.start {
            place.0[member] = place.0[other];
        }
        self.series.follow_member(member, other);
    }

    fn has_signals(&self) -> bool {
        self.series.has_signals()
    }

    fn signal(&mut self, member: usize, model: &Model, registers: &[f64]) {
        self.series.signal(member, model, registers);
    }

    fn begin(&mut self) {
        self.begun = self.series.begin(self.order, &self.start);
        self.finite = self.series.finite();
    }

    fn expand(&mut self) {
        self.series.advance(1, self.order - 2);
    }

    fn lengths(&self) -> Each<f64> {
        let reach = |derivative| self.series.reach(self.order, share(self.tolerance), derivative);
        let rates = reach(1);
        let positions = if rates.iter().any(|rate| is_long(self.order, *rate)) { reach(0) } else { rates };
        let mut lengths = [0.0; MOST_LANES];
        for ((length, rate), position) in lengths.iter_mut().zip(rates).zip(positions) {
            *length = natural(self.order, rate, || position);
        }
        lengths
    }

    fn go(&mut self, h: &Each<f64>) {
        self.series.evaluate(self.order, Many(*h), &mut self.end);
        self.begun = self.series.begin(self.order, &self.end);
        self.finite = self.series.finite();
        self.defect = self.series.defect(self.order, *h);
    }

    fn roll(&mut self) {
        std::mem::swap(&mut self.start, &mut self.end);
    }

    fn is_regular(&self, member: usize) -> bool {
        self.begun.regular[member] && self.finite[member]
    }

    fn scalar(&self, member: usize, slot: Slot, series: &mut [f64]) {
        self.series.scalar(member, slot, series);
    }

    fn amplification(&self, member: usize) -> f64 {
        self.begun.amplification.0[member]
    }

    fn openness(&self, member: usize) -> f64 {
        self.begun.open.0[member]
    }

    fn defect(&self, member: usize) -> f64 {
        self.defect[member]
    }

    fn closeness(&self, member: usize, closeness: &mut [f64]) {
        self.series.closeness(member, closeness);
    }

    fn end(&self, member: usize, motion: &mut [f64]) {
        for (place, value) in motion.iter_mut().zip(&self.end) {
            *place = value.0[member];
        }
    }

    fn polynomial(&self, member: usize, polynomial: &mut [f64]) {
        self.series.polynomial(member, self.order, polynomial);
    }
}
