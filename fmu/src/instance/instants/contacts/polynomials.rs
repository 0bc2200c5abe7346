//! Open contacts in a step of the series: their gaps are polynomials, whose first roots are found without looking at the step in many places.
//!
//! This serves where nothing but gaps can turn and each gap is clear of zero or falls through it. Everything else is looked through place by place (see [`super::super::events`]): reactions, friction, comparisons,
//! steps of Runge-Kutta methods, gaps that nearly close, and flights that begin without a rate.

use super::super::super::{Computed, Instance};
use super::super::{Instants, Searched};
use crate::hybrid::contact::{TOUCHING, is_closed};
use crate::hybrid::descent::{self, Descent};
use crate::hybrid::onset::{HALVINGS, Reach, turn};
use crate::linalg::SPACINGS;
use crate::math::{horner, maximum, minimum};
use crate::program::arm_form::ORDERS;
use crate::taylor::TapeAlong;

/// So often a root of a polynomial is improved: Newton's method doubles the digits.
const IMPROVEMENTS: usize = 8;
/// A gap is looked at so many times as far ahead as it seems to stay open, before the rest of the step.
const AHEAD: f64 = 2.0;

/// What becomes of a gap in a step.
enum Flight {
    Open,
    /// It closes this share of the step after its beginning.
    Ends(f64),
    Unknown,
}

impl Instance {
    /// Looks through the last step by the polynomials of the gaps; none if these do not tell.
    pub(in super::super) fn search_polynomials(&mut self, instants: &mut Instants, step: [f64; 2]) -> Option<Searched> {
        let mut gaps = instants.contacts.gaps_along.take()?;
        let found = self.has_flights_only(instants).then(|| self.search_gaps(instants, &mut gaps, step)).flatten();
        instants.contacts.gaps_along = Some(gaps);
        found
    }

    /// True if everything that may turn is an open contact, whose gap nobody else keeps at zero.
    fn has_flights_only(&self, instants: &Instants) -> bool {
        let program = &self.model.program().instants;
        let Some(data) = program.contacts.as_ref().filter(|_| program.events.is_empty()) else { return false };
        let flies = |index: usize| {
            let contact = &data.all[index];
            contact.slip.is_none() && !contact.of_rate && !is_closed(data, &self.now.state, index)
        };
        instants.indicators.len() == data.all.len()
            && (0..data.all.len()).all(|index| flies(index) && !self.now.happened.redundant[index])
    }

    fn search_gaps(&mut self, instants: &mut Instants, gaps: &mut TapeAlong, step: [f64; 2]) -> Option<Searched> {
        self.expand_along(gaps, step[0])?;
        let (whole, mut first) = (step[1] - step[0], None);
        instants.armed.fill(true);
        let mut flights = std::mem::take(&mut instants.contacts.flights);
        flights.iter_mut().enumerate().for_each(|(event, flight)| *flight = self.guess(gaps, event) / whole);
        // What seems to close first does so, mostly: then little of the other polynomials matters.
        let likely = (0..flights.len()).min_by(|&a, &b| flights[a].total_cmp(&flights[b]))?;
        let others = (0..flights.len()).filter(|&event| event != likely);
        let mut is_known = true;
        for event in std::iter::once(likely).chain(others) {
            let limit = first.map_or(1.0, |(share, _)| share);
            match self.flight(gaps, (event, [AHEAD * flights[event], limit]), step) {
                Flight::Open => {}
                Flight::Unknown => is_known = false,
                Flight::Ends(share) if share < limit || first.is_none() => first = Some((share, event)),
                Flight::Ends(_) => {}
            }
            if !is_known {
                break;
            }
        }
        instants.contacts.flights = flights;
        is_known.then_some(())?;
        let first = first.map(|(share, event)| (step[0] + share * whole, event));
        if let Some((_, event)) = first {
            instants.armed[event] = false;
        } else {
            // Where the loops are closed again gaps are not quite those of the polynomial.
            self.evaluate_sides(instants, (step, step), 1.0);
            let is_open = instants.contacts.gaps.iter().all(|gap| *gap > 0.0);
            is_open.then_some(())?;
        }
        instants.end = None;
        instants.seen =
            first.filter(|_| instants.record.is_some()).map(|found| self.seen_before(instants, step, found));
        self.computed = Computed::default();
        Some(Searched { step, first })
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
    fn flight(&self, gaps: &mut TapeAlong, (event, [ahead, limit]): (usize, [f64; 2]), step: [f64; 2]) -> Flight {
        let (whole, left) = (step[1] - step[0], !self.now.happened.armed[event]);
        let touching = TOUCHING * self.scale_of(event);
        let begin = gaps.polynomial(event)[0];
        if left && begin.abs() > touching {
            return Flight::Unknown;
        }
        let first = usize::from(left);
        let mut last = Flight::Unknown;
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
                Descent::None => Flight::Open,
                Descent::Unknown => Flight::Unknown,
                Descent::Between(part) => {
                    let spacing = Reach::new([step[0], step[0] + span], step[1]).spacing;
                    Flight::Ends(length * root(polynomial, part, spacing, &mut gap))
                }
            };
            let is_done = match last {
                Flight::Open => length >= limit,
                Flight::Ends(_) => true,
                // Something else may happen at the same time: then the rest of the step tells.
                Flight::Unknown => length >= 1.0,
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

/// A root of the polynomial itself, likewise: a step of Newton's method that leaves the interval is replaced by its middle.
fn within(polynomial: &[f64], [mut from, mut to]: [f64; 2], is_found: impl Fn(f64, f64) -> bool) -> f64 {
    let mut at = 0.5 * (from + to);
    for _ in 0..HALVINGS {
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
