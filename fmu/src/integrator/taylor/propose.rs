//! How long the next step may be, and along which series.

use super::step::PREDICTED;
use super::{Start, Taylor};
use crate::context::Context;
use crate::events::{Choices, half_width};
use crate::failure::Failure;
use crate::integrator::control::{Horizon, Progress, Proposal, STRETCH, shortest};
use crate::machine::ROUNDING;
use crate::math;
use crate::model::Model;
use crate::motion::Run;
use crate::motion::last_step::LONGEST_STEP;
use crate::program::arm_form::MAX_ORDER;
use crate::singular::detect::{HORIZON, Plan, plan};
use crate::taylor::SERIES_SAFETY;

/// Share of the tolerance that one step may use: what the user sees is the sum of the errors of many steps.
const SERIES_TOLERANCE: f64 = 0.03;
/// Orders of the coarsest series.
const LEAST_ORDER: usize = 8;
/// A step that is cut short ends its series when two terms are this much smaller than the tolerance.
const NEGLIGIBLE: f64 = 1e-3;
/// Loops may open so much along a step, and its end accelerate otherwise than the equations demand, in units of the tolerance.
const OPENING: f64 = 10.0;
/// So far beyond its natural step a polynomial still tells where a singular pose is, in units of that step.
pub(super) const POLYNOMIAL_REACH: f64 = 1.6;
/// A step is at most so many times as long as the one before.
pub(super) const SERIES_GROWTH: f64 = 4.0;
/// A step shorter than this share of the one before is cut short.
const CUT: f64 = 0.9;
/// A step is not rejected for what rounding errors do, of the order of one and of positions, in units of their spacing.
const DEFECT_SPACINGS: f64 = 8.0;
/// Two terms behind the last one of a parabola.
const FALL: usize = 4;
/// Next to a singular pose rounding errors make steps shorter and shorter; the pose is passed with one that is no shorter than this share of
/// those before.
const SHORTENED: f64 = 0.75;

/// There is no series, or none that knows so long a step.
const UNKNOWN: Proposal<Step> = Proposal::Nothing(Progress::Declined);

/// A step to be tried, and what bounds it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Length to be tried.
    pub h: f64,
    pub order: usize,
    /// The length that the series permits, and that of the steps before.
    pub natural: f64,
    pub usual: f64,
    /// Beyond this the polynomial does not know the laws.
    pub most: f64,
    pub shortest: f64,
    /// Nothing is evaluated after this time, nor after so long.
    pub limit: f64,
    pub room: f64,
    /// What the loops may open by, and the accelerations miss.
    pub goal: f64,
    /// Where a smooth branch of a law ends, and which ones begin there.
    pub switch: Option<(f64, Choices)>,
    /// The branches that the series is on.
    pub branches: Choices,
    /// Is a curve followed where branches of the motion come close to each other?
    pub follows: bool,
    /// Was a singular pose predicted, has one been located along the polynomial, and was one located wrongly?
    pub predicted: bool,
    pub located: bool,
    pub missed: bool,
    /// How long after its start the step crosses the singular pose, if it does, located precisely before the end is evaluated.
    pub passed: Option<f64>,
}

impl Step {
    /// The end of a step that begins at a time, and the switch there.
    pub fn end(&self, time: f64) -> (f64, Option<(f64, Choices)>) {
        let whole = if STRETCH * self.h >= self.room && self.room <= self.most { self.limit } else { time + self.h };
        let switch = self.switch.filter(|(length, _)| time + length <= whole);
        (switch.map_or(whole, |(length, _)| time + length), switch)
    }

    /// The length for a singular pose so far ahead; 0 for none.
    pub fn planned(&self, ahead: f64) -> f64 {
        let length = match if ahead > 0.0 { plan(ahead, self.usual) } else { Plan::Free } {
            Plan::Free => self.natural,
            Plan::Approach(most) => self.natural.min(most),
            Plan::Pass(least) => self.natural.max(least),
        };
        length.min(self.most)
    }
}

