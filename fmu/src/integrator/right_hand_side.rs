//! The right-hand side of Eqs. (22): (q, v)' as a function of time, q and v.

use crate::context::{Context, Statistics};
use crate::machine::Machine;
use crate::model::{Model, State};

/// y' = f(t, y).
pub(crate) trait Derivative {
    /// Writes f(t, y).
    fn evaluate(&mut self, time: f64, y: &[f64], derivative: &mut [f64]);
}

impl<F: FnMut(f64, &[f64], &mut [f64])> Derivative for F {
    fn evaluate(&mut self, time: f64, y: &[f64], derivative: &mut [f64]) {
        self(time, y, derivative);
    }
}

/// (q, v)' with the signals continued from `origin`.
pub(crate) struct RightHandSide<'a> {
    pub model: &'a Model,
    pub machine: &'a mut Machine,
    pub statistics: &'a mut Statistics,
    pub origin: &'a State,
}

impl<'a> RightHandSide<'a> {
    pub fn new(context: &'a mut Context<'_>, origin: &'a State) -> Self {
        Self { model: context.model, machine: context.machine, statistics: context.statistics, origin }
    }
}

impl Derivative for RightHandSide<'_> {
    fn evaluate(&mut self, time: f64, y: &[f64], derivative: &mut [f64]) {
        let n = self.model.coordinates();
        self.machine.load_signals(self.model, self.origin, time);
        self.machine.load_motion(self.model, y);
        let (rates, accelerations) = derivative.split_at_mut(n);
        rates.copy_from_slice(&y[n..]);
        self.machine.evaluate(&self.model.program().tapes.acceleration, accelerations);
        self.statistics.evaluations += 1;
    }
}
