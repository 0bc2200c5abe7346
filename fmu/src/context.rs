//! What the parts of a run work on together: the model, its machine, the settings, the counters.

use crate::constraints::projection::Projection;
use crate::machine::Machine;
use crate::model::Model;
use crate::program::Engine;

/// How to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The method that takes the steps.
    pub engine: Engine,
    /// May the run change to the implicit method while the motion is stiff?
    pub automatic: bool,
    /// Relative tolerance on what the user sees.
    pub tolerance: f64,
    /// Longest step [s].
    pub max_step: f64,
    /// Nothing is evaluated after this time [s].
    pub stop: Option<f64>,
}

/// What the solver has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Evaluations of the accelerations, or series of the motion.
    pub evaluations: u64,
    /// Factorisations of the implicit method; each is of a real and of a complex matrix.
    pub factorisations: u64,
    /// Jacobians of the accelerations.
    pub jacobians: u64,
    /// Projections that moved the state.
    pub projections: u64,
    /// Steps of the explicit method where there was no Taylor series.
    pub fallbacks: u64,
}

/// What the parts of the solver work on together.
pub(crate) struct Context<'a> {
    pub(crate) model: &'a Model,
    pub(crate) machine: &'a mut Machine,
    pub(crate) projection: &'a mut Projection,
    pub(crate) statistics: &'a mut Statistics,
    pub(crate) settings: &'a Settings,
}
