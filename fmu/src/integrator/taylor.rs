//! Integration of Eqs. (22) by Taylor series, each step from the loop-closed state that the last one left.
//!
//! The polynomial of a step is its dense output. Its length follows from its last coefficients (Jorba & Zou, 2005). A step is rejected
//! if the loops do not stay closed along it, or if its end does not accelerate as the equations there demand. Where a series does not exist (a law that is not analytic at this very
//! state, a singular pose), one step of the explicit method leads on; [`Statistics::fallbacks`] counts them.

mod passage;

use super::continuation::Continuation;
use super::dynamic::{Dynamic, Horizon};
use crate::context::Context;
use crate::events::{Choices, Layers, half_width};
use crate::failure::Failure;
use crate::integrator::control::{LONGEST, STRETCH, shortest};
use crate::math;
use crate::model::Model;
use crate::singular::dependence::{begins_near, end_of_reach};
use crate::singular::detect::{Course, Guard, HORIZON, Plan, plan};
use crate::taylor::{Jet, MAX_ORDER};

/// Nothing is evaluated between the ends of a step.
pub(crate) const COURSE: Course = Course { take_off: 0.77, passes: 0.85, landing: 1.28, nearer: 0.0 };
/// Share of the tolerance that one step may use: what the user sees is the sum of the errors of many steps.
const SHARE_OF_TOLERANCE: f64 = 0.03;
/// Orders of the coarsest series.
const LEAST_ORDER: usize = 8;
/// Rounding is larger than an error below this.
const FINEST: f64 = 1e-15;
/// A step that is cut short ends its series when two terms are this much smaller than the tolerance.
const NEGLIGIBLE: f64 = 1e-3;
/// Loops may open so much along a step, in units of the tolerance.
const OPENING: f64 = 10.0;
/// Share of the step that the last coefficients permit: the terms after the last one count too.
const SAFETY: f64 = 0.9;
/// A step is at most so many times as long as the one before.
const GROW: f64 = 4.0;
/// A step shorter than this share of its natural length needs no look at its end if there are no loops to be closed there, and no laws of the
/// motion, which may be steep where no coefficient tells of it.
const SURE: f64 = 0.5;
/// A piece that is no longer than so many shortest steps is one of several that begin together.
const FLEETING: f64 = 64.0;
/// A step shorter than this share of the one before is cut short.
const CUT: f64 = 0.9;
/// So far beyond its natural step a polynomial still tells where a singular pose is, in units of that step.
const REACH: f64 = 1.6;
/// A pose predicted no further ahead than so many natural steps is looked for: a row that has just begun to fall falls faster and faster.
const FORESEEN: f64 = 3.0;
/// A step is not rejected for what rounding errors do, of the order of one and of positions, in units of their spacing.
const ROUNDING: f64 = 1e-12;
const SPACINGS: f64 = 8.0;
/// A pose predicted further ahead than so many steps is not to be relied on.
const PREDICTED: f64 = 1.8;
/// Next to a singular pose rounding errors make steps shorter and shorter; the pose is passed with one that is no shorter than this share of
/// those before.
const SHORTENED: f64 = 0.75;
/// So often a step is halved.
const HALVINGS: usize = 12;
/// A step that would end near a singular pose is cut to this share.
const SHORTER: f64 = 0.6;
/// Across a singular pose rounding errors that point away from the branch grow so large, in units of those of rates; the loops take them off.
const NOISE: f64 = 1e-7;

/// Storage for Taylor series.
#[derive(Clone, Debug)]
pub struct Taylor {
    jet: Jet,
    layers: Layers,
    next: Vec<f64>,
    /// (q, v) at the front, on the loops.
    closed: Vec<f64>,
    /// Series of q, order 2, in the piece that was left at once.
    left: Vec<f64>,
    guard: Guard,
    /// What the jet holds begins at the front.
    known: Start,
    /// Has it been begun with the loops closed tightly?
    tight: bool,
}

/// Whether there is a series at the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Start {
    Unknown,
    Regular,
    /// There is one, but rounding errors may spoil it.
    Near,
    Singular,
}

/// What comes of a state that the front has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// It is on the loops.
    Closed,
    /// It must still be projected.
    Open,
}

