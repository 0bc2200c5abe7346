//! A run whose series are found together with those of others, several at a time.
//!
//! Only the usual is done there: steps of natural length, far from singular poses, that are accepted. For everything else the run takes the step by itself, from the
//! same state. Both ways follow from its own state alone, so its neighbours do not matter.

use super::passage::is_foreseen;
use super::propose::{GROW, goal, is_long, natural, share};
use super::{Taylor, order_for};
use crate::context::{Context, Settings};
use crate::events::Choices;
use crate::integrator::control::{LONGEST, STRETCH, shortest};
use crate::integrator::run::Run;
use crate::linalg::many::{Many, Number};
use crate::model::Model;
use crate::program::Engine;
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
    pub fn propose_with(&self, context: &Context, run: &Run, length: f64) -> Option<Proposed> {
        let (time, settings) = (run.last.end_time, context.settings);
        let natural = length.min(GROW * run.last.natural).min(LONGEST).min(settings.max_step);
        // Written so that NaN is too short.
        let long = natural >= shortest(time);
        if !long || is_foreseen(run, natural) {
            return None;
        }
        let limit = settings.limit();
        let cut = STRETCH * natural >= limit - time;
        let end = if cut { limit } else { time + natural };
        Some(Proposed { h: end - time, end, cut, goal: goal(context, run) })
    }

    /// Accepts the step, unless the run must take it alone.
    pub fn conclude_with<const W: usize>(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        step: &Proposed,
        motions: &Motions<W>,
        member: usize,
    ) -> bool {
        let Motions { begun, defect, .. } = motions;
        motions.series.closeness(member, &mut self.guard.next);
        let good = begun.open.0[member] <= step.goal && defect[member] <= step.goal;
        let passed = run.singular.ahead > 0.0 && self.guard.turned(step.h).is_some();
        let near = self.guard.arrives() || self.guard.ends_near() || self.guard.began_near() || passed;
        if !good || near || !motions.is_regular(member) {
            return false;
        }
        for (place, value) in self.next.iter_mut().zip(&motions.end) {
            *place = value.0[member];
        }
        self.tight = false;
        context.statistics.evaluations += 1;
        self.accept(context, run, step.end, step.cut);
        true
    }
}

/// Several motions and their series.
#[derive(Clone, Debug)]
pub(crate) struct Motions<const W: usize> {
    pub series: Members<Many<W>>,
    pub tolerance: f64,
    pub order: usize,
    /// (q, v) where the steps begin, and where they end.
    start: Vec<Many<W>>,
    end: Vec<Many<W>>,
    begun: Begun<Many<W>>,
    finite: [bool; W],
    defect: [f64; W],
}

impl<const W: usize> Motions<W> {
    /// For a model whose motions can be found together.
    pub fn new(model: &Model, tolerance: f64) -> Option<Self> {
        let motion = vec![Many::ZERO; 2 * model.coordinates()];
        Some(Self {
            series: Members::new(model)?,
            tolerance,
            order: order_for(tolerance),
            start: motion.clone(),
            end: motion,
            begun: Begun { open: Many::ZERO, regular: [false; W], amplification: Many::ZERO },
            finite: [false; W],
            defect: [0.0; W],
        })
    }

    /// One member begins at (q, v).
    pub fn place(&mut self, member: usize, motion: &[f64]) {
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
    pub fn lengths(&self) -> [f64; W] {
        let reach = |derivative| self.series.reach(self.order, share(self.tolerance), derivative);
        let rates = reach(1);
        let positions = if rates.iter().any(|rate| is_long(self.order, *rate)) { reach(0) } else { rates };
        std::array::from_fn(|member| natural(self.order, rates[member], || positions[member]))
    }

    /// The motions so long after the starts.
    pub fn evaluate(&mut self, h: [f64; W]) {
        self.series.evaluate(self.order, Many(h), &mut self.end);
    }

    /// Begins all series where the steps end.
    pub fn test(&mut self, h: [f64; W]) {
        self.begun = self.series.begin(self.order, &self.end);
        self.finite = self.series.finite();
        self.defect = self.series.defect(self.order, h);
    }

    /// The next steps begin where these end.
    pub fn roll(&mut self) {
        std::mem::swap(&mut self.start, &mut self.end);
    }

    /// Has a member a series that needs no pivots?
    pub fn is_regular(&self, member: usize) -> bool {
        self.begun.regular[member] && self.finite[member]
    }

    /// How many times rounding errors are multiplied where the series of a member begins.
    pub fn amplification(&self, member: usize) -> f64 {
        self.begun.amplification.0[member]
    }
}
