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
use cotree_fmu::program::check::Fault;
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
    Along, At as AlongAt, Feature, FeatureDerivatives, FeatureKind, Guess, ModeChanges, NotDifferentiable,
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
    /// What runs over pulleys is not where it was found to be.
    #[error(
        "no equilibrium was found from the guess: in the one that balances, {why}; start nearer to it in `[initial]`, or let `simulate` come to rest with dampers"
    )]
    OffCourse { why: String },
    /// The features on which a disc rests are found by events, not by an equilibrium.
    #[error(
        "`{name}` touches a profile, and which of its lines and arcs carry a load follows from a motion: no equilibrium is searched for; let `simulate` come to rest with dampers"
    )]
    AtProfile { name: String },
    /// Of what is held on one side only.
    #[error(
        "{cause} (in the mode of the start; there is no equilibrium in any of the {tried} combinations of open or closed, free or engaged)"
    )]
    NoModeRests { tried: usize, cause: Box<AnalysisFailure> },
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
    /// The modes that are asked for, or those that would be tried, cannot be had.
    #[error("{0}")]
    Modes(String),
    /// Several elements hold the same together: what each of them carries is not determined.
    #[error("{0}")]
    Redundant(String),
    /// Friction acts where drivers determine the motion.
    #[error(
        "{friction} acts on a driven motion: at rest its force is not determined, so there is no linear system; use `simulate` or `motion`"
    )]
    DrivenFriction {
        /// What it is, with its name.
        friction: String,
    },
    /// What is sampled goes on changing where everything else rests.
    #[error(
        "the values of sampler `{sampler}` never become constant, so there is no equilibrium: use `simulate`, or `--at` a time"
    )]
    Sampled {
        /// The sampler.
        sampler: String,
    },
    /// A motion that cannot be differentiated.
    #[error("at t = {time} s there are no derivatives: {what}")]
    NoDerivative {
        /// When \[s\].
        time: f64,
        what: String,
    },
    /// One of several experiments.
    #[error("experiment {number}: {cause}")]
    Experiment {
        /// From 1.
        number: usize,
        cause: Box<AnalysisFailure>,
    },
    /// One turn or stroke of an input, and its figures.
    #[error("{0}")]
    Turn(String),
    /// Nothing is left that could vibrate.
    #[error(
        "no degree of freedom can vibrate: {sticking} in this mode; use a mode in which it slides at a time of the motion (`--at 0 --mode {first}=slides+`), or one without its friction (`--mode {first}=idle`)"
    )]
    Stuck { sticking: String, first: String },
    #[error("the eigenvalues cannot be computed: the iteration does not converge")]
    Eigenvalues,
    /// What is computed here leaves the range of numbers.
    #[error(
        "values are too large or too small for double precision; check for a mass, a length, a stiffness or a load that differs from the others by many orders of magnitude"
    )]
    Range,
    #[error(transparent)]
    Motion(#[from] InstanceError),
    /// The accelerations at the point of interest do.
    #[error(transparent)]
    Solver(#[from] failure::Failure),
    #[error(transparent)]
    Program(#[from] Fault),
}
