//! Contacts without friction in a step of the series: the gaps of open ones and the reactions of closed ones are polynomials, whose first roots are found without looking at the step in many places.
//!
//! This serves where nothing else can turn and each of them is clear of zero or falls through it. Everything else is looked through place by place (see [`super::super::events`]): friction, comparisons,
//! steps of Runge-Kutta methods, gaps that nearly close, reactions that begin at zero, and flights that begin without a rate.

use super::super::super::{Computed, Instance};
use super::super::{Instants, Searched};
use crate::hybrid::contact::TOUCHING;
use crate::hybrid::descent::{self, Descent};
use crate::hybrid::onset::{CHECKS, ROOT_HALVINGS, Reach, turn};
use crate::linalg::SPACINGS;
use crate::math::{horner, maximum, minimum};
use crate::program::arm_form::ORDERS;
use crate::taylor::TapeAlong;

/// So often a root of a polynomial is improved: Newton's method doubles the digits.
const IMPROVEMENTS: usize = 8;
/// A gap is looked at so many times as far ahead as it seems to stay open, before the rest of the step.
const FLIGHTS_AHEAD: f64 = 2.0;
/// Where reactions are compared with their polynomials, in shares of a step.
const COMPARED: [f64; 2] = [CHECKS[1], 1.0];

/// What becomes of a gap or a reaction in a step.
enum Course {
    Positive,
    /// It falls to zero this share of the step after its beginning.
    Ends(f64),
    Unknown,
}

impl Instance {
    /// Looks through the last step by the polynomials of gaps and reactions; none if these do not tell.
    pub(in super::super) fn search_polynomials(&mut self, instants: &mut Instants, step: [f64; 2]) -> Option<Searched> {
        if !self.model.program().instants.has_gaps_only() || self.now.happened.redundant.contains(&true) {
            return None;
        }
        let mut gaps = instants.contacts.gaps_along.take()?;
        let found = self.search_contacts(instants, &mut gaps, step);
        instants.contacts.gaps_along = Some(gaps);
        found
    }

    fn search_contacts(&mut self, instants: &mut Instants, gaps: &mut TapeAlong, step: [f64; 2]) -> Option<Searched> {
        self.expand_along(gaps, step[0])?;
        self.test_reactions(instants, step)?;
        let whole = step[1] - step[0];
        let mut flights = std::mem::take(&mut instants.contacts.flights);
        flights.iter_mut().enumerate().for_each(|(event, flight)| *flight = self.guess(gaps, event) / whole);
        let first = self.first_course(instants, gaps, &flights, step);
        instants.contacts.flights = flights;
        let first = first?.map(|(share, event)| (step[0] + share * whole, event));
        instants.armed.fill(true);
        match first {
            Some((_, event)) => instants.armed[event] = false,
            None => self.all_stay(instants, step).then_some(())?,
        }
        Some(self.searched_by_polynomials(instants, step, first))
    }

    /// What a search by polynomials has found in the last step.
    pub(super) fn searched_by_polynomials(
        &mut self,
        instants: &mut Instants,
        step: [f64; 2],
        first: Option<(f64, usize)>,
    ) -> Searched {
        instants.known.end = None;
        instants.known.seen =
            first.filter(|_| instants.record.is_some()).map(|found| self.seen_before(instants, step, found));
        self.computed = Computed::default();
        Searched { step, first }
    }

    /// The first contact that changes, and after which share of the step; none if this is not known.
    fn first_course(
        &mut self,
        instants: &mut Instants,
        gaps: &mut TapeAlong,
        flights: &[f64],
        step: [f64; 2],
    ) -> Option<Option<(f64, usize)>> {
        // What seems to close first does so, mostly: then little of the other polynomials matters.
        let likely = (0..flights.len()).min_by(|&a, &b| flights[a].total_cmp(&flights[b]))?;
        let others = (0..flights.len()).filter(|&event| event != likely);
        let mut first = None;
        for event in std::iter::once(likely).chain(others) {
            let limit = first.map_or(1.0, |(share, _)| share);
            let course = match self.is_open(event) {
                true => self.flight(gaps, (event, [FLIGHTS_AHEAD * flights[event], limit]), step),
                false => self.pressing(instants, event, step),
            };
            match course {
                Course::Positive => {}
                Course::Unknown => return None,
                Course::Ends(share) if share < limit || first.is_none() => first = Some((share, event)),
                Course::Ends(_) => {}
            }
        }
        Some(first)
    }