impl Taylor {
    /// Expands the series and proposes the next step.
    pub(super) fn propose(
        &mut self,
        context: &mut Context,
        run: &mut Run,
        horizon: Horizon,
    ) -> Result<Proposal<Step>, Failure> {
        let (time, tolerance) = (run.last.end_time, share(context.settings.tolerance));
        let (shortest, following) = (shortest(time), run.following());
        let predicted = predict(run);
        // No step ends in the zone, whoever asks for it: the polynomial serves what lies there.
        let limit = if run.in_zone(horizon.limit) { f64::INFINITY } else { horizon.limit };
        let room = limit - time;
        let order = self.expand(context, run, room.min(context.settings.max_step));
        let growing = if run.last.natural > 0.0 { SERIES_GROWTH * run.last.natural } else { LONGEST_STEP };
        let longest = growing.min(LONGEST_STEP).min(context.settings.max_step).min(following.unwrap_or(LONGEST_STEP));
        // What has ended is known further than its last terms tell.
        let reach = if is_fall(context, order) { room.min(longest) } else { self.natural_length(order, tolerance) };
        // A law that is not analytic here, |x|^1.5 at zero say; its series, and those of the switching functions, hold no numbers. Written so that NaN is no length.
        let analytic = reach >= shortest;
        if !analytic {
            return Ok(UNKNOWN);
        }
        let natural = reach.min(longest);
        if self.may_leap(context, run, natural.min(room)) {
            // Proposed again, as at a finer tolerance.
            (self.memory.turns_far, self.known) = (true, Start::Unknown);
            return Ok(Proposal::Nothing(Progress::Stepped));
        }
        self.follow_laws(order);
        let sighted = self.jet.sighted(order, room.min(POLYNOMIAL_REACH * natural), tolerance);
        let switch = self.jet.end_of_piece(order, 0.0, sighted);
        if let Some((_, branches)) = switch.filter(|(length, branches)| *length < self.at_once(*branches, shortest)) {
            return self.switch_at_once(context, run, branches).map(Proposal::Nothing);
        }
        let cut = self.layers.first_cut(natural.min(room), half_width(tolerance));
        let most = if sighted < natural.min(room) { math::minimum(cut, sighted) } else { cut };
        // At a root of a law the series knows nothing, however its coefficients come out.
        let known = most >= shortest;
        if !known {
            return Ok(UNKNOWN);
        }
        let natural = natural.min(most);
        let before = run.last.natural;
        let usual = if before > 0.0 { before.min(natural.max(SHORTENED * before)) } else { natural };
        let branches = self.jet.chosen();
        let located = self.locate_ahead(context, run, natural.min(room));
        let goal = goal(context, run);
        let follows = following.is_some();
        let step = Step {
            h: natural,
            order,
            natural,
            usual,
            most,
            shortest,
            limit,
            room,
            goal,
            switch,
            branches,
            follows,
            predicted,
            located,
            missed: false,
            passed: None,
        };
        let h = step.planned(run.singular.ahead);
        // Written so that NaN is too short.
        Ok(if h >= shortest { Proposal::Step(Step { h, ..step }) } else { UNKNOWN })
    }

    /// The length that the tolerance permits.
    pub(super) fn natural_length(&mut self, order: usize, tolerance: f64) -> f64 {
        natural(order, self.jet.reach(order, tolerance, 1), || self.jet.reach(order, tolerance, 0))
    }

    /// The rest of the series, as far as a step within the room may need it; returns its order.
    fn expand(&mut self, context: &mut Context, run: &mut Run, room: f64) -> usize {
        let tolerance = context.settings.tolerance;
        let order = order_of(run, tolerance);
        context.statistics.evaluations += 1;
        let longest = if run.last.natural > 0.0 { room.min(SERIES_GROWTH * run.last.natural) } else { room };
        let has_contacts = context.model.program().instants.contacts.is_some();
        match if has_contacts { self.expand_fall(longest, NEGLIGIBLE * share(tolerance)) } else { Some(2) } {
            Some(known) => self.expand_from(known, run, room, (order, tolerance)),
            None => self.keep(run, FALL),
        }
        run.last.order as usize
    }

    /// Two orders more, if the series ends before them for a step this long: between contacts bodies often fall, which is a parabola. Else returns the last order that is known then.
    fn expand_fall(&mut self, longest: f64, goal: f64) -> Option<usize> {
        let mut power = longest;
        for last in 3..=FALL {
            self.jet.advance(last - 2, last - 2);
            power *= longest;
            let size = last as f64 * power * self.jet.size(last);
            // Written so that what is not a number is not small.
            let is_small = size <= goal && longest * size <= goal;
            if !is_small {
                return Some(last);
            }
        }
        if self.knows_laws(FALL, longest, goal) { None } else { Some(FALL) }
    }

    /// The same up to an order.
    pub(super) fn expand_to(&mut self, run: &mut Run, room: f64, order: usize, tolerance: f64) {
        self.expand_from(2, run, room, (order, tolerance));
    }

