//! A run whose series are found together with those of others, several at a time.
//!
//! Only the usual is done there: steps of natural length, far from singular poses, that are accepted. For everything else the run takes the step by itself, from the
//! same state. Both ways follow from its own state alone, so its neighbours do not matter.

use super::passage::FORESEEN;
use super::propose::{GROW, OPENING, SAFETY, rounding, share};
use super::{Taylor, order_for};
use crate::context::{Context, Settings};
use crate::events::Choices;
use crate::integrator::control::{LONGEST, STRETCH, shortest};
use crate::integrator::run::Run;
use crate::linalg::many::{MANY, Many, Number};
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
        let (last, singular) = (&run.last, &run.singular);
        let room = settings.stop.unwrap_or(f64::INFINITY) - last.end_time;
        let regular = singular.ahead == 0.0 || singular.ahead >= FORESEEN * last.natural;
        let series = run.taylor.series == Some(false) && run.taylor.branches == Choices::default();
        let usual = !run.stiffness.is_other() && run.following().is_none() && !run.in_zone(last.end_time + room);
        let known = last.natural > 0.0 && last.natural <= room && !last.undefined;
        settings.engine == Engine::Taylor && self.jet.joins() && regular && series && usual && known
    }

    /// Takes note of how close loop equations are to depending on each other where the series begins.
    pub fn join(&mut self, closeness: impl FnOnce(&mut [f64])) {
        closeness(&mut self.guard.next);
        self.guard.roll();
        self.forget();
    }

    /// The next step, whose rates and positions reach so far by the last coefficients of the series; none if the run must look for itself.
    pub fn propose_with(
        &self,
        context: &Context,
        run: &Run,
        [rates, positions]: [f64; 2],
        order: usize,
    ) -> Option<Proposed> {
        let (time, settings) = (run.last.end_time, context.settings);
        let step = SAFETY * rates;
        let step = if step > order as f64 { step.min(SAFETY * positions) } else { step };
        let natural = step.min(GROW * run.last.natural).min(LONGEST).min(settings.max_step);
        // Written so that NaN is too short.
        let long = natural >= shortest(time);
        if !long || run.singular.ahead > 0.0 && run.singular.ahead < FORESEEN * natural {
            return None;
        }
        let limit = settings.stop.unwrap_or(f64::INFINITY);
        let cut = STRETCH * natural >= limit - time;
        let end = if cut { limit } else { time + natural };
        let goal = f64::max(OPENING * share(settings.tolerance), rounding(context.model, &run.last.end));
        Some(Proposed { h: end - time, end, cut, goal })
    }

    /// Accepts the step, unless it is one that the run must look at for itself.
    pub fn conclude_with(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        step: &Proposed,
        motions: &Motions,
        member: usize,
    ) -> bool {
        let Motions { begun, defect, .. } = motions;
        motions.series.closeness(member, &mut self.guard.next);
        let good = begun.open[member] <= step.goal && defect[member] <= step.goal;
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
pub(crate) struct Motions {
    pub series: Members,
    pub tolerance: f64,
    pub order: usize,
    /// (q, v) where the steps begin, and where they end.
    start: Vec<Many>,
    end: Vec<Many>,
    begun: Begun,
    finite: [bool; MANY],
    defect: [f64; MANY],
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
            begun: Begun::default(),
            finite: [false; MANY],
            defect: [0.0; MANY],
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

    /// How far the series of each member reach: rates, and positions.
    pub fn reach(&self) -> [[f64; MANY]; 2] {
        [1, 0].map(|derivative| self.series.reach(self.order, share(self.tolerance), derivative))
    }

    /// The motions so long after the starts.
    pub fn evaluate(&mut self, h: [f64; MANY]) {
        self.series.evaluate(self.order, h, &mut self.end);
    }

    /// Begins all series where the steps end.
    pub fn test(&mut self, h: [f64; MANY]) {
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
        self.begun.amplification[member]
    }
}
