//! Motion of fully driven mechanisms: the loop equations determine everything, and what is left to do is to stay on the branch.
//!
//! A continuation with steps of its own (Allgower, Georg 1990; Deuflhard 2011, chapter 5): the pose is predicted along its first two
//! derivatives and corrected by Newton's method (`correction`), and three rules say whether what was found
//! is on the same branch. Communication points are read in between; they neither choose the steps nor judge them.

mod correction;
mod path;
mod regularity;

use super::domains::outside;
use super::projection::largest_gap;
use crate::context::Context;
use crate::failure::Failure;
use crate::model::{Model, State, motion};
use crate::pace::Pace;
use correction::{Corrector, Rejection};
use path::Path;

/// Shortest step, in units of the rounding error of time.
const SHORTEST: f64 = 4.0 * f64::EPSILON;
/// Longest step, as a share of the default experiment: a driver that begins slowly must not come around unnoticed.
const LONGEST: f64 = 1.0 / 64.0;
/// A mechanism that stops in a pose at least this close to a singular one locks up; elsewhere it is stopped by what drives it.
const LOCKED: f64 = 1e-4;

/// Storage for kinematic motion.
#[derive(Clone, Debug)]
pub struct Kinematic {
    corrector: Corrector,
    /// Where the last step ended and the next one starts.
    state: State,
}

/// What a run remembers of its last step. Time, parameters and inputs continue from `origin`; a motion is q, then v.
pub(crate) struct Track<'a> {
    pub origin: &'a State,
    /// Start of the last step, with the motion there.
    pub start_time: &'a mut f64,
    pub start: &'a mut [f64],
    /// Its end.
    pub end_time: &'a mut f64,
    pub end: &'a mut [f64],
    /// Natural length of the next step; 0 if it is not known.
    pub step: &'a mut f64,
}

/// Where a continuation stands, and how far it may go.
struct Course<'a> {
    /// Of the path.
    s: f64,
    /// Natural length of the next step.
    step: f64,
    shortest: f64,
    longest: f64,
    /// At least so far.
    target: f64,
    /// No further than that.
    limit: f64,
    path: Path<'a>,
}

impl Course<'_> {
    /// The failure at a time of the motion, which a change of inputs and parameters does not move.
    fn too_slow(&self, failure: Failure, time: f64) -> Failure {
        match (self.path, failure) {
            (Path::Change(..), Failure::TooManySteps { pace, most, .. }) => {
                Failure::TooManySteps { time, pace, target: time, most }
            }
            (_, failure) => failure,
        }
    }
}