impl Taylor {
    /// Storage for a model with an arm form.
    pub fn new(model: &Model) -> Option<Self> {
        let size = 2 * model.coordinates();
        let jet = Jet::new(model)?;
        let layers = Layers::new(model.program().arms.as_ref()?.tape.steep_laws());
        let guard = Guard::new(jet.groups());
        Some(Self {
            jet,
            layers,
            next: vec![0.0; size],
            closed: vec![0.0; size],
            left: vec![0.0; model.coordinates()],
            guard,
            known: Start::Unknown,
            tight: false,
        })
    }

    /// Are there laws of positions or rates?
    pub fn has_laws(&self) -> bool {
        self.jet.has_laws()
    }

    /// About what a step costs, in instructions of a tape.
    pub fn cost(&self) -> f64 {
        self.jet.cost()
    }

    /// Numbers in the dense output of a step.
    pub fn dense_length(model: &Model) -> usize {
        model.program().arms.as_ref().map_or(0, Jet::room)
    }

    /// To be called when the front is not the one that the last step left.
    pub fn forget(&mut self) {
        self.known = Start::Unknown;
    }

    /// Takes one step.
    pub fn single(
        &mut self,
        context: &mut Context,
        explicit: &mut Dynamic,
        run: &mut Continuation,
        horizon: Horizon,
    ) -> Result<(), Failure> {
        self.begin(context, run);
        if self.known == Start::Singular {
            return self.leave(context, run);
        }
        if self.known == Start::Near {
            if self.leave(context, run).is_ok() {
                return Ok(());
            }
            // Too slow to be left: it is followed like any other motion.
            self.next.copy_from_slice(&run.front);
            self.known = self.start(context, run, run.front_time, true).map_or(Start::Singular, |_| Start::Regular);
            self.guard.roll();
            return Ok(());
        }
        if self.step(context, run, horizon)? {
            return Ok(());
        }
        match end_of_reach(context, run) {
            Some(failure) => Err(failure),
            None => self.lead_on(context, explicit, run, horizon),
        }
    }

    /// (q, v) at the target, from the front or from the polynomial.
    pub fn read(&mut self, context: &mut Context, run: &Continuation, target: f64, motion: &mut [f64]) -> Reading {
        if run.front_time == target {
            if self.jet.is_open() {
                motion.copy_from_slice(&run.front);
                return Reading::Closed;
            }
            self.begin(context, run);
            let regular = matches!(self.known, Start::Regular | Start::Near);
            motion.copy_from_slice(if regular { &self.closed } else { &run.front });
            return if regular { Reading::Closed } else { Reading::Open };
        }
        self.glide(run, target, motion);
        Reading::Closed
    }

    /// (q, v) at the target, from the polynomial.
    pub fn glide(&mut self, run: &Continuation, target: f64, motion: &mut [f64]) {
        self.jet.evaluate(&run.dense, run.order as usize, target - run.dense_from, motion);
    }

    /// Puts the front on the loops, if that has not been done.
    pub(crate) fn begin(&mut self, context: &mut Context, run: &Continuation) {
        if self.known == Start::Unknown {
            self.next.copy_from_slice(&run.front);
            self.jet.force(run.choices);
            // Only what the continuation remembers counts: what the guard holds may come from another run.
            self.guard.front.fill(0.0);
            self.known = match self.start(context, run, run.front_time, run.series == Some(true)) {
                Some(_) if run.series.is_none() && begins_near(context, run) => Start::Near,
                Some(_) => Start::Regular,
                None => Start::Singular,
            };
            self.guard.roll();
        }
    }

    /// Starts a series at `next`; returns how far the loops were open there.
    fn start(&mut self, context: &mut Context, run: &Continuation, time: f64, tightly: bool) -> Option<f64> {
        let Context { model, machine, settings, .. } = context;
        machine.load_signals(model, &run.origin, time);
        if self.known == Start::Unknown {
            // Parameters change at communication points only.
            self.jet.update(machine.registers());
        }
        let order = order_for(settings.tolerance);
        let open = self.jet.begin(model, machine.registers(), order, &self.next).ok()?;
        self.jet.closeness(model, &mut self.guard.next);
        self.take_closed(model);
        self.tight = tightly || self.guard.arrives();
        if self.tight {
            // The series must come from the matrix of the very pose in which the loops are closed.
            self.jet.close_tightly(model);
            self.take_closed(model);
            self.jet.begin(model, machine.registers(), order, &self.closed).ok()?;
            self.jet.close_tightly(model);
            self.take_closed(model);
        }
        (open.is_finite() && self.closed.iter().all(|value| value.is_finite())).then_some(open)
    }

