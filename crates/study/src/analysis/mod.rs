//! Analysis without simulation: equilibria and their stability, linearisation, natural vibrations. All derivatives are exact: the equations are
//! differentiated symbolically.

mod contacts;
pub(crate) mod decompose;
mod driven;
mod equilibrium;
mod independent;
mod kept;
mod local;
mod matrix;
mod modes;
mod pieces;
mod point;
pub mod report;
mod requested;
mod rest;
mod resting;
mod search;
mod sensitivity;
mod sharing;
mod state_space;
mod study;
mod supports;
mod variation;

use cotree::diagnostic::lines;
use cotree_fmu::failure;
use cotree_fmu::instance::InstanceError;
use cotree_fmu::program::check::ProgramError;
use nalgebra::DMatrix;
use thiserror::Error;

pub use contacts::{ContactStatus, at_start};
pub use driven::InputTableError;
pub use equilibrium::{Equilibrium, Stability};
pub use matrix::{dense, saddle};
pub use modes::{VibrationMode, modes};
pub use point::OperatingPoint;
pub use requested::{ModeError, RequestedMode, WantedMode};
pub use rest::at_rest;
pub use sensitivity::{
    Along, At as AlongAt, EarlyEnd, Feature, FeatureDerivatives, FeatureKind, Guess, ModeChanges, NotDifferentiable,
    Sensitivities, VariedQuantity, Varying,
};
pub(crate) use sensitivity::{Differentiated, is_finite};
pub use state_space::{StateSpace, StateSpaceSignal};
pub use study::{LinearisedAt, SetError, Study, StudyError, state_at};
pub use variation::Variation;

/// Independent and dependent coordinates for a Jacobian of loop equations; none in a singular pose.
pub fn independent_columns(jacobian: &DMatrix<f64>) -> Option<(Vec<usize>, Vec<usize>)> {
    let partition = independent::Partition::new(jacobian).ok()?;
    Some((partition.independent, partition.dependent))
}

/// Why an analysis has no result.
#[derive(Debug, Error)]
pub enum AnalysisFailure {
    #[error(
        "no equilibrium was found from the guess; still accelerating there: {accelerating}; give another guess in `[initial]`, or constrain this motion"
    )]
    NoEquilibrium { accelerating: String },
    #[error(
        "no equilibrium was found from the guess: the search ends at or near a singular configuration, where branches of the motion cross and loop equations are dependent: {pose}; the reactions there are not determined; start from another configuration in `[initial]`"
    )]
    Crossing { pose: String },
    /// The loads balance where what is held on one side only does not permit it.
    #[error("no equilibrium was found from the guess: where the loads balance, {why}")]
    Unfit { why: String },
    /// The loop equations depend on each other in this pose only.
    #[error(
        "at t = {time} s the configuration is singular: the mechanism gains a degree of freedom and `{coordinate}` is not determined; choose another configuration"
    )]
    Singular {
        /// When \[s\].
        time: f64,
        coordinate: String,
    },
    /// An expression has no value or no derivative here.
    #[error("at t = {time} s `{what}` has no finite value or derivative")]
    NotFinite {
        /// When \[s\].
        time: f64,
        what: String,
    },
    /// Parameters, inputs or initial values that the scene does not have.
    #[error("{}", lines(.0))]
    Unknown(Vec<SetError>),
    /// An input is to be held that moves a driver.
    #[error(
        "a driver also follows `{input}`: a zero-order hold would make its motion jump; let the driver integrate an input"
    )]
    Followed {
        /// The input.
        input: String,
    },
    /// A motion that cannot be differentiated.
    #[error("at t = {time} s there are no derivatives: {what}")]
    NoDerivative {
        /// When \[s\].
        time: f64,
        what: String,
    },
    /// What is computed here leaves the range of numbers.
    #[error(
        "values are too large or too small for double precision; check for a mass, a length, a stiffness or a load that differs from the others by many orders of magnitude"
    )]
    Range,
    /// Anything else, as a message.
    #[error("{0}")]
    Other(String),
}

cotree::diagnostic::from_messages!(AnalysisFailure as AnalysisFailure::Other: InstanceError, failure::Failure, ProgramError);