    /// Looks whether all contacts stay as they are at the end of a step in which their polynomials find nothing.
    fn all_stay(&mut self, instants: &mut Instants, step: [f64; 2]) -> bool {
        if self.model.program().constraints.len() == instants.indicators.len() && !self.is_any_solved() {
            return true;
        }
        // Where loops are closed again gaps are not quite those of the polynomial.
        self.evaluate_sides(instants, (step, step), 1.0);
        (0..instants.armed.len()).all(|event| instants.excess(event) < 0.0)
    }

    /// Evaluates the reactions in two places of a step, which tell how good their polynomials are; none if one of them began at zero.
    fn test_reactions(&mut self, instants: &mut Instants, step: [f64; 2]) -> Option<()> {
        let closed = |event: &usize| !self.is_open(*event);
        if !(0..instants.armed.len()).any(|event| closed(&event)) {
            return Some(());
        }
        (0..instants.armed.len()).filter(closed).all(|event| self.now.happened.armed[event]).then_some(())?;
        for (place, share) in COMPARED.into_iter().enumerate() {
            self.evaluate_sides(instants, (step, step), share);
            for event in 0..instants.armed.len() {
                instants.excesses[event][place] = instants.excess(event);
            }
        }
        Some(())
    }

    /// What becomes of the reaction of a closed contact in a step.
    fn pressing(&mut self, instants: &mut Instants, event: usize, step: [f64; 2]) -> Course {
        let (settings, mut reaction) = (self.settings(), [0.0; ORDERS]);
        let constraint = self.model.program().instants.contacts()[event].constraint;
        let (run, memory) = (&self.now.run, &self.now.memory);
        let series = self.stepper.series(&self.model, run, memory, &settings);
        if !series.is_some_and(|series| series.reaction(run, constraint, &mut reaction)) {
            return Course::Unknown;
        }
        // Positive as long as it presses.
        let polynomial = &scaled(&reaction.map(|coefficient| -coefficient), step[1] - step[0]);
        let errors = COMPARED.iter().zip(&instants.excesses[event]);
        let error =
            errors.fold(0.0, |most, (share, excess)| maximum(most, (horner(polynomial, *share) + excess).abs()));
        let mut force = |share: f64| {
            self.evaluate_sides(instants, (step, step), share);
            -instants.excess(event)
        };
        match descent::first(polynomial, |_| error) {
            Descent::None => Course::Positive,
            Descent::Unknown => Course::Unknown,
            Descent::Between(part) => {
                let spacing = Reach::new(step, step[1]).spacing;
                let at = root(polynomial, part, spacing, &mut force);
                Course::Ends(passed(at, part[1], spacing, &mut force))
            }
        }
    }

    /// Finds the polynomials of a tape in the last step; none if it has no series.
    pub(super) fn expand_along(&mut self, tape: &mut TapeAlong, start: f64) -> Option<()> {
        let settings = self.settings();
        self.machine.load_constant(&self.model, &self.now.state);
        let (run, memory) = (&self.now.run, &self.now.memory);
        let series = self.stepper.series(&self.model, run, memory, &settings)?;
        let order = run.last.order as usize;
        tape.begin(self.machine.registers(), (start, order), |index, coefficients| {
            series.coordinate(run, index, coefficients);
        });
        Some(())
    }

    /// How long a gap seems to stay open, by the first terms of its polynomial.
    fn guess(&self, gaps: &TapeAlong, event: usize) -> f64 {
        let from = usize::from(!self.now.happened.armed[event]);
        let term = |order: usize| gaps.polynomial(event).get(from + order).copied().unwrap_or_default();
        let [value, rate, bend] = [0, 1, 2].map(term);
        // The smallest positive root of the parabola; none is not a number.
        let root = (rate * rate - 4.0 * value * bend).sqrt();
        let roots = [2.0 * value / (-rate - root), 2.0 * value / (-rate + root)];
        roots.into_iter().filter(|root| *root > 0.0).fold(f64::INFINITY, minimum)
    }

