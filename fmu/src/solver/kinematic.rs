//! Motion of fully driven mechanisms: the loop equations determine everything.
//!
//! Positions follow by Newton's method from a prediction, in sub-steps short enough that the motion cannot jump to another branch; rates,
//! accelerations and reactions are linear equations.

use super::accelerations::Accelerations;
use super::{Context, Failure};
use crate::model::{Model, State};

/// Longest correction of a prediction, relative to the scale of a coordinate.
pub(crate) const REACH: f64 = 0.05;
/// A correction this short lets the next sub-step be twice as long.
const EASY: f64 = 0.01;
/// Shortest sub-step [s].
const SHORTEST: f64 = 1e-12;

/// Storage for kinematic motion.
#[derive(Clone, Debug)]
pub struct Kinematic {
    work: State,
    accelerations: Accelerations,
}

impl Kinematic {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        Self { work: model.default_state(0.0), accelerations: Accelerations::new(model) }
    }

    /// Moves a state to a later time. `step` is the sub-step that served last; 0 if there is none.
    pub(super) fn advance(
        &mut self,
        context: &mut Context,
        state: &mut State,
        step: &mut f64,
        target: f64,
    ) -> Result<(), Failure> {
        while state.time() < target {
            let remaining = target - state.time();
            // The first sub-step is one that the scene calls usual: in a long one a driver could begin slowly and come
            // around unnoticed.
            let usual = context.model.program().experiment.step;
            let natural = if *step > 0.0 { *step } else { usual.min(remaining) };
            let shortest = SHORTEST.max(4.0 * f64::EPSILON * target.abs());
            let h = natural.min(context.settings.max_step).max(shortest).min(remaining);
            let time = if h < remaining { state.time() + h } else { target };
            match self.attempt(context, state, time) {
                Ok(moved) => {
                    state.copy_from(&self.work);
                    context.statistics.steps += 1;
                    *step = if moved <= EASY { natural.max(2.0 * h) } else { natural };
                }
                Err(failure) => {
                    context.statistics.rejected += 1;
                    *step = 0.5 * h;
                    if *step < shortest {
                        return Err(lock_up(failure));
                    }
                }
            }
        }
        Ok(())
    }

    /// One sub-step into `work`; returns how far the prediction was off.
    fn attempt(&mut self, context: &mut Context, state: &State, time: f64) -> Result<f64, Failure> {
        let Context { model, machine, projection, statistics, settings } = context;
        machine.load(model, state);
        self.accelerations.evaluate(model, machine)?;
        statistics.evaluations += 1;
        let h = time - state.time();
        let work = &mut self.work;
        work.copy_from(state);
        model.advance_signals(state, time, work.registers_mut());
        let motion = state.rates().iter().zip(self.accelerations.accelerations());
        for (q, (v, a)) in work.positions_mut().iter_mut().zip(motion) {
            *q += h * (v + 0.5 * h * a);
        }
        machine.load(model, work);
        let moved = projection.positions(model, machine, work.positions_mut(), settings.tolerance, REACH)?;
        projection.rates(model, machine, work.rates_mut(), settings.tolerance)?;
        Ok(moved)
    }
}

/// The same failure as the user of a driven mechanism sees it.
pub(crate) fn lock_up(failure: Failure) -> Failure {
    match failure {
        Failure::Drift { time, gap } => Failure::LockUp { time, gap },
        other => other,
    }
}
