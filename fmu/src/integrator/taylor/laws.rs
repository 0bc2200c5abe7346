//! Laws along the polynomial of a step: where they are steep, and where their smooth branches end.

use super::{Start, Taylor};
use crate::context::Context;
use crate::events::Choices;
use crate::events::sliding::pushed;
use crate::failure::Failure;
use crate::integrator::accuracy::EVERY;
use crate::integrator::control::Progress;
use crate::machine::ROUNDING;
use crate::math;
use crate::motion::Run;

/// A smooth branch that is no longer than so many shortest steps is one of several that begin together.
const FLEETING: f64 = 64.0;
/// Where within a step it is compared: away from both ends, where laws may switch, and at no round time (the smaller golden section).
const WITHIN: f64 = 0.381_966;
/// Fewer orders do not tell how far an argument is known: two in a row may vanish.
const LEAST: usize = 6;

impl Taylor {
    /// Takes the arguments of steep laws along the polynomial over.
    pub(super) fn follow_laws(&mut self, order: usize) {
        if !self.layers.is_empty() || self.jet.has_switches() {
            self.jet.complete(order);
            self.layers.take(order - 1, |slot, place| place.copy_from_slice(&self.jet.scalar(slot)[..order]));
        }
    }

    /// Are the arguments of laws known so far by their terms below an order? Where a law is constant the motion needs few orders, however fast its
    /// argument changes.
    pub(super) fn knows_laws(&mut self, order: usize, h: f64, share: f64) -> bool {
        if self.layers.is_empty() && !self.jet.has_switches() {
            return true;
        }
        if order < LEAST {
            return false;
        }
        self.jet.complete(order);
        self.layers.are_known(order - 1, h, |slot| self.jet.scalar(slot)) && self.jet.sighted(order, h, share) == h
    }

    /// Where the effect of a law begins that the polynomial of a step of length h overlooks: at a place where the law may be steep the accelerations
    /// are not what the equations demand.
    pub(super) fn overlooked(&mut self, context: &mut Context, run: &Run, h: f64, goal: f64) -> Option<f64> {
        let mut from = (0, 0.0);
        while let Some(suspect) = self.layers.suspect(from, h) {
            let excess = suspect.excess(|place| self.excess(context, run, place * h, goal));
            if excess > 1.0 {
                return Some(self.layers.begin(&suspect, h, excess));
            }
            from = (suspect.law, suspect.place);
        }
        None
    }

    /// By how much the accelerations that the equations demand so long after the start of the step are not those of its polynomial, in units of what may be
    /// overlooked.
    fn excess(&mut self, context: &mut Context, run: &Run, place: f64, goal: f64) -> f64 {
        let order = run.last.order as usize;
        self.jet.evaluate(&run.last.dense, order, place, &mut self.next);
        let begun = self.start(context, run, run.last.end_time + place, false).is_some();
        context.statistics.evaluations += 1;
        let excess = if begun { self.jet.defect(order, place) / goal } else { f64::INFINITY };
        if excess.is_nan() { f64::INFINITY } else { excess }
    }

    /// Begins the next step on the branches that begin at a switch, so long after the step began; on those of the motion if it ends at none.
    pub(super) fn enter(&mut self, switch: Option<(f64, Choices)>, shortest: f64) {
        self.memory.branches = match switch {
            // What has just changed may be zero by rounding still.
            Some((length, branches)) if length < FLEETING * shortest => self.after(branches),
            Some((_, branches)) => branches,
            None => Choices::default(),
        };
        if switch.is_some() {
            self.known = Start::Unknown;
            self.memory.series = None;
        }
    }

    /// A branch that ends before so long ends where it begins. What follows from a switch is told by its value, which is that of the switch's rounding errors yet.
    pub(super) fn at_once(&self, branches: Choices, shortest: f64) -> f64 {
        let follows = self.jet.following(self.memory.branches) & branches.known != 0;
        if follows { FLEETING * shortest } else { shortest }
    }

    /// Begins anew on other branches where the step begins, unless nothing changes by that. If the motion has just come from there, each branch leads back to the
    /// other: fails if accelerations jump, and declines if rounding errors alone switch.
    pub(super) fn switch_at_once(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        branches: Choices,
    ) -> Result<Progress, Failure> {
        self.known = Start::Unknown;
        if self.memory.branches.reversed & branches.known != 0 {
            let sliding_mode = |coordinate| Failure::SlidingMode { time: run.last.end_time, coordinate };
            return self.pushed(context, run, branches).map_or(Ok(Progress::Declined), |name| Err(sliding_mode(name)));
        }
        self.memory.branches = self.after(branches);
        self.memory.series = None;
        Ok(if branches.known != 0 { Progress::Stepped } else { Progress::Declined })
    }

    /// The branches that the step begins on, but for later ones and what follows from those: its values tell.
    fn after(&self, branches: Choices) -> Choices {
        self.memory.branches.without(self.jet.following(branches)).then(branches)
    }

    /// Does the tape of the accelerations demand within a step of length h what its polynomial does? Laws have one meaning, but the series and the tape find it in
    /// different ways; where the sides of a comparison differ by rounding errors for long, the tape decides. Looked at after each switch and now and then.
    pub(super) fn agrees(&mut self, context: &mut Context, run: &mut Run, h: f64, goal: f64) -> bool {
        let has_switches = self.jet.has_switches();
        // An impact switches contacts, not laws.
        let begins =
            self.memory.series.is_none() && (has_switches || context.model.program().instants.contacts.is_none());
        let due = begins || self.memory.unseen >= EVERY - 1;
        if !due || !(has_switches || self.has_laws()) {
            return true;
        }
        self.memory.unseen = 0;
        self.jet.evaluate(&run.last.dense, run.last.order as usize, WITHIN * h, &mut self.next);
        let residual = self.residual(context, &run.signals.origin, run.last.end_time + WITHIN * h);
        // What is no number says nothing.
        let differs = h * residual > math::maximum(goal, run.last.order as f64 * ROUNDING);
        !differs
    }

    /// The coordinate whose acceleration changes most with these branches, if that is no rounding error.
    fn pushed(&mut self, context: &mut Context, run: &Run, branches: Choices) -> Option<String> {
        self.jet.coordinates(2, &mut self.left);
        self.next.copy_from_slice(&run.last.end);
        self.jet.force(self.after(branches));
        self.start(context, run, run.last.end_time, false)?;
        let Self { jet, left, next, closed, .. } = self;
        let n = left.len();
        jet.coordinates(2, &mut next[..n]);
        let most = pushed(context.model, context.settings.tolerance, &closed[n..], [&left[..], &next[..n], &next[..n]]);
        most.map(|index| context.model.program().coordinates[index].name.clone())
    }
}