    /// What becomes of a gap in a step, of which only what is before a limit matters, and first what is before a share at which it has probably closed. What has just been left begins at zero: its gap over the time since then does not.
    fn flight(&self, gaps: &mut TapeAlong, (event, [ahead, limit]): (usize, [f64; 2]), step: [f64; 2]) -> Course {
        let (whole, left) = (step[1] - step[0], !self.now.happened.armed[event]);
        let touching = TOUCHING * self.scale_of(event);
        let begin = gaps.polynomial(event)[0];
        if left && begin.abs() > touching {
            return Course::Unknown;
        }
        let first = usize::from(left);
        let mut last = Course::Unknown;
        let is_linear = gaps.is_linear(event);
        for length in [minimum(ahead, limit), limit, 1.0] {
            let span = length * whole;
            let scaled = scaled(gaps.polynomial(event), span);
            let polynomial = &scaled[first..gaps.polynomial(event).len()];
            // Written so that what is not a number is not clear.
            let is_clear = polynomial.first().is_some_and(|begin| *begin > if left { touching * span } else { 0.0 });
            if !is_clear {
                break;
            }
            let mut gap = |share: f64| gaps.value(event, share * span) / if left { share } else { 1.0 };
            let error = |share: f64| if is_linear { 0.0 } else { (gap(share) - horner(polynomial, share)).abs() };
            last = match descent::first(polynomial, error) {
                Descent::None => Course::Positive,
                Descent::Unknown => Course::Unknown,
                Descent::Between(part) => {
                    let spacing = Reach::new([step[0], step[0] + span], step[1]).spacing;
                    Course::Ends(length * root(polynomial, part, spacing, &mut gap))
                }
            };
            let is_done = match last {
                Course::Positive => length >= limit,
                Course::Ends(_) => true,
                // Something else may happen at the same time: then the rest of the step tells.
                Course::Unknown => length >= 1.0,
            };
            if is_done {
                break;
            }
        }
        last
    }
}

/// The coefficients in the share of a span.
pub(super) fn scaled(polynomial: &[f64], span: f64) -> [f64; ORDERS] {
    let (mut scaled, mut power) = ([0.0; ORDERS], 1.0);
    for (place, coefficient) in scaled.iter_mut().zip(polynomial) {
        *place = coefficient * power;
        power *= span;
    }
    scaled
}

/// Where a function is zero that is positive at one place and negative at the other, from its polynomial, which is nearly right: Newton's method. Where that leads out of the interval it is closed in from both sides.
pub(super) fn root(
    polynomial: &[f64],
    [mut from, mut to]: [f64; 2],
    spacing: f64,
    function: &mut impl FnMut(f64) -> f64,
) -> f64 {
    let is_found = |at: f64, next: f64| (next - at).abs() <= maximum(spacing, SPACINGS * next.abs());
    let mut at = within(polynomial, [from, to], is_found);
    for _ in 0..IMPROVEMENTS {
        let value = function(at);
        let next = at - value / with_slope(polynomial, at)[1];
        *(if value > 0.0 { &mut from } else { &mut to }) = at;
        if is_found(at, next) {
            return minimum(maximum(next, from), to);
        }
        if !(from < next && next < to) {
            break;
        }
        at = next;
    }
    let mut excess = |share: f64| -function(share);
    let ends = [from, to].map(|share| (share, excess(share)));
    turn(&|value| value > 0.0, ends[0], ends[1], spacing, &mut excess)
}

/// The first place found behind a root, up to another one, where the function has fallen below zero: steps from the root double.
fn passed(root: f64, limit: f64, spacing: f64, function: &mut impl FnMut(f64) -> f64) -> f64 {
    let (mut at, mut ahead) = (root, maximum(spacing, SPACINGS * root));
    while at < limit && function(at) >= 0.0 {
        at = minimum(at + ahead, limit);
        ahead *= 2.0;
    }
    at
}

/// A root of the polynomial itself, likewise: a step of Newton's method that leaves the interval is replaced by its middle.
fn within(polynomial: &[f64], [mut from, mut to]: [f64; 2], is_found: impl Fn(f64, f64) -> bool) -> f64 {
    let mut at = 0.5 * (from + to);
    for _ in 0..ROOT_HALVINGS {
        let [value, slope] = with_slope(polynomial, at);
        *(if value > 0.0 { &mut from } else { &mut to }) = at;
        let next = at - value / slope;
        let next = if from < next && next < to { next } else { 0.5 * (from + to) };
        let found = is_found(at, next);
        at = next;
        if found {
            break;
        }
    }
    at
}

/// The value of a polynomial and its derivative.
fn with_slope(polynomial: &[f64], at: f64) -> [f64; 2] {
    polynomial.iter().rev().fold([0.0; 2], |[value, slope], coefficient| [value * at + coefficient, slope * at + value])
}
