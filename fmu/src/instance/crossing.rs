//! Singular poses in Model Exchange. Two branches of the motion cross there. The importer's integrator does not know and goes on along either of
//! them, with results that look good. So every completed step is searched for such a pose, and one that is found is an error.

use crate::constraints::poses::{closed, rows_of};
use crate::math::GOLDEN;
use crate::model::{Model, State};
use crate::singular::dependence::DEPENDENT;
use crate::singular::detect::{dependent, weakest};

/// With more loop equations the search would take longer than the step.
const MOST_EQUATIONS: usize = 50;
/// A pose is singular if its distance is a smaller share than this of the usual one. From there on it takes an error of the square of it to get
/// onto the other branch.
const SINGULAR_SHARE: f64 = 1e-3;
/// How many times as steep as it is seen to be the distance from singular poses may be.
const STEEPER: f64 = 2.0;
/// Halvings or so of the interval in which the distance is smallest.
const REFINEMENTS: usize = 30;

/// How far the loop equations are from depending on each other, in units of what they hold.
fn distance(model: &Model, state: &State) -> f64 {
    weakest(model, &rows_of(model, state, &closed(model, state)))
        .map_or(f64::INFINITY, |(least, ..)| least.max(0.0).sqrt())
}

/// A singular pose within a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// When [s].
    pub time: f64,
    /// Joints and drivers whose loop equations depend on each other there.
    pub joints: Vec<String>,
}

/// What is known of the step before.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    /// Its end, and the distance from singular poses there.
    last: Option<(State, f64)>,
    /// How fast that distance changed [1/s].
    slope: f64,
    /// The largest distance so far.
    usual: f64,
}

impl Watch {
    /// Looks at a start; gives the pose if it is singular.
    pub fn begin(&mut self, model: &Model, state: &State) -> Option<Crossing> {
        *self = Self::default();
        let distance = self.resume(model, state)?;
        (distance <= DEPENDENT).then(|| Crossing { time: state.time(), joints: dependent(model, state).1 })
    }

    /// The next step begins in this state; gives its distance from singular poses, unless that takes too long to find out.
    pub fn resume(&mut self, model: &Model, state: &State) -> Option<f64> {
        if closed(model, state).is_empty() || model.active().len() > MOST_EQUATIONS {
            self.last = None;
            return None;
        }
        let distance = distance(model, state);
        self.usual = self.usual.max(distance);
        self.last = Some((state.clone(), distance));
        Some(distance)
    }

    /// Looks at a step that ends in `state`; gives the singular pose in it, if it is as close as an integrator with this tolerance can tell.
    pub fn step(&mut self, model: &Model, state: &State, tolerance: f64) -> Option<Crossing> {
        let before = self.last.take().filter(|(before, _)| before.time() < state.time());
        let Some((before, start)) = before else {
            self.resume(model, state);
            return None;
        };
        let limit = tolerance.sqrt().min(SINGULAR_SHARE) * self.usual;
        let path = Path { model, before: &before, after: state };
        let (middle, end) = (path.distance(0.5), path.distance(1.0));
        let half = 0.5 * (state.time() - before.time());
        let slope = f64::max((start - middle).abs(), (middle - end).abs()) / half;
        let fall = STEEPER * slope.max(self.slope) * half;
        let halves = [(0.0, start, middle), (0.5, middle, end)];
        let found = halves.into_iter().find_map(|(from, first, last)| {
            // Between its ends the distance may fall this low, but no lower.
            let lowest = 0.5 * (first + last - fall);
            (lowest <= limit).then(|| path.closest(from, from + 0.5)).filter(|&share| path.distance(share) <= limit)
        });
        let crossing = found.map(|share| path.crossing(share));
        *self = Self { last: Some((state.clone(), end)), slope, usual: self.usual.max(end) };
        crossing
    }
}

/// The motion during a step, as the cubic that fits positions and rates at its ends.
struct Path<'a> {
    model: &'a Model,
    before: &'a State,
    after: &'a State,
}

impl Path<'_> {
    fn at(&self, share: f64) -> State {
        let mut state = self.after.clone();
        let h = self.after.time() - self.before.time();
        state.set_time(self.before.time() + share * h);
        let [p, r] = [share * share * (3.0 - 2.0 * share), share * (1.0 - share)];
        let ends = self.before.positions().iter().zip(self.after.positions());
        let rates = self.before.rates().iter().zip(self.after.rates());
        for ((q, (q0, q1)), (v0, v1)) in state.positions_mut().iter_mut().zip(ends).zip(rates) {
            *q = q0 + p * (q1 - q0) + h * r * ((1.0 - share) * v0 - share * v1);
        }
        state
    }

    fn distance(&self, share: f64) -> f64 {
        distance(self.model, &self.at(share))
    }

    /// Where between two shares of the step the distance is smallest.
    fn closest(&self, mut from: f64, mut to: f64) -> f64 {
        let inner = |from: f64, to: f64| [to - GOLDEN * (to - from), from + GOLDEN * (to - from)];
        let mut places = inner(from, to);
        let mut distances = places.map(|share| self.distance(share));
        for _ in 0..REFINEMENTS {
            if distances[0] <= distances[1] {
                to = places[1];
                places = inner(from, to);
                distances = [self.distance(places[0]), distances[0]];
            } else {
                from = places[0];
                places = inner(from, to);
                distances = [distances[1], self.distance(places[1])];
            }
        }
        0.5 * (from + to)
    }

    fn crossing(&self, share: f64) -> Crossing {
        let state = self.at(share);
        Crossing { time: state.time(), joints: dependent(self.model, &state).1 }
    }
}
