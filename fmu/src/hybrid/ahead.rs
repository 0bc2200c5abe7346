//! Which of several modes goes on, where more than one fits at an instant.
//!
//! At breakaway margins are zero: friction is at its limit, a contact has just ceased to press, what begins to slip has no acceleration yet. Beside another unilateral constraint, or another friction of the
//! same degree of freedom, several modes fit then within rounding errors, and only one of them a moment later: that in which no margin that is zero falls (Pfeiffer and Glocker, *Multibody Dynamics with
//! Unilateral Contacts*, 1996: the complementarity problem of the next derivatives). Here these derivatives are not formed. The motion in each mode is followed by single steps of Runge and Kutta's method of order 4,
//! each longer than the one before, until a margin that was zero has left it by more than rounding errors: so the first derivative of a margin that is not zero decides, whichever it is.

use super::contact::{ContactValues, Place};
use crate::integrator::control::shortest;
use crate::machine::CANCELLED;
use crate::math::maximum;
use crate::model::{Model, State};

/// How often a mode is looked at ahead of the instant.
pub(super) const TIMES_AHEAD: u32 = 13;
/// The first step ahead \[s\], and by how much each is longer than the one before: the last one is a second.
const FIRST_TIME_AHEAD: f64 = 1.0 / (1_u64 << 36) as f64;
const FURTHER: f64 = 8.0;
/// The first step is no shorter than so many of the shortest steps at a time.
const RESOLVED: f64 = 64.0;

/// Storage.
#[derive(Clone, Debug)]
pub(crate) struct Ahead {
    start: State,
    /// Rates and accelerations of the present stage, and their weighted sums.
    slope: [Vec<f64>; 2],
    sum: [Vec<f64>; 2],
    /// The margins at the instant that are zero; none of the others.
    zero: Vec<Option<f64>>,
}

impl Ahead {
    pub fn new(model: &Model, count: usize) -> Self {
        let zeros = || vec![0.0; model.coordinates()];
        Self {
            start: model.default_state(0.0),
            slope: [zeros(), zeros()],
            sum: [zeros(), zeros()],
            zero: vec![None; count],
        }
    }
}

impl ContactValues {
    /// How many of the looks ahead the present mode passes: no margin that is zero at the instant falls. All if a margin that is not zero is the first to end it, or if there is nobody to share with.
    pub(super) fn lasts(&mut self, context: &mut Place) -> u32 {
        if self.choices.concerned().nth(1).is_none() || !self.note_zeros(context) {
            return TIMES_AHEAD;
        }
        self.ahead.start.copy_from(context.state);
        let first = maximum(FIRST_TIME_AHEAD, RESOLVED * shortest(context.state.time()));
        let mut passed = TIMES_AHEAD;
        for step in 0..TIMES_AHEAD {
            self.follow_mode(context, first * FURTHER.powi(step as i32));
            match self.falls(context) {
                Some(true) => passed = step,
                Some(false) => (),
                None => continue,
            }
            break;
        }
        context.state.copy_from(&self.ahead.start);
        self.accelerate(context);
        passed
    }

    /// Notes which margins are zero; false if none is.
    fn note_zeros(&mut self, context: &Place) -> bool {
        let sizes = self.sizes(context);
        for index in 0..self.ahead.zero.len() {
            let margin = self.choices.includes(index).then(|| self.margin(context, index, &sizes)).flatten();
            let margin = margin.filter(|_| !self.is_idle(context, index));
            let zero = margin.filter(|margin| margin.value <= self.rounding(context, index, margin.moves, margin.size));
            self.ahead.zero[index] = zero.map(|margin| margin.value);
        }
        self.ahead.zero.iter().any(Option::is_some)
    }

    /// What is zero at an instant that the method knows to within its tolerance.
    fn rounding(&self, context: &Place, index: usize, moves: bool, size: f64) -> f64 {
        if moves { self.slack(context, index) } else { self.found() * size }
    }

    /// True if a margin that was zero has fallen, false if another one has ended the mode; none as long as it lasts.
    fn falls(&self, context: &Place) -> Option<bool> {
        if !self.solved.iter().all(|value| value.is_finite()) {
            return Some(false);
        }
        let sizes = self.sizes(context);
        let mut ended = None;
        for index in self.choices.concerned() {
            let Some(margin) = self.margin(context, index, &sizes) else { continue };
            let least = -CANCELLED * maximum(margin.size, if margin.moves { sizes.acceleration } else { 0.0 });
            let fell = match self.ahead.zero[index] {
                Some(value) => margin.value < value.min(0.0) + least,
                None => margin.value < least,
            };
            if fell && self.ahead.zero[index].is_some() {
                return Some(true);
            }
            ended = if fell { Some(false) } else { ended };
        }
        ended
    }

    /// Moves the state on from the instant in the present mode, and finds its accelerations and reactions there.
    fn follow_mode(&mut self, context: &mut Place, step: f64) {
        let n = context.model.coordinates();
        self.ahead.sum.iter_mut().for_each(|sum| sum.fill(0.0));
        for (share, weight) in [(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)] {
            self.move_to(context, share * step);
            self.accelerate(context);
            let Ahead { slope, sum, .. } = &mut self.ahead;
            slope[0].copy_from_slice(context.state.rates());
            slope[1].copy_from_slice(&self.solved[..n]);
            for (sum, slope) in sum.iter_mut().flatten().zip(slope.iter().flatten()) {
                *sum += weight * slope;
            }
        }
        let Ahead { slope, sum, .. } = &mut self.ahead;
        std::mem::swap(slope, sum);
        self.move_to(context, step);
        self.accelerate(context);
    }

    /// The state after so much time with the present slope.
    fn move_to(&mut self, context: &mut Place, after: f64) {
        let Ahead { start, slope, .. } = &self.ahead;
        let time = start.time() + after;
        context.model.advance_signals(start, time, context.state.registers_mut());
        let places = context.state.positions_mut().iter_mut().zip(start.positions()).zip(&slope[0]);
        places.for_each(|((place, start), slope)| *place = start + after * slope);
        let rates = context.state.rates_mut().iter_mut().zip(start.rates()).zip(&slope[1]);
        rates.for_each(|((rate, start), slope)| *rate = start + after * slope);
    }
}