impl Kinematic {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        Self { corrector: Corrector::new(model), state: model.default_state(0.0) }
    }

    /// Moves a state to a later time, along steps that may go on to `limit`.
    pub(crate) fn advance(
        &mut self,
        context: &mut Context,
        track: &mut Track,
        [target, limit]: [f64; 2],
        state: &mut State,
    ) -> Result<(), Failure> {
        if *track.end_time < target {
            self.step_past(context, track, [target, limit])?;
        }
        if self.read(context, track, target, state) {
            return Ok(());
        }
        // Something happens inside the step and is over at its end.
        *track.end_time = *track.start_time;
        track.end.copy_from_slice(track.start);
        *track.step = 0.5 * (target - *track.start_time);
        self.step_past(context, track, [target, target])?;
        state.copy_from(&self.state);
        Ok(())
    }

    /// Steps from the last step's end until a time is passed.
    fn step_past(
        &mut self,
        context: &mut Context,
        track: &mut Track,
        [target, limit]: [f64; 2],
    ) -> Result<(), Failure> {
        let (model, range) = (context.model, motion(context.model.layout()));
        let experiment = &model.program().experiment;
        let start = &mut self.state;
        start.copy_from(track.origin);
        model.advance_signals(track.origin, *track.end_time, start.registers_mut());
        start.registers_mut()[range.clone()].copy_from_slice(track.end);
        let mut course = Course {
            s: *track.end_time,
            step: if *track.step > 0.0 { *track.step } else { experiment.step },
            shortest: SHORTEST * f64::max(target.abs(), experiment.step),
            longest: context
                .settings
                .max_step
                .min(f64::max(LONGEST * (experiment.stop - experiment.start), experiment.step)),
            target,
            limit,
            path: Path::Time(track.origin),
        };
        let done = self.follow(context, &mut course, |s, motion| {
            *track.start_time = s;
            track.start.copy_from_slice(motion);
        });
        (*track.step, *track.end_time) = (course.step, course.s);
        track.end.copy_from_slice(&self.state.registers()[range]);
        done
    }

    /// Takes over a change of time, parameters and inputs: `state` comes with the change and the old pose. On failure it stays as it was.
    pub(crate) fn close(&mut self, context: &mut Context, before: &State, state: &mut State) -> Result<(), Failure> {
        self.state.copy_from(before);
        let path = Path::Change(before, state);
        let mut course = Course { s: 0.0, step: 1.0, shortest: SHORTEST, longest: 1.0, target: 1.0, limit: 1.0, path };
        self.follow(context, &mut course, |_, _| ())?;
        self.corrector.rates(context, &mut self.state)?;
        state.copy_from(&self.state);
        Ok(())
    }

    /// Steps along a path; `begun` hears where each accepted step began.
    fn follow(
        &mut self,
        context: &mut Context,
        course: &mut Course,
        mut begun: impl FnMut(f64, &[f64]),
    ) -> Result<(), Failure> {
        let range = motion(context.model.layout());
        let mut pace = Pace::new(context, course.s);
        while course.s < course.target {
            pace.check(context, course.s, course.target).map_err(|slow| course.too_slow(slow, self.state.time()))?;
            context.settings.check_deadline(self.state.time())?;
            self.corrector.begin(context, course.path, &self.state)?;
            let (from, h) = (course.s, self.step(context, course)?);
            begun(from, &self.state.registers()[range.clone()]);
            self.state.copy_from(self.corrector.end());
            course.s = if h < course.limit - from { from + h } else { course.limit };
            context.statistics.steps += 1;
        }
        Ok(())
    }

    /// One step from where the corrector has begun; returns its length.
    fn step(&mut self, context: &mut Context, course: &mut Course) -> Result<f64, Failure> {
        let remaining = course.limit - course.s;
        loop {
            let natural = course.step.min(course.longest).max(course.shortest);
            let h = natural.min(remaining);
            if let Some(h) = self.cross(context, course, h) {
                return Ok(h);
            }
            match self.corrector.attempt(context, course.path, [course.s, h], false) {
                Ok(easy) => {
                    course.step = if easy { f64::max(natural, 2.0 * h) } else { natural };
                    return Ok(h);
                }
                Err(rejection) => {
                    context.statistics.rejected += 1;
                    course.step = 0.5 * h;
                    if course.step < course.shortest {
                        return Err(self.stuck(context, course, h, rejection));
                    }
                }
            }
        }
    }

    /// Near a singular pose, a step that ends as far behind it as it began in front of it, so that nothing is evaluated in the pose: where
    /// branches cross, or touch. `h` is a step that stays in front of it.
    fn cross(&mut self, context: &mut Context, course: &Course, h: f64) -> Option<f64> {
        let remaining = course.limit - course.s;
        let [crossing, touching] = self.corrector.meeting(context, course.path, [course.s, 0.25 * h])?;
        for (meeting, crosses) in [(crossing, true), (touching, false)] {
            let over = 2.0 * meeting;
            if over <= remaining && self.corrector.attempt(context, course.path, [course.s, over], crosses).is_ok() {
                return Some(over);
            }
        }
        // The last point allowed lies in the pose.
        let last = (0.5 * crossing..2.0 * crossing).contains(&remaining);
        (last && self.corrector.extrapolate(context, course.path, [course.s, remaining])).then_some(remaining)
    }

    /// Why there is no step from here.
    fn stuck(&mut self, context: &mut Context, course: &Course, h: f64, rejection: Rejection) -> Failure {
        let model = context.model;
        let distance = self.corrector.distance();
        let (time, residuals) = self.corrector.residuals(context, course.path, [course.s, h]);
        if let Rejection::Redundant(row) = rejection {
            return Failure::Redundant { time, gap: largest_gap(model, &[row], residuals) };
        }
        let gap = largest_gap(model, model.active(), residuals);
        if !gap.size.is_finite() {
            outside(model, context.machine).unwrap_or(Failure::DriverUndefined { time, owner: gap.owner })
        } else if distance < LOCKED {
            Failure::LockUp { time, gap }
        } else {
            Failure::DriverJumps { time, gap }
        }
    }

    /// The state at a time within the last step. False if the step does not show what happens then.
    fn read(&mut self, context: &mut Context, track: &Track, target: f64, state: &mut State) -> bool {
        let (model, range) = (context.model, motion(context.model.layout()));
        state.copy_from(track.origin);
        model.advance_signals(track.origin, target, state.registers_mut());
        if target == *track.end_time {
            state.registers_mut()[range].copy_from_slice(track.end);
            return true;
        }
        let h = *track.end_time - *track.start_time;
        let share = (target - *track.start_time) / h;
        let starts = track.start.iter().zip(&track.start[model.coordinates()..]);
        let ends = track.end.iter().zip(&track.end[model.coordinates()..]);
        for (index, ((from, slope), (to, end_slope))) in starts.zip(ends).take(model.coordinates()).enumerate() {
            let [position, rate] = hermite(share, h, [*from, *slope, *to, *end_slope]);
            state.positions_mut()[index] = position;
            state.rates_mut()[index] = rate;
        }
        self.corrector.settle(context, state)
    }
}

/// Value and derivative of the cubic polynomial with these values and derivatives at its ends, at a share of its length h.
fn hermite(share: f64, h: f64, [from, slope, to, end_slope]: [f64; 4]) -> [f64; 2] {
    let chord = (to - from) / h;
    let [first, second] = [slope - chord, end_slope - chord];
    let rest = 1.0 - share;
    let value = from + share * (to - from) + h * share * rest * (rest * first - share * second);
    let rate = chord + rest * (1.0 - 3.0 * share) * first + share * (3.0 * share - 2.0) * second;
    [value, rate]
}

#[cfg(test)]
mod tests {
    use super::hermite;

    #[test]
    fn cubics_are_met_everywhere() {
        let cubic = |t: f64| [2.0 - t + 3.0 * t * t - 0.5 * t * t * t, -1.0 + 6.0 * t - 1.5 * t * t];
        let ([from, slope], [to, end]) = (cubic(1.0), cubic(3.0));
        for share in [0.0, 0.25, 0.6, 1.0] {
            let [value, rate] = hermite(share, 2.0, [from, slope, to, end]);
            let [expected, expected_rate] = cubic(1.0 + 2.0 * share);
            assert!((value - expected).abs() < 1e-13 && (rate - expected_rate).abs() < 1e-13, "{share}");
        }
    }
}