    fn take_closed(&mut self, model: &Model) {
        let (q, v) = self.closed.split_at_mut(model.coordinates());
        self.jet.coordinates(0, q);
        self.jet.coordinates(1, v);
    }

    /// One step from the front; false if there is no series to step along.
    fn step(&mut self, context: &mut Context, run: &mut Continuation, horizon: Horizon) -> Result<bool, Failure> {
        let time = run.front_time;
        let shortest = shortest(time);
        let following = run.following();
        if following.is_some() {
            run.ahead = 0.0;
        }
        let falling = run.ahead > 0.0;
        if falling && run.ahead < PREDICTED * run.step {
            run.pose = Some(time + run.ahead);
        }
        // No step ends in the zone, whoever asks for it: the polynomial serves what lies there.
        let limit = if run.in_zone(horizon.limit) { f64::INFINITY } else { horizon.limit };
        let room = limit - time;
        let tolerance = share(context.settings.tolerance);
        let order =
            if is_near(run) { order_near(context.settings.tolerance) } else { order_for(context.settings.tolerance) };
        self.expand(context, run, room.min(context.settings.max_step), order);
        let order = run.order as usize;
        context.statistics.evaluations += 1;
        let natural = self.natural_step(order, tolerance);
        let longest = if run.step > 0.0 { GROW * run.step } else { LONGEST };
        let natural = natural.min(longest).min(LONGEST).min(context.settings.max_step);
        let natural = natural.min(following.unwrap_or(LONGEST));
        self.follow_laws(order);
        let piece = self.jet.end_of_piece(order, room.min(REACH * natural));
        if let Some((_, choices)) = piece.filter(|(length, _)| *length < shortest) {
            return self.change_at_once(context.model, run, choices);
        }
        // Beyond this the polynomial does not know the laws.
        let mut most = self.layers.first_cut(natural.min(room), half_width(tolerance));
        // At a root of a law the series knows nothing, however its coefficients come out.
        let known = most >= shortest;
        if !known {
            return Ok(false);
        }
        let natural = natural.min(most);
        let chosen = self.jet.chosen();
        let usual = if run.step > 0.0 { run.step.min(natural.max(SHORTENED * run.step)) } else { natural };
        let mut found = self.look_ahead(context, run, natural.min(room));
        let strict = f64::max(OPENING * tolerance, rounding(context.model, &run.front));
        let mut h = planned(run.ahead, natural, usual).min(most);
        for _ in 0..HALVINGS {
            // Written so that NaN is too short.
            let long = h >= shortest;
            if !long {
                return Ok(false);
            }
            let whole = if STRETCH * h >= room && room <= most { limit } else { time + h };
            let change = piece.filter(|(length, _)| time + length <= whole);
            let end = change.map_or(whole, |(length, _)| time + length);
            // What lies behind the end of a piece says nothing about the step up to it.
            self.jet.force(if change.is_some() { chosen } else { Choices::default() });
            if let Some(overlooked) = self.overlooked(context, run, end - time, strict) {
                context.statistics.rejected += 1;
                (h, most) = (overlooked, overlooked);
                continue;
            }
            self.jet.evaluate(&run.dense, order, end - time, &mut self.next);
            let sure = self.jet.is_even() && self.layers.is_empty() && change.is_none() && end - time < SURE * natural;
            if sure && self.next.iter().all(|value| value.is_finite()) {
                self.known = Start::Unknown;
                self.accept(context, run, end, true);
                return Ok(true);
            }
            let goal = if found && run.ahead < end - time { strict.max(NOISE) } else { strict };
            let closed = self.start(context, run, end, false).is_some_and(|open| open <= goal);
            if following.is_some() && closed && self.guard.jumps() {
                h = 0.5 * (end - time);
                continue;
            }
            if closed && following.is_none() && self.guard.ends_near() {
                (run.ahead, h) = (0.0, SHORTER * (end - time));
                if !found && let Some(ahead) = self.locate(context, run, end - time) {
                    (run.ahead, run.pose, found) = (ahead, Some(time + ahead), true);
                    h = planned(ahead, natural, usual).min(most);
                }
                continue;
            }
            if closed && self.jet.defect(order, end - time) <= goal {
                if following.is_none() && self.guard.began_near() {
                    self.known = Start::Singular;
                    return Ok(true);
                }
                if falling && !found {
                    found = self.look_back(context, run, end);
                }
                if found && run.ahead < end - time && !self.note_passage(context, run, end) {
                    // Judged again from here, by the step just spoiled.
                    return Ok(true);
                }
                let left = found.then_some(f64::max(run.ahead - (end - time), 0.0));
                let falls = run.ahead > 0.0 && run.ahead < PREDICTED * run.step;
                self.accept(context, run, end, end == limit || falls || change.is_some() || most.is_finite());
                run.ahead = left.unwrap_or(run.ahead);
                run.choices = match change {
                    // What has just changed may be zero by rounding still.
                    Some((length, choices)) if length < FLEETING * shortest => run.choices.then(choices),
                    Some((_, choices)) => choices,
                    None => Choices::default(),
                };
                if change.is_some() {
                    self.known = Start::Unknown;
                    run.series = None;
                }
                return Ok(true);
            }
            context.statistics.rejected += 1;
            h = 0.5 * (end - time);
        }
        Ok(false)
    }