    /// Expands the series from an order on; those before it are known.
    fn expand_from(&mut self, known: usize, run: &mut Run, room: f64, (order, tolerance): (usize, f64)) {
        // Only a step much shorter than its natural length needs fewer terms.
        let cut = run.last.natural == 0.0 || room < CUT * run.last.natural;
        let last = if cut {
            self.expand_within(known, room, order, NEGLIGIBLE * share(tolerance))
        } else {
            self.jet.advance(known - 1, order - 2);
            order
        };
        self.keep(run, last);
    }

    /// The polynomial of the step is the series up to an order.
    fn keep(&mut self, run: &mut Run, last: usize) {
        run.last.order = last as u32;
        self.jet.write_polynomial(last, &mut run.last.dense);
    }

    /// Orders until two terms in a row are negligible in a step; returns the last one.
    fn expand_within(&mut self, known: usize, room: f64, order: usize, goal: f64) -> usize {
        let (mut power, mut small) = (room, 0);
        for last in 2..order {
            let rate = last as f64 * power;
            let size = self.jet.size(last);
            small = if rate * size <= goal { small + 1 } else { 0 };
            if small == 2 && rate * room * size <= goal && self.knows_laws(last, room, goal) {
                return last;
            }
            power *= room;
            if last >= known {
                self.jet.advance(last - 1, last - 1);
            }
        }
        order
    }
}

/// The length of a step whose rates reach so far by the last coefficients. They decide, or positions if the step is so long that their error is larger.
pub(super) fn natural(order: usize, rates: f64, positions: impl FnOnce() -> f64) -> f64 {
    let step = SERIES_SAFETY * rates;
    if is_long(order, rates) { step.min(SERIES_SAFETY * positions()) } else { step }
}

/// True for a series that has ended: a parabola, between contacts.
pub(super) fn is_fall(context: &Context, order: usize) -> bool {
    order == FALL && context.model.program().instants.contacts.is_some()
}

/// May the error of positions be larger than that of rates?
pub(super) fn is_long(order: usize, rates: f64) -> bool {
    SERIES_SAFETY * rates > order as f64
}

/// What the loops may open by in the next step, and the accelerations at its end miss.
pub(super) fn goal(context: &Context, run: &Run) -> f64 {
    f64::max(OPENING * share(context.settings.tolerance), rounding(context.model, &run.last.end))
}

/// Notes the pose that the last step predicts, if it is near, unless a curve is followed. Says whether there is one.
fn predict(run: &mut Run) -> bool {
    if run.following().is_some() {
        run.singular.ahead = 0.0;
    }
    let ahead = run.singular.ahead;
    if ahead > 0.0 && ahead < PREDICTED * run.last.natural {
        run.singular.pose = Some(run.last.end_time + ahead);
    }
    ahead > 0.0
}

/// Does the step begin where rounding errors of a singular pose may count?
pub(super) fn is_near(run: &Run) -> bool {
    run.last.natural == 0.0 || is_near_pose(run)
}

/// Is a singular pose near, as far as is known?
pub(super) fn is_near_pose(run: &Run) -> bool {
    let near = |pose: f64| (run.last.end_time - pose).abs() < HORIZON * run.last.natural;
    run.singular.ahead > 0.0 || run.singular.pose.is_some_and(near)
}

/// How far loops are open by rounding errors alone: those of the positions count, for angles grow with every turn.
fn rounding(model: &Model, positions: &[f64]) -> f64 {
    let coordinates = model.program().coordinates.iter().zip(positions).take(model.mechanical());
    let largest = coordinates.fold(0.0, |largest, (coordinate, q)| math::maximum(largest, q.abs() / coordinate.scale));
    math::maximum(ROUNDING, DEFECT_SPACINGS * f64::EPSILON * largest)
}

/// What one step may be wrong by at a tolerance.
pub(crate) fn share(tolerance: f64) -> f64 {
    SERIES_TOLERANCE * tolerance
}

/// The order of the next step.
pub(super) fn order_of(run: &Run, tolerance: f64) -> usize {
    if is_near(run) { order_near(tolerance) } else { order_for(tolerance) }
}

/// Orders that cost least at a tolerance: two more for each decade. The optimum is flat; with fewer of them steps stay away from the radius of
/// convergence.
pub(crate) fn order_for(tolerance: f64) -> usize {
    let decades = -math::rough_log2(tolerance) * std::f64::consts::LOG10_2;
    let even = LEAST_ORDER + 2 * (decades + 0.5) as usize;
    even.min(MAX_ORDER)
}

/// Orders near a singular pose: the rounding errors that it multiplies grow with the order.
pub(super) fn order_near(tolerance: f64) -> usize {
    match tolerance {
        _ if tolerance >= 1e-5 => 12,
        _ if tolerance >= 1e-7 => 16,
        _ if tolerance >= 1e-11 => 18,
        _ => 20,
    }
}
