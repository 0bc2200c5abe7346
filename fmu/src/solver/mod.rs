//! From a consistent initial state to the state at any later time.
//!
//! [`initial`] finds the first state, [`stepping`] moves it from one communication point to the next. Constrained motion is integrated in
//! the branch coordinates and projected back onto the loop equations after every step ([`projection`]); fully driven mechanisms need no
//! integrator ([`kinematic`]).

mod abreast;
pub mod accelerations;
mod branch;
mod choice;
mod continuation;
mod dense;
mod dependence;
mod dop853;
mod dynamic;
mod each_stage;
pub mod expansion;
pub mod explicit;
pub mod failure;
mod implicit;
pub mod initial;
pub mod kinematic;
mod least_squares;
mod leaving;
mod length;
mod loops;
mod passing;
pub mod poses;
pub mod projection;
mod radau;
pub mod redundancy;
mod singular;
mod sparse;
mod spectrum;
pub mod stepping;
pub mod tangent;
mod taylor;

pub use crate::program::Engine;
pub use failure::{Failure, Gap};
pub use passing::Passage;
pub(crate) use singular::weakest;

use crate::machine::Machine;
use crate::model::Model;
use projection::Projection;

/// How to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Who takes the steps.
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
struct Context<'a> {
    model: &'a Model,
    machine: &'a mut Machine,
    projection: &'a mut Projection,
    statistics: &'a mut Statistics,
    settings: &'a Settings,
}