    /// Takes the arguments of steep laws along the polynomial over.
    fn follow_laws(&mut self, order: usize) {
        if !self.layers.is_empty() || self.jet.has_switches() {
            self.jet.complete(order);
            self.layers.take(order - 1, |slot| self.jet.scalar(slot));
        }
    }

    /// Where the effect of a law begins that the polynomial of a step of length h overlooks: at a place where the law may be steep the accelerations
    /// are not what the equations demand.
    fn overlooked(&mut self, context: &mut Context, run: &Continuation, h: f64, goal: f64) -> Option<f64> {
        let order = run.order as usize;
        let mut law = 0;
        while let Some(suspect) = self.layers.suspect(law, h) {
            let place = suspect.place * h;
            self.jet.evaluate(&run.dense, order, place, &mut self.next);
            let begun = self.start(context, run, run.front_time + place, false).is_some();
            context.statistics.evaluations += 1;
            let excess = if begun { self.jet.defect(order, place) / goal } else { f64::INFINITY };
            // Written so that NaN is overlooked.
            let met = excess <= 1.0;
            if !met {
                return Some(self.layers.begin(&suspect, h, excess));
            }
            law = suspect.law + 1;
        }
        None
    }

    /// Begins anew in another piece at the front; false if nothing changes by that. Fails if the motion has just come from there: each piece
    /// leads back into the other.
    fn change_at_once(&mut self, model: &Model, run: &mut Continuation, choices: Choices) -> Result<bool, Failure> {
        if run.choices.reversed & choices.known != 0 {
            return Err(Failure::Chatter { time: run.front_time, coordinate: self.most_switched(model) });
        }
        self.jet.coordinates(2, &mut self.left);
        run.choices = run.choices.then(choices);
        self.known = Start::Unknown;
        run.series = None;
        Ok(choices.known != 0)
    }

    /// The coordinate whose acceleration has changed most with the piece.
    fn most_switched(&mut self, model: &Model) -> String {
        let here = &mut self.next[..model.coordinates()];
        self.jet.coordinates(2, here);
        let coordinates = &model.program().coordinates;
        let change = |index: usize| (here[index] - self.left[index]).abs() / coordinates[index].scale;
        let most = (0..coordinates.len()).max_by(|&a, &b| change(a).total_cmp(&change(b)));
        most.map_or_else(|| model.program().name.clone(), |index| coordinates[index].name.clone())
    }

    /// The end of the step becomes the front.
    fn accept(&mut self, context: &mut Context, run: &mut Continuation, end: f64, cut: bool) {
        let h = end - run.front_time;
        run.ahead = self.guard.ahead(h);
        run.follow_on(self.guard.arrival(h));
        self.guard.roll();
        // A step cut short says nothing against the natural length.
        run.step = if cut { h.max(run.step) } else { h };
        run.series = Some(self.tight);
        run.dense_from = run.front_time;
        run.front_time = end;
        run.front.copy_from_slice(&self.next);
        context.statistics.steps += 1;
    }

    /// Makes sure of the next singular pose, if one may be near. Says whether there is one.
    fn look_ahead(&mut self, context: &mut Context, run: &mut Continuation, natural: f64) -> bool {
        let near = run.ahead > 0.0 && run.ahead < FORESEEN * natural;
        if near {
            let guess = f64::min(run.ahead, REACH * natural);
            run.ahead = self.locate(context, run, guess).unwrap_or(0.0);
            if run.ahead > 0.0 {
                run.pose = Some(run.front_time + run.ahead);
            }
        }
        near && run.ahead > 0.0
    }

    /// The step that the tolerance permits. Rates decide, or positions if the step is so long that their error is larger.
    fn natural_step(&mut self, order: usize, tolerance: f64) -> f64 {
        let step = SAFETY * self.jet.reach(order, tolerance, 1);
        if step > order as f64 { step.min(SAFETY * self.jet.reach(order, tolerance, 0)) } else { step }
    }

    /// The rest of the series at the front, as far as the step may need it.
    fn expand(&mut self, context: &Context, run: &mut Continuation, room: f64, order: usize) {
        let goal = NEGLIGIBLE * share(context.settings.tolerance);
        // Only a step much shorter than its natural length needs fewer terms.
        let cut = run.step == 0.0 || room < CUT * run.step;
        let last = if cut {
            self.expand_within(room, order, goal)
        } else {
            self.jet.advance(1, order - 2);
            order
        };
        run.order = last as u32;
        let polynomial = self.jet.polynomial(last);
        run.dense[..polynomial.len()].copy_from_slice(polynomial);
    }

    /// Orders until two terms in a row are negligible in a step; returns the last one.
    fn expand_within(&mut self, room: f64, order: usize, goal: f64) -> usize {
        let (mut power, mut small) = (room, 0);
        for last in 2..order {
            let rate = last as f64 * power;
            let size = self.jet.size(last);
            small = if rate * size <= goal { small + 1 } else { 0 };
            if small == 2 && rate * room * size <= goal {
                return last;
            }
            power *= room;
            self.jet.advance(last - 1, last - 1);
        }
        order
    }

    /// One step of the explicit method.
    fn lead_on(
        &mut self,
        context: &mut Context,
        explicit: &mut Dynamic,
        run: &mut Continuation,
        horizon: Horizon,
    ) -> Result<(), Failure> {
        explicit.forget();
        run.step = 0.0;
        run.order = 0;
        run.choices = Choices::default();
        run.series = None;
        context.machine.load(context.model, &run.origin);
        explicit.single(context, run, horizon)?;
        run.series = None;
        context.statistics.fallbacks += 1;
        self.known = Start::Unknown;
        Ok(())
    }
}

/// Length of a step that its series permits to be so long.
fn planned(ahead: f64, natural: f64, usual: f64) -> f64 {
    match if ahead > 0.0 { plan(&COURSE, ahead, usual) } else { Plan::Free } {
        Plan::Free => natural,
        Plan::Approach(most) => natural.min(most),
        Plan::Pass(least) => natural.max(least),
    }
}

/// How far loops are open by rounding errors alone: those of the positions count, for angles grow with every turn.
fn rounding(model: &Model, front: &[f64]) -> f64 {
    let coordinates = model.program().coordinates.iter().zip(front);
    let largest = coordinates.fold(0.0, |largest, (coordinate, q)| math::maximum(largest, q.abs() / coordinate.scale));
    math::maximum(ROUNDING, SPACINGS * f64::EPSILON * largest)
}

/// What one step may be wrong by at a tolerance.
fn share(tolerance: f64) -> f64 {
    (SHARE_OF_TOLERANCE * tolerance).max(FINEST)
}

/// Does the front lie where rounding errors of a singular pose may count?
fn is_near(run: &Continuation) -> bool {
    let near = |pose: f64| (run.front_time - pose).abs() < HORIZON * run.step;
    run.step == 0.0 || run.ahead > 0.0 || run.pose.is_some_and(near)
}

/// Orders that cost least at a tolerance: two more for each decade. The optimum is flat; with fewer of them steps stay away from the radius of
/// convergence.
pub(crate) fn order_for(tolerance: f64) -> usize {
    let decades = -math::rough_log2(tolerance) * std::f64::consts::LOG10_2;
    let even = LEAST_ORDER + 2 * (decades + 0.5) as usize;
    even.min(MAX_ORDER)
}

/// Orders near a singular pose: the rounding errors that it multiplies grow with the order.
fn order_near(tolerance: f64) -> usize {
    if tolerance >= 1e-5 {
        12
    } else if tolerance >= 1e-7 {
        16
    } else if tolerance >= 1e-11 {
        18
    } else {
        20
    }
}
